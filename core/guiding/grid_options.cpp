#include "core/guiding/grid_options.h"

#include <bit>

#include "core/guiding/setting_bytes.h"

namespace lodestar {
namespace {

void Require(bool holds, const char* what) {
  RequireSetting(holds, "grid guiding", what);
}

}  // namespace

void GridOptions::Validate() const {
  Require(cells >= 1 && cells <= 32, "cells must be in [1, 32]");
  Require(directions >= 4 && directions <= 32 && std::has_single_bit(static_cast<unsigned>(directions)),
          "directions must be 4, 8, 16 or 32");
  Require(uint64_t{cell_count()} * direction_count() <= kMostEntries,
          "cells^3 * 2 * directions^2 must not exceed 2^24; take fewer of one");
  Require(learning_rate >= 1e-6f && learning_rate <= 1, "learning_rate must be in [1e-6, 1]");
  Require(prior >= 0 && prior <= 1000, "prior must be in [0, 1000]");
}

void GridOptions::Write(ByteWriter& out) const {
  out.Put<int32_t>(cells);
  out.Put<int32_t>(directions);
  out.Put(learning_rate);
  out.Put(prior);
}

GridOptions GridOptions::Read(ByteReader& in) {
  GridOptions options;
  options.cells = in.Get<int32_t>();
  options.directions = in.Get<int32_t>();
  options.learning_rate = in.Get<float>();
  options.prior = in.Get<float>();
  return Validated(options, in);
}

}  // namespace lodestar
