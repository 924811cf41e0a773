// CIE data in steps of 5 nm; see spectrum_tables.cpp for the sources.
#pragma once

namespace lodestar {

inline constexpr int kCieFirstNm = 380, kCieLastNm = 780, kCieStepNm = 5;
inline constexpr int kCieRows = (kCieLastNm - kCieFirstNm) / kCieStepNm + 1;

struct CieRow {
  float x, y, z;  // colour-matching functions of the 1931 2-degree observer
  float d65;      // relative power of illuminant D65
};
extern const CieRow kCieRowsTable[kCieRows];

}  // namespace lodestar
