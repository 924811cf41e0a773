// Which surfaces the radiance grid guides, on which side and how often, and from which step on.
#include "core/tracing/grid_guide.h"

#include <gtest/gtest.h>

#include "tests/guiding/grid_testing.h"

namespace lodestar {
namespace {

using grid_testing::kUnit;

const Vec3 kFront{0, 0, 1}, kBack{0, 0, -1};  // wo, in the shading frame

GridMethod::Options Options(uint32_t exploration) {
  GridMethod::Options options;
  options.grid.cells = 2;
  options.bsdf_fraction = 0.5f;
  options.exploration = exploration;
  return options;
}

SurfaceInteraction Surface() {
  SurfaceInteraction si{};
  si.p = {0.2f, 0.7f, 0.1f};
  si.shading = Frame::FromNormal(Normalize({0.2f, -0.3f, 0.9f}));
  return si;
}

// A guide that knows of light from everywhere.
class GridGuideAt : public testing::Test {
 protected:
  float Fraction(const Bsdf& bsdf, Vec3 wo) const { return guide_.At(si_, bsdf, wo).bsdf_fraction; }
  // Guided are `share` of the directions that the BSDF does not draw, on the normal's side or on the other.
  void ExpectGuided(const Bsdf& bsdf, Vec3 wo, float share, bool normals_side) const {
    const GridGuide::Local local = guide_.At(si_, bsdf, wo);
    EXPECT_NEAR(local.bsdf_fraction, 1 - 0.5f * share, 1e-5f);
    ASSERT_TRUE(local.at.usable);
    const Vec3 towards = normals_side ? si_.shading.n : -si_.shading.n;
    EXPECT_GT(guide_.Pdf(local, towards), 0);
    EXPECT_EQ(guide_.Pdf(local, -towards), 0);
  }

  const SurfaceInteraction si_ = Surface();
  const GridGuide guide_{grid_testing::Train(Options(1).grid, kUnit, 20000), Options(1)};
};

TEST_F(GridGuideAt, DiffuseSurfacesOnTheSideThatIsSeen) {
  for (const Rgb reflectance : {Rgb(0.5f), Rgb(0.01f)}) {
    ExpectGuided(Bsdf::Diffuse(reflectance), kFront, 1, true);
    ExpectGuided(Bsdf::Diffuse(reflectance), kBack, 1, false);
  }
}

// Diolatzis et al. 2020: from an alpha of 0.5 on, by the sharper axis.
TEST_F(GridGuideAt, GgxLobesByTheirRoughness) {
  const auto metal = [](Vec2 alpha) { return Bsdf::Conductor(Rgb(0.2f), Rgb(3), alpha); };
  for (const Vec2 alpha : {Vec2{0.5f, 0.5f}, Vec2{0.51f, 0.51f}, Vec2{0.51f, 0.9f}}) {
    ExpectGuided(metal(alpha), kFront, 1, true);
    ExpectGuided(metal(alpha), kBack, 1, false);
  }
  for (const Vec2 alpha : {Vec2{0.49f, 0.49f}, Vec2{0.49f, 0.9f}, Vec2{0.9f, 0.49f}, Vec2{0, 0}})
    EXPECT_EQ(Fraction(metal(alpha), kFront), 1) << alpha.x << ' ' << alpha.y;
}

TEST_F(GridGuideAt, UnderACoatTheBasesShare) {
  constexpr float kHeadOn = 0.04f;  // what an interface of index 1.5 reflects
  const Bsdf flat = Bsdf::CoatedDiffuse(Rgb(0.5f), 1.5f, {0, 0});
  const float base = 1 - kHeadOn / Luminance(flat.Albedo(kFront));
  ASSERT_GT(base, 0.8f);
  ExpectGuided(flat, kFront, base, true);
  // A rough coat counts where it is rough enough.
  const Bsdf sharp = Bsdf::CoatedDiffuse(Rgb(0.5f), 1.5f, {0.3f, 0.3f});
  EXPECT_GT(Fraction(sharp, kFront), 0.505f);
  EXPECT_LT(Fraction(sharp, kFront), 0.6f);
  ExpectGuided(Bsdf::CoatedDiffuse(Rgb(0.5f), 1.5f, {0.6f, 0.6f}), kFront, 1, true);
}

TEST_F(GridGuideAt, TranslucentSurfacesOnTheSideOfTheGreaterShare) {
  const Bsdf mostly_through = Bsdf::DiffuseTransmission(Rgb(0.2f), Rgb(0.6f)),
             mostly_back = Bsdf::DiffuseTransmission(Rgb(0.6f), Rgb(0.2f));
  ExpectGuided(mostly_through, kFront, 0.75f, false);
  ExpectGuided(mostly_through, kBack, 0.75f, true);
  ExpectGuided(mostly_back, kFront, 0.75f, true);
  ExpectGuided(mostly_back, kBack, 0.75f, false);
  ExpectGuided(Bsdf::DiffuseTransmission(Rgb(0), Rgb(0.6f)), kFront, 1, false);
}

// However rough glass is, what it refracts is not diffuse: no more is guided than it reflects.
TEST_F(GridGuideAt, GlassAndMirrorsAreTheBsdfs) {
  for (const Vec3 wo : {kFront, kBack}) {
    EXPECT_EQ(Fraction(Bsdf::Dielectric(1.5f, {0.3f, 0.3f}), wo), 1);
    EXPECT_EQ(Fraction(Bsdf::Dielectric(1.5f, {0, 0}), wo), 1);
    EXPECT_EQ(Fraction(Bsdf::ThinDielectric(1.5f), wo), 1);
  }
  ExpectGuided(Bsdf::Dielectric(1.5f, {0.6f, 0.6f}), kFront, 0.04f, true);
}

TEST(GridGuide, StepsOfExplorationAreNotGuided) {
  const SurfaceInteraction si = Surface();
  const Bsdf diffuse = Bsdf::Diffuse(Rgb(0.5f));
  for (const uint32_t exploration : {0u, 1u, 2u, 3u}) {
    auto grid = RadianceGrid::Initial(kUnit, Options(exploration).grid);
    for (uint32_t step = 0; step < 5; ++step) {
      ASSERT_EQ(grid->iteration(), step);
      const GridGuide guide(grid, Options(exploration));
      // Nothing is known before the first step.
      const bool guided = step >= std::max(exploration, 1u);
      EXPECT_EQ(guide.At(si, diffuse, kFront).bsdf_fraction, guided ? 0.5f : 1.0f) << step << " of " << exploration;
      grid = Advance(*grid, grid_testing::Recorded(grid, kUnit, 100 + step, 20000));
    }
  }
}

}  // namespace
}  // namespace lodestar
