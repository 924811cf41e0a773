// SD-tree and focal field as one guide: that it samples by the density it tells, and what it tells each of its parts of
// a path (docs/decisions/0020-mixture.md).
#include "core/tracing/mixed_guide.h"

#include <gtest/gtest.h>

#include "core/math/warp.h"
#include "tests/guiding/focal_testing.h"
#include "tests/guiding/synthetic.h"
#include "tests/support/statistical.h"

namespace lodestar {
namespace {

using test::Random;

// Trees whose records go where they were made, and weigh by the tree's own share. Without iterations: not learned yet.
std::shared_ptr<const SdTree> Tree(int iterations) {
  synthetic::Training training;
  training.options.target = SdTreeOptions::Target::kSimple;
  training.options.spatial_filter = SdTreeOptions::SpatialFilter::kNearest;
  training.options.directional_filter = SdTreeOptions::DirectionalFilter::kNearest;
  training.first_records = 10000;
  return synthetic::Train(training, iterations);
}

// Narrows from the third iteration on, and ends with the fifth.
std::shared_ptr<const FocalField> Field(uint32_t iterations) {
  focal_testing::Training training;
  training.options.initial_iterations = 2;
  training.options.narrowing_iterations = 3;
  training.options.learn_fraction = true;
  training.radius = 0.1f;
  training.ambient = 0.1f;
  return focal_testing::Train(training, iterations);
}

// What the mixture is made of in one direction: p = beta (alpha p_bsdf + (1 - alpha) p_tree) + (1 - beta) p_focal,
// where a part that has not learned has no share.
struct Densities {
  float bsdf, tree, focal, alpha, beta;
  float inner() const { return alpha * bsdf + (1 - alpha) * tree; }
  float all() const { return beta * inner() + (1 - beta) * focal; }
};

struct Mixture {
  std::shared_ptr<const SdTree> tree;
  std::shared_ptr<const FocalField> field;
  MixedGuide guide;

  Mixture(std::shared_ptr<const SdTree> of_tree, std::shared_ptr<const FocalField> of_field)
      : tree(std::move(of_tree)),
        field(std::move(of_field)),
        guide(std::make_shared<const MixedState>(std::make_shared<const SdTreeState>(tree, PixelEstimate()),
                                                 std::make_shared<const FocalState>(field)),
              SdTreeMethod::Learn::kAll) {}

  MixedGuide::Local At(Vec3 p) const {
    SurfaceInteraction si{};
    si.p = p;
    return guide.At(si, Bsdf::Diffuse(Rgb(0.5f)), {0, 0, 1});
  }
  Densities DensitiesAt(Vec3 p, Vec3 wi, float bsdf_pdf) const {
    const uint32_t leaf = tree->LeafAt(p);
    Densities d{bsdf_pdf, 0, 0, 1, 1};
    if (tree->HasLearned(leaf)) d.tree = tree->Pdf(leaf, wi), d.alpha = tree->BsdfFraction(leaf);
    if (field->HasLearned()) d.focal = field->Pdf(p, wi), d.beta = field->BsdfFraction(p);
    return d;
  }
  // As the kernel makes it of a direction that a diffuse lobe or the guide has drawn.
  PathVertex Vertex(Vec3 p, Vec3 wi, float bsdf_pdf) const {
    const MixedGuide::Local local = At(p);
    PathVertex vertex{.weight = {0.5f, 0.25f, 0.75f},
                      .beta = Rgb(1),
                      .distance = 0.3f,
                      .p = p,
                      .wi = wi,
                      .bsdf_pdf = bsdf_pdf,
                      .leaf = local.leaf,
                      .smooth = true,
                      .recorded = true};
    if (local.bsdf_fraction < 1) vertex.guide_pdf = guide.Pdf(local, wi);
    vertex.pdf = local.bsdf_fraction * bsdf_pdf + (1 - local.bsdf_fraction) * vertex.guide_pdf;
    return vertex;
  }
  MixedStatistics Recorded(const std::vector<PathVertex>& vertices) const {
    MixedStatistics statistics(SdTreeStatistics{tree}, FocalStatistics{field});
    MixedGuide::Scratch scratch;
    guide.Record(vertices, {}, &scratch, &statistics);
    return statistics;
  }
};

// ---- Sampling ----

TEST(MixedGuide, SampledPdfIsThePdfOfTheDirection) {
  const auto tree = Tree(4);
  const auto field = Field(3);
  Random random(1);
  for (const Mixture& mixture : {Mixture(tree, field), Mixture(tree, Field(0)), Mixture(Tree(0), field)}) {
    for (int i = 0; i < 10000; ++i) {
      const Vec3 p{random.Next1D(), random.Next1D(), random.Next1D()};
      const MixedGuide::Local local = mixture.At(p);
      ASSERT_LT(local.bsdf_fraction, 1);
      const Vec2 u = random.Next2D();
      const GuidedSample sample = mixture.guide.Sample(local, u, random.Next1D());
      ASSERT_GT(sample.pdf, 0);
      ASSERT_NEAR(Length(sample.w), 1, 1e-5);
      ASSERT_EQ(sample.pdf, mixture.guide.Pdf(local, sample.w));
    }
  }
}

TEST(MixedGuide, APartThatHasNotLearnedHasNoShare) {
  const Vec3 p{0.2f, 0.8f, 0.4f};
  const Mixture of_tree(Tree(4), Field(0)), of_field(Tree(0), Field(3)), of_neither(Tree(0), Field(0));
  EXPECT_EQ(of_tree.At(p).tree_share, 1);
  EXPECT_EQ(of_tree.At(p).bsdf_fraction, of_tree.tree->BsdfFraction(of_tree.tree->LeafAt(p)));
  EXPECT_EQ(of_field.At(p).tree_share, 0);
  EXPECT_EQ(of_field.At(p).bsdf_fraction, of_field.field->BsdfFraction(p));
  EXPECT_EQ(of_neither.At(p).bsdf_fraction, 1);
}

// Shares of kBins x kBins cells of equal area, by midpoints: both densities have many steps and kinks. The tree's cells
// are no smaller than the midpoints' squares, which lie within them.
constexpr int kBins = 16, kPoints = 32, kSamples = 60000;

std::vector<double> Expected(const Mixture& mixture, const MixedGuide::Local& local) {
  std::vector<double> expected(kBins * kBins);
  constexpr int kSide = kBins * kPoints;
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j) {
      const Vec2 square{(static_cast<float>(i) + 0.5f) / kSide, (static_cast<float>(j) + 0.5f) / kSide};
      expected[static_cast<size_t>(i / kPoints * kBins + j / kPoints)] +=
          mixture.guide.Pdf(local, CylindricalToDirection(square)) * (4 * double{kPi} / (kSide * kSide)) * kSamples;
    }
  return expected;
}

std::vector<double> Observed(const Mixture& mixture, const MixedGuide::Local& local, uint64_t seed) {
  std::vector<double> observed(kBins * kBins);
  Random random(seed);
  for (int i = 0; i < kSamples; ++i) {
    const Vec2 u = random.Next2D();
    const Vec2 square = DirectionToCylindrical(mixture.guide.Sample(local, u, random.Next1D()).w);
    ++observed[static_cast<size_t>(square.x * kBins) * kBins + static_cast<size_t>(square.y * kBins)];
  }
  return observed;
}

TEST(MixedGuide, SamplesFollowTheDensity) {
  const double level = test::SidakLevel(0.01, 2);
  const Mixture mixture(Tree(4), Field(3));
  uint64_t seed = 1;
  for (const Vec3 p : {Vec3{0.9f, 0.1f, 0.1f}, Vec3{0.2f, 0.8f, 0.4f}}) {
    const MixedGuide::Local local = mixture.At(p);
    ASSERT_GT(local.tree_share, 0.02f);
    ASSERT_LT(local.tree_share, 0.98f);
    const std::vector<double> observed = Observed(mixture, local, seed++);
    const test::TestResult right = test::ChiSquareTest(observed, Expected(mixture, local), level);
    EXPECT_TRUE(right.accepted) << right.message;
    // The same of shares that are a little wrong.
    MixedGuide::Local wrong = local;
    wrong.tree_share = local.tree_share + (local.tree_share < 0.5f ? 0.1f : -0.1f);
    EXPECT_FALSE(test::ChiSquareTest(observed, Expected(mixture, wrong), level).accepted);
  }
}

// ---- Recording ----

// The sums themselves are of units of 2^-56.
void ExpectNear(double value, double expected, double relative) {
  EXPECT_NEAR(value, expected, relative * std::fabs(expected) + 0x1p-50);
}

void ExpectSame(const FractionSums& recorded, const FractionSums& expected, double rounding) {
  ASSERT_EQ(recorded.count, expected.count);
  const double weight = expected.weight.Value();
  ExpectNear(recorded.weight.Value(), weight, 1e-5);
  for (int i = 0; i < kFractionGrid; ++i)
    EXPECT_NEAR(static_cast<double>(recorded.GradientUnits(i)), static_cast<double>(expected.GradientUnits(i)),
                rounding * weight * 0x1p30);
}

// The tree hears of densities in the proportions that they would have without the field.
SdTreeRecord ForTree(const PathVertex& vertex, const Densities& d, Rgb light) {
  const float scale = d.all() / d.inner();
  return {.position = vertex.p,
          .direction = vertex.wi,
          .radiance = Luminance(light),
          .pdf = d.all(),
          .bsdf_pdf = d.bsdf * scale,
          .tree_pdf = d.tree * scale,
          .product = Luminance(vertex.weight * light) * d.all(),
          .leaf = vertex.leaf};
}

// The field hears of the tree's mixture in the place of the BSDF.
FocalRecord ForField(const PathVertex& vertex, const Densities& d, Rgb light, float distance) {
  return {.position = vertex.p,
          .direction = vertex.wi,
          .distance = distance,
          .value = Luminance(vertex.beta * vertex.weight * light),
          .pdf = d.all(),
          .bsdf_pdf = d.inner(),
          .guide_pdf = d.focal};
}

double SlotsOf(const SdTreeStatistics& statistics, uint32_t leaf) {
  double sum = 0;
  for (const ExactSum& slot : statistics.slots(leaf)) sum += slot.Value();
  return sum;
}

// Two vertices, a mirror between them, and a lamp; a diffuse lobe of that density in these directions.
struct Path {
  PathVertex first, mirror, second, lamp;
  Densities at_first, at_second;

  Path(const Mixture& mixture, Random& random) {
    const auto vertex = [&](Densities* densities) {
      const Vec3 p{random.Next1D(), random.Next1D(), random.Next1D()};
      // Towards what the field knows, and anywhere.
      const bool anywhere = random.Next1D() < 0.5f;
      const Vec2 u = random.Next2D();
      const Vec3 wi = anywhere ? SquareToSphere(u) : mixture.field->Sample(p, u).w;
      const float bsdf_pdf = 0.05f + 0.3f * random.Next1D();
      *densities = mixture.DensitiesAt(p, wi, bsdf_pdf);
      return mixture.Vertex(p, wi, bsdf_pdf);
    };
    first = vertex(&at_first);
    mirror = {.weight = {0.9f, 0.8f, 0.7f}, .beta = first.beta * first.weight, .distance = 0.4f};
    second = vertex(&at_second);
    second.beta = mirror.beta * mirror.weight;
    lamp = {.emitted = {8, 4, 2}, .distance = 0.2f};
  }
  std::vector<PathVertex> vertices() const { return {first, mirror, second, lamp}; }
  Rgb LightToSecond() const { return lamp.emitted; }
  Rgb LightToFirst() const { return mirror.weight * (second.weight * lamp.emitted); }
};

TEST(MixedGuideRecord, TheTreeHearsOfItsOwnMixtureAndTheFieldOfTheTrees) {
  Random random(5);
  for (const int learned_tree : {0, 4})
    for (const uint32_t learned_field : {0u, 3u}) {
      SCOPED_TRACE("tree " + std::to_string(learned_tree) + ", field " + std::to_string(learned_field));
      const Mixture mixture(Tree(learned_tree), Field(learned_field));
      ASSERT_EQ(mixture.field->HasLearned(), learned_field > 0);
      double field_total = 0, tree_total = 0;
      uint64_t tree_fractions = 0;
      for (int i = 0; i < 50; ++i) {
        const Path path(mixture, random);
        ASSERT_EQ(mixture.tree->HasLearned(path.first.leaf), learned_tree > 0);
        ExpectNear(path.first.pdf, path.at_first.all(), 1e-5);
        ExpectNear(path.second.pdf, path.at_second.all(), 1e-5);
        const MixedStatistics recorded = mixture.Recorded(path.vertices());

        SdTreeStatistics for_tree(mixture.tree);
        for_tree.Record(ForTree(path.second, path.at_second, path.LightToSecond()), {});
        for_tree.Record(ForTree(path.first, path.at_first, path.LightToFirst()), {});
        const SdTreeStatistics& tree = recorded.tree().sums();
        ASSERT_EQ(tree.counts(), for_tree.counts());
        for (const uint32_t leaf : {path.first.leaf, path.second.leaf}) {
          EXPECT_EQ(tree.leaf(leaf).weight, for_tree.leaf(leaf).weight);
          ExpectNear(tree.leaf(leaf).flux.Value(), for_tree.leaf(leaf).flux.Value(), 1e-5);
          ExpectNear(SlotsOf(tree, leaf), SlotsOf(for_tree, leaf), 1e-4);
          ExpectSame(tree.leaf(leaf).fraction, for_tree.leaf(leaf).fraction, 1e-4);
          tree_total += SlotsOf(for_tree, leaf);
          tree_fractions += for_tree.leaf(leaf).fraction.count;
        }

        FocalStatistics for_field(mixture.field);
        for_field.Record(ForField(path.first, path.at_first, path.LightToFirst(), path.mirror.distance));
        for_field.Record(ForField(path.second, path.at_second, path.LightToSecond(), path.lamp.distance));
        const FocalStatistics& field = recorded.focal().sums();
        ASSERT_EQ(field.counts(), for_field.counts());
        // The field's own density is found by taking the tree's from the guide's, which costs bits where it is less.
        double rounding = 1e-5;
        for (const Densities& d : {path.at_first, path.at_second})
          if (d.focal > 0) rounding = std::max(rounding, 1e-5 * d.tree / d.focal);
        for (uint32_t slot = 0; slot < for_field.slot_count(); ++slot) {
          const double expected = for_field.sum(slot).Value();
          ExpectNear(field.sum(slot).Value(), expected, rounding);
          field_total += expected;
        }
        for (const Vec3 p : {path.first.p, path.second.p})
          ExpectSame(field.fraction(mixture.field->CellAt(p)), for_field.fraction(mixture.field->CellAt(p)), 1e-3);
      }
      EXPECT_GT(field_total, 0);
      EXPECT_GT(tree_total, 0);
      EXPECT_EQ(tree_fractions > 0, learned_tree > 0);
    }
}

TEST(MixedGuideRecord, AfterItsIterationsTheFieldLearnsNoMore) {
  const Mixture mixture(Tree(4), Field(5));
  ASSERT_EQ(mixture.field->iteration(), mixture.field->options().iterations());
  Random random(6);
  const Path path(mixture, random);
  const MixedStatistics recorded = mixture.Recorded(path.vertices());
  EXPECT_EQ(recorded.tree().sums().counts().accepted, 2u);
  EXPECT_EQ(recorded.focal().sums().counts(), FocalStatistics::Counts());
}

}  // namespace
}  // namespace lodestar
