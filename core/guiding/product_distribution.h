// Sampling by the product of a D-tree and a surface's lobes (Diolatzis et al. 2020, section 3.1), prepared once per
// vertex and then asked for samples and densities any number of times.
//
// Deviations from the document, measured in docs/decisions/0009-product-guiding.md:
// - The product is not chosen level by level but summed up from the 8 x 8 cells of the third level, then within one
//   from the 4 x 4 cells of the fifth, and so once more where a narrow lobe has a good part of such a cell: light and
//   lobe that share a quarter of the sphere need not overlap. Below that the flux alone decides. What cells are looked
//   at depends on the lobes alone, also below the tree's own leaves, so Sample and Pdf agree on it.
// - Cells are integrated over by points (product_cells.h), not by their edges.
// - Every choice is mixed with the tree's own: whatever the errors of lobes and integrals,
//   Pdf(w) >= kLeastRatio * the tree's density.
#pragma once

#include "core/guiding/sd_tree.h"
#include "core/guiding/tree_top.h"

namespace lodestar {

class ProductDistribution {
 public:
  // Shares of the tree alone in the choice of the block's cell, and in each below it.
  static constexpr float kBlockDefence = 1.0f / 32, kPatchDefence = 1.0f / 16;
  static constexpr float kLeastRatio = kBlockDefence * kPatchDefence * kPatchDefence;

  // `nodes`: root first, SdTree::Tree(leaf); `top` is made from them. Both must stay valid.
  ProductDistribution(const DirectionalNode* nodes, const TreeTop& top, const ProductLobes& lobes);

  // False where the product vanishes: no lobes, or no flux on their side. Then sample the BSDF alone.
  bool usable() const { return usable_; }
  // The integral of lobes (of albedo 1) times the tree's density: times the albedo and the leaf's mean flux, an
  // estimate of the reflected radiance. At block resolution.
  float mass() const { return mass_; }
  // Within cells of this level the density is as even as the tree's.
  int finest_level() const;

  // usable() must hold. u in [0, 1)^2 with 24 bits. The density is Pdf(w), bit for bit.
  GuidedSample Sample(Vec2 u) const;
  // Per steradian, w of unit length; integrates to 1.
  float Pdf(Vec3 w) const;

 private:
  struct Step;
  float Locate(uint32_t x, uint32_t y) const;
  float Share(uint32_t cell) const { return product_[cell] * scale_ + top_->flux[cell] * kBlockDefence; }

  const DirectionalNode* nodes_;
  const TreeTop* top_;
  ProductLobes lobes_;
  bool usable_ = false;
  float mass_ = 0;
  float density_ = 0;  // of a cell whose share is 1
  float scale_ = 0;
  product::Block product_;
  alignas(32) std::array<float, product::kSide> columns_;  // running sums of shares over cos theta
};

}  // namespace lodestar
