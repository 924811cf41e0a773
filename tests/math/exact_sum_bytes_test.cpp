#include "core/math/exact_sum_bytes.h"

#include <gtest/gtest.h>

#include <optional>
#include <random>
#include <vector>

namespace lodestar {
namespace {

const std::vector<__int128> kWide = [] {
  std::vector<__int128> values = {0, 1, -1, 127, 128, 255, 256, -256};
  for (int bits = 1; bits < 126; bits += 5) {
    const __int128 power = static_cast<__int128>(1) << bits;
    values.insert(values.end(), {power, power - 1, power + 1, -power, 1 - power});
  }
  return values;
}();

TEST(ExactSumBytes, NumbersReturnAndTakeWhatTheyNeed) {
  for (int shift = 0; shift < 64; ++shift) {
    const uint64_t value = ~uint64_t{0} >> shift;
    ByteWriter out;
    PutVarint(out, value);
    EXPECT_EQ(out.bytes().size(), static_cast<size_t>((64 - shift + 6) / 7));
    ByteReader in(out.bytes(), "number");
    EXPECT_EQ(GetVarint(in), value);
    in.ExpectEnd();
  }
  for (const __int128 value : kWide) {
    ByteWriter out;
    PutWide(out, value);
    EXPECT_LE(out.bytes().size(), 17u);
    ByteReader in(out.bytes(), "sum");
    EXPECT_TRUE(GetWide(in) == value);
    in.ExpectEnd();
  }
}

// All short byte strings: whatever is read is written alike, so no value has two forms.
TEST(ExactSumBytes, EveryValueHasOneForm) {
  size_t read = 0, refused = 0;
  for (uint32_t bits = 0; bits < (1u << 24); bits += 37) {
    const Bytes bytes = {static_cast<char>(bits), static_cast<char>(bits >> 8), static_cast<char>(bits >> 16)};
    for (const bool wide : {false, true}) {
      ByteReader in(bytes, "bytes");
      ByteWriter out;
      try {
        if (wide) {
          PutWide(out, GetWide(in));
        } else {
          PutVarint(out, GetVarint(in));
        }
      } catch (const Error& error) {
        ASSERT_EQ(error.kind(), ErrorKind::kCorrupt);
        ++refused;
        continue;
      }
      ++read;
      ASSERT_EQ(out.bytes(), bytes.substr(0, bytes.size() - in.remaining()));
    }
  }
  EXPECT_GT(read, 1000u);
  EXPECT_GT(refused, 1000u);
}

// The fast reader of sums and the general one: the same values from the same bytes, and the same refused.
TEST(ExactSumBytes, BothReadersOfSumsAgree) {
  std::mt19937 random(1);
  size_t read = 0, refused = 0;
  for (int i = 0; i < 200000; ++i) {
    Bytes bytes(1 + random() % 20, '\0');
    for (char& c : bytes) c = static_cast<char>(random() % 4 == 0 ? 0 : random());
    bytes[0] = static_cast<char>(random() % 2 ? random() % 128 : random());
    ByteReader fast(bytes, "bytes"), general(bytes, "bytes");
    std::optional<ExactSum> a, b;
    try {
      b = GetAnySum(general);
      ++read;
    } catch (const Error&) {
      ++refused;
    }
    try {
      a = GetSum(fast);
    } catch (const Error&) {
    }
    ASSERT_EQ(a, b) << i;
    ASSERT_EQ(fast.remaining(), general.remaining());
  }
  EXPECT_GT(read, 10000u);
  EXPECT_GT(refused, 10000u);
}

TEST(ExactSumBytes, SumsOutOfRangeAreRefused) {
  const auto refused = [](__int128 units) {
    ByteWriter out;
    PutWide(out, units);
    ByteReader in(out.bytes(), "sum");
    try {
      GetSum(in);
    } catch (const Error&) {
      return true;
    }
    return false;
  };
  const __int128 limit = static_cast<__int128>(1) << 126;
  EXPECT_FALSE(refused(0));
  EXPECT_FALSE(refused(limit - 1));
  EXPECT_TRUE(refused(limit));
  EXPECT_TRUE(refused(-1));
}

TEST(ExactSumBytes, IndicesStayWithinTheirLimit) {
  ByteWriter out;
  IndexWriter writer;
  for (const uint64_t index : {0u, 1u, 7u, 300u, 301u}) writer.Put(out, index);
  const auto last = [&](uint64_t limit) {
    ByteReader in(out.bytes(), "indices");
    IndexReader reader(limit);
    uint64_t index = 0;
    for (int i = 0; i < 5; ++i) index = reader.Get(in, "too far");
    return index;
  };
  EXPECT_EQ(last(302), 301u);
  EXPECT_THROW(last(301), Error);
  EXPECT_THROW(last(0), Error);
}

}  // namespace
}  // namespace lodestar
