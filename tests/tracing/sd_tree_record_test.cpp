// What the SD-tree's guide records of a path: a path made by hand, against records written down from the definitions
// (Mueller et al. 2017; Rath et al. 2020 for what the targets weigh). That a picture gains from it.
#include <gtest/gtest.h>

#include "core/tracing/sd_tree_guide.h"
#include "tests/guiding/synthetic.h"
#include "tests/statistical/small_scenes.h"
#include "tests/support/render.h"
#include "tests/support/statistical.h"

namespace lodestar {
namespace {

using Learn = SdTreeMethod::Learn;
using Target = SdTreeOptions::Target;

constexpr uint8_t kGroup = 1;
constexpr float kGroupShares[] = {0.25f, 0.75f};
constexpr PixelSample kPixel{.x = 1, .y = 0, .key = 5};
constexpr float kPixelLuminance = 0.3f;

// A tree that has learned directions and how often to sample lights, of more than one leaf. Filters are off, so that
// a record goes where it was made.
std::shared_ptr<const SdTree> Learned(Target target, bool learn_lights = true) {
  SdTreeOptions options;
  options.target = target;
  options.spatial_threshold = 1000;
  options.spatial_filter = SdTreeOptions::SpatialFilter::kNearest;
  options.directional_filter = SdTreeOptions::DirectionalFilter::kNearest;
  options.learn_nee = learn_lights;
  const auto initial = SdTree::Initial(synthetic::UnitCube(), options,
                                       learn_lights ? std::span<const float>(kGroupShares) : std::span<const float>());
  SdTreeStatistics statistics(initial);
  statistics.Record(synthetic::MakeRecords(*initial, synthetic::MovingLobes, 1, 2, 8000), 1);
  if (learn_lights)
    for (int i = 0; i < 1000; ++i) statistics.Record(NeeRecord{.direct = 0.2f, .reflected = static_cast<float>(i % 7)});
  return Advance(*initial, statistics, 4);
}

// Two diffuse vertices and a lamp that light samples find as well as directions do.
struct TwoBounces {
  PathVertex first, second, lamp;

  explicit TwoBounces(const SdTree& tree) {
    first = {.direct = {0.5f, 0.25f, 1},
             .light_group = kGroup,
             .weight = {0.5f, 0.25f, 0.75f},
             .beta = {0.9f, 0.8f, 0.7f},
             .p = {0.2f, 0.3f, 0.1f},
             .wi = Normalize({0.1f, 0.2f, 0.9f}),
             .pdf = 0.4f,
             .bsdf_pdf = 0.3f,
             .guide_pdf = 0.5f,
             .smooth = true,
             .recorded = true};
    second = {.direct = {1, 2, 3},
              .light_group = kGroup,
              .weight = {0.6f, 0.7f, 0.2f},
              .roulette = 2,
              .p = {0.8f, 0.7f, 0.9f},
              .wi = Normalize({-0.3f, 0.5f, -0.7f}),
              .pdf = 0.25f,
              .bsdf_pdf = 0.1f,
              .guide_pdf = 0.6f,
              .smooth = true,
              .recorded = true};
    second.beta = first.beta * first.weight;
    lamp = {.emitted = {8, 4, 2}, .emission_weight = 0.5f};
    first.leaf = tree.LeafAt(first.p);
    second.leaf = tree.LeafAt(second.p);
  }
  std::vector<PathVertex> vertices() const { return {first, second, lamp}; }
};

SdTreeStatistics Recorded(const std::shared_ptr<const SdTree>& tree, Learn learn,
                          const std::vector<PathVertex>& vertices) {
  const PixelEstimate pixels{2, 1, {1e6f, kPixelLuminance}};
  SdTreeGuidingStatistics statistics{SdTreeStatistics(tree)};
  SdTreeGuide<false>::Scratch scratch;
  SdTreeGuide<false>(std::make_shared<SdTreeState>(tree, pixels), learn)
      .Record(vertices, kPixel, &scratch, &statistics);
  return std::move(statistics.sums());
}

// `light` arrives along the vertex' direction.
SdTreeRecord Direction(const PathVertex& vertex, Rgb light, Target target) {
  const Rgb f_cos = vertex.weight * vertex.pdf;  // as weight is f cos / pdf
  return {.position = vertex.p,
          .direction = vertex.wi,
          .radiance = Luminance(light),
          .pdf = vertex.pdf,
          .bsdf_pdf = vertex.bsdf_pdf,
          .tree_pdf = vertex.guide_pdf,
          .product = Luminance(f_cos * light),
          .relative = target == Target::kFull ? Luminance(vertex.beta * f_cos * light) / kPixelLuminance : 0,
          .leaf = vertex.leaf};
}

LightRecord LightSample(const PathVertex& vertex, const SdTree& tree) {
  return {Luminance(vertex.direct), kGroupShares[kGroup] * tree.leaf(vertex.leaf).nee_probability, vertex.leaf, kGroup};
}

void ExpectNear(double value, double expected) {
  EXPECT_NEAR(value, expected, 1e-5 * std::fabs(expected));
}
void ExpectNear(const ExactSum& value, const ExactSum& expected) {
  ExpectNear(value.Value(), expected.Value());
}

// Equal to the bit, unless the test's own products are rounded in another order.
void ExpectSame(const SdTreeStatistics& recorded, const SdTreeStatistics& expected) {
  ASSERT_EQ(recorded.counts(), expected.counts());
  for (uint32_t leaf = 0; leaf < expected.tree()->leaf_count(); ++leaf) {
    SCOPED_TRACE("leaf " + std::to_string(leaf));
    const SdTreeStatistics::LeafSums &sums = recorded.leaf(leaf), &by_hand = expected.leaf(leaf);
    EXPECT_EQ(sums.weight, by_hand.weight);
    ExpectNear(sums.flux, by_hand.flux);
    EXPECT_EQ(sums.nee.count, by_hand.nee.count);
    EXPECT_EQ(sums.nee.vertices, by_hand.nee.vertices);
    ExpectNear(sums.nee.direct, by_hand.nee.direct);
    ExpectNear(sums.nee.direct_squared, by_hand.nee.direct_squared);
    ExpectNear(sums.nee.reflected, by_hand.nee.reflected);
    ExpectNear(sums.nee.reflected_squared, by_hand.nee.reflected_squared);
    EXPECT_EQ(sums.fraction.count, by_hand.fraction.count);
    ExpectNear(sums.fraction.weight, by_hand.fraction.weight);
    for (int i = 0; i < kFractionGrid; ++i)
      ExpectNear(static_cast<double>(sums.fraction.GradientUnits(i)),
                 static_cast<double>(by_hand.fraction.GradientUnits(i)));
    for (size_t slot = 0; slot < expected.slots(leaf).size(); ++slot)
      ExpectNear(recorded.slots(leaf)[slot], expected.slots(leaf)[slot]);
    for (size_t group = 0; group < expected.lights(leaf).size(); ++group)
      ExpectNear(recorded.lights(leaf)[group], expected.lights(leaf)[group]);
  }
}

// What the vertex before the lamp learns of it, as a share. All that the vertex before that one gets is reflected,
// which the estimate knows: by half the lamp and by light samples, whatever is learned.
struct Share {
  Learn learn;
  float lamp;
};

TEST(SdTreeGuideRecord, RadianceProductAndRelativeByWhatIsLearned) {
  for (const Target target : {Target::kRadiance, Target::kSimple, Target::kFull})
    for (const auto& [learn, share] : {Share{Learn::kAll, 1}, {Learn::kWeighted, 0.5f}, {Learn::kIndirect, 0}}) {
      SCOPED_TRACE("target " + std::to_string(static_cast<int>(target)) + ", learn " +
                   std::to_string(static_cast<int>(learn)));
      const auto tree = Learned(target);
      ASSERT_EQ(tree->target(), target);
      const TwoBounces path(*tree);
      ASSERT_NE(path.first.leaf, path.second.leaf);
      ASSERT_TRUE(tree->HasLearned(path.first.leaf) && tree->HasLearned(path.second.leaf));
      ASSERT_LT(tree->leaf(path.second.leaf).nee_probability, 0.9f);
      // Survival has doubled what comes to the second vertex.
      const Rgb learned = path.lamp.emitted * (share * 2), arriving = path.lamp.emitted * (0.5f * 2);
      const Rgb from_second = path.second.direct + path.second.weight * arriving;
      SdTreeStatistics expected(tree);
      expected.Record(Direction(path.second, learned, target), {});
      expected.Record(Direction(path.first, from_second, target), {});
      expected.Record(
          NeeRecord{Luminance(path.second.direct), Luminance(path.second.weight * arriving), 2, path.second.leaf});
      expected.Record(
          NeeRecord{Luminance(path.first.direct), Luminance(path.first.weight * from_second), 3, path.first.leaf});
      for (const PathVertex& vertex : {path.first, path.second}) expected.Record(LightSample(vertex, *tree));
      ExpectSame(Recorded(tree, learn, path.vertices()), expected);
    }
}

// Light that no light sample could have found is learned of in any case.
TEST(SdTreeGuideRecord, EmissionThatOnlyDirectionsFindIsLearnedInFull) {
  const auto tree = Learned(Target::kSimple);
  TwoBounces path(*tree);
  path.lamp.emission_weight = 1;
  path.second.emitted = {1, 0.5f, 3};
  const Rgb arriving = path.lamp.emitted * 2;
  const Rgb from_second = path.second.emitted + path.second.direct + path.second.weight * arriving;
  for (const Learn learn : {Learn::kAll, Learn::kWeighted, Learn::kIndirect}) {
    const SdTreeStatistics recorded = Recorded(tree, learn, path.vertices());
    ExpectNear(recorded.leaf(path.second.leaf).flux.Value(),
               static_cast<double>(Luminance(arriving)) / path.second.pdf * tree->radiance_scale());
    ExpectNear(recorded.leaf(path.first.leaf).flux.Value(),
               static_cast<double>(Luminance(from_second)) / path.first.pdf * tree->radiance_scale());
  }
}

// Where the path ended, the direction brought nothing, which is recorded as well: survival has made up for it
// elsewhere.
TEST(SdTreeGuideRecord, APathThatRouletteEndedHasBroughtNothing) {
  const auto tree = Learned(Target::kRadiance);
  TwoBounces path(*tree);
  path.second.roulette = 0;
  SdTreeStatistics expected(tree);
  expected.Record(Direction(path.second, Rgb(), Target::kRadiance), {});
  expected.Record(Direction(path.first, path.second.direct, Target::kRadiance), {});
  expected.Record(NeeRecord{Luminance(path.second.direct), 0, 1, path.second.leaf});
  expected.Record(
      NeeRecord{Luminance(path.first.direct), Luminance(path.first.weight * path.second.direct), 2, path.first.leaf});
  for (const PathVertex& vertex : {path.first, path.second}) expected.Record(LightSample(vertex, *tree));
  ExpectSame(Recorded(tree, Learn::kWeighted, {path.first, path.second}), expected);
}

// A mirror between them passes the light on and is not recorded; a smooth vertex that the path ended at has no
// direction, yet its light sample counts; one that found no light tells nothing of lights.
TEST(SdTreeGuideRecord, MirrorsAndLastVertices) {
  const auto tree = Learned(Target::kFull);
  TwoBounces path(*tree);
  const PathVertex mirror{.weight = {0.9f, 0.8f, 0.7f}, .beta = path.second.beta};
  path.first.direct = {};
  path.second.recorded = false;
  path.second.weight = {};
  SdTreeStatistics expected(tree);
  const Rgb arriving = mirror.weight * path.second.direct;
  expected.Record(Direction(path.first, arriving, Target::kFull), {});
  expected.Record(NeeRecord{Luminance(path.second.direct), 0, 1, path.second.leaf});
  expected.Record(NeeRecord{0, Luminance(path.first.weight * arriving), 3, path.first.leaf});
  expected.Record(LightSample(path.second, *tree));
  ExpectSame(Recorded(tree, Learn::kWeighted, {path.first, mirror, path.second}), expected);
}

TEST(SdTreeGuideRecord, NothingOfLightSamplesWhereTheyAreNotLearned) {
  const auto tree = Learned(Target::kRadiance, false);
  const TwoBounces path(*tree);
  const SdTreeStatistics recorded = Recorded(tree, Learn::kWeighted, path.vertices());
  EXPECT_EQ(recorded.counts().accepted, 2u);
  for (uint32_t leaf = 0; leaf < tree->leaf_count(); ++leaf) {
    EXPECT_EQ(recorded.leaf(leaf).nee.count, 0u);
    EXPECT_TRUE(recorded.lights(leaf).empty());
  }
}

// Mean squared error of a method's pictures without light samples, training and all, of the same samples each.
double MeanSquaredError(const CompiledJob& compiled, const std::string& method, const Image& reference) {
  JobSpec job;
  job.method = method;
  job.options["nee"] = "never";
  job.budget.spp = 511;
  test::Moments error;
  for (job.seed = 1; job.seed <= 4; ++job.seed) error.Add(Compare(test::Render(compiled, job).image, reference).mse);
  return error.mean();
}

// All light comes by way of the ceiling, which a lamp faces closely.
TEST(SdTreeRenderTest, GuidingLowersTheErrorAtEqualSamples) {
  JobSpec job;
  job.method = "path";
  job.budget.spp = 2048;
  job.seed = 1000;
  const CompiledJob compiled = CompileJob(ParsePbrtText(test::kSmallScenes[0].text, "test.pbrt", "."), job);
  const Image reference = test::Render(compiled, job).image;
  const double path = MeanSquaredError(compiled, "path", reference),
               guided = MeanSquaredError(compiled, "sdtree", reference);
  EXPECT_LT(guided, 0.6 * path);
  RecordProperty("mse", std::to_string(path) + " " + std::to_string(guided));
}

}  // namespace
}  // namespace lodestar
