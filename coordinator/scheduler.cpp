#include "coordinator/scheduler.h"

#include <algorithm>

namespace lodestar {

void SortByRank(std::vector<JobRank>& jobs) {
  std::sort(jobs.begin(), jobs.end(), [](const JobRank& a, const JobRank& b) {
    return a.priority != b.priority ? a.priority > b.priority : a.number < b.number;
  });
}

}  // namespace lodestar
