// What product guiding is measured against: the document's product without optimisation, its Monte Carlo product
// (Diolatzis et al. 2020, sections 3.1 and 4), and the variance of an estimator that samples by any of them beside the
// BSDF.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "core/guiding/product_distribution.h"
#include "core/scene/microfacet.h"
#include "tests/guiding/synthetic.h"

namespace lodestar::product_baselines {

// A surface without colour or Fresnel: what the lobes of product guiding stand for.
class Surface {
 public:
  Surface(const Frame& frame, Vec3 wo, std::vector<ProductLobe> lobes)
      : frame_(frame), wo_(wo), local_(frame.ToLocal(wo)), lobes_(std::move(lobes)) {
    if (local_.z < 0) {
      frame_ = {-frame.s, frame.t, -frame.n};
      local_ = frame_.ToLocal(wo);
    }
    float sum = 0;
    for (const ProductLobe& lobe : lobes_) sum += lobe.weight;
    for (ProductLobe& lobe : lobes_) lobe.weight /= sum;
  }

  ProductLobes Lobes() const { return {frame_, wo_, lobes_}; }

  struct Value {
    float f_cos = 0, pdf = 0;  // pdf: of SampleBsdf
  };
  Value Evaluate(Vec3 w) const {
    const Vec3 wi = frame_.ToLocal(w);
    Value value;
    for (const ProductLobe& lobe : lobes_) {
      if (lobe.kind == ProductLobe::Kind::kGgxReflection) {
        if (!(wi.z > 0)) continue;
        const GgxReflection r = EvaluateMirrored(Ggx{{lobe.alpha, lobe.alpha}}, local_, wi);
        value.f_cos += lobe.weight * r.value;
        value.pdf += lobe.weight * r.pdf;
      } else {
        const float cos = lobe.kind == ProductLobe::Kind::kDiffuseReflection ? wi.z : -wi.z;
        value.f_cos += lobe.weight * std::max(cos, 0.0f) * kInvPi;
        value.pdf += lobe.weight * std::max(cos, 0.0f) * kInvPi;
      }
    }
    return value;
  }
  Vec3 SampleBsdf(float u_lobe, Vec2 u) const {
    size_t i = 0;
    for (; i + 1 < lobes_.size() && u_lobe >= lobes_[i].weight; ++i) u_lobe -= lobes_[i].weight;
    Vec3 wi = SquareToCosineHemisphere(u);
    if (lobes_[i].kind == ProductLobe::Kind::kGgxReflection) {
      const Vec3 m = Ggx{{lobes_[i].alpha, lobes_[i].alpha}}.SampleVisible(local_, u);
      wi = Normalize(m * (2 * Dot(local_, m)) - local_);
    } else if (lobes_[i].kind == ProductLobe::Kind::kDiffuseTransmission) {
      wi.z = -wi.z;
    }
    return frame_.ToWorld(wi);
  }

 private:
  Frame frame_;
  Vec3 wo_, local_;
  std::vector<ProductLobe> lobes_;
};

// Descends a tree by child probabilities that `weights(node, level, x, y)` gives, child by child.
template <class Weights>
GuidedSample SampleTree(const DirectionalNode* nodes, Vec2 u, const Weights& weights) {
  uint32_t node = 0, x = 0, y = 0;
  int level = 0;
  float density = kUniformSpherePdf;
  do {
    const std::array<float, 4> p = weights(node, level, x, y);
    const float left = p[0] + p[2];
    const uint32_t bx = u.x >= left;
    u.x = bx ? (u.x - left) / (1 - left) : u.x / left;
    const float lower = p[bx] / (p[bx] + p[bx + 2]);
    const uint32_t by = u.y >= lower;
    u.y = by ? (u.y - lower) / (1 - lower) : u.y / lower;
    const uint32_t c = bx + 2 * by;
    density *= 4 * p[c];
    x = 2 * x + bx, y = 2 * y + by, ++level;
    node = nodes[node].child[c];
  } while (node != 0);
  const float size = std::ldexp(1.0f, -level);
  const auto at = [&](uint32_t i, float t) {
    return std::min((static_cast<float>(i) + std::clamp(t, 0.0f, kOneMinusEpsilon)) * size, kOneMinusEpsilon);
  };
  return {CylindricalToDirection({at(x, u.x), at(y, u.y)}), density};
}
template <class Weights>
float PdfOfTree(const DirectionalNode* nodes, Vec3 w, const Weights& weights) {
  const Vec2 square = DirectionToCylindrical(w);
  const uint32_t ix = directional::ToInteger(square.x), iy = directional::ToInteger(square.y);
  uint32_t node = 0;
  int level = 0;
  float density = kUniformSpherePdf;
  do {
    const int shift = directional::kBits - level;
    const uint32_t c = ((ix >> (shift - 1)) & 1) + 2 * ((iy >> (shift - 1)) & 1);
    density *= 4 * weights(node, level, ix >> shift, iy >> shift)[c];
    node = nodes[node].child[c];
    ++level;
  } while (node != 0);
  return density;
}
// P_k = D_k F_k / sum; where all vanish, the flux.
inline std::array<float, 4> Product(const DirectionalNode& node, const std::array<float, 4>& d) {
  std::array<float, 4> p;
  float sum = 0;
  for (uint32_t c = 0; c < 4; ++c) sum += p[c] = node.Probability(c) * d[c];
  for (uint32_t c = 0; c < 4; ++c) p[c] = sum > 0 ? p[c] / sum : node.Probability(c);
  return p;
}

// The document's algorithm 1: four integrals at each level, one after the other, polygons clipped at the horizon,
// nothing precomputed. Parallels get a corner every 45 degrees.
class NaiveProduct {
 public:
  NaiveProduct(const DirectionalNode* nodes, const ProductLobes& lobes) : nodes_(nodes), lobes_(lobes) {}

  GuidedSample Sample(Vec2 u) const {
    return SampleTree(nodes_, u, [&](auto... at) { return Weights(at...); });
  }
  float Pdf(Vec3 w) const {
    return PdfOfTree(nodes_, w, [&](auto... at) { return Weights(at...); });
  }

 private:
  std::array<float, 4> Weights(uint32_t node, int level, uint32_t x, uint32_t y) const {
    std::array<float, 4> d;
    for (uint32_t c = 0; c < 4; ++c) d[c] = Integral(level + 1, 2 * x + (c & 1), 2 * y + (c >> 1));
    return Product(nodes_[node], d);
  }
  float Integral(int level, uint32_t x, uint32_t y) const {
    std::array<Vec3, 16> corners;
    int count = 0;
    const float size = std::ldexp(1.0f, -level);
    const int parts = level < 3 ? 8 >> level : 1;
    const auto add = [&](uint32_t i, float t) {
      corners[count++] =
          CylindricalToDirection({std::min(static_cast<float>(i) * size, 1.0f), (static_cast<float>(y) + t) * size});
    };
    for (int i = 0; i <= parts; ++i) add(x, static_cast<float>(i) / static_cast<float>(parts));
    for (int i = parts; i >= 0; --i) add(x + 1, static_cast<float>(i) / static_cast<float>(parts));
    const auto row = [](Vec3 a, Vec3 b, Vec3 c) { return std::array<Vec3, 3>{a, b, c}; };
    const Frame cosine = Frame::FromNormal(lobes_.normal());
    float sum = 0;
    if (lobes_.diffuse() > 0) sum += lobes_.diffuse() * Clipped(corners, count, row(cosine.s, cosine.t, cosine.n));
    if (lobes_.transmission() > 0)
      sum += lobes_.transmission() * Clipped(corners, count, row(cosine.t, cosine.s, -cosine.n));
    for (int i = 0; i < lobes_.glossy_count(); ++i) {
      const Ltc& ltc = lobes_.glossy(i);
      sum += lobes_.glossy_weight(i) * Clipped(corners, count, row(ltc.x(), ltc.y(), ltc.z()));
    }
    return sum;
  }
  static float Clipped(const std::array<Vec3, 16>& corners, int count, const std::array<Vec3, 3>& m) {
    std::array<Vec3, 24> above;
    int n = 0;
    const auto at = [&](int i) { return Vec3{Dot(m[0], corners[i]), Dot(m[1], corners[i]), Dot(m[2], corners[i])}; };
    Vec3 from = at(count - 1);
    for (int i = 0; i < count; ++i) {
      const Vec3 to = at(i);
      if ((from.z >= 0) != (to.z >= 0)) above[n++] = Normalize(from * std::fabs(to.z) + to * std::fabs(from.z));
      if (to.z >= 0) above[n++] = Normalize(to);
      from = to;
    }
    float sum = 0;
    for (int i = 0; i < n; ++i) {
      const Vec3 a = above[i], b = above[(i + 1) % n], cross = Cross(a, b);
      const float length = Length(cross);
      if (length > 0) sum += std::acos(std::clamp(Dot(a, b), -1.0f, 1.0f)) * cross.z / length;
    }
    return std::max(sum * 0.5f * kInvPi, 0.0f);
  }

  const DirectionalNode* nodes_;
  const ProductLobes& lobes_;
};

// `samples` of the BSDF in a tree of the same structure, and 5 % of their energy over all the sphere.
class MonteCarloProduct {
 public:
  MonteCarloProduct(const DirectionalNode* nodes, uint32_t node_count, const Surface& surface, int samples,
                    uint64_t seed)
      : nodes_(nodes), mass_(node_count * 4, 0.0f) {
    uint64_t rng = Mix64(seed);
    for (int i = 0; i < samples; ++i) {
      const float u_lobe = synthetic::Unit(rng);
      const Vec3 w = surface.SampleBsdf(u_lobe, synthetic::Unit2(rng));
      mass_[directional::Locate(nodes, DirectionToCylindrical(w)).slot] += 1 / static_cast<float>(samples);
    }
    for (uint32_t node = node_count; node-- > 0;) {
      for (uint32_t c = 0; c < 4; ++c) {
        const uint32_t child = nodes[node].child[c];
        if (child == 0) continue;
        for (uint32_t i = 0; i < 4; ++i) mass_[node * 4 + c] += mass_[child * 4 + i];
      }
    }
  }
  GuidedSample Sample(Vec2 u) const {
    return SampleTree(nodes_, u, [&](auto... at) { return Weights(at...); });
  }
  float Pdf(Vec3 w) const {
    return PdfOfTree(nodes_, w, [&](auto... at) { return Weights(at...); });
  }

 private:
  std::array<float, 4> Weights(uint32_t node, int level, uint32_t, uint32_t) const {
    std::array<float, 4> d;
    for (uint32_t c = 0; c < 4; ++c) d[c] = mass_[node * 4 + c] + std::ldexp(0.05f, -2 * (level + 1));
    return Product(nodes_[node], d);
  }

  const DirectionalNode* nodes_;
  std::vector<float> mass_;
};

// The flux alone.
class FluxOnly {
 public:
  explicit FluxOnly(const DirectionalNode* nodes) : nodes_(nodes) {}
  GuidedSample Sample(Vec2 u) const {
    const auto point = directional::Sample(nodes_, u);
    return {CylindricalToDirection(point.square), point.density};
  }
  float Pdf(Vec3 w) const { return directional::Locate(nodes_, DirectionToCylindrical(w)).density; }

 private:
  const DirectionalNode* nodes_;
};

// E[(f L cos / p)^2] / E[f L cos / p]^2 - 1 of one sample, p = fraction p_bsdf + (1 - fraction) p_guide, for each of
// the fractions; by `samples` of the mixture of half and half.
template <class Guide, class Radiance>
std::vector<double> RelativeVariance(const Surface& surface, const Guide& guide, const Radiance& radiance,
                                     std::span<const float> fractions, int samples, uint64_t seed) {
  std::vector<double> second(fractions.size());
  double first = 0;
  uint64_t rng = Mix64(seed);
  for (int i = 0; i < samples; ++i) {
    const float u_lobe = synthetic::Unit(rng);
    const Vec2 u = synthetic::Unit2(rng);
    const Vec3 w = i % 2 ? surface.SampleBsdf(u_lobe, u) : guide.Sample(u).w;
    const Surface::Value value = surface.Evaluate(w);
    const double by_guide = guide.Pdf(w), p = 0.5 * value.pdf + 0.5 * by_guide;
    const double product = value.f_cos * radiance(w);
    if (!(product > 0)) continue;
    first += product / p;
    for (size_t k = 0; k < fractions.size(); ++k)
      second[k] += product * product / (fractions[k] * value.pdf + (1 - fractions[k]) * by_guide) / p;
  }
  for (double& s : second) s = s / samples * samples * samples / (first * first) - 1;
  return second;
}

}  // namespace lodestar::product_baselines
