// The two gRPC services over a farm.
#pragma once

#include "coordinator/service/work_pool.h"
#include "lodestar/v1/farm.grpc.pb.h"
#include "lodestar/v1/worker.grpc.pb.h"

namespace lodestar {

class Farm;
std::unique_ptr<grpc::Service> NewFarmService(Farm& farm, WorkPool& pool);
std::unique_ptr<grpc::Service> NewWorkService(Farm& farm, WorkPool& pool);

}  // namespace lodestar
