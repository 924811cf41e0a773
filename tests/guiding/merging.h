// For tests of statistics: that parts of very unequal sizes merge to one part's bytes.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace lodestar {

// part(first, end): statistics of these of `count` records.
template <class Part>
void ExpectEmptySingleAndUnequalPartsMerge(int count, const Part& part) {
  const auto empty = part(0, 0), one = part(0, 1), most = part(1, count);
  const auto whole = part(0, count).Serialize();
  ASSERT_FALSE(most.Serialize() == whole);
  const decltype(&empty) parts[] = {&empty, &one, &most};
  std::array<size_t, 3> order = {0, 1, 2};
  do {
    auto merged = part(0, 0), read = part(0, 0);
    for (const size_t next : order) {
      merged.Merge(*parts[next]);
      read.MergeSerialized(parts[next]->Serialize());
    }
    EXPECT_TRUE(merged.Serialize() == whole);
    EXPECT_TRUE(read.Serialize() == whole);
  } while (std::next_permutation(order.begin(), order.end()));
  auto nothing = part(0, 0);
  nothing.Merge(empty);
  nothing.MergeSerialized(empty.Serialize());
  EXPECT_TRUE(nothing.Serialize() == empty.Serialize());
}

}  // namespace lodestar
