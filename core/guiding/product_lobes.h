// What a surface scatters at one vertex, as product guiding sees it: cosine lobes in front and behind, and linearly
// transformed cosines for glossy reflections. Only the lobes' shape and share count; colours and Fresnel do not.
// Where wo is within 5 degrees of the horizon, glossy lobes count as cosine lobes (Diolatzis et al. 2020, section
// 3.2.3): their peak moves too fast, and the product was worse than the tree.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/guiding/ltc.h"

namespace lodestar {

struct ProductLobe {
  enum class Kind : uint8_t {
    kDiffuseReflection,    // on wo's side
    kGgxReflection,        // on wo's side, about the mirror direction
    kDiffuseTransmission,  // on the other side
  };
  Kind kind = Kind::kDiffuseReflection;
  float alpha = 1;   // of a GGX lobe; the geometric mean of an anisotropic one's
  float weight = 0;  // of the lobe's albedo, in any unit; not negative
};

class ProductLobes {
 public:
  static constexpr int kMaxGlossy = 3;
  // Lobes with a smaller share of the weight are left out: they cost as much as large ones.
  static constexpr float kLeastShare = 0.01f;
  // Of a glossy lobe's weight, given to a cosine lobe: a microfacet lobe's far tail reaches every direction above the
  // horizon, an LTC ends at a plane of its own; and what the tree blurs, a narrow lobe must not sharpen
  // (docs/decisions/0009-product-guiding.md).
  static constexpr float kTailShare = 0.1f;

  // wo in the frame's own (outer) space, of unit length; n on either side. More glossy lobes than kMaxGlossy: the
  // last ones count as diffuse. No weight, or one that is denormal or infinite: none() holds.
  ProductLobes(const Frame& frame, Vec3 wo, std::span<const ProductLobe> lobes);

  bool none() const { return glossy_count_ == 0 && !(diffuse_ > 0) && !(transmission_ > 0); }
  // The lobes' density per steradian. Glossy lobes are cut off at the horizon, so it integrates to 1 or slightly less.
  float Density(Vec3 w) const {
    const float cos = Dot(normal_, w);
    float sum = std::max(cos, 0.0f) * diffuse_ * kInvPi + std::max(-cos, 0.0f) * transmission_ * kInvPi;
    if (!(cos > 0)) return sum;
    for (int i = 0; i < glossy_count_; ++i) sum += weight_[i] * glossy_[i].Density(w);
    return sum;
  }

  // On wo's side.
  Vec3 normal() const { return normal_; }
  // Shares of all; they add up to 1.
  float diffuse() const { return diffuse_; }
  float transmission() const { return transmission_; }
  int glossy_count() const { return glossy_count_; }
  const Ltc& glossy(int i) const { return glossy_[i]; }
  float glossy_weight(int i) const { return weight_[i]; }

 private:
  Vec3 normal_;
  float diffuse_ = 0, transmission_ = 0;
  int glossy_count_ = 0;
  std::array<float, kMaxGlossy> weight_{};
  std::array<Ltc, kMaxGlossy> glossy_;
};

}  // namespace lodestar
