// What roulette makes of what a guide expects: at the vertices of a room, and of a path that has left a guided vertex
// through glass.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/scene/pbrt_parser.h"
#include "core/tracing/path_kernel.h"
#include "tests/tracing/cosine_guide.h"
#include "tests/tracing/trace_paths.h"

namespace lodestar {
namespace {

// Expects the same radiance along every direction, and has another fluence at vertices that face up than at others.
struct KnowingGuide : CosineGuide {
  float radiance, fluence_of_floor, fluence_of_roof;
  float Fluence(const Local& at) const { return at.frame.n.y > 0 ? fluence_of_floor : fluence_of_roof; }
  float Radiance(const Local&, Vec3, float) const { return radiance; }
};

struct Outcome {
  double mean = 0, standard_error = 0;  // of a sample
  int ended = 0, strengthened = 0;      // vertices after which roulette did so
  float strongest = 1;
};
// A dark floor behind a window, below a sky of radiance 1; pixels are expected to have a radiance of 1.
template <class Guide>
Outcome Trace(const Guide& guide, uint64_t seed) {
  const auto scene = Scene::Compile(ParsePbrtText(R"(Film "rgb" "integer xresolution" [8] "integer yresolution" [8]
LookAt 0 3 -2  0 0 0  0 1 0
Camera "perspective" "float fov" [20]
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
Material "diffuse" "rgb reflectance" [0.03 0.03 0.03]
AttributeBegin Rotate -90 1 0 0 Shape "disk" "float radius" [9] AttributeEnd
Material "dielectric"
Shape "trianglemesh" "point3 P" [-9 1 -9  9 1 -9  9 1 9  -9 1 9] "integer indices" [0 2 1 0 3 2]
Shape "trianglemesh" "point3 P" [-9 2 -9  9 2 -9  9 2 9  -9 2 9] "integer indices" [0 1 2 0 2 3]
)",
                                                  "window.pbrt", "."));
  const PathSettings settings{.max_depth = 16, .next_event = NextEvent::kNone, .roulette = Roulette::kPixel};
  const PathKernel<kRecord | kEnvironment | kSpecular, Guide> kernel(*scene, settings, guide);
  Outcome outcome;
  double sum = 0, squares = 0, count = 0;
  TracePaths(*scene, kernel, {.width = 8, .height = 8, .passes = 2000, .seed = seed, .pixel = 1},
             [&](Rgb radiance, const auto& path) {
               const double sample = Luminance(radiance);
               sum += sample;
               squares += sample * sample;
               ++count;
               for (const PathVertex& vertex : path) {
                 outcome.ended += vertex.roulette == 0;
                 outcome.strengthened += vertex.roulette > 1;
                 outcome.strongest = std::max(outcome.strongest, vertex.roulette);
               }
             });
  outcome.mean = sum / count;
  outcome.standard_error = std::sqrt((squares / count - outcome.mean * outcome.mean) / count);
  return outcome;
}

TEST(KernelRoulette, GlassEndsNoPathThatTheGuideExpectsMuchOf) {
  const Outcome outcome = Trace(KnowingGuide{{}, 1e12f, 1, 1}, 1);
  EXPECT_EQ(outcome.ended, 0);
  EXPECT_EQ(outcome.strengthened, 0);
}

TEST(KernelRoulette, WhatWasExpectedBeforeGlassHoldsBehindIt) {
  const Outcome outcome = Trace(KnowingGuide{{}, 1e-3f, 1, 1}, 1);
  EXPECT_GT(outcome.ended, 1000);
  EXPECT_EQ(outcome.strongest, 1 / kLeastSurvival);
}

TEST(KernelRoulette, TheMeanIsThatOfOtherExpectations) {
  const Outcome unknown = Trace(CosineGuide{}, 1);
  for (const float radiance : {1e-3f, 0.3f, 1e12f}) {
    const Outcome known = Trace(KnowingGuide{{}, radiance, 1, 1}, 2);
    EXPECT_NEAR(known.mean, unknown.mean, 4.5 * std::hypot(known.standard_error, unknown.standard_error)) << radiance;
  }
}

constexpr float kFloor = 0.5f, kRoof = 0.8f;  // albedos, below

// How many of the vertices of a depth roulette let go on, and with which weights.
struct Survival {
  int vertices = 0, survivors = 0;
  float least = kInfinity, most = 0;
};
// Between two disks so large that paths go up and down: at even depths they are on the floor.
std::array<Survival, 4> TraceRoom(const PathSettings& settings, float pixel, const KnowingGuide& guide) {
  const auto scene = Scene::Compile(ParsePbrtText(R"(Film "rgb" "integer xresolution" [8] "integer yresolution" [8]
LookAt 0 1 -2  0 0 0  0 1 0
Camera "perspective" "float fov" [20]
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
AttributeBegin Rotate -90 1 0 0 Shape "disk" "float radius" [9] AttributeEnd
Material "diffuse" "rgb reflectance" [0.8 0.8 0.8]
AttributeBegin Translate 0 2 0 Rotate 90 1 0 0 Shape "disk" "float radius" [9] AttributeEnd
)",
                                                  "room.pbrt", "."));
  const PathKernel<kRecord | kEnvironment, KnowingGuide> kernel(*scene, settings, guide);
  std::array<Survival, 4> depths;
  TracePaths(*scene, kernel, {.width = 8, .height = 8, .passes = 200, .pixel = pixel}, [&](Rgb, const auto& path) {
    for (size_t depth = 0; depth < std::min(path.size(), depths.size()); ++depth) {
      const PathVertex& vertex = path[depth];
      if (!vertex.recorded) continue;
      Survival& survival = depths[depth];
      ++survival.vertices;
      if (vertex.roulette == 0) continue;
      ++survival.survivors;
      survival.least = std::min(survival.least, vertex.roulette);
      survival.most = std::max(survival.most, vertex.roulette);
    }
  });
  return depths;
}

void ExpectSurvival(const Survival& survival, double expected) {
  ASSERT_GT(survival.vertices, 500);
  for (const float weight : {survival.least, survival.most}) EXPECT_NEAR(weight, 1 / expected, 1e-3 / expected);
  EXPECT_NEAR(static_cast<double>(survival.survivors) / survival.vertices, expected,
              4.5 * std::sqrt(expected * (1 - expected) / survival.vertices));
}

// With no estimate of the pixel, what the first vertex reflects of its fluence: albedo * fluence / 2 pi.
TEST(KernelRoulette, TheFirstVertexSaysWhatIsExpected) {
  const KnowingGuide guide{{}, 0.6f, 20 * kPi, 7};  // the roof's fluence comes second and does not count
  const PathSettings settings{.next_event = NextEvent::kNone, .roulette_start = 1, .roulette = Roulette::kContribution};
  const auto depths = TraceRoom(settings, 123, guide);
  constexpr double kStake = double{kWindow} * kFloor * 10;
  const double first = kFloor * 0.6 / kStake, second = kFloor * kRoof * 0.6 / first / kStake,
               third = kFloor * kRoof * kFloor * 0.6 / (first * second) / kStake;
  ExpectSurvival(depths[0], first);  // 0.6, 0.8, 0.5
  ExpectSurvival(depths[1], second);
  ExpectSurvival(depths[2], third);
}

// One that knows nothing is passed over, and what has been lost up to the next counts there.
TEST(KernelRoulette, TheFirstVertexThatKnowsSaysWhatIsExpected) {
  const KnowingGuide guide{{}, 0.6f, 0, 20 * kPi};
  const PathSettings settings{.next_event = NextEvent::kNone, .roulette_start = 2, .roulette = Roulette::kContribution};
  const auto depths = TraceRoom(settings, 123, guide);
  constexpr double kExpected = double{kFloor} * kRoof * 10;
  ExpectSurvival(depths[1], kFloor * kRoof * 0.6 / (kWindow * kExpected));  // 0.6
}

TEST(KernelRoulette, LooksAtWhatItsOptionSays) {
  const KnowingGuide guide{{}, 0.6f, 20 * kPi, 20 * kPi};
  struct Case {
    Roulette roulette;
    float pixel;
    double survival;
  };
  for (const Case& c : {Case{Roulette::kThroughput, 4, kFloor}, Case{Roulette::kContribution, 4, 0.6},
                        Case{Roulette::kPixel, 4, kFloor * 0.6 / (kWindow * 4)}, Case{Roulette::kPixel, 0, 0.6}}) {
    SCOPED_TRACE(static_cast<int>(c.roulette));
    const PathSettings settings{.next_event = NextEvent::kNone, .roulette_start = 1, .roulette = c.roulette};
    ExpectSurvival(TraceRoom(settings, c.pixel, guide)[0], c.survival);
  }
}

}  // namespace
}  // namespace lodestar
