#include "core/guiding/bsdf_fraction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "tests/support/statistical.h"

namespace lodestar {
namespace {

using Loss = SdTreeOptions::BsdfFractionLoss;

// A one-dimensional problem on [0, 1): a target and two techniques, piecewise constant over 64 bins.
struct Problem {
  std::vector<double> target, bsdf, tree;
  static std::vector<double> Normal(std::vector<double> p) {
    const double sum = std::accumulate(p.begin(), p.end(), 0.0) / static_cast<double>(p.size());
    for (double& v : p) v /= sum;
    return p;
  }
  double Mixture(double alpha, size_t bin) const { return alpha * bsdf[bin] + (1 - alpha) * tree[bin]; }
  // Expected loss: the KL divergence, or the variance of target / mixture.
  double Value(Loss loss, double alpha) const {
    double sum = 0;
    for (size_t i = 0; i < target.size(); ++i) {
      if (target[i] == 0) continue;
      sum += loss == Loss::kKl ? target[i] * std::log(target[i] / Mixture(alpha, i))
                               : target[i] * target[i] / Mixture(alpha, i);
    }
    return sum / static_cast<double>(target.size());
  }
  double Best(Loss loss) const {
    double best = kMinBsdfFraction;
    for (double a = kMinBsdfFraction; a <= kMaxBsdfFraction; a += 0.001) {
      if (Value(loss, a) < Value(loss, best)) best = a;
    }
    return best;
  }
  struct Draw {
    float product, pdf, bsdf_pdf, tree_pdf;
  };
  Draw Sample(double alpha, std::mt19937& rng) const {
    const std::vector<double>& technique = std::uniform_real_distribution<double>(0, 1)(rng) < alpha ? bsdf : tree;
    // By rejection: the densities are at most `top`.
    const double top = *std::max_element(technique.begin(), technique.end());
    size_t bin;
    do {
      bin = rng() % technique.size();
    } while (std::uniform_real_distribution<double>(0, top)(rng) >= technique[bin]);
    return {static_cast<float>(target[bin]), static_cast<float>(Mixture(alpha, bin)), static_cast<float>(bsdf[bin]),
            static_cast<float>(tree[bin])};
  }
};

Problem MakeProblem(int kind) {
  std::vector<double> a(64), b(64), t(64);
  for (int i = 0; i < 64; ++i) {
    const double x = (i + 0.5) / 64;
    a[i] = std::exp(-30 * (x - 0.3) * (x - 0.3)) + 0.01;
    b[i] = std::exp(-200 * (x - 0.6) * (x - 0.6)) + 0.02;
    switch (kind) {
      case 0:
        t[i] = a[i] * b[i];
        break;  // a product of both
      case 1:
        t[i] = a[i];
        break;  // the BSDF alone is right
      case 2:
        t[i] = b[i];
        break;  // the tree alone is right
      case 3:
        t[i] = 0.3 * a[i] + 0.2 * b[i];
        break;  // a mixture of both
      default:
        t[i] = a[i] + (i == 40 ? 20.0 : 0.0);  // a firefly
    }
  }
  return {Problem::Normal(t), Problem::Normal(a), Problem::Normal(b)};
}

// As published: one Adam step a record on theta, alpha = logistic(theta) (Mueller 2019, section 10.5, and its released
// settings).
class Adam {
 public:
  double alpha() const { return 1 / (1 + std::exp(-theta_)); }
  void Step(Loss loss, const Problem::Draw& d) {
    const double a = alpha(), mixture = a * d.bsdf_pdf + (1 - a) * d.tree_pdf;
    const double ratio = d.product / mixture;
    const double gradient =
        -(loss == Loss::kKl ? ratio : ratio * ratio) / d.pdf * (d.bsdf_pdf - d.tree_pdf) * a * (1 - a) + 0.01 * theta_;
    m_ = 0.9 * m_ + 0.1 * gradient;
    v_ = 0.999 * v_ + 0.001 * gradient * gradient;
    ++t_;
    theta_ -= 0.01 * (m_ / (1 - std::pow(0.9, t_))) / (std::sqrt(v_ / (1 - std::pow(0.999, t_))) + 1e-8);
    theta_ = std::clamp(theta_, -20.0, 20.0);
  }

 private:
  double theta_ = 0, m_ = 0, v_ = 0;
  int t_ = 0;
};

// Excess loss over the best alpha, ours against Adam's over paired seeds. Adam samples by its own alpha, as published.
TEST(BsdfFraction, NoWorseThanAdam) {
  int better = 0, cases = 0;
  for (Loss loss : {Loss::kKl, Loss::kVariance}) {
    for (int kind = 0; kind < 5; ++kind) {
      const Problem problem = MakeProblem(kind);
      const double floor = problem.Value(loss, problem.Best(loss));
      for (int records : {200, 1000, 10000}) {
        test::Moments ours, adams, difference;
        const int seeds = records > 5000 ? 8 : 32;
        for (int seed = 0; seed < seeds; ++seed) {
          std::mt19937 rng(static_cast<uint32_t>(seed * 100 + kind));
          FractionSums sums;
          Adam adam;
          for (int i = 0; i < records; ++i) {
            const auto d = problem.Sample(0.5, rng);
            sums.Add(loss, d.product, d.pdf, d.bsdf_pdf, d.tree_pdf);
            adam.Step(loss, problem.Sample(adam.alpha(), rng));
          }
          const double mine = problem.Value(loss, SolveBsdfFraction(sums, 0.5f, 64)) - floor;
          const double published = problem.Value(loss, std::clamp(adam.alpha(), 0.05, 0.95)) - floor;
          ours.Add(mine);
          adams.Add(published);
          difference.Add(mine - published);
        }
        const std::string name = std::string(loss == Loss::kKl ? "kl" : "variance") + "_" + std::to_string(kind) + "_" +
                                 std::to_string(records);
        // Within the noise of the seeds, and of a thousandth of the loss.
        EXPECT_LE(difference.mean(), 3 * difference.standard_error() + 1e-3) << name;
        ++cases;
        better += difference.mean() <= 0;
        RecordProperty(name, std::to_string(ours.mean()) + " (Adam " + std::to_string(adams.mean()) + ")");
      }
    }
  }
  EXPECT_GT(better * 3, cases * 2);
}

TEST(BsdfFraction, FindsTheOptimumBetweenTheGridPoints) {
  for (int kind = 0; kind < 4; ++kind) {
    const Problem problem = MakeProblem(kind);
    std::mt19937 rng(5);
    FractionSums sums;
    for (int i = 0; i < 200000; ++i) {
      const auto d = problem.Sample(0.5, rng);
      sums.Add(Loss::kKl, d.product, d.pdf, d.bsdf_pdf, d.tree_pdf);
    }
    EXPECT_NEAR(SolveBsdfFraction(sums, 0.5f, 64), problem.Best(Loss::kKl), 0.02) << kind;
  }
}

TEST(BsdfFraction, IsDrivenToBothEndsAndKeptOffThem) {
  for (Loss loss : {Loss::kKl, Loss::kVariance}) {
    FractionSums bsdf_only, tree_only;
    for (int i = 0; i < 100000; ++i) {
      bsdf_only.Add(loss, 1, 1, 2, 0);
      tree_only.Add(loss, 1, 1, 0, 2);
    }
    EXPECT_EQ(SolveBsdfFraction(bsdf_only, 0.5f, 64), kMaxBsdfFraction);
    EXPECT_EQ(SolveBsdfFraction(tree_only, 0.5f, 64), kMinBsdfFraction);
  }
}

TEST(BsdfFraction, FewRecordsStayNearThePrevious) {
  EXPECT_EQ(SolveBsdfFraction(FractionSums{}, 0.7f, 64), 0.7f);
  FractionSums one;
  one.Add(Loss::kKl, 1, 1, 2, 0);
  EXPECT_NEAR(SolveBsdfFraction(one, 0.5f, 64), 0.5, 0.02);
}

TEST(BsdfFraction, RecordsWithoutWeightSayNothing) {
  FractionSums sums;
  for (int i = 0; i < 1000; ++i) sums.Add(Loss::kVariance, 1e-10f, 1, 0.5f, 1);
  ASSERT_EQ(sums.count, 1000u);
  EXPECT_EQ(SolveBsdfFraction(sums, 0.7f, 64), 0.7f);
}

TEST(BsdfFraction, ExtremesAreFinite) {
  for (Loss loss : {Loss::kKl, Loss::kVariance}) {
    FractionSums sums;
    for (float product : {1e-38f, 1e-12f, 1e12f, 3e38f}) {
      for (float pdf : {1e-30f, 1.0f, 1e30f}) {
        sums.Add(loss, product, pdf, pdf, 1e-30f);
        sums.Add(loss, product, pdf, 1e-40f, 1e30f);
      }
    }
    const float alpha = SolveBsdfFraction(sums, 0.5f, 64);
    EXPECT_GE(alpha, kMinBsdfFraction);
    EXPECT_LE(alpha, kMaxBsdfFraction);
  }
}

TEST(BsdfFraction, SumsDoNotDependOnTheOrder) {
  const Problem problem = MakeProblem(0);
  std::mt19937 rng(5);
  FractionSums whole, parts[3];
  for (int i = 0; i < 1000; ++i) {
    const auto d = problem.Sample(0.5, rng);
    whole.Add(Loss::kVariance, d.product, d.pdf, d.bsdf_pdf, d.tree_pdf);
    parts[rng() % 3].Add(Loss::kVariance, d.product, d.pdf, d.bsdf_pdf, d.tree_pdf);
  }
  parts[2].Merge(parts[0]);
  parts[2].Merge(parts[1]);
  EXPECT_EQ(parts[2].weight, whole.weight);
  for (int i = 0; i < kFractionGrid; ++i) {
    EXPECT_TRUE(parts[2].GradientUnits(i) == whole.GradientUnits(i));
    FractionSums copy;
    copy.count = whole.count;
    copy.SetGradientUnits(i, whole.GradientUnits(i));
    EXPECT_TRUE(copy.GradientUnits(i) == whole.GradientUnits(i));
  }
}

}  // namespace
}  // namespace lodestar
