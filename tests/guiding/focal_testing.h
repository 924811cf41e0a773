// Fields to test with: a room with a small ball of light, learned in as a renderer would, and octrees made by hand.
#pragma once

#include <functional>
#include <vector>

#include "core/guiding/focal_advance.h"
#include "core/math/sampler.h"

namespace lodestar::focal_testing {

// SplitMix64, as tests/support's; here, so that bench/ needs no more than this header.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  uint64_t Next() { return Mix64(state_ += 0x9e3779b97f4a7c15ULL); }
  float Next1D() { return Sampler::ToUnit(static_cast<uint32_t>(Next() >> 32)); }
  Vec2 Next2D() {
    const float x = Next1D();
    return {x, Next1D()};
  }

 private:
  uint64_t state_;
};

inline Vec3 PointIn(const Bounds3& box, Random& random) {
  const Vec2 u = random.Next2D();
  return box.min + Vec3{u.x, u.y, random.Next1D()} * box.Diagonal();
}
inline Vec3 UniformDirection(Random& random) {
  for (;;) {
    const Vec2 u = random.Next2D();
    const Vec3 d = Vec3{u.x, u.y, random.Next1D()} * 2 - Vec3{1, 1, 1};
    if (LengthSquared(d) <= 1 && LengthSquared(d) > 1e-4f) return Normalize(d);
  }
}

// The distance to a ball, or infinity.
inline float BallDistance(Vec3 x, Vec3 w, Vec3 center, float radius) {
  const Vec3 to = center - x;
  const float along = Dot(to, w), square = radius * radius - (LengthSquared(to) - along * along);
  if (square < 0 || along < 0) return kInfinity;
  return std::max(along - std::sqrt(square), 1e-6f * along);
}

// Of a box, from inside.
inline float WallDistance(Vec3 x, Vec3 w, const Bounds3& box) {
  float t = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    if (w[axis] > 0) t = std::min(t, (box.max[axis] - x[axis]) / w[axis]);
    if (w[axis] < 0) t = std::min(t, (box.min[axis] - x[axis]) / w[axis]);
  }
  return std::max(t, 1e-12f * MaxComponent(box.Diagonal()));
}

struct Training {
  FocalOptions options;
  Bounds3 box{{0, 0, 0}, {1, 1, 1}};
  Vec3 light{0.3f, 0.7f, 0.6f};         // in the box's coordinates
  float radius = 0.02f;                 // in the box's longest sides
  float emission = 1, ambient = 1e-4f;  // the ball's and the walls' radiance
  uint64_t seed = 1;
  int records = 20000;  // an iteration
};

// Segments from anywhere; half the directions uniform, half from the field once it has learned.
inline FocalRecord MakeRecord(const FocalField& field, const Training& training, Random& random) {
  const float longest = MaxComponent(training.box.Diagonal());
  const Vec3 light = training.box.min + training.light * training.box.Diagonal();
  FocalRecord r;
  r.position = PointIn(training.box, random);
  const bool guided = field.HasLearned() && random.Next1D() < 0.5f;
  const FocalSample sample = field.Sample(r.position, random.Next2D());
  r.direction = guided ? sample.w : UniformDirection(random);
  r.guide_pdf = field.Pdf(r.position, r.direction);
  r.bsdf_pdf = kInvPi / 4;
  r.pdf = field.HasLearned() ? 0.5f * r.bsdf_pdf + 0.5f * r.guide_pdf : r.bsdf_pdf;
  const float wall = WallDistance(r.position, r.direction, training.box);
  const float ball = BallDistance(r.position, r.direction, light, training.radius * longest);
  r.distance = std::min(wall, ball);
  r.value = training.emission * (ball < wall ? 1 : training.ambient) / r.pdf;
  return r;
}

inline FocalStatistics Recorded(std::shared_ptr<const FocalField> field, const Training& training, uint64_t seed,
                                int records) {
  FocalStatistics statistics(field);
  Random random(seed);
  for (int i = 0; i < records; ++i) statistics.Record(MakeRecord(*field, training, random));
  return statistics;
}

inline std::shared_ptr<const FocalField> Train(const Training& training, uint32_t iterations) {
  auto field = FocalField::Initial(training.box, training.options);
  for (uint32_t k = 0; k < iterations; ++k)
    field = Advance(*field, Recorded(field, training, training.seed * 1000 + k, training.records));
  return field;
}

// A field over `box` whose octree has random shape and masses: nodes split at random down to `depth`, deepest along
// one path; a quarter of the voxels has no mass, the others' vary over `decades` powers of ten.
inline std::shared_ptr<const FocalField> RandomField(const Bounds3& box, int depth, uint64_t seed, float decades = 4,
                                                     bool diverging = false) {
  FocalOptions options;
  options.diverging = diverging;
  FocalParts parts = PartsOf(*FocalField::Initial(box, options));
  Random random(seed);
  for (FocalParts::Octree& octree : parts.octrees) {
    octree = {};
    std::vector<int> levels = {1};
    bool deepest = true;  // the first node of each level goes on
    for (size_t i = 0; i < levels.size(); ++i) {
      const int level = levels[i];
      uint8_t inner = 0;
      const bool forced = deepest && (i == 0 || levels[i - 1] < level);
      for (int c = 0; c < 8; ++c) {
        const bool split = level < depth &&
                           ((forced && c == static_cast<int>(seed % 8)) || random.Next1D() < (level < 3 ? 0.7f : 0.1f));
        if (split) {
          inner |= static_cast<uint8_t>(1 << c);
          levels.push_back(level + 1);
        } else {
          const float mass = static_cast<float>(std::pow(10.0, -decades * random.Next1D()));
          octree.leaf_masses.push_back(random.Next1D() < 0.25f ? 0 : mass);
        }
      }
      octree.inner.push_back(inner);
    }
    double total = 0;
    for (const float mass : octree.leaf_masses) total += mass;
    total *= static_cast<double>(parts.octrees.size());
    for (float& mass : octree.leaf_masses) mass = static_cast<float>(mass / total);
  }
  parts.weight = 1;
  return std::make_shared<const FocalField>(std::move(parts));
}

// The same integral by the book: recursively, in double, voxel by voxel. Calls visit(slot, t0, t1, density) too.
template <class Visit>
void WalkNaively(const FocalOctree& octree, uint32_t index, std::array<double, 3> lower, double size, const double* x,
                 const double* w, double t_end, Visit&& visit) {
  const double half = size / 2;
  for (int c = 0; c < 8; ++c) {
    std::array<double, 3> corner;
    double t0 = 0, t1 = t_end;
    for (int axis = 0; axis < 3; ++axis) {
      corner[axis] = lower[axis] + (((c >> axis) & 1) ? half : 0);
      if (w[axis] == 0) {
        if (x[axis] < corner[axis] || x[axis] >= corner[axis] + half) t1 = -1;
        continue;
      }
      const double a = (corner[axis] - x[axis]) / w[axis], b = (corner[axis] + half - x[axis]) / w[axis];
      t0 = std::max(t0, std::min(a, b));
      t1 = std::min(t1, std::max(a, b));
    }
    if (!(t0 < t1)) continue;
    const FocalOctree::Node& node = octree.node(index);
    if ((node.inner >> c) & 1) {
      WalkNaively(octree, node.Child(c), corner, half, x, w, t_end, visit);
    } else {
      visit(index * 8 + static_cast<uint32_t>(c), t0, t1, node.density[c]);
    }
  }
}

inline double NaivePdf(const FocalField& field, Vec3 x, Vec3 w) {
  const Vec3 from = field.ToUnit(x);
  double sum = 0, volume = 1;
  for (int axis = 0; axis < 3; ++axis) volume *= double{field.sides()[axis]} / field.longest_side();
  for (size_t i = 0; i < field.octrees().size(); ++i) {
    double origin[3], direction[3];
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis] = from[axis];
      direction[axis] = double{w[axis]} * field.longest_side() / field.sides()[axis] * (i == 1 ? -1 : 1);
    }
    WalkNaively(field.octrees()[i], 0, {0, 0, 0}, 1, origin, direction, 1e30,
                [&](uint32_t, double t0, double t1, float density) {
                  sum += density * (t1 - t0) * (t1 * t1 + t1 * t0 + t0 * t0);
                });
  }
  return sum / (3 * volume * field.mass());
}

}  // namespace lodestar::focal_testing
