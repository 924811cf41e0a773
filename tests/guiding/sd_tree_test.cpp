#include "core/guiding/sd_tree.h"

#include <gtest/gtest.h>

#include "tests/guiding/synthetic.h"

namespace lodestar {
namespace {

using synthetic::Train;
using synthetic::Training;

TEST(SdTree, SampledPdfIsThePdfOfTheDirection) {
  Training training;
  training.options.spatial_threshold = 1000;
  const auto tree = Train(training, 5);
  ASSERT_GT(tree->leaf_count(), 50u);
  uint64_t rng = 5;
  for (int i = 0; i < 1000000; ++i) {
    const uint32_t leaf = tree->LeafAt(synthetic::Unit3(rng));
    const GuidedSample s = tree->Sample(leaf, synthetic::Unit2(rng));
    ASSERT_GT(s.pdf, 0);
    ASSERT_EQ(s.pdf, tree->Pdf(leaf, s.w)) << i;
  }
}

TEST(SdTree, SerialFormIsCanonical) {
  Training training;
  training.options.spatial_threshold = 1000;
  const auto tree = Train(training, 4);
  const Bytes bytes = tree->Serialize();
  const auto again = SdTree::Parse(bytes);
  EXPECT_EQ(again->fingerprint(), tree->fingerprint());
  EXPECT_EQ(again->Serialize(), bytes);
}

}  // namespace
}  // namespace lodestar
