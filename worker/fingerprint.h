// What two workers must have in common for their results to be the same bits.
#pragma once

#include <string>

#include "rpc/work_types.h"

namespace lodestar {

// Build id: hash of the running executable. Canary: hash of the image of a small scene, rendered here.
WorkerInfo DescribeWorker(const std::string& name, int threads);

}  // namespace lodestar
