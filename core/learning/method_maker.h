// How any method is made: of the job alone, or with the survey where it asks for one.
#pragma once

#include <memory>
#include <type_traits>

#include "core/learning/method.h"

namespace lodestar {

template <class M>
std::unique_ptr<Method> Make(const JobSpec& job, const Survey& survey) {
  if constexpr (std::is_constructible_v<M, const JobSpec&, const Survey&>) {
    return std::make_unique<M>(job, survey);
  } else {
    return std::make_unique<M>(job);
  }
}

}  // namespace lodestar
