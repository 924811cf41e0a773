#include "core/math/exact_sum_bytes.h"

namespace lodestar {

// One form only for each value: a trailing zero byte or a tenth byte above one is refused.
uint64_t GetLongVarint(ByteReader& in, uint64_t first) {
  uint64_t value = first & 0x7f;
  for (int shift = 7; shift < 64; shift += 7) {
    const uint64_t byte = in.Get<uint8_t>();
    if (shift == 63 && byte > 1) in.Fail("has a number of more than 64 bits");
    value |= (byte & 0x7f) << shift;
    if (byte < 0x80) {
      if (byte == 0) in.Fail("has a number that is not in its shortest form");
      return value;
    }
  }
  in.Fail("has a number of more than 64 bits");
}

namespace {

template <class T>
T Load(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof(T));
  return value;
}

// 1 to 16 little-endian bytes, by loads of fixed size that may overlap: a copy of variable length costs more than all
// else that is done with a sum.
unsigned __int128 LoadBytes(std::string_view bytes) {
  const char* const p = bytes.data();
  const size_t n = bytes.size();
  if (n > 8) {
    const uint64_t high = Load<uint64_t>(p + n - 8) >> (8 * (16 - n));
    return static_cast<unsigned __int128>(high) << 64 | Load<uint64_t>(p);
  }
  if (n >= 4) return Load<uint32_t>(p) | static_cast<uint64_t>(Load<uint32_t>(p + n - 4)) << (8 * (n - 4));
  const auto byte = [&](size_t i) { return static_cast<uint32_t>(static_cast<uint8_t>(p[i])) << (8 * i); };
  return byte(0) | byte(n / 2) | byte(n - 1);
}

}  // namespace

__int128 GetWide(ByteReader& in) {
  const int header = in.Get<uint8_t>();
  if (header == 0xff) return 0;
  const int skipped = header / 16, count = header % 16 + 1;
  if (skipped + count > 16) in.Fail("has a sum of more than 128 bits");
  const std::string_view bytes = in.GetRaw(static_cast<size_t>(count));
  if (bytes.front() == 0 || bytes.back() == 0) in.Fail("has a sum that is not in its shortest form");
  const unsigned __int128 bits = LoadBytes(bytes) << (8 * skipped);
  return static_cast<__int128>((bits >> 1) ^ (~(bits & 1) + 1));
}

ExactSum GetAnySum(ByteReader& in) {
  const __int128 units = GetWide(in);
  const ExactSum sum = ExactSum::FromUnits(units);
  if (units < 0 || sum.Units() != units) in.Fail("has a sum out of range");
  return sum;
}

}  // namespace lodestar
