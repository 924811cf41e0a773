// Statistics of any kind, read back from the bytes they were written as.
#pragma once

#include <memory>
#include <string_view>
#include <utility>

namespace lodestar::test {

template <class Sums, class State>
Sums FromBytes(std::shared_ptr<const State> state, std::string_view bytes) {
  Sums sums(std::move(state));
  sums.MergeSerialized(bytes);
  return sums;
}

}  // namespace lodestar::test
