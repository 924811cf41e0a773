// The letters of pictures' titles: 5 x 7 points a glyph.
#pragma once

#include <array>
#include <cstdint>

namespace lodestar {

// Seven rows from the top, bit 4 the leftmost point. Small letters are drawn as capitals; what there is no glyph for,
// as a blank.
std::array<uint8_t, 7> Glyph(char c);

}  // namespace lodestar
