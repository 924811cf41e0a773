// One function out of a handler for each kind of a variant, for std::visit.
#pragma once

namespace lodestar {

template <class... Handlers>
struct Overloaded : Handlers... {
  using Handlers::operator()...;
};

}  // namespace lodestar
