// A job's method and options on one line, for what a failing test says.
#pragma once

#include <string>

#include "core/learning/job.h"

namespace lodestar {

inline std::string Text(const JobSpec& job) {
  std::string text = job.method;
  for (const auto& [name, value] : job.options) text += " " + name + "=" + value;
  return text;
}

}  // namespace lodestar
