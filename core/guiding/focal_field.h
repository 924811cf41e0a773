// Where light converges in space: pinholes, foci of lenses and mirrors, small and indirect lights (Rath et al. 2023,
// "Focal Path Guiding for Light Transport Simulation"; Sadek 2025). An immutable state: every worker of an iteration
// samples from the same bits and records into FocalStatistics; Advance() makes the next one.
//
// The density lies over the scene's box, a little enlarged, each side at least an eighth of the longest: so flat scenes
// have a volume, and voxels no extreme shape. Directions and densities are in the space of the positions; densities per
// steradian. With FocalOptions::diverging a second octree holds the places that directions come from: its ray runs
// backwards. The two are one mixture and share one mass.
#pragma once

#include <memory>

#include "core/guiding/focal_octree.h"
#include "core/guiding/focal_options.h"
#include "core/guiding/guide_box.h"

namespace lodestar {

struct FocalSample {
  Vec3 w;
  float pdf;  // solid angle; exactly what Pdf() returns for w
};

// The pieces of a state; FocalField's constructor checks that they fit together.
struct FocalParts {
  FocalOptions options;
  GuideBox box;
  uint32_t iteration = 0;
  float radiance_scale = 1;  // a power of two
  double weight = 0;         // what was recorded so far, decayed: the masses' common factor; 0: nothing learned yet
  struct Octree {
    std::vector<uint8_t> inner;
    std::vector<float> leaf_masses;
  };
  std::vector<Octree> octrees;   // converging, and diverging where the options say so
  std::vector<float> fractions;  // of BSDF sampling, by cell; one for all where it is not learned
};

class FocalField {
 public:
  static constexpr int kFractionCells = 8;  // along each side

  // Uniform. Throws Error(kInvalidInput) for bounds that are empty or not finite, or bad options.
  static std::shared_ptr<const FocalField> Initial(const Bounds3& bounds, const FocalOptions& options);
  explicit FocalField(FocalParts parts);

  // u in [0, 1)^2 with 24 bits. u.x chooses the voxel; the point within it comes from a hash of both.
  FocalSample Sample(Vec3 x, Vec2 u) const {
    const Vec3 w = Direction(x, u);
    return {w, Pdf(x, w)};
  }
  // What Sample() draws, without its density, which is most of the work.
  Vec3 Direction(Vec3 x, Vec2 u) const;
  // w of unit length. Zero where no voxel of any mass lies on the whole ray to the box's edge.
  float Pdf(Vec3 x, Vec3 w) const {
    float sum = octrees_[0].Integrate(RayOf(x, w));
    if (octrees_.size() > 1) sum += octrees_[1].Integrate(RayOf(x, -w));
    return sum * pdf_scale_;
  }

  uint32_t CellAt(Vec3 x) const;
  float BsdfFraction(Vec3 x) const { return fractions_.size() == 1 ? fractions_[0] : fractions_[CellAt(x)]; }
  bool HasLearned() const { return weight_ > 0; }

  // In the octrees' coordinates: the parameter is in units of the longest side.
  FocalRay RayOf(Vec3 x, Vec3 w) const { return {ToUnit(x), w * stretch_}; }
  Vec3 ToUnit(Vec3 x) const { return (x - corner_) * per_side_; }
  float longest_side() const { return longest_; }
  Bounds3 bounds() const { return {corner_, corner_ + sides_}; }
  // Share of the mass per share of the volume, so 1 on average.
  float RelativeDensity(float density) const { return density / static_cast<float>(mass_); }

  const FocalOptions& options() const { return options_; }
  uint32_t iteration() const { return iteration_; }
  float radiance_scale() const { return radiance_scale_; }
  double weight() const { return weight_; }
  double mass() const { return mass_; }
  std::span<const FocalOctree> octrees() const { return octrees_; }
  std::span<const float> fractions() const { return fractions_; }
  Vec3 corner() const { return corner_; }
  Vec3 sides() const { return sides_; }
  size_t memory() const;
  // A hash of the content, for telling states apart; not a content address.
  uint64_t fingerprint() const { return fingerprint_; }

  // Canonical: equal fields have equal bytes.
  Bytes Serialize() const;
  // Throws Error(kCorrupt) for anything but what Serialize() wrote.
  static std::shared_ptr<const FocalField> Parse(std::string_view bytes);

 private:
  FocalOptions options_;
  Vec3 corner_, sides_;
  Vec3 per_side_;  // 1 / sides
  Vec3 stretch_;   // longest side / sides
  Vec3 shape_;     // sides / longest side
  float longest_;
  uint32_t iteration_;
  float radiance_scale_;
  double weight_, mass_ = 0;
  float pdf_scale_;
  std::vector<FocalOctree> octrees_;
  std::vector<float> fractions_;
  uint64_t fingerprint_;
};

// The pieces of a field, as they would be given to make it again.
FocalParts PartsOf(const FocalField& field);

}  // namespace lodestar
