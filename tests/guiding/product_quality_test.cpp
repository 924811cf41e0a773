// What product guiding is for: less variance than the tree alone, and than the Monte Carlo product.
#include <gtest/gtest.h>

#include "tests/guiding/product_baselines.h"
#include "tests/guiding/product_cases.h"

namespace lodestar {
namespace {

using namespace product_baselines;
using enum ProductLobe::Kind;

// A room: a window, a lamp, a patch of sun on the floor.
float Room(Vec3 w) {
  float radiance = 0.3f + 0.2f * w.z;
  if (w.x > 0.5f && w.z > 0.1f && w.z < 0.6f && std::fabs(w.y) < 0.4f) radiance += 8;
  if (w.y < -0.8f && w.z > 0 && w.z < 0.4f) radiance += 3;
  if (w.z < -0.5f && w.x < 0) radiance += 0.6f;
  return radiance;
}

TEST(ProductQuality, HalvesTheVarianceOfTheTree) {
  const auto tree = product_cases::Learn(Room, 6, 50000);
  const DirectionalNode* const nodes = tree.nodes.data();
  const TreeTop top(nodes);
  const std::vector<std::vector<ProductLobe>> materials = {
      {{kDiffuseReflection, 1, 1}},
      {{kGgxReflection, 0.1f, 1}},
      {{kGgxReflection, 0.4f, 1}},
      {{kDiffuseReflection, 1, 0.6f}, {kGgxReflection, 0.2f, 0.4f}},
      {{kDiffuseReflection, 1, 0.5f}, {kDiffuseTransmission, 1, 0.5f}},
  };
  constexpr std::array<float, 5> kFractions = {0.02f, 0.1f, 0.3f, 0.5f, 0.8f};  // of BSDF samples; the best counts
  for (size_t m = 0; m < materials.size(); ++m) {
    double by_tree = 0, by_product = 0, by_naive = 0, by_monte_carlo = 0;
    uint64_t rng = 5;
    for (int i = 0; i < 16; ++i) {
      const Frame frame = Frame::FromNormal(SquareToSphere(synthetic::Unit2(rng)));
      const Vec3 wo = frame.ToWorld(SquareToCosineHemisphere(synthetic::Unit2(rng)));
      const Surface surface(frame, wo, materials[m]);
      const ProductLobes lobes = surface.Lobes();
      const ProductDistribution product(nodes, top, lobes);
      ASSERT_TRUE(product.usable());
      const auto variance = [&](const auto& guide) {
        const auto found = RelativeVariance(surface, guide, Room, kFractions, 2000, i);
        return std::log(std::max(*std::min_element(found.begin(), found.end()), 1e-4)) / 16;
      };
      by_tree += variance(FluxOnly(nodes));
      by_product += variance(product);
      by_naive += variance(NaiveProduct(nodes, lobes));
      by_monte_carlo += variance(MonteCarloProduct(nodes, static_cast<uint32_t>(tree.nodes.size()), surface, 64, i));
    }
    const bool two_sided = m == 4;  // nothing lies below its horizon
    EXPECT_LT(std::exp(by_product - by_tree), two_sided ? 0.8 : 0.5) << m;
    EXPECT_LT(std::exp(by_product - by_naive), 1.0) << m;
    EXPECT_LT(std::exp(by_product - by_monte_carlo), 0.5) << m;
  }
}

// The estimate of what is reflected, which comes for free.
TEST(ProductQuality, MassEstimatesTheReflectedRadiance) {
  const auto tree = product_cases::Learn(Room, 6, 50000);
  const TreeTop top(tree.nodes.data());
  double flux = 0;
  uint64_t rng = 2;
  constexpr int kSamples = 200000;
  for (int i = 0; i < kSamples; ++i) flux += Room(SquareToSphere(synthetic::Unit2(rng))) / kUniformSpherePdf / kSamples;
  for (int i = 0; i < 10; ++i) {
    const Frame frame = Frame::FromNormal(SquareToSphere(synthetic::Unit2(rng)));
    const Vec3 wo = frame.ToWorld(SquareToCosineHemisphere(synthetic::Unit2(rng)));
    const Surface surface(frame, wo, {{kDiffuseReflection, 1, 1}});
    double reflected = 0;
    for (int k = 0; k < 20000; ++k) reflected += Room(surface.SampleBsdf(0, synthetic::Unit2(rng))) / 20000;
    const ProductDistribution product(tree.nodes.data(), top, surface.Lobes());
    EXPECT_NEAR(product.mass() * flux / reflected, 1, 0.15);
  }
}

}  // namespace
}  // namespace lodestar
