// The learned share of BSDF sampling, alpha in p = alpha p_bsdf + (1 - alpha) p_tree, in a form that merges over
// workers (docs/decisions/0003-bsdf-fraction.md). Instead of stepping alpha, each record adds the gradient of the loss
// (Mueller 2019, section 10.5) at eight fixed alphas to exact sums; both losses are convex in alpha, so the gradients'
// sign change brackets the optimum.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "core/base/bytes.h"
#include "core/guiding/sd_tree_options.h"
#include "core/math/exact_sum.h"

namespace lodestar {

// Off 0, so that what the BSDF alone can reach keeps a weight of at most 20; off 1, so that the tree keeps learning
// from its own samples.
inline constexpr float kMinBsdfFraction = 0.05f, kMaxBsdfFraction = 0.95f;

inline constexpr int kFractionGrid = 8;
// Evenly spaced in logit(alpha): the optimum matters most in ratio near the ends.
inline constexpr std::array<double, kFractionGrid> kFractionAlphas = {0.05, 0.11, 0.22, 0.40, 0.60, 0.78, 0.89, 0.95};

// Sums of one spatial leaf. Each gradient is rounded to 2^-30 and clamped to +-2^20 (in units of the scaled record,
// whose mean is about 1), then added as an integer. Adding 1.5 * 2^52 to a double leaves the rounded integer in its low
// bits, biased by a constant; the two halves of those bits are summed apart, so that 2^31 records fit, and `count`
// takes the bias off again.
struct FractionSums {
  std::array<uint64_t, kFractionGrid> low{}, high{};
  ExactSum weight;     // sum of the records' own weights: scales the prior
  uint64_t count = 0;  // gradients added

  // product: lum(f cos L), scaled; pdf: of the mixture that was sampled. All finite, pdf > 0, product > 0.
  void Add(SdTreeOptions::BsdfFractionLoss loss, float product, float pdf, float bsdf_pdf, float tree_pdf) {
    double ratio = static_cast<double>(product) / pdf;
    double factor = 1;
    if (loss == SdTreeOptions::BsdfFractionLoss::kVariance) {
      ratio *= ratio;
      factor = pdf;
    }
    ratio = ratio < kClamp ? ratio : kClamp;
    if (!weight.Add(static_cast<float>(ratio))) return;
    ++count;
    const double difference = static_cast<double>(bsdf_pdf) - tree_pdf;
    const bool squared = loss == SdTreeOptions::BsdfFractionLoss::kVariance;
    for (int i = 0; i < kFractionGrid; ++i) {
      const double inverse = 1 / (tree_pdf + kFractionAlphas[i] * difference);
      double gradient = -ratio * difference * inverse * (squared ? factor * inverse : 1.0);
      gradient = gradient < kClamp ? gradient : kClamp;
      gradient = gradient > -kClamp ? gradient : -kClamp;
      const uint64_t bits = std::bit_cast<uint64_t>(gradient * 0x1p30 + kMagic);
      low[i] += bits & 0xffffffff;
      high[i] += bits >> 32;
    }
  }

  void Merge(const FractionSums& other) {
    for (int i = 0; i < kFractionGrid; ++i) {
      low[i] += other.low[i];
      high[i] += other.high[i];
    }
    weight.Merge(other.weight);
    count += other.count;
  }

  // The exact sum of gradients at kFractionAlphas[i], in units of 2^-30.
  __int128 GradientUnits(int i) const {
    const __int128 biased = (static_cast<__int128>(high[i]) << 32) + low[i];
    return biased - static_cast<__int128>(std::bit_cast<uint64_t>(kMagic)) * count;
  }
  // Inverse of GradientUnits for the current count.
  void SetGradientUnits(int i, __int128 units) {
    const __int128 biased = units + static_cast<__int128>(std::bit_cast<uint64_t>(kMagic)) * count;
    low[i] = static_cast<uint64_t>(biased) & 0xffffffff;
    high[i] = static_cast<uint64_t>(biased >> 32);
  }

  void Write(ByteWriter& out) const;
  // Fails the reader (Error kCorrupt).
  static FractionSums Read(ByteReader& in);

 private:
  static constexpr double kClamp = 0x1p20;
  static constexpr double kMagic = 0x1.8p52;
};

// How many records the previous fraction of a leaf or cell counts as.
inline constexpr double kFractionPriorRecords = 64;

// The minimiser of the summed loss plus a prior that counts as `prior_records` records which found `previous` to be
// right; `previous` where no record has a weight.
float SolveBsdfFraction(const FractionSums& sums, float previous, double prior_records);

}  // namespace lodestar
