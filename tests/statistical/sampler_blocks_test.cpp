// A guide must not know the random numbers of the passes that it guides.
#include <gtest/gtest.h>

#include "core/scene/pbrt_parser.h"
#include "core/tracing/tracer.h"
#include "tests/statistical/image_means.h"

namespace lodestar {
namespace {

// One pixel of a floor that one bright wall lights. One pass teaches a tree, the second, which continues the first
// one's block of sixteen, is drawn from it. While iterations shared their blocks' scramble the mean was off: where the
// first pass had met the wall, the second one's direction lay in the other half of the square.
TEST(SamplerBlocks, IterationsAreIndependent) {
  const CompiledJob compiled = CompileJob(ParsePbrtText(R"(PixelFilter "box"
Film "rgb" "integer xresolution" [1] "integer yresolution" [1]
Integrator "path" "integer maxdepth" [1]
LookAt 0 0 1  0 0 0  0 1 0
Camera "perspective" "float fov" [1]
WorldBegin
Shape "trianglemesh" "point3 P" [-1 -1 0  1 -1 0  1 1 0  -1 1 0] "integer indices" [0 1 2 0 2 3]
AreaLightSource "diffuse" "rgb L" [1 1 1] "bool twosided" true
Shape "trianglemesh" "point3 P" [9 -90 -9  9 90 -9  9 90 90  9 -90 90] "integer indices" [0 1 2 0 2 3]
)",
                                                        "test.pbrt", "."),
                                          JobSpec{});
  JobSpec job;
  job.budget.spp = 2;
  job.method = "path";
  job.options = {{"nee", "never"}};
  const test::ImageMeans reference = test::RenderSeeds(compiled, job, 8000, 100000);
  job.method = "sdtree";
  job.options = {{"preset", "2017"}, {"training", "1"}, {"combine", "discard"}, {"spatial-filter", "nearest"}};
  const test::ImageMeans guided = test::RenderSeeds(compiled, job, 8000, 1);
  const test::TestResult result = test::WelchTest(guided[4], reference[4], 1e-3);
  EXPECT_TRUE(result.accepted) << result.message;
}

}  // namespace
}  // namespace lodestar
