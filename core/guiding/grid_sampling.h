// Directions by a radiance grid: the five rules of Kim 2022, chapter 5, each with its density in solid angle. Immutable
// but for what it remembers of places already met, which cannot show in a result.
//
// On the sphere the table is sampled as it is. On the hemisphere about a normal it is sampled times the cosine: the
// product with a diffuse BSDF. Its form there:
//
// - Exact (default): the table is gathered into the square of a hemisphere (grid_hemisphere.h) of the cell of normals
//   that n lies in, and the square is turned to n itself. It is this table that is sampled, and this table's sum that
//   normalises it, so the density is exact although the gathering is made once for all normals of a cell. The even
//   distribution u of the document is here the cosine-weighted one.
// - Memo: the document's. The density is radiance(w) cos / N with N, and the rejection's bound, remembered for the
//   middle of a cell of normals and summed over the middles of the table's cells. It does not integrate to one: images
//   are biased. For rejection only.
#pragma once

#include <memory>
#include <optional>

#include "core/guiding/grid_chain.h"
#include "core/guiding/grid_hemisphere.h"
#include "core/guiding/grid_memo.h"
#include "core/guiding/grid_square.h"
#include "core/guiding/radiance_grid.h"
#include "core/guiding/sd_tree.h"

namespace lodestar {

struct GridRules {
  enum class Sampling : uint8_t {
    kInversionSphere,
    kInversionHemisphere,
    kRejection,
    kRejectionMixed,  // of (1 - e) p + e u
    kMetropolis,
  };
  static constexpr float kDocumentsMix = -1;  // e = max((1 - 2 c) / (2 - 2 c), 0), c the acceptance rate (eq. 5.2)

  Sampling sampling = Sampling::kInversionHemisphere;
  bool memo = false;  // of rejection only
  float mix = 0.2f;   // e; measured to be better than the document's (decisions/0011)

  bool on_sphere() const { return sampling == Sampling::kInversionSphere; }
};

class GridSampling {
 public:
  // Entries that are remembered, of a kilobyte at 16 directions; beyond, they are computed at each vertex.
  static constexpr uint32_t kMostRemembered = 1 << 15;

  struct Product {
    float mean = 0;                    // radiance: over the sphere, or cosine-weighted over the hemisphere
    std::optional<GridSquare> square;  // what is sampled; nothing where the mean is zero
    std::vector<float> target;         // of the chain
  };
  struct Sums {  // of radiance times cosine over the middles of the sphere's cells
    float integral, greatest;
  };
  // What is known at one point.
  struct Local {
    bool usable = false;               // false: no radiance on the side of the normal, sample otherwise
    const Product* product = nullptr;  // null with a memo
    Frame frame{};                     // of the normal, on the hemisphere
    uint32_t cell = 0;                 // the rest: with a memo
    float mix = 0;
    Sums sums{};
    std::unique_ptr<const Product> own;
  };

  GridSampling(std::shared_ptr<const RadianceGrid> grid, const GridRules& rules);

  Local At(uint32_t cell, Vec3 n) const;
  // u and u_more in [0, 1), with 24 bits. Local must be usable.
  GuidedSample Sample(const Local& local, Vec2 u, float u_more) const;
  // Per steradian; w of unit length. Zero below the surface, but on the sphere.
  float Pdf(const Local& local, Vec3 w) const;

  // The radiance that a diffuse surface would see, whose normal is of that cell of normals (the stratified sum of
  // expected SARSA, divided by its BSDF).
  float MeanRadiance(uint32_t cell, uint32_t normal) const;

  const RadianceGrid& grid() const { return *grid_; }
  const GridRules& rules() const { return rules_; }

 private:
  static constexpr uint32_t kMostDirections = 2 * 32 * 32;

  static constexpr uint32_t kSphere = GridHemispheres::kNormals;  // in place of a cell of normals

  const Product* ProductAt(uint32_t cell, uint32_t normal, std::unique_ptr<const Product>* own) const;
  Product MakeProduct(uint32_t cell, uint32_t normal) const;
  Sums MakeSums(uint32_t cell, uint32_t direction) const;
  Vec3 Reject(const Local& local, GridRandom random, Vec2 fallback) const;
  Vec3 RejectByMemo(const Local& local, GridRandom random) const;

  std::shared_ptr<const RadianceGrid> grid_;
  GridRules rules_;
  const GridHemispheres& hemispheres_;
  GridMemo<Product, GridHemispheres::kNormals + 1> products_;
  GridMemo<Sums, kMostDirections> sums_;
};

inline float GridSampling::Pdf(const Local& local, Vec3 w) const {
  if (rules_.on_sphere()) return local.product->square->Density(DirectionToCylindrical(w)) * kUniformSpherePdf;
  const Vec3 in_frame = local.frame.ToLocal(w);
  if (!(in_frame.z > 0)) return 0;
  if (rules_.memo) {
    const float p = grid_->Radiance(local.cell, grid_->DirectionAt(w)) * in_frame.z / local.sums.integral;
    return (1 - local.mix) * p + local.mix * (0.5f * kInvPi);
  }
  return local.product->square->Density(DirectionToHemisphere(in_frame)) * (in_frame.z * kInvPi);
}

}  // namespace lodestar
