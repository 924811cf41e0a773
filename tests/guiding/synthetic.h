// A light field with a known answer: over the unit cube, two lobes whose directions and widths drift with the position,
// on a dim ground. Trains a tree in it as a renderer would, with the mixture of a cosine-like "BSDF" (uniform sphere
// here) and the tree.
#pragma once

#include <functional>
#include <vector>

#include "core/guiding/sd_tree_advance.h"
#include "core/math/sampler.h"

namespace lodestar::synthetic {

inline float Unit(uint64_t& state) {
  state += 0x9e3779b97f4a7c15ULL;
  return Sampler::ToUnit(static_cast<uint32_t>(Mix64(state) >> 32));
}
inline Vec2 Unit2(uint64_t& state) {
  const float x = Unit(state);
  return {x, Unit(state)};
}
inline Vec3 Unit3(uint64_t& state) {
  const Vec2 xy = Unit2(state);
  return {xy.x, xy.y, Unit(state)};
}
inline Bounds3 UnitCube() {
  return {{0, 0, 0}, {1, 1, 1}};
}

using Field = std::function<float(Vec3 position, Vec3 direction)>;

inline float MovingLobes(Vec3 p, Vec3 w) {
  const Vec3 a = Normalize(Vec3{p.x * 2 - 1, p.y * 2 - 1, 0.7f}),
             b = Normalize(Vec3{0.4f, p.z - 0.5f, p.x * p.y - 0.9f});
  const auto lobe = [&](Vec3 axis, float kappa) { return kappa * Exp(kappa * (Dot(axis, w) - 1)) * (0.5f * kInvPi); };
  return 0.02f + lobe(a, 40 + 200 * p.z) + 0.5f * lobe(b, 400);
}

struct Training {
  SdTreeOptions options;
  Field field = MovingLobes;
  float scale = 1;  // of the radiance
  uint64_t seed = 1;
  int first_records = 20000;  // of iteration 0; doubled each time
};

inline SdTreeRecord MakeRecord(const SdTree& tree, const Field& field, float scale, uint64_t& rng) {
  SdTreeRecord r;
  r.position = Unit3(rng);
  r.leaf = tree.LeafAt(r.position);
  const float alpha = tree.BsdfFraction(r.leaf);
  if (Unit(rng) < alpha) {
    r.direction = SquareToSphere(Unit2(rng));
    r.tree_pdf = tree.Pdf(r.leaf, r.direction);
  } else {
    const GuidedSample s = tree.Sample(r.leaf, Unit2(rng));
    r.direction = s.w;
    r.tree_pdf = s.pdf;
  }
  r.bsdf_pdf = kUniformSpherePdf;
  r.pdf = alpha * r.bsdf_pdf + (1 - alpha) * r.tree_pdf;
  r.radiance = scale * field(r.position, r.direction);
  r.product = r.radiance * kUniformSpherePdf;
  r.relative = r.product / scale;  // pixels are as bright as the field
  return r;
}

inline std::vector<SdTreeRecord> MakeRecords(const SdTree& tree, const Field& field, float scale, uint64_t seed,
                                             size_t count) {
  std::vector<SdTreeRecord> records(count);
  uint64_t rng = Mix64(seed);
  for (SdTreeRecord& r : records) r = MakeRecord(tree, field, scale, rng);
  return records;
}

inline std::shared_ptr<const SdTree> Train(const Training& training, int iterations) {
  auto tree = SdTree::Initial(UnitCube(), training.options);
  for (int k = 0; k < iterations; ++k) {
    SdTreeStatistics statistics(tree);
    const size_t count = static_cast<size_t>(training.first_records) << k;
    statistics.Record(MakeRecords(*tree, training.field, training.scale, training.seed + k, count),
                      training.seed * 77 + k);
    tree = Advance(*tree, statistics, 4.0 * (1 << k));
  }
  return tree;
}

}  // namespace lodestar::synthetic
