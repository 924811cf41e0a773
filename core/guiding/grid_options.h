// Settings of the radiance grid (Kim 2022, "Fast and Lightweight Path Guiding Algorithm on GPU"). The resolutions are
// the document's choice; its learning rate is not stated.
#pragma once

#include <cstdint>

#include "core/base/bytes.h"

namespace lodestar {

struct GridOptions {
  static constexpr uint64_t kMostEntries = uint64_t{1} << 24;  // of the whole table; 8 bytes each in a state

  int cells = 8;                // along each side of the scene's box; 1 to 32
  int directions = 16;          // over cos theta, twice as many over phi; 4, 8, 16 or 32
  float learning_rate = 0.02f;  // a: what a record takes from all before it; from 1e-6 to 1
  float prior = 10;  // what the directions around say of an entry counts as this many records; 0 to 1000, 0: nothing

  uint32_t cell_count() const { return static_cast<uint32_t>(cells * cells * cells); }
  uint32_t direction_count() const { return static_cast<uint32_t>(2 * directions * directions); }

  // Throws Error(kInvalidInput) naming the setting.
  void Validate() const;
  void Write(ByteWriter& out) const;
  // Throws Error(kCorrupt).
  static GridOptions Read(ByteReader& in);
  friend bool operator==(const GridOptions&, const GridOptions&) = default;
};

}  // namespace lodestar
