// What the SD-tree expects of a direction and of a pixel, by which roulette decides.
#include <gtest/gtest.h>

#include <cmath>

#include "core/tracing/sd_tree_guide.h"
#include "tests/guiding/synthetic.h"
#include "tests/statistical/small_scenes.h"
#include "tests/support/render.h"

namespace lodestar {
namespace {

// Of a product, the tree's density still says what arrives: the product's says what is reflected.
TEST(SdTreeRoulette, RadianceIsFluenceTimesTheTreesDensityAndAUniformShare) {
  const auto state = std::make_shared<const SdTreeState>(synthetic::Train({}, 5), PixelEstimate());
  const SdTree& tree = state->tree();
  const SdTreeGuide<false> plain(state, SdTreeMethod::Learn::kWeighted);
  const SdTreeGuide<true> product(state, SdTreeMethod::Learn::kWeighted);
  const Bsdf bsdf = Bsdf::Diffuse(Rgb(0.5f));
  uint64_t rng = 1;
  int others = 0;
  for (int i = 0; i < 200; ++i) {
    SurfaceInteraction si{};
    si.p = synthetic::Unit3(rng);
    si.shading = Frame::FromNormal(SquareToSphere(synthetic::Unit2(rng)));
    const Vec3 wo = SquareToCosineHemisphere(synthetic::Unit2(rng)), wi = SquareToSphere(synthetic::Unit2(rng));
    const auto by_tree = plain.At(si, bsdf, wo);
    const auto by_product = product.At(si, bsdf, wo);
    const uint32_t leaf = tree.LeafAt(si.p);
    ASSERT_GT(tree.leaf(leaf).mean_flux, 0);
    EXPECT_EQ(plain.Fluence(by_tree), tree.leaf(leaf).mean_flux);
    EXPECT_EQ(product.Fluence(by_product), tree.leaf(leaf).mean_flux);
    const float expected = tree.leaf(leaf).mean_flux * (0.9f * tree.Pdf(leaf, wi) + 0.1f * kUniformSpherePdf);
    EXPECT_NEAR(plain.Radiance(by_tree, wi, plain.Pdf(by_tree, wi)), expected, 1e-5f * expected);
    ASSERT_LT(by_product.bsdf_fraction, 1);
    const float product_pdf = product.Pdf(by_product, wi);
    EXPECT_NEAR(product.Radiance(by_product, wi, product_pdf), expected, 1e-5f * expected);
    others += std::fabs(product_pdf - tree.Pdf(leaf, wi)) > 0.1f * tree.Pdf(leaf, wi);
  }
  EXPECT_GT(others, 100);  // so that it shows whose density was taken
}

// One pixel of a picture that is not square is expected to be far brighter than its paths: they, and no others, are at
// stake.
TEST(SdTreeRoulette, APixelsPathsLookAtItsOwnEstimate) {
  constexpr uint32_t kWidth = 6, kHeight = 4, kX = 4, kY = 1;
  JobSpec job;
  job.method = "sdtree";
  job.budget.spp = 63;
  job.resolution_x = kWidth;
  job.resolution_y = kHeight;
  const CompiledJob compiled = CompileJob(ParsePbrtText(test::kSmallScenes[0].text, "test.pbrt", "."), job);
  const auto tree = SdTreeState::Parse(test::Render(compiled, job).state)->shared_tree();
  ASSERT_GT(tree->leaf(0).mean_flux, 0);
  for (const std::string roulette : {"throughput", "contribution", "pixel"}) {
    job.options["roulette"] = roulette;
    const auto method = MakeMethod(job, compiled.survey);
    const auto prepare = [&](float estimate) {
      PixelEstimate pixels{kWidth, kHeight, std::vector<float>(kWidth * kHeight, 1e-6f)};
      pixels.luminance[kY * kWidth + kX] = estimate;
      return PrepareTracer(compiled.scene, job, *method, std::make_shared<const SdTreeState>(tree, std::move(pixels)));
    };
    const auto dim = prepare(1e-6f), bright = prepare(1e6f);
    const Round round{.iteration = 5, .passes = 32, .unit_count = 1, .record = false};
    for (uint32_t y = 0; y < kHeight; ++y)
      for (uint32_t x = 0; x < kWidth; ++x) {
        int changed = 0;
        for (uint32_t pass = 0; pass < round.passes; ++pass)
          changed += !(dim->TraceSample(round, x, y, pass) == bright->TraceSample(round, x, y, pass));
        EXPECT_EQ(changed > 0, roulette == "pixel" && x == kX && y == kY) << roulette << " " << x << " " << y;
      }
  }
}

}  // namespace
}  // namespace lodestar
