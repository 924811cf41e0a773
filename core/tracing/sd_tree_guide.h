// The SD-tree as a guide, and what a path tells the next one. With kProduct, directions come from the product of tree
// and BSDF (Diolatzis et al. 2020).
#pragma once

#include <optional>
#include <span>
#include <type_traits>
#include <variant>
#include <vector>

#include "core/guiding/product_distribution.h"
#include "core/learning/sd_tree_guiding.h"
#include "core/tracing/guide.h"

namespace lodestar {

// The BSDF's lobes at wo (in the shading frame), in the space of the positions.
ProductLobes MakeProductLobes(const SurfaceInteraction& si, const Bsdf& bsdf, Vec3 wo);

template <bool kProduct>
class SdTreeGuide {
 public:
  static constexpr bool kGuides = true, kRecords = true, kUsesAlpha = false, kDefersDensities = false;
  struct Local {
    float bsdf_fraction = 1, nee_probability = 1;
    uint32_t leaf = 0;
    LightGroupWeights lights{};
    std::conditional_t<kProduct, std::optional<ProductDistribution>, std::monostate> product{};
  };
  using Scratch = std::vector<SdTreeRecord>;

  SdTreeGuide(std::shared_ptr<const SdTreeState> state, SdTreeMethod::Learn learn)
      : state_(std::move(state)), tree_(state_->tree()), learn_(learn) {
    if constexpr (kProduct) {
      tops_.reserve(tree_.leaf_count());
      for (uint32_t leaf = 0; leaf < tree_.leaf_count(); ++leaf) tops_.emplace_back(tree_.Tree(leaf));
    }
  }

  Local At(const SurfaceInteraction& si, const Bsdf& bsdf, Vec3 wo) const {
    Local local;
    local.leaf = tree_.LeafAt(si.p);
    const SdTreeLeaf& leaf = tree_.leaf(local.leaf);
    if (leaf.learned) {
      local.bsdf_fraction = leaf.bsdf_fraction;
      tree_.Prefetch(local.leaf);  // comes in while the light sample and its ray are made
    }
    local.nee_probability = leaf.nee_probability;
    local.lights = tree_.Lights(local.leaf);
    if constexpr (kProduct) {
      // Where light is refracted as well, lobes of the reflection alone would send the guide the wrong way
      // (docs/decisions/0009-product-guiding.md): there the tree guides without them.
      if (leaf.learned && bsdf.kind() != Bsdf::Kind::kDielectric) {
        const TreeTop& top = tops_[local.leaf];
        top.Prefetch();
        local.product.emplace(tree_.Tree(local.leaf), top, MakeProductLobes(si, bsdf, wo));
        // No light where the BSDF scatters to: the BSDF alone, as the document has it at the root.
        if (!local.product->usable()) local.bsdf_fraction = 1;
      }
    }
    return local;
  }
  GuidedSample Sample(const Local& local, Vec2 u, float) const {
    if constexpr (kProduct) {
      if (local.product) return local.product->Sample(u);
    }
    return tree_.Sample(local.leaf, u);
  }
  float Pdf(const Local& local, Vec3 wi) const {
    if constexpr (kProduct) {
      if (local.product) return local.product->Pdf(wi);
    }
    return tree_.Pdf(local.leaf, wi);
  }
  // As the kernel sees them at a vertex of this leaf: 1 and 0 where nothing is learned yet.
  float BsdfFraction(uint32_t leaf) const { return tree_.HasLearned(leaf) ? tree_.leaf(leaf).bsdf_fraction : 1; }
  float TreePdf(uint32_t leaf, Vec3 wi) const { return tree_.HasLearned(leaf) ? tree_.Pdf(leaf, wi) : 0; }
  float Fluence(const Local& local) const { return tree_.leaf(local.leaf).mean_flux; }
  float Radiance(const Local& local, Vec3 wi, float guide_pdf) const {
    constexpr float kDefensive = 0.1f;  // of uniform density, which bounds what a wrong tree can cost
    return Fluence(local) * Lerp(kDefensive, kProduct ? tree_.Pdf(local.leaf, wi) : guide_pdf, kUniformSpherePdf);
  }
  float PixelLuminance(uint32_t x, uint32_t y) const {
    return state_->pixels().empty() ? 0.0f : state_->pixels().At(x, y);
  }

  void Record(std::span<const PathVertex> vertices, const PixelSample& sample, Scratch* records,
              Statistics* statistics) const;

 private:
  std::shared_ptr<const SdTreeState> state_;
  const SdTree& tree_;
  SdTreeMethod::Learn learn_;
  std::vector<TreeTop> tops_;  // of the leaves' trees; with kProduct
};

}  // namespace lodestar
