#include "core/math/exact_sum_bytes.h"

namespace lodestar {

void PutVarint(ByteWriter& out, uint64_t value) {
  for (; value >= 0x80; value >>= 7) out.Put(static_cast<uint8_t>(value | 0x80));
  out.Put(static_cast<uint8_t>(value));
}

// One form only for each value: a trailing zero byte or a tenth byte above one is refused.
uint64_t GetVarint(ByteReader& in) {
  uint64_t value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    const uint64_t byte = in.Get<uint8_t>();
    if (shift == 63 && byte > 1) in.Fail("has a number of more than 64 bits");
    value |= (byte & 0x7f) << shift;
    if (byte < 0x80) {
      if (byte == 0 && shift > 0) in.Fail("has a number that is not in its shortest form");
      return value;
    }
  }
  in.Fail("has a number of more than 64 bits");
}

// Zigzag, then the bytes between the lowest and highest that are not zero. Header: skipped low bytes * 16 + count - 1;
// 0xff for zero.
void PutWide(ByteWriter& out, __int128 value) {
  unsigned __int128 bits = (static_cast<unsigned __int128>(value) << 1) ^ static_cast<unsigned __int128>(value >> 127);
  if (bits == 0) return out.Put<uint8_t>(0xff);
  int skipped = 0, count = 0;
  for (; (bits & 0xff) == 0; bits >>= 8) ++skipped;
  uint8_t bytes[16];
  for (; bits != 0; bits >>= 8) bytes[count++] = static_cast<uint8_t>(bits);
  out.Put(static_cast<uint8_t>(skipped * 16 + count - 1));
  for (int i = 0; i < count; ++i) out.Put(bytes[i]);
}

__int128 GetWide(ByteReader& in) {
  const int header = in.Get<uint8_t>();
  if (header == 0xff) return 0;
  const int skipped = header / 16, count = header % 16 + 1;
  if (skipped + count > 16) in.Fail("has a sum of more than 128 bits");
  unsigned __int128 bits = 0;
  for (int i = 0; i < count; ++i) {
    const uint8_t byte = in.Get<uint8_t>();
    if (byte == 0 && (i == 0 || i == count - 1)) in.Fail("has a sum that is not in its shortest form");
    bits |= static_cast<unsigned __int128>(byte) << (8 * (skipped + i));
  }
  return static_cast<__int128>((bits >> 1) ^ (~(bits & 1) + 1));
}

ExactSum GetSum(ByteReader& in) {
  const __int128 units = GetWide(in);
  const ExactSum sum = ExactSum::FromUnits(units);
  if (units < 0 || sum.Units() != units) in.Fail("has a sum out of range");
  return sum;
}

}  // namespace lodestar
