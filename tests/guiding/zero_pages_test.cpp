#include "core/guiding/zero_pages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

namespace lodestar {
namespace {

constexpr size_t kMany = size_t{1} << 20;

bool AllZero(const ZeroPages<uint64_t>& array) {
  return std::all_of(array.data(), array.data() + array.size(), [](uint64_t value) { return value == 0; });
}

TEST(ZeroPages, KeptPagesServeALargerArray) {
  ZeroPages<uint64_t> first(kMany);
  std::fill_n(first.data(), kMany, 7);
  std::fill_n(first.data(), kMany, 0);
  const uint64_t* const at = first.data();
  first.Keep();
  EXPECT_EQ(first.data(), nullptr);
  ZeroPages<uint64_t> second(2 * kMany);
  EXPECT_EQ(second.data(), at);
  EXPECT_EQ(second.size(), 2 * kMany);
  EXPECT_TRUE(AllZero(second));
  second[2 * kMany - 1] = 1;  // dropped as it is
}

// How much of a mapping has pages is not forgotten where a smaller array used it in between: what has most is taken.
TEST(ZeroPages, ASmallUserDoesNotHideTheGreaterOneBefore) {
  ZeroPages<uint64_t> great(8 * kMany);
  const uint64_t* const at = great.data();
  great.Keep();
  ZeroPages<uint64_t> small(kMany);
  ASSERT_EQ(small.data(), at);
  ZeroPages<uint64_t> middle(4 * kMany);
  ASSERT_NE(middle.data(), at);
  small.Keep();
  middle.Keep();
  EXPECT_EQ(ZeroPages<uint64_t>(2 * kMany).data(), at);
}

TEST(ZeroPages, WhatIsNotKeptIsNotSeenAgain) {
  for (int i = 0; i < 3; ++i) {
    ZeroPages<uint64_t> array(kMany);
    EXPECT_TRUE(AllZero(array));
    std::fill_n(array.data(), kMany, 7);
  }
}

TEST(ZeroPages, BeginsACacheLine) {
  for (const size_t size : {size_t{1}, size_t{9}, size_t{1000}, kMany}) {
    ZeroPages<uint64_t> a(size), b(size);
    EXPECT_EQ(reinterpret_cast<uintptr_t>(a.data()) % 64, 0u) << size;
    EXPECT_EQ(reinterpret_cast<uintptr_t>(b.data()) % 64, 0u) << size;
  }
}

TEST(ZeroPages, SmallAndEmptyArraysToo) {
  for (const size_t size : {size_t{0}, size_t{1}, size_t{1000}}) {
    ZeroPages<uint64_t> array(size);
    EXPECT_EQ(array.size(), size);
    EXPECT_TRUE(AllZero(array));
    ZeroPages<uint64_t> moved = std::move(array);
    moved.Keep();
    moved.Keep();
    EXPECT_EQ(moved.size(), 0u);
  }
}

}  // namespace
}  // namespace lodestar
