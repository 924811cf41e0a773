#include "core/guiding/focal_field.h"

#include <gtest/gtest.h>

#include "core/math/frame.h"
#include "core/math/warp.h"
#include "tests/guiding/focal_testing.h"
#include "tests/support/statistical.h"

namespace lodestar {
namespace {

using focal_testing::NaivePdf;
using focal_testing::PointIn;
using focal_testing::Random;
using focal_testing::RandomField;
using focal_testing::Train;
using focal_testing::Training;
using focal_testing::UniformDirection;

const Bounds3 kUnit{{0, 0, 0}, {1, 1, 1}};
const double kLevel = test::SidakLevel(0.01, 32);

// Directions against the density, in kBins x kBins cells of equal area. The density has many kinks and no lobe, so a
// dense grid of midpoints integrates it better than an adaptive rule. x_pdf: where the density is taken.
test::TestResult ChiSquare(const FocalField& field, Vec3 x, uint64_t seed, Vec3 x_pdf, double factor = 1) {
  constexpr int kBins = 16, kPoints = 40, kSamples = 60000;
  std::vector<double> observed(kBins * kBins + 1), expected(kBins * kBins + 1);
  Random random(seed);
  for (int i = 0; i < kSamples; ++i) {
    const Vec2 square = DirectionToCylindrical(field.Sample(x, random.Next2D()).w);
    ++observed[static_cast<size_t>(square.x * kBins) * kBins + static_cast<size_t>(square.y * kBins)];
  }
  double sum = 0;
  constexpr double kArea = 4 * 3.14159265358979 / (kBins * kBins * kPoints * kPoints);
  for (int i = 0; i < kBins * kPoints; ++i) {
    for (int j = 0; j < kBins * kPoints; ++j) {
      const Vec2 square{(static_cast<float>(i) + 0.5f) / (kBins * kPoints),
                        (static_cast<float>(j) + 0.5f) / (kBins * kPoints)};
      const double share = factor * kArea * field.Pdf(x_pdf, CylindricalToDirection(square));
      expected[static_cast<size_t>(i / kPoints * kBins + j / kPoints)] += kSamples * share;
      sum += share;
    }
  }
  // What the density leaves to be sampled elsewhere is a bin of its own, as in test::ChiSquareOnSphere.
  expected.back() = sum < 0.998 ? kSamples * (1 - sum) : 0;
  test::TestResult result = test::ChiSquareTest(observed, expected, kLevel);
  result.accepted &= sum < 1.002;
  result.message += "; integral " + std::to_string(sum);
  return result;
}
test::TestResult ChiSquare(const FocalField& field, Vec3 x, uint64_t seed) {
  return ChiSquare(field, x, seed, x);
}

// All mass in the voxels that hold these points, at this depth; an eighth of it evenly around.
std::shared_ptr<const FocalField> Focused(const Bounds3& box, int depth, Vec3 focus, float ground = 0.125f) {
  FocalParts parts = PartsOf(*FocalField::Initial(box, {}));
  FocalParts::Octree& octree = parts.octrees[0];
  octree = {};
  for (int level = 1; level <= depth; ++level) {
    const float cells = std::ldexp(1.0f, level);
    int octant = 0;
    for (int axis = 0; axis < 3; ++axis) octant |= (static_cast<int>(focus[axis] * cells) & 1) << axis;
    octree.inner.push_back(level < depth ? static_cast<uint8_t>(1 << octant) : 0);
    for (int c = 0; c < 8; ++c) {
      if (c == octant && level < depth) continue;
      octree.leaf_masses.push_back(c == octant ? 1 - ground : ground / static_cast<float>(7 * depth));
    }
  }
  parts.weight = 1;
  return std::make_shared<const FocalField>(std::move(parts));
}

TEST(FocalField, SamplesFollowTheDensity) {
  Training training;
  training.radius = 0.1f;
  const auto trained = Train(training, 9);
  ASSERT_EQ(trained->octrees()[0].depth(), 6);
  uint64_t seed = 1;
  for (const Vec3 x : {Vec3{0.9f, 0.1f, 0.1f}, Vec3{0.5f, 0, 0.5f}, Vec3{1, 1, 1}}) {
    const test::TestResult result = ChiSquare(*trained, x, seed++);
    EXPECT_TRUE(result.accepted) << result.message;
  }
  for (uint64_t tree = 0; tree < 4; ++tree) {
    const auto field = RandomField(kUnit, 5, tree, 2, tree == 3);
    const test::TestResult result = ChiSquare(*field, {0.2f, 0.8f, 0.4f}, seed++);
    EXPECT_TRUE(result.accepted) << tree << ": " << result.message;
  }
}

// Voxels of the ninth level, which the cells above cannot resolve: as many samples fall into a narrow cone around the
// light as the density, integrated over that cone, says.
TEST(FocalField, AFocusIsFoundAsOftenAsItsDensitySays) {
  Training training;
  const auto field = Train(training, 12);
  ASSERT_GE(field->octrees()[0].depth(), 7);
  Random random(12);
  for (const Vec3 x : {Vec3{0.9f, 0.1f, 0.1f}, Vec3{0.5f, 0, 0.5f}}) {
    const Frame frame = Frame::FromNormal(Normalize(training.light - x));
    constexpr float kRadius = 0.03f;
    constexpr int kSide = 1000, kSamples = 100000;
    double share = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      const Vec2 d = Vec2{static_cast<float>(i / kSide) + 0.5f, static_cast<float>(i % kSide) + 0.5f} * (2.0f / kSide) -
                     Vec2{1, 1};
      if (d.x * d.x + d.y * d.y > 1) continue;
      // Of the disc (x, y) = (sin theta cos phi, sin theta sin phi): solid angle is area / cos theta.
      const float a = d.x * kRadius, b = d.y * kRadius, cos = std::sqrt(1 - a * a - b * b);
      share += field->Pdf(x, frame.ToWorld({a, b, cos})) / cos * Sqr(2 * kRadius / kSide);
    }
    int inside = 0;
    for (int i = 0; i < kSamples; ++i) {
      const Vec3 local = frame.ToLocal(field->Sample(x, random.Next2D()).w);
      inside += local.z > 0 && local.x * local.x + local.y * local.y < kRadius * kRadius;
    }
    EXPECT_GT(share, 0.1);
    EXPECT_NEAR(inside, kSamples * share, 4 * std::sqrt(kSamples * share * (1 - share)));
  }
}

TEST(FocalField, AWrongDensityIsSeen) {
  const auto field = RandomField(kUnit, 5, 1, 2);
  const Vec3 x{0.2f, 0.8f, 0.4f};
  EXPECT_FALSE(ChiSquare(*field, x, 1, x, 0.95).accepted);
  EXPECT_FALSE(ChiSquare(*field, x, 1, x, 1.05).accepted);
  EXPECT_FALSE(ChiSquare(*field, x, 1, {0.24f, 0.8f, 0.4f}).accepted);
}

TEST(FocalField, ThePointMayLieInAHeavyVoxelOrOnItsFaces) {
  const auto field = Focused(kUnit, 5, {0.3f, 0.7f, 0.6f}, 0.5f);
  FocalOctree::Voxel voxel = field->octrees()[0].Choose(0);
  for (double target = 0; target < 1; target += 0.01) {
    const FocalOctree::Voxel other = field->octrees()[0].Choose(target * field->mass());
    if (field->octrees()[0].mass(other.slot) > field->octrees()[0].mass(voxel.slot)) voxel = other;
  }
  ASSERT_LT(voxel.size, 0.04f);
  const Vec3 lower = field->corner() + voxel.lower * field->sides(), side = field->sides() * voxel.size;
  uint64_t seed = 50;
  for (const Vec3 in : {Vec3{0.5f, 0.5f, 0.5f}, Vec3{0.01f, 0.3f, 0.99f}, Vec3{0, 0, 0}, Vec3{0.5f, 1, 0.5f}}) {
    const test::TestResult result = ChiSquare(*field, lower + in * side, seed++);
    EXPECT_TRUE(result.accepted) << result.message;
  }
}

// From inside it is all of the sphere, from outside a small part; elsewhere the density is zero.
TEST(FocalField, OneVoxelMayHoldAllMass) {
  const auto field = Focused(kUnit, 3, {0.3f, 0.7f, 0.6f}, 0);
  const FocalOctree::Voxel voxel = field->octrees()[0].Choose(0.5 * field->mass());
  ASSERT_EQ(voxel.size, 0.125f);
  ASSERT_EQ(field->octrees()[0].mass(voxel.slot), field->mass());
  const Vec3 lower = field->corner() + voxel.lower * field->sides(), side = field->sides() * voxel.size;
  uint64_t seed = 60;
  for (const Vec3 in : {Vec3{0.5f, 0.5f, 0.5f}, Vec3{0.9f, 0.2f, 0.02f}, Vec3{0, 0, 0}, Vec3{0.5f, 0, 0.5f},
                        Vec3{-0.5f, 0.3f, 0.5f}, Vec3{2, -2, 1.5f}, Vec3{0.5f, 3, 0.5f}, Vec3{5, -5, -4}}) {
    const Vec3 x = lower + in * side;
    const test::TestResult result = ChiSquare(*field, x, seed++);
    EXPECT_TRUE(result.accepted) << in.x << " " << in.y << " " << in.z << ": " << result.message;
  }
}

TEST(FocalField, FlatAndLongBoxesHaveDensities) {
  uint64_t seed = 80;
  for (const Bounds3& box :
       {Bounds3{{0, 0, 0}, {1, 1, 0}}, Bounds3{{-3, 5, 5}, {40, 5, 6}}, Bounds3{{1, 1, 1}, {1, 1, 1}}}) {
    const auto field = Focused(box, 2, {0.3f, 0.6f, 0.5f}, 0.5f);
    const Vec3 x = box.min + box.Diagonal() * 0.2f;
    const test::TestResult result = ChiSquare(*field, x, seed++);
    EXPECT_TRUE(result.accepted) << result.message;
  }
}

TEST(FocalField, ThePdfIntegratesToOne) {
  for (const auto& [field, tolerance] :
       {std::pair(RandomField(kUnit, 4, 2, 2), 1e-3), std::pair(Train({}, 12), 1e-2)}) {
    for (const Vec3 x : {Vec3{0.4f, 0.3f, 0.2f}, Vec3{0, 0.5f, 0.5f}, Vec3{0.3f, 0.7f, 0.6f}}) {
      double sum = 0;
      constexpr int kSide = 1000;
      for (int i = 0; i < kSide * kSide; ++i) {
        const Vec2 square{(static_cast<float>(i / kSide) + 0.5f) / kSide,
                          (static_cast<float>(i % kSide) + 0.5f) / kSide};
        sum += field->Pdf(x, CylindricalToDirection(square));
      }
      EXPECT_NEAR(sum * 4 * 3.14159265358979 / (kSide * kSide), 1, tolerance);
    }
  }
}

TEST(FocalField, SampledPdfIsThePdfOfTheDirection) {
  Training training;
  const auto trained = Train(training, 12);
  const auto random_field = RandomField(kUnit, 10, 3, 6, true);
  Random random(6);
  for (const auto& field : {trained, random_field}) {
    for (int i = 0; i < 100000; ++i) {
      const Vec3 x = PointIn(kUnit, random);
      const FocalSample s = field->Sample(x, random.Next2D());
      ASSERT_GT(s.pdf, 0);
      ASSERT_NEAR(Length(s.w), 1, 1e-6);
      ASSERT_EQ(s.pdf, field->Pdf(x, s.w));
    }
  }
}

TEST(FocalField, ThePdfIsThatOfTheRecursiveWalk) {
  Random random(7);
  for (uint64_t seed = 0; seed < 4; ++seed) {
    const Bounds3 box{{10, -2, 3}, {12, -1, 3.5f}};
    const auto field = RandomField(box, 6, seed, 3, seed == 3);
    for (int i = 0; i < 5000; ++i) {
      const Vec3 x = PointIn(box, random), w = UniformDirection(random);
      const double expected = NaivePdf(*field, x, w);
      ASSERT_NEAR(field->Pdf(x, w), expected, 3e-3 * expected + 1e-4);
    }
  }
}

// All mass in one voxel of the deepest level: 256 steps of a float wide. No sample may miss it.
TEST(FocalField, SamplesOfADeepVoxelStayInIt) {
  for (const Vec3 focus : {Vec3{0.3f, 0.7f, 0.6f}, Vec3{0, 0, 0}, Vec3{0.999999f, 0.5f, 0.25f}}) {
    const auto field = Focused(kUnit, FocalOctree::kMaxDepth, focus, 0);
    Random random(8);
    for (int i = 0; i < 50000; ++i) {
      const Vec3 x = PointIn(kUnit, random);
      const FocalSample s = field->Sample(x, random.Next2D());
      ASSERT_GT(s.pdf, 0) << i;
      ASSERT_TRUE(std::isfinite(s.pdf));
    }
  }
}

TEST(FocalField, PowersOfTwoOfTheScaleChangeNothing) {
  Training training, scaled;
  training.records = scaled.records = 4000;
  const float kFactor = 0x1p20f;
  scaled.box = {training.box.min * kFactor, training.box.max * kFactor};
  scaled.emission = training.emission * 0x1p30f;
  const auto field = Train(training, 12), same = Train(scaled, 12);
  ASSERT_EQ(field->octrees()[0].node_count(), same->octrees()[0].node_count());
  Random random(9);
  for (int i = 0; i < 10000; ++i) {
    const Vec3 x = PointIn(training.box, random);
    const Vec2 u = random.Next2D();
    const FocalSample a = field->Sample(x, u), b = same->Sample(x * kFactor, u);
    ASSERT_EQ(a.w, b.w);
    ASSERT_EQ(a.pdf, b.pdf);
  }
}

TEST(FocalField, TinyHugeAndFarBoxesStayFinite) {
  Random random(10);
  for (const Bounds3& box :
       {Bounds3{{0, 0, 0}, {1e-4f, 1e-4f, 1e-5f}}, Bounds3{{-1e7f, -1e7f, -1e7f}, {1e7f, 1e7f, 1e7f}},
        Bounds3{{1e6f, 1e6f, 1e6f}, {1.01e6f, 1.01e6f, 1e6f}}}) {
    Training training;
    training.box = box;
    training.records = 3000;
    const auto field = Train(training, 12);
    ASSERT_TRUE(field->HasLearned());
    for (int i = 0; i < 5000; ++i) {
      const Vec3 x = PointIn(box, random);
      const FocalSample s = field->Sample(x, random.Next2D());
      ASSERT_TRUE(std::isfinite(s.pdf) && s.pdf > 0);
      ASSERT_TRUE(IsFinite(s.w));
      const float elsewhere = field->Pdf(x, UniformDirection(random));
      ASSERT_TRUE(std::isfinite(elsewhere) && elsewhere >= 0);
    }
  }
}

TEST(FocalField, SerialFormIsCanonical) {
  for (const auto& field : {Train({}, 9), RandomField(kUnit, 8, 4, 4, true)}) {
    const Bytes bytes = field->Serialize();
    const auto again = FocalField::Parse(bytes);
    EXPECT_EQ(again->fingerprint(), field->fingerprint());
    EXPECT_TRUE(again->Serialize() == bytes);
    EXPECT_EQ(again->Pdf({0.1f, 0.2f, 0.3f}, {0, 0, 1}), field->Pdf({0.1f, 0.2f, 0.3f}, {0, 0, 1}));
  }
}

TEST(FocalField, CorruptBytesAreRefusedOrValid) {
  const auto field = RandomField(kUnit, 4, 4, 3, true);
  const Bytes bytes = field->Serialize();
  for (size_t size = 0; size < bytes.size(); size += size < 300 ? 1 : 37)
    ASSERT_THROW(FocalField::Parse(std::string_view(bytes).substr(0, size)), Error) << size;
  EXPECT_THROW(FocalField::Parse(bytes + '\0'), Error);
  Random random(11);
  int refused = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    Bytes changed = bytes;
    const size_t range = trial % 2 ? changed.size() : 200;
    for (int flips = 1 + trial % 3; flips > 0; --flips)
      changed[random.Next() % range] ^= static_cast<char>(1 << (trial % 8));
    try {
      const auto parsed = FocalField::Parse(changed);
      ASSERT_TRUE(parsed->Serialize() == changed);
      const FocalSample s = parsed->Sample(PointIn(kUnit, random), random.Next2D());
      ASSERT_FALSE(std::isnan(s.pdf));
    } catch (const Error& error) {
      ASSERT_EQ(error.kind(), ErrorKind::kCorrupt);
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
}

TEST(FocalField, BadBoundsAndSettingsAreRefused) {
  EXPECT_THROW(FocalField::Initial(Bounds3{}, {}), Error);
  EXPECT_THROW(FocalField::Initial({{0, 0, 0}, {kInfinity, 1, 1}}, {}), Error);
  EXPECT_THROW(FocalField::Initial({{0, 0, std::nanf("")}, {1, 1, 1}}, {}), Error);
  const auto refused = [](auto change) {
    FocalOptions options;
    change(options);
    EXPECT_THROW(FocalField::Initial(kUnit, options), Error);
  };
  refused([](FocalOptions& o) { o.start_depth = 0; });
  refused([](FocalOptions& o) { o.initial_iterations = 0; });
  refused([](FocalOptions& o) { o.narrow_factor = std::nanf(""); });
  refused([](FocalOptions& o) { o.split_threshold = 0; });
  refused([](FocalOptions& o) { o.decay = 1.5f; });
  refused([](FocalOptions& o) { o.bsdf_fraction = 1; });
  refused([](FocalOptions& o) { o.max_nodes = 10; });
}

}  // namespace
}  // namespace lodestar
