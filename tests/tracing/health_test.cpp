// Samples that are not numbers one can add, made by a guide whose densities are wrong on half of a floor: each kind is
// counted, none enters the film, and the first that is reported comes again when it is traced alone.
#include <gtest/gtest.h>

#include "core/tracing/path_tracer.h"
#include "tests/support/render.h"

namespace lodestar {
namespace {

// Draws as a diffuse surface does. Where x > 0 its densities are those of `fault`.
struct FaultyGuide {
  static constexpr bool kGuides = true, kRecords = false, kDefersDensities = false;
  HealthEvent fault;

  struct Local {
    float bsdf_fraction = 0.5f, nee_probability = 1;
    LightGroupWeights lights{};
    Frame frame;
    bool faulty;
  };
  struct Scratch {};
  bool WrongWhereTheBsdfDrew() const { return fault == HealthEvent::kNan || fault == HealthEvent::kNegative; }
  Local At(const SurfaceInteraction& si, const Bsdf&, Vec3) const {
    Local local{.frame = si.shading, .faulty = si.p.x > 0};
    // The BSDF's own density would hide a small one of the guide.
    if (local.faulty && !WrongWhereTheBsdfDrew()) local.bsdf_fraction = 0;
    return local;
  }
  GuidedSample Sample(const Local& local, Vec2 u, float) const {
    const Vec3 w = SquareToCosineHemisphere(u);
    float pdf = CosineHemispherePdf(w.z);
    if (local.faulty && fault == HealthEvent::kZeroPdf) pdf = 0;
    if (local.faulty && fault == HealthEvent::kInfinite) pdf = 1e-40f;
    if (local.faulty && fault == HealthEvent::kClamped) pdf = 1e-25f;
    return {local.frame.ToWorld(w), pdf};
  }
  float Pdf(const Local& local, Vec3 wi) const {
    if (local.faulty && fault == HealthEvent::kNan) return NAN;
    if (local.faulty && fault == HealthEvent::kNegative) return -1;
    return CosineHemispherePdf(local.frame.ToLocal(wi).z);
  }
  float Fluence(const Local&) const { return 0; }
  float Radiance(const Local&, Vec3, float) const { return 0; }
  float PixelLuminance(uint32_t, uint32_t) const { return 0; }
};

// Every sample is the albedo.
constexpr float kAlbedo = 0.5f;
constexpr const char* kFloor = R"(Film "rgb" "integer xresolution" [24] "integer yresolution" [24]
PixelFilter "box"
LookAt 0 3 0  0 0 0  0 0 1
Camera "perspective" "float fov" [30]
WorldBegin
LightSource "infinite"
Shape "trianglemesh" "point3 P" [-9 0 -9  9 0 -9  9 0 9  -9 0 9] "integer indices" [0 2 1 0 3 2]
)";

class TracedHealth : public testing::TestWithParam<HealthEvent> {};

bool Offends(Rgb sample) {
  return !(std::fabs(sample.g - kAlbedo) < 1e-4f);
}

// What the kernel makes of such a density.
bool Is(HealthEvent event, Rgb sample) {
  switch (event) {
    case HealthEvent::kNan:
      return std::isnan(sample.g);
    case HealthEvent::kInfinite:
      return std::isinf(sample.g);
    case HealthEvent::kNegative:
      return sample.g < 0;
    case HealthEvent::kZeroPdf:
      return IsBlack(sample);  // the path ended there
    default:
      return std::isfinite(sample.g) && std::isinf(sample.g * sample.g);  // too bright for a sum of squares
  }
}

TEST_P(TracedHealth, IsCountedKeptOutAndReplayed) {
  const CompiledJob compiled = CompileJob(ParsePbrtText(kFloor, "test.pbrt", "."), JobSpec{});
  const PathSettings settings{.max_depth = 1, .next_event = NextEvent::kNone, .roulette = Roulette::kThroughput};
  const PathTracer<FaultyGuide> tracer(compiled.scene, 5, settings, FaultyGuide{GetParam()});
  const Round round{.iteration = 2, .first_pass = 7, .passes = 3, .unit_count = 4, .record = false};
  Contribution contribution;
  for (uint32_t unit = 0; unit < round.unit_count; ++unit)
    ASSERT_TRUE(tracer.Execute(round, unit, StopToken(), &contribution));

  uint64_t offenders = 0;
  HealthReport::Offender first;
  for (uint32_t pass = round.first_pass; pass < round.first_pass + round.passes; ++pass)
    for (uint32_t y = 0; y < 24; ++y)
      for (uint32_t x = 0; x < 24; ++x) {
        const Rgb sample = tracer.TraceSample(round, x, y, pass);
        if (!Offends(sample)) continue;
        EXPECT_TRUE(Is(GetParam(), sample)) << sample.g;
        if (offenders++ == 0) first = {x, y, pass, GetParam(), round.iteration};
      }
  // Half of the floor; of what is drawn there, half by the BSDF.
  const double share = FaultyGuide{GetParam()}.WrongWhereTheBsdfDrew() ? 0.25 : 0.5;
  EXPECT_NEAR(static_cast<double>(offenders), share * 3 * 24 * 24, 80);

  const HealthReport& health = contribution.health;
  EXPECT_EQ(health.counts[static_cast<size_t>(GetParam())], offenders);
  EXPECT_EQ(health.total(), offenders);
  EXPECT_EQ(health.first.pass, first.pass);
  EXPECT_EQ(health.first.pixel_x, first.pixel_x);
  EXPECT_EQ(health.first.pixel_y, first.pixel_y);
  EXPECT_EQ(health.first.event, GetParam());
  EXPECT_EQ(health.first.iteration, round.iteration);
  EXPECT_TRUE(Is(GetParam(), tracer.TraceSample(round, health.first.pixel_x, health.first.pixel_y, health.first.pass)));

  double healthy = 0;
  for (const FilmTile& tile : contribution.tiles)
    for (const PixelSum& sum : tile.pixels) {
      EXPECT_TRUE(std::isfinite(sum.g) && std::isfinite(sum.luminance_squared) && sum.g >= 0);
      if (sum.g < 1e6f) healthy += sum.g;
    }
  if (GetParam() != HealthEvent::kClamped) {
    EXPECT_NEAR(healthy, kAlbedo * static_cast<double>(3 * 24 * 24 - offenders), 0.1);
  }
}

INSTANTIATE_TEST_SUITE_P(Of, TracedHealth,
                         testing::Values(HealthEvent::kNan, HealthEvent::kInfinite, HealthEvent::kNegative,
                                         HealthEvent::kZeroPdf, HealthEvent::kClamped),
                         [](const auto& info) { return std::string(HealthEventName(info.param)); });

}  // namespace
}  // namespace lodestar
