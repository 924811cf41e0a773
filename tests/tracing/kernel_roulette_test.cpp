// What roulette makes of a path that has left a guided vertex through glass.
#include <gtest/gtest.h>

#include <cmath>

#include "core/scene/pbrt_parser.h"
#include "core/tracing/path_kernel.h"
#include "tests/tracing/cosine_guide.h"

namespace lodestar {
namespace {

struct ExpectingGuide : CosineGuide {
  float radiance = 0;
  float Fluence(const Local&) const { return 1; }
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
  std::vector<PathVertex> path;
  PathCounters counters;
  for (uint32_t y = 0; y < 8; ++y)
    for (uint32_t x = 0; x < 8; ++x)
      for (uint32_t pass = 0; pass < 2000; ++pass) {
        Sampler sampler(seed, x, y, pass);
        const Vec2 u = sampler.Next2D();
        const CameraRay ray = scene->camera().Generate({float(x) + u.x, float(y) + u.y}, {});
        const double sample = Luminance(kernel.Trace(ray, 1, sampler, &counters, &path));
        sum += sample;
        squares += sample * sample;
        ++count;
        for (const PathVertex& vertex : path) {
          outcome.ended += vertex.roulette == 0;
          outcome.strengthened += vertex.roulette > 1;
          outcome.strongest = std::max(outcome.strongest, vertex.roulette);
        }
      }
  outcome.mean = sum / count;
  outcome.standard_error = std::sqrt((squares / count - outcome.mean * outcome.mean) / count);
  return outcome;
}

TEST(KernelRoulette, GlassEndsNoPathThatTheGuideExpectsMuchOf) {
  const Outcome outcome = Trace(ExpectingGuide{{}, 1e12f}, 1);
  EXPECT_EQ(outcome.ended, 0);
  EXPECT_EQ(outcome.strengthened, 0);
}

TEST(KernelRoulette, WhatWasExpectedBeforeGlassHoldsBehindIt) {
  const Outcome outcome = Trace(ExpectingGuide{{}, 1e-3f}, 1);
  EXPECT_GT(outcome.ended, 1000);
  EXPECT_EQ(outcome.strongest, 1 / kLeastSurvival);
}

TEST(KernelRoulette, TheMeanIsThatOfOtherExpectations) {
  const Outcome unknown = Trace(CosineGuide{}, 1);
  for (const float radiance : {1e-3f, 0.3f, 1e12f}) {
    const Outcome known = Trace(ExpectingGuide{{}, radiance}, 2);
    EXPECT_NEAR(known.mean, unknown.mean, 4.5 * std::hypot(known.standard_error, unknown.standard_error)) << radiance;
  }
}

}  // namespace
}  // namespace lodestar
