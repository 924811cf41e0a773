// Closed boxes where every ray meets emission 1 on a surface of albedo a: after d bounces at most, the radiance is
// 1 + a + ... + a^d everywhere.
#include <gtest/gtest.h>

#include "core/tracing/path_tracer.h"
#include "tests/support/render.h"
#include "tests/support/statistical.h"

namespace lodestar {
namespace {

constexpr int kDepth = 12;

CompiledJob Furnace(double albedo) {
  const std::string a = std::to_string(albedo);
  return CompileJob(ParsePbrtText("Integrator \"path\" \"integer maxdepth\" [" + std::to_string(kDepth) + R"(]
PixelFilter "box"
Film "rgb" "integer xresolution" [8] "integer yresolution" [8]
Camera "perspective" "float fov" [60]
WorldBegin
AreaLightSource "diffuse" "rgb L" [1 1 1] "bool twosided" [true]
Material "diffuse" "rgb reflectance" [)" +
                                      a + " " + a + " " + a + R"(]
Shape "trianglemesh" "point3 P" [-1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1  -1 1 -1  1 1 -1  1 1 1  -1 1 1]
  "integer indices" [0 2 1 0 3 2  4 5 6 4 6 7  3 6 2 3 7 6  0 4 7 0 7 3  1 2 6 1 6 5  0 1 5 0 5 4]
)",
                                  "furnace.pbrt", "."),
                    JobSpec{});
}

double Radiance(double albedo, int depth = kDepth) {
  double sum = 0;
  for (int bounce = 0; bounce <= depth; ++bounce) sum += std::pow(albedo, bounce);
  return sum;
}

// At albedo 1 nothing but the depth ends a path: one bounce more or less is eight per cent.
TEST(AnalyticTest, FurnaceBoxes) {
  const double level = test::SidakLevel(0.01, 44);
  for (const double albedo : {0.0, 0.5, 0.8, 1.0}) {
    const CompiledJob compiled = Furnace(albedo);
    for (const std::string method : {"path", "sdtree", "focal", "grid", "sdtree+focal", "auto"})
      for (const std::string nee : {"never", "always"}) {
        const bool races = method == "auto";
        if (races && nee == "never") continue;  // its candidates have their own defaults
        test::Moments mean;
        for (uint64_t seed = 1; seed <= 24; ++seed) {
          JobSpec job;
          job.method = method;
          if (races) {
            job.options["pilot"] = "1000";  // so that there is a race in so small a picture
          } else {
            job.options["nee"] = nee;
            if (method != "path") job.options["combine"] = "discard";
          }
          if (method == "grid") job.options.insert({{"batch", "2"}, {"steps", "4"}});
          job.budget.spp = 63;
          job.seed = seed;
          double sum = 0;
          const Image image = test::Render(compiled, job).image;
          for (const Rgb pixel : image.pixels) sum += Luminance(pixel);
          mean.Add(sum / static_cast<double>(image.size()));
        }
        const double expected = Radiance(albedo);
        // Weights by variances of their own move the mean of 64 pixels by a thousandth (core/learning/combination.h).
        const double bias = (races ? 3e-3 : 2e-5) * expected;
        const test::TestResult result = test::TTest(mean, expected, level, bias);
        EXPECT_TRUE(result.accepted) << method << ", nee " << nee << ", albedo " << albedo << ": " << result.message;
        EXPECT_FALSE(test::TTest(mean, 1.05 * expected, level).accepted) << result.message;  // a wrong one is seen
      }
  }
}

test::Moments Samples(const CompiledJob& furnace, const PathSettings& settings) {
  const PathTracer<NoGuide> tracer(furnace.scene, 1, settings, NoGuide{});
  test::Moments samples;
  for (uint32_t pass = 0; pass < 64; ++pass)
    for (uint32_t y = 0; y < 8; ++y)
      for (uint32_t x = 0; x < 8; ++x) samples.Add(Luminance(tracer.TraceSample({.record = false}, x, y, pass)));
  return samples;
}

// Where neither lights are sampled nor roulette is played, every single path carries the radiance exactly. Roulette,
// from the first bounce on or late, and light samples only spread it: white paths are never ended, grey ones fairly.
TEST(AnalyticTest, FurnacePathsWithAndWithoutRoulette) {
  constexpr int kNever = kDepth + 1;
  const double level = test::SidakLevel(0.01, 18);
  for (const double albedo : {0.5, 0.8, 1.0}) {
    const CompiledJob furnace = Furnace(albedo);
    const double expected = Radiance(albedo);
    for (const bool lights : {false, true})
      for (const int roulette_start : {kNever, 6, 2, 1}) {
        const test::Moments samples = Samples(furnace, {.max_depth = kDepth,
                                                        .next_event = lights ? NextEvent::kAll : NextEvent::kNone,
                                                        .roulette_start = roulette_start});
        const std::string name = "albedo " + std::to_string(albedo) + (lights ? ", light samples" : "") +
                                 ", roulette from " + std::to_string(roulette_start);
        if (!lights && (roulette_start == kNever || albedo == 1)) {
          EXPECT_NEAR(samples.mean(), expected, 1e-5 * expected) << name;
          EXPECT_LT(samples.variance(), 1e-10) << name;
        } else {
          const test::TestResult result = test::TTest(samples, expected, level);
          EXPECT_TRUE(result.accepted) << name << ": " << result.message;
        }
      }
  }
}

}  // namespace
}  // namespace lodestar
