// What reconstruction costs and gains: `dense` (Nilsson 2023) against `native`, on trees recorded from known
// distributions (docs/decisions/0008-reconstruction.md). Single-threaded; times are medians of interleaved repetitions
// in CPU time. Prints tables; about a minute.
//
//   build/release/bin/reconstruction_bench [SEEDS = 8]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "bench/study_main.h"
#include "core/guiding/reconstruction_blur.h"
#include "tests/guiding/recorded_tree.h"

namespace lodestar {
namespace {

using directional::CellMasses;
using directional::Tree;
using synthetic::RecordedTree;

// Microseconds of one call.
template <class F>
double Time(int repetitions, F&& f) {
  const double begin = CpuSeconds();
  for (int i = 0; i < repetitions; ++i) f();
  return 1e6 * (CpuSeconds() - begin) / repetitions;
}

// A distribution over the cells of a 1024 x 1024 grid, constant in each, with the integrals of its density and of its
// square over every square of the quadtree: what any tree's divergences from it are, without sampling.
class Truth {
 public:
  Truth(std::string name, const std::function<double(Vec3)>& radiance) : name(std::move(name)) {
    constexpr int n = 1 << kDepth;
    integral_.resize(kDepth + 1);
    square_.resize(kDepth + 1);
    std::vector<double>& f = integral_[kDepth];
    double sum = 0;
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x)
        sum += f.emplace_back(
            radiance(CylindricalToDirection({(static_cast<float>(x) + 0.5f) / n, (static_cast<float>(y) + 0.5f) / n})));
    }
    for (double& v : f) {
      v /= sum;
      square_[kDepth].push_back(v * v * n * n);
      if (v > 0) entropy_ += v * std::log(v * n * n);
    }
    for (int d = kDepth; d-- > 0;) {
      for (auto* levels : {&integral_, &square_}) {
        const int size = 1 << d;
        const std::vector<double>& fine = (*levels)[d + 1];
        for (int y = 0; y < size; ++y) {
          for (int x = 0; x < size; ++x) {
            const size_t i = static_cast<size_t>(y) * 4 * size + 2 * x;
            (*levels)[d].push_back(fine[i] + fine[i + 1] + fine[i + 2 * size] + fine[i + 2 * size + 1]);
          }
        }
      }
    }
  }
  double operator()(Vec3 w) const {
    const Vec2 s = DirectionToCylindrical(w);
    constexpr int n = 1 << kDepth;
    return integral_[kDepth][static_cast<size_t>(s.y * n) * n + static_cast<size_t>(s.x * n)] * n * n;
  }

  // E_p[(f / p)^2] - 1 with p the tree beside a fifth of the uniform sphere, as a BSDF would be beside it: the relative
  // variance of a guided estimate; and the Kullback-Leibler divergence, with 1 % of it.
  struct Divergence {
    double chi_square = -1, kullback = 0;
  };
  Divergence From(const Tree& tree) const {
    Divergence out;
    out.kullback = entropy_;
    synthetic::ForEachCell(tree, [&](uint32_t, uint32_t x, uint32_t y, int depth) {
      const double q =
          directional::Locate(tree.nodes.data(), x << (24 - depth), y << (24 - depth)).density / kUniformSpherePdf;
      const int below = std::max(depth - kDepth, 0), d = depth - below;
      const size_t i = (static_cast<size_t>(y >> below) << d) + (x >> below);
      out.chi_square += std::ldexp(square_[d][i], -2 * below) / (0.2 + 0.8 * q);
      out.kullback -= std::ldexp(integral_[d][i], -2 * below) * std::log(0.01 + 0.99 * q);
    });
    return out;
  }

  std::string name;

 private:
  static constexpr int kDepth = 10;
  std::vector<std::vector<double>> integral_, square_;
  double entropy_ = 0;
};

std::vector<Truth> Truths() {
  const auto lobe = [](Vec3 axis, double kappa, Vec3 w) {
    return kappa * std::exp(kappa * (static_cast<double>(Dot(Normalize(axis), w)) - 1)) * 0.16;
  };
  std::vector<Truth> truths;
  truths.emplace_back("sky", [&](Vec3 w) { return (w.z > 0 ? 0.3 + 0.2 * w.z : 0.1) + lobe({1, -0.2f, 0.3f}, 2, w); });
  truths.emplace_back("sun", [&](Vec3 w) { return (w.z > 0 ? 0.08 : 0.02) + lobe({1, 0.01f, 0.5f}, 4000, w); });
  truths.emplace_back("window", [](Vec3 w) {
    const float u = w.y / w.x, v = w.z / w.x;
    const bool inside = w.x > 0 && u > -0.3f && u < 0.5f && v > 0.1f && v < 0.9f && !(u > 0.08f && u < 0.12f);
    return inside ? 4.0 + w.z : 0.05;
  });
  truths.emplace_back("ring", [](Vec3 w) {
    const double angle = std::acos(std::clamp(Dot(Normalize(Vec3{0.3f, 0.5f, -0.8f}), w), -1.0f, 1.0f));
    return 0.02 + 3 * std::exp(-0.5 * (angle - 0.5) * (angle - 0.5) / (0.012 * 0.012)) * (1 + 0.8 * w.x);
  });
  truths.emplace_back("lobes", [&](Vec3 w) {
    return 0.02 + 0.3 * (lobe({1, 1, 1}, 30, w) + lobe({-1, 1, 0.2f}, 200, w) + lobe({0, -1, -0.5f}, 1000, w) +
                         lobe({0.1f, 0, 1}, 60, w) + lobe({1, -0.001f, -0.1f}, 8, w));
  });
  truths.emplace_back("bulbs", [](Vec3 w) {
    const auto within = [&](Vec3 axis, float cosine) { return Dot(Normalize(axis), w) > cosine; };
    return 0.002 + (within({1, 2, 0.5f}, 0.9995f) ? 300.0 : 0) + (within({-1, 0.2f, 0.4f}, 0.9985f) ? 100.0 : 0);
  });
  return truths;
}

struct Method {
  const char* name;
  synthetic::Reconstruct reconstruct;
};
std::vector<Method> Methods() {
  const auto dense = [](float sigma) {
    return [sigma](const CellMasses& m, double threshold, int depth) {
      return directional::ReconstructDense(m, sigma, threshold, depth);
    };
  };
  return {{"dense 0.5", dense(0.5f)}, {"dense 0.8", dense(0.8f)}, {"native", directional::ReconstructNative}};
}

// A stand-in for a scene's trees: every distribution, well and badly sampled.
std::vector<RecordedTree> Scene(const std::vector<Truth>& truths) {
  std::vector<RecordedTree> trees;
  for (const Truth& truth : truths) {
    for (int records : {300, 1000, 3000, 10000, 30000}) {
      for (bool second_moment : {false, true})
        trees.push_back(
            synthetic::Record({.radiance = std::cref(truth), .records = records, .second_moment = second_moment}));
    }
  }
  return trees;
}

void BlurCost(const std::vector<RecordedTree>& trees) {
  constexpr int kDepth = 11, kSize = 1 << kDepth;
  directional::FramedMatrix matrix(kDepth);
  std::vector<float> out(static_cast<size_t>(kSize) * kSize);
  const auto kernel = directional::Gaussian(0.8f);
  constexpr int kTiles = kSize / directional::kBlurTile;
  // As in the document: a tree flattened to 2048 x 2048, here one of this size or the next smaller.
  const RecordedTree* deepest = &trees[0];
  for (const RecordedTree& t : trees) {
    if (t.tree.depth <= kDepth && t.tree.depth > deepest->tree.depth) deepest = &t;
  }
  directional::SameTiles same(static_cast<size_t>(kTiles) * kTiles, 0), none = same;
  synthetic::ForEachCell(deepest->tree, [&](uint32_t slot, uint32_t x, uint32_t y, int depth) {
    const int size = kSize >> depth, x0 = static_cast<int>(x) * size, y0 = static_cast<int>(y) * size;
    for (int row = y0; row < y0 + size; ++row)
      std::fill_n(matrix.Row(row) + x0, size, static_cast<float>(deepest->masses.total[slot]));
    for (int ty = (y0 + 18) / 16; ty < (y0 + size - 3) / 16; ++ty) {
      for (int tx = (x0 + 18) / 16; tx < (x0 + size - 3) / 16; ++tx) same[static_cast<size_t>(ty) * kTiles + tx] = 1;
    }
  });
  std::vector<double> masked, unmasked;
  for (int i = 0; i < 15; ++i) {
    masked.push_back(Time(1, [&] { directional::Blur(matrix, same, kernel, out.data()); }));
    unmasked.push_back(Time(1, [&] { directional::Blur(matrix, none, kernel, out.data()); }));
  }
  std::printf(
      "7 x 7 Gaussian over 2048 x 2048 (a tree of depth %d): masked %.2f ms, unmasked %.2f ms "
      "(Nilsson 2023, table 5.1: 12.2 and 250)\n\n",
      deepest->tree.depth, Median(masked) / 1000, Median(unmasked) / 1000);
}

void Cost(const std::vector<RecordedTree>& trees) {
  struct Sums {
    int trees = 0, dense_trees = 0;
    double nodes = 0, plain = 0, native = 0, dense = 0;
  };
  std::map<int, Sums> by_depth;
  Sums all, deep;
  for (const RecordedTree& t : trees) {
    if (t.tree.depth > directional::kMaxDenseDepth) continue;
    std::vector<double> plain, native, dense;
    for (int i = 0; i < 5; ++i) {
      plain.push_back(Time(20, [&] { synthetic::Plain(t.masses, 0.01, 20); }));
      native.push_back(Time(20, [&] { directional::ReconstructNative(t.masses, 0.01, 20); }));
      dense.push_back(Time(1, [&] { directional::ReconstructDense(t.masses, 0.8f, 0.01, 20); }));
    }
    std::vector<Sums*> into = {&by_depth[t.tree.depth], &all};
    if (t.tree.depth >= 10) into.push_back(&deep);
    for (Sums* s : into) {
      ++s->trees;
      s->nodes += t.masses.node_count;
      s->plain += Median(plain);
      s->native += Median(native);
      s->dense += Median(dense);
    }
  }
  std::printf("cost of a tree in us, rebuilding included\n%-10s %6s %6s %8s %8s %9s %6s %12s\n", "depth", "trees",
              "nodes", "rebuild", "native", "dense", "ratio", "ns per node");
  const auto row = [](const char* name, const Sums& s) {
    std::printf("%-10s %6d %6.0f %8.1f %8.1f %9.1f %6.1f %12.0f\n", name, s.trees, s.nodes / s.trees, s.plain / s.trees,
                s.native / s.trees, s.dense / s.trees, s.dense / s.native, (s.native - s.plain) / s.nodes * 1000);
  };
  for (const auto& [depth, sums] : by_depth) row(std::to_string(depth).c_str(), sums);
  row("10 to 12", deep);
  row("all", all);
  std::printf("\n");
}

// Relative to no reconstruction: the geometric mean of the ratios of chi-squares over seeds, and the mean difference of
// Kullback-Leibler divergences in thousandths of a nat.
void Quality(const std::vector<Truth>& truths, bool second_moment, bool in_training, int seeds) {
  const std::vector<Method> methods = Methods();
  std::printf("%s, %s: chi-square relative to none (KL difference, 1e-3 nats)\n%-8s %7s %9s %7s",
              second_moment ? "masses sqrt(second moment)" : "masses of radiance",
              in_training ? "reconstructed in every iteration" : "the same trees, reconstructed once", "truth",
              "records", "none", "KL");
  for (const Method& m : methods) std::printf(" %16s", m.name);
  std::printf("\n");
  std::map<int, std::vector<double>> mean, mean_kl;
  for (const Truth& truth : truths) {
    for (int records : {300, 1000, 3000, 10000}) {
      const int count = std::max(1, records > 2000 ? seeds / 2 : seeds);
      std::vector<double> log_ratio(methods.size()), kl(methods.size());
      double base_log = 0, base_kl = 0;
      for (int seed = 1; seed <= count; ++seed) {
        const synthetic::Recording recording = {.radiance = std::cref(truth),
                                                .records = records,
                                                .second_moment = second_moment,
                                                .seed = static_cast<uint64_t>(seed)};
        const RecordedTree plain = synthetic::Record(recording);
        const Truth::Divergence base = truth.From(synthetic::Plain(plain.masses, 0.01, 20));
        base_log += std::log(base.chi_square) / count;
        base_kl += base.kullback / count;
        for (size_t m = 0; m < methods.size(); ++m) {
          const synthetic::Reconstruct& reconstruct = methods[m].reconstruct;
          Truth::Divergence d;
          if (in_training) {
            const RecordedTree own = synthetic::Record(recording, reconstruct);
            d = truth.From(reconstruct(own.masses, 0.01, 20));
          } else {
            d = truth.From(reconstruct(plain.masses, 0.01, 20));
          }
          log_ratio[m] += std::log(d.chi_square / base.chi_square) / count;
          kl[m] += 1000 * (d.kullback - base.kullback) / count;
        }
      }
      std::printf("%-8s %7d %9.3f %7.3f", truth.name.c_str(), records, std::exp(base_log), base_kl);
      auto &m_ratio = mean[records], &m_kl = mean_kl[records];
      m_ratio.resize(methods.size());
      m_kl.resize(methods.size());
      for (size_t m = 0; m < methods.size(); ++m) {
        std::printf("    %5.2f (%+5.0f)", std::exp(log_ratio[m]), kl[m]);
        m_ratio[m] += log_ratio[m] / static_cast<double>(truths.size());
        m_kl[m] += kl[m] / static_cast<double>(truths.size());
      }
      std::printf("\n");
    }
  }
  for (const auto& [records, ratios] : mean) {
    std::printf("%-8s %7d %17s", "mean", records, "");
    for (size_t m = 0; m < methods.size(); ++m)
      std::printf("    %5.2f (%+5.0f)", std::exp(ratios[m]), mean_kl[records][m]);
    std::printf("\n");
  }
  std::printf("\n");
}

}  // namespace
}  // namespace lodestar

int main(int argc, char** argv) {
  using namespace lodestar;
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 8;
  const std::vector<Truth> truths = Truths();
  const std::vector<RecordedTree> trees = Scene(truths);
  BlurCost(trees);
  Cost(trees);
  for (bool in_training : {false, true}) {
    for (bool second_moment : {true, false}) Quality(truths, second_moment, in_training, seeds);
  }
}
