// Settings of a guide read back: what their Validate() refuses is corrupt.
#pragma once

#include "core/base/bytes.h"

namespace lodestar {

// Throws Error(kInvalidInput).
inline void RequireSetting(bool holds, const char* guide, const char* what) {
  if (!holds) throw Error(ErrorKind::kInvalidInput, std::string(guide) + " setting out of range: " + what);
}

template <class Options>
Options Validated(const Options& options, const ByteReader& in) {
  try {
    options.Validate();
  } catch (const Error& error) {
    in.Fail(error.what());
  }
  return options;
}

}  // namespace lodestar
