#include "core/guiding/focal_advance.h"

#include <gtest/gtest.h>

#include <optional>

#include "tests/guiding/focal_testing.h"

namespace lodestar {
namespace {

using focal_testing::Random;
using focal_testing::RandomField;
using focal_testing::Recorded;
using focal_testing::Train;
using focal_testing::Training;

const Bounds3 kUnit{{0, 0, 0}, {1, 1, 1}};

double LeafMass(const FocalOctree& octree, Vec3 p) {
  for (uint32_t index = 0;;) {
    int octant = 0;
    const float cells = std::ldexp(1.0f, octree.node(index).level);
    for (int axis = 0; axis < 3; ++axis) octant |= (static_cast<int>(p[axis] * cells) & 1) << axis;
    if (((octree.node(index).inner >> octant) & 1) == 0) return octree.mass(index * 8 + static_cast<uint32_t>(octant));
    index = octree.node(index).Child(octant);
  }
}

// Calls visit(slot, node) for every leaf of `before`: the node that it has become in `after`, or nothing.
template <class Visit>
void ForLeavesOf(const FocalOctree& before, uint32_t from, const FocalOctree& after, uint32_t to, Visit&& visit) {
  for (int c = 0; c < 8; ++c) {
    const bool inner = (after.node(to).inner >> c) & 1;
    if ((before.node(from).inner >> c) & 1) {
      ASSERT_TRUE(inner) << "a node has become a leaf";
      ForLeavesOf(before, before.node(from).Child(c), after, after.node(to).Child(c), visit);
    } else {
      visit(from * 8 + static_cast<uint32_t>(c), inner ? std::optional(after.node(to).Child(c)) : std::nullopt);
    }
  }
}

float LargestLeaf(const FocalField& field) {
  float largest = 0;
  for (const FocalOctree& octree : field.octrees())
    for (uint32_t slot = 0; slot < octree.node_count() * 8; ++slot)
      if (((octree.node(slot / 8).inner >> (slot % 8)) & 1) == 0) largest = std::max(largest, octree.mass(slot));
  return largest;
}

// Of directions from anywhere, those that hit the ball of light.
double HitShare(const Training& training, const std::function<Vec3(Vec3, Random&)>& direction) {
  Random random(1);
  int hits = 0;
  constexpr int kSamples = 20000;
  for (int i = 0; i < kSamples; ++i) {
    const Vec3 x = focal_testing::PointIn(kUnit, random);
    hits += std::isfinite(focal_testing::BallDistance(x, direction(x, random), training.light, training.radius));
  }
  return static_cast<double>(hits) / kSamples;
}

TEST(FocalAdvance, FindsTheLight) {
  Training training;
  const auto field = Train(training, 12);
  const FocalOctree& octree = field->octrees()[0];
  EXPECT_GE(octree.depth(), 7);
  // The ball subtends 1e-3 of the sphere or less.
  const double by_chance =
      HitShare(training, [](Vec3, Random& random) { return focal_testing::UniformDirection(random); });
  const double guided = HitShare(training, [&](Vec3 x, Random& random) { return field->Sample(x, random.Next2D()).w; });
  EXPECT_GT(guided, 100 * by_chance);
  EXPECT_GT(guided, 0.3);
}

TEST(FocalAdvance, SplitsWhatIsHeavyAfterNarrowingIterationsOnly) {
  Training training;
  auto field = FocalField::Initial(kUnit, training.options);
  for (uint32_t k = 0; k < 11; ++k) {
    const auto next = Advance(*field, Recorded(field, training, k, 5000));
    EXPECT_EQ(next->iteration(), k + 1);
    if (k < 6) {
      EXPECT_EQ(next->octrees()[0].node_count(), field->octrees()[0].node_count()) << k;
    } else {
      EXPECT_GT(next->octrees()[0].node_count(), field->octrees()[0].node_count()) << k;
      EXPECT_LE(next->octrees()[0].depth(), field->octrees()[0].depth() + 1);
    }
    field = next;
  }
  EXPECT_EQ(field->octrees()[0].depth(), 8);
}

// A voxel splits for its share of the blended mass, whatever its size.
TEST(FocalAdvance, SplitsExactlyTheVoxelsAboveTheThreshold) {
  FocalParts parts = PartsOf(*RandomField(kUnit, 6, 3));
  parts.iteration = 6;
  parts.weight = 25000;  // of the order of what is recorded, so that old and new masses both count
  const auto field = std::make_shared<const FocalField>(std::move(parts));
  const FocalOptions& options = field->options();
  ASSERT_TRUE(options.Narrows(field->iteration()) && field->iteration() + 1 < options.iterations());
  Training training;
  training.ambient = 1;
  const FocalStatistics statistics = Recorded(field, training, 9, 2000);
  const auto next = Advance(*field, statistics);
  const FocalOctree& before = field->octrees()[0];
  const FocalOctree& after = next->octrees()[0];

  const auto blended = [&](uint32_t slot) {
    return options.decay * field->weight() * before.mass(slot) / field->mass() +
           statistics.sum(slot).Value() / field->radiance_scale();
  };
  double total = 0;
  ForLeavesOf(before, 0, after, 0, [&](uint32_t slot, std::optional<uint32_t>) { total += blended(slot); });
  struct Level {
    int kept = 0, split = 0;
  };
  std::array<Level, FocalOctree::kMaxDepth + 1> levels;
  int decided_by_records = 0;
  ForLeavesOf(before, 0, after, 0, [&](uint32_t slot, std::optional<uint32_t> node) {
    const double share = blended(slot) / total;
    const int level = before.node(slot / 8).level;
    ASSERT_EQ(node.has_value(), share > options.split_threshold) << share << " at level " << level;
    ++(node ? levels[static_cast<size_t>(level)].split : levels[static_cast<size_t>(level)].kept);
    decided_by_records += (before.mass(slot) / field->mass() > options.split_threshold) != node.has_value();
    if (!node) return;
    EXPECT_EQ(after.node(*node).inner, 0) << "by one level only";
    for (uint32_t c = 0; c < 8; ++c) EXPECT_NEAR(after.mass(*node * 8 + c), share / 8, 1e-6 * share);
  });
  for (const size_t level : {3u, 4u, 5u}) {
    EXPECT_GT(levels[level].kept, 0) << level;
    EXPECT_GT(levels[level].split, 0) << level;
  }
  EXPECT_GT(decided_by_records, 0);
}

TEST(FocalAdvance, PruningKeepsTheMassAndCollapsesWhatIsEven) {
  Training training;
  training.options.prune_ratio = 0;
  const auto unpruned = Train(training, 12);
  training.options.prune_ratio = 2;
  const auto pruned = Train(training, 12);
  EXPECT_LT(pruned->octrees()[0].node_count(), unpruned->octrees()[0].node_count() / 2);
  EXPECT_NEAR(pruned->mass(), 1, 1e-5);
  // Where the light is the voxels are kept.
  EXPECT_GT(LargestLeaf(*pruned), 1e-3);
  EXPECT_GE(pruned->octrees()[0].depth(), 7);
  // No node is left whose leaves are all even.
  const FocalOctree& octree = pruned->octrees()[0];
  for (uint32_t i = 1; i < octree.node_count(); ++i) {
    if (octree.node(i).inner != 0) continue;
    float largest = 0, sum = 0;
    for (uint32_t c = 0; c < 8; ++c) {
      largest = std::max(largest, octree.mass(i * 8 + c));
      sum += octree.mass(i * 8 + c);
    }
    EXPECT_GT(largest, 2 * sum / 8 * (1 - 1e-5f));
  }
}

// A budget may end training before all iterations: what is left without use is pruned then.
TEST(FocalAdvance, TrainingThatEndsEarlyEndsInAPrunedOctree) {
  const Training training;
  const auto field = Train(training, 9);
  const FocalStatistics statistics = Recorded(field, training, 9, 5000);
  const auto goes_on = Advance(*field, statistics), ends = Advance(*field, statistics, true);
  ASSERT_LT(ends->iteration(), training.options.iterations());
  EXPECT_LT(ends->octrees()[0].node_count(), field->octrees()[0].node_count());
  EXPECT_GE(goes_on->octrees()[0].node_count(), field->octrees()[0].node_count());
}

TEST(FocalAdvance, OldMassesDecay) {
  Training training;
  training.options.decay = 0.5f;
  const auto first = Train(training, 1);
  const FocalStatistics statistics = Recorded(first, training, 77, 5000);
  const auto second = Advance(*first, statistics);
  double recorded = 0;
  for (uint32_t slot = 0; slot < statistics.slot_count(); ++slot) recorded += statistics.sum(slot).Value();
  recorded /= first->radiance_scale();
  EXPECT_NEAR(second->weight(), 0.5 * first->weight() + recorded, 1e-6 * second->weight());
  const FocalOctree& a = first->octrees()[0];
  const FocalOctree& b = second->octrees()[0];
  for (uint32_t slot = 73 * 4; slot < 73 * 8; ++slot) {
    if ((b.node(slot / 8).inner >> (slot % 8)) & 1) continue;
    const double expected =
        0.5 * first->weight() * a.mass(slot) + statistics.sum(slot).Value() / first->radiance_scale();
    EXPECT_NEAR(b.mass(slot) * second->weight(), expected, 1e-5 * expected + 1e-9);
  }
}

TEST(FocalAdvance, NodesAreBounded) {
  Training training;
  training.options.split_threshold = 1e-5f;
  training.options.max_nodes = 40000;
  training.options.start_depth = 5;
  training.options.prune_ratio = 0;
  training.ambient = 1;
  const auto field = Train(training, 12);
  EXPECT_LE(field->octrees()[0].node_count(), 40000u);
  EXPECT_GT(field->octrees()[0].node_count(), 4681u);
}

TEST(FocalAdvance, DepthIsBounded) {
  Training training;
  training.options.narrowing_iterations = 20;
  training.radius = 1e-6f;
  training.ambient = 0;
  // Every record leads to one point.
  auto field = FocalField::Initial(kUnit, training.options);
  Random random(4);
  for (int k = 0; k < 25; ++k) {
    FocalStatistics statistics(field);
    for (int i = 0; i < 500; ++i) {
      FocalRecord r;
      r.position = focal_testing::PointIn(kUnit, random);
      r.direction = Normalize(training.light - r.position);
      r.distance = kInfinity;
      r.value = r.pdf = r.bsdf_pdf = r.guide_pdf = 1;
      statistics.Record(r);
    }
    field = Advance(*field, statistics);
  }
  EXPECT_EQ(field->octrees()[0].depth(), FocalOctree::kMaxDepth);
  EXPECT_GT(LargestLeaf(*field), 0.02f);
}

TEST(FocalAdvance, ABlackSceneLearnsNothing) {
  Training training;
  training.emission = 0;
  const auto field = Train(training, 12);
  EXPECT_FALSE(field->HasLearned());
  EXPECT_EQ(field->iteration(), 12u);
  EXPECT_GT(field->Pdf({0.1f, 0.2f, 0.3f}, {0, 1, 0}), 0);
}

TEST(FocalAdvance, UnitsOfRadianceDoNotMatter) {
  std::vector<double> found;
  for (const float emission : {0x1p-40f, 1.0f, 0x1p40f}) {
    Training training;
    training.emission = emission;
    training.records = 5000;
    const auto field = Train(training, 12);
    ASSERT_TRUE(field->HasLearned());
    found.push_back(HitShare(training, [&](Vec3 x, Random& random) { return field->Sample(x, random.Next2D()).w; }));
  }
  EXPECT_GT(found[1], 0.2);
  EXPECT_NEAR(found[0] / found[1], 1, 0.1);
  EXPECT_NEAR(found[2] / found[1], 1, 0.1);
}

TEST(FocalAdvance, LearnsTheShareOfBsdfSampling) {
  Training training;
  training.options.learn_fraction = true;
  const auto field = Train(training, 12);
  // The light is all there is: what leads to it is worth more than the uniform directions.
  float mean = 0;
  for (const float fraction : field->fractions()) mean += fraction / static_cast<float>(field->fractions().size());
  EXPECT_LT(mean, 0.4f);
}

// In one cell the BSDF leads to the light and the guide does not, in another the guide alone; of the rest is nothing
// known.
TEST(FocalAdvance, EveryCellLearnsItsOwnShareOfBsdfSampling) {
  FocalOptions options;
  options.learn_fraction = true;
  FocalParts parts = PartsOf(*FocalField::Initial(kUnit, options));
  parts.weight = 1;  // something: until then no share is learned
  const auto field = std::make_shared<const FocalField>(std::move(parts));
  FocalStatistics statistics(field);
  const Vec3 by_bsdf{0.1f, 0.3f, 0.3f}, by_guide{0.9f, 0.3f, 0.3f};
  for (int i = 0; i < 1000; ++i) {
    FocalRecord r;
    r.direction = {0, 0, 1};
    r.distance = 0.2f;
    r.value = 1;
    r.pdf = 1.01f;
    r.position = by_bsdf;
    r.bsdf_pdf = 2;
    r.guide_pdf = 0.02f;
    statistics.Record(r);
    r.position = by_guide;
    std::swap(r.bsdf_pdf, r.guide_pdf);
    statistics.Record(r);
  }
  const auto next = Advance(*field, statistics);
  EXPECT_GT(next->BsdfFraction(by_bsdf), 0.9f);
  EXPECT_LT(next->BsdfFraction(by_guide), 0.1f);
  for (uint32_t cell = 0; cell < next->fractions().size(); ++cell) {
    if (cell != next->CellAt(by_bsdf) && cell != next->CellAt(by_guide)) {
      EXPECT_EQ(next->fractions()[cell], 0.5f) << cell;
    }
  }
}

TEST(FocalAdvance, ADivergingOctreeFindsWhereDirectionsComeFrom) {
  Training training;
  training.options.diverging = true;
  auto field = FocalField::Initial(kUnit, training.options);
  const Vec3 focus{0.1f, 0.2f, 0.3f};
  Random random(5);
  for (int k = 0; k < 12; ++k) {
    FocalStatistics statistics(field);
    for (int i = 0; i < 3000; ++i) {
      FocalRecord r;
      r.position =
          Lerp(0.3f + 0.7f * random.Next1D(), focus, focal_testing::PointIn({{0.5f, 0.5f, 0.5f}, {1, 1, 1}}, random));
      r.direction = Normalize(r.position - focus);
      r.distance = focal_testing::WallDistance(r.position, r.direction, kUnit);
      r.value = r.pdf = r.bsdf_pdf = r.guide_pdf = 1;
      statistics.Record(r);
    }
    field = Advance(*field, statistics);
  }
  EXPECT_GT(field->octrees()[1].mass(), 0.9 * field->mass());
  EXPECT_GT(LeafMass(field->octrees()[1], field->ToUnit(focus)), 1e-2);
  const Vec3 x{0.7f, 0.8f, 0.9f};
  EXPECT_GT(field->Pdf(x, Normalize(x - focus)), 10);
}

}  // namespace
}  // namespace lodestar
