// Where the product of tree and BSDF guides, and where the tree does alone.
#include <gtest/gtest.h>

#include "core/tracing/sd_tree_guide.h"
#include "tests/guiding/synthetic.h"

namespace lodestar {
namespace {

class ProductGuide : public testing::Test {
 protected:
  static SurfaceInteraction At(Vec3 p, uint64_t& rng) {
    SurfaceInteraction si{};
    si.p = p;
    si.shading = Frame::FromNormal(SquareToSphere(synthetic::Unit2(rng)));
    return si;
  }

  std::shared_ptr<const SdTree> tree_ = synthetic::Train({}, 5);
  SdTreeGuide<true> guide_{std::make_shared<const SdTreeState>(tree_, PixelEstimate()), SdTreeMethod::Learn::kWeighted};
};

// Its lobes know of no refraction: without it the guide would look for light where little is scattered to.
TEST_F(ProductGuide, RoughGlassIsGuidedByTheTree) {
  uint64_t rng = 1;
  for (const float alpha : {0.1f, 0.6f}) {
    const Bsdf glass = Bsdf::Dielectric(1.5f, {alpha, alpha});
    for (int i = 0; i < 200; ++i) {
      const SurfaceInteraction si = At(synthetic::Unit3(rng), rng);
      const auto local = guide_.At(si, glass, SquareToSphere(synthetic::Unit2(rng)));
      ASSERT_LT(local.bsdf_fraction, 1);
      const Vec2 u = synthetic::Unit2(rng);
      const GuidedSample sample = guide_.Sample(local, u, 0);
      EXPECT_EQ(sample.pdf, tree_->Sample(local.leaf, u).pdf);
      EXPECT_EQ(sample.pdf, guide_.Pdf(local, sample.w));
      const Vec3 wi = SquareToSphere(synthetic::Unit2(rng));
      EXPECT_EQ(guide_.Pdf(local, wi), tree_->Pdf(local.leaf, wi));
    }
  }
}

TEST_F(ProductGuide, OtherSurfacesAreGuidedByTheProduct) {
  uint64_t rng = 2;
  for (int i = 0; i < 200; ++i) {
    const SurfaceInteraction si = At(synthetic::Unit3(rng), rng);
    const Vec3 wo = SquareToCosineHemisphere(synthetic::Unit2(rng));
    const auto local = guide_.At(si, Bsdf::Diffuse(Rgb(0.5f)), wo);
    ASSERT_LT(local.bsdf_fraction, 1);
    const GuidedSample sample = guide_.Sample(local, synthetic::Unit2(rng), 0);
    EXPECT_EQ(sample.pdf, guide_.Pdf(local, sample.w));
    // Directly behind the surface, what the product leaves to the tree.
    EXPECT_LT(guide_.Pdf(local, -si.shading.n), 0.5f * tree_->Pdf(local.leaf, -si.shading.n));
  }
}

}  // namespace
}  // namespace lodestar
