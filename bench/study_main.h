// What studies share: how they end, with what their run returned or with the message of what it was given wrong; their
// clock, and the median of what it measured.
#pragma once

#include <time.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "core/base/error.h"

namespace lodestar {

inline int StudyMain(int (*run)(int argc, char** argv), int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}

// Of this process, all threads, system time included.
inline double CpuSeconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Of at least one value; the upper of two in the middle.
inline double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace lodestar
