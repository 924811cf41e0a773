// Which job's work goes out first. Pure.
#pragma once

#include <cstdint>
#include <vector>

namespace lodestar {

struct JobRank {
  int64_t number = 0;  // ascending with age: smaller is older
  int priority = 0;
};
// Larger priorities first, older first among equals.
void SortByRank(std::vector<JobRank>& jobs);

}  // namespace lodestar
