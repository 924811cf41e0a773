// Fits linearly transformed cosines to the GGX reflection lobe, cosine and masking-shadowing included, Fresnel left
// out, and writes the table that core/guiding/ltc.cpp includes. Takes 12 s on one core.
//
//   build/release/bin/ltc_fit core/guiding/ltc_table.inc
//
// Each entry minimises the Kullback-Leibler divergence of the lobe from the LTC (Heitz et al. 2016 minimise the cubed
// error; for sampling it is the ratio that counts). The lobe below the horizon does not exist, so the LTC is normalised
// over the upper hemisphere, and beside it a fiftieth of a cosine lobe is allowed for (product sampling has more).
// Simplex search (Nelder and Mead 1965), started from the neighbours' solutions, rough to smooth, normal to grazing.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "core/guiding/ltc.h"
#include "core/scene/microfacet.h"

namespace lodestar {
namespace {

constexpr int kParameters = 4;
using Point = std::array<double, kParameters>;  // log(x / alpha), log(y / alpha), skew / alpha, sine of the peak

// Directions distributed as the lobe, with the lobe's normalised density.
struct LobeSample {
  Vec3 w;
  double weight;  // the weights add up to 1
  double density;
};
std::vector<LobeSample> SampleLobe(float alpha, float cos_o) {
  constexpr int kPhis = 32, kCaps = 64;
  const Ggx ggx{{alpha, alpha}};
  const Vec3 wo{-SafeSqrt(1 - cos_o * cos_o), 0, cos_o};
  std::vector<LobeSample> samples;
  double albedo = 0;
  for (int n = 0; n < kPhis * kCaps; ++n) {
    const VisibleNormalNode node = VisibleNormalQuadrature(n, kPhis, kCaps);
    const Vec3 m = ggx.SampleVisible(wo, node.u);
    const Vec3 w = m * (2 * Dot(wo, m)) - wo;
    if (!(w.z > 0)) continue;
    const double weight = node.weight * MaskingWeight(ggx.Stretch(wo), wo.z, ggx.Stretch(w), w.z);
    samples.push_back({Normalize(w), weight, EvaluateMirrored(ggx, wo, w).value});
    albedo += weight;
  }
  for (LobeSample& s : samples) {
    s.weight /= albedo;
    s.density /= albedo;
  }
  return samples;
}

LtcShape Shape(const Point& p, float alpha) {
  return {static_cast<float>(std::exp(p[0])) * alpha, static_cast<float>(std::exp(p[1])) * alpha,
          static_cast<float>(p[2]) * alpha, static_cast<float>(p[3])};
}

struct Errors {
  double divergence = 0;       // Kullback-Leibler
  double chi_square = 0;       // integral f^2 / D - 1
  double total_variation = 0;  // integral |f - D| / 2
  double below = 0;            // share of the LTC below the horizon
};
constexpr double kDefence = 0.02;
Errors Measure(const std::vector<LobeSample>& lobe, const LtcShape& shape) {
  const Ltc ltc(shape, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  const double above = ltc.ShareAbove({0, 0, 1});
  Errors errors;
  errors.below = 1 - above;
  for (const LobeSample& s : lobe) {
    const double d = (1 - kDefence) * ltc.Density(s.w) / above + kDefence * s.w.z * kInvPi;
    errors.divergence += s.weight * std::log(s.density / d);
    errors.chi_square += s.weight * s.density / d;
    // Where D exceeds f: the integrals are equal, so half the absolute difference is the positive part's.
    errors.total_variation += s.weight * std::max(0.0, 1 - d / s.density);
  }
  errors.chi_square -= 1;
  return errors;
}

class Simplex {
 public:
  Simplex(const std::vector<LobeSample>& lobe, float alpha, bool symmetric)
      : lobe_(lobe), alpha_(alpha), symmetric_(symmetric) {}

  // The best point found from `start`, and its value.
  std::pair<Point, double> Minimize(const Point& start) const {
    const int n = symmetric_ ? 1 : kParameters;
    std::vector<std::pair<double, Point>> simplex{{Value(start), start}};
    for (int i = 0; i < n; ++i) {
      Point p = start;
      p[i] += i < 2 ? 0.1 : 0.05;
      simplex.push_back({Value(p), p});
    }
    for (int iteration = 0; iteration < 400; ++iteration) {
      std::sort(simplex.begin(), simplex.end());
      if (simplex.back().first - simplex.front().first < 1e-9) break;
      Point centre{};
      for (int i = 0; i < n; ++i) centre = Combine(centre, 1, simplex[i].second, 1.0 / n);
      const auto along = [&](double t) {  // 1 is the worst point, 0 the centre of the others
        const Point p = Combine(centre, 1 - t, simplex.back().second, t);
        return std::pair(Value(p), p);
      };
      auto next = along(-1);
      if (next.first < simplex.front().first) {
        next = std::min(next, along(-2));
      } else if (next.first >= simplex[n - 1].first) {
        next = along(next.first < simplex.back().first ? -0.5 : 0.5);
        if (next.first >= simplex.back().first) {
          for (int i = 1; i <= n; ++i) {
            simplex[i].second = Combine(simplex[0].second, 0.5, simplex[i].second, 0.5);
            simplex[i].first = Value(simplex[i].second);
          }
          continue;
        }
      }
      simplex.back() = next;
    }
    const auto best = std::min_element(simplex.begin(), simplex.end());
    return {best->second, best->first};
  }

 private:
  static Point Combine(const Point& a, double s, const Point& b, double t) {
    Point sum;
    for (int i = 0; i < kParameters; ++i) sum[i] = a[i] * s + b[i] * t;
    return sum;
  }
  double Value(Point p) const {
    if (symmetric_) p[1] = p[0];
    if (std::fabs(p[3]) > 0.999 || std::fabs(p[0]) > 8 || std::fabs(p[1]) > 8) return 1e9;
    // Narrow lobes hardly feel the skew. Of equals, the straightest, so that neighbouring entries blend.
    const double skew = p[2] * alpha_;
    return Measure(lobe_, Shape(p, alpha_)).divergence + 1e-3 * skew * skew;
  }

  const std::vector<LobeSample>& lobe_;
  float alpha_;
  bool symmetric_;
};

void Fit(std::FILE* out) {
  constexpr int kAlphas = LtcTable::kAlphas, kAngles = LtcTable::kAngles;
  std::vector<Point> row(kAngles, Point{0, 0, 0, 0});  // the solutions of the previous, rougher alpha
  std::vector<std::array<std::string, kAngles>> lines(kAlphas);
  Errors worst, mean;
  for (int i = kAlphas - 1; i >= 0; --i) {
    const float alpha = LtcTable::Alpha(i);
    for (int j = 0; j < kAngles; ++j) {
      const auto lobe = SampleLobe(alpha, LtcTable::CosAt(j));
      const float sin_o = SafeSqrt(1 - Sqr(LtcTable::CosAt(j)));
      const Simplex simplex(lobe, alpha, j == 0);
      Point start = row[j];
      if (i == kAlphas - 1 && j > 0) start = row[j - 1];
      auto best = simplex.Minimize(start);
      if (j > 0) {
        for (Point other : {row[j - 1], Point{row[j - 1][0], row[j - 1][1], row[j - 1][2], sin_o}}) {
          const auto found = simplex.Minimize(other);
          if (found.second < best.second - 1e-6) best = found;
        }
      }
      best = simplex.Minimize(best.first);
      if (j == 0) best.first[1] = best.first[0], best.first[2] = best.first[3] = 0;
      row[j] = best.first;
      const LtcShape s = Shape(best.first, alpha);
      const Errors e = Measure(lobe, s);
      char line[200];
      std::snprintf(line, sizeof(line), "{%.5ff, %.5ff, %.5ff, %.5ff},  // %.4f %.4f %.4f %.4f\n", s.x / alpha,
                    s.y / alpha, s.skew / alpha, s.peak_sin - sin_o, e.divergence, e.chi_square, e.total_variation,
                    e.below);
      lines[i][j] = line;
      for (double Errors::*f : {&Errors::divergence, &Errors::chi_square, &Errors::total_variation, &Errors::below}) {
        worst.*f = std::max(worst.*f, e.*f);
        mean.*f += e.*f / (kAlphas * kAngles);
      }
    }
    std::fprintf(stderr, "alpha %.4f: %s", alpha, lines[i][kAngles / 2].c_str());
  }
  std::fprintf(out,
               "// Written by bench/ltc_fit.cpp; do not edit. Rows of %d angles for each of %d alphas, as LtcTable has "
               "them:\n"
               "// width along x and y and skew, all over alpha, and the sine of the peak less that of the mirror "
               "direction.\n"
               "// Then the fit's errors: Kullback-Leibler divergence (nats), chi-square divergence, total variation, "
               "and\n"
               "// the share of the LTC below the horizon. Mean %.4f %.4f %.4f %.4f, worst %.4f %.4f %.4f %.4f.\n"
               "// clang-format off\n",
               kAngles, kAlphas, mean.divergence, mean.chi_square, mean.total_variation, mean.below, worst.divergence,
               worst.chi_square, worst.total_variation, worst.below);
  for (int i = 0; i < kAlphas; ++i) {
    for (int j = 0; j < kAngles; ++j) std::fputs(lines[i][j].c_str(), out);
  }
}

}  // namespace
}  // namespace lodestar

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: ltc_fit TABLE.inc\n");
    return 2;
  }
  std::FILE* const out = std::fopen(argv[1], "w");
  if (out == nullptr) {
    std::fprintf(stderr, "ltc_fit: cannot write %s\n", argv[1]);
    return 1;
  }
  lodestar::Fit(out);
  return std::fclose(out) == 0 ? 0 : 1;
}
