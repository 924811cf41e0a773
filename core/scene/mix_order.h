// The order in which materials can be compiled. A mix names its parts by index, and in a file they may stand before or
// after it.
#pragma once

#include <vector>

#include "core/scene/description.h"

namespace lodestar {

// All indices of `materials`, the parts of every mix before it. Throws Error(kInvalidInput) with the directive's place
// for a mix that contains itself or names a material that does not exist.
std::vector<int> PartsBeforeMixes(const std::vector<MaterialDescription>& materials);

}  // namespace lodestar
