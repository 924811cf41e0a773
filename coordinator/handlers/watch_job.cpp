#include "coordinator/handlers/farm_handlers.h"
#include "rpc/convert.h"

namespace lodestar {

uint64_t WatchJob(Farm& farm, const v1::WatchJobRequest& request, std::function<void(v1::JobStatus)> changed) {
  return farm.Watch({request.job_id()},
                    [changed = std::move(changed)](const JobStatus& status) { changed(ToProto(status)); });
}

}  // namespace lodestar
