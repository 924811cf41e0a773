// All conversion between the protocol's messages and the plain types. From a message: throws Error(kInvalidInput) for
// what cannot be represented.
#pragma once

#include "lodestar/v1/contribution.pb.h"
#include "lodestar/v1/job.pb.h"
#include "lodestar/v1/work.pb.h"
#include "lodestar/v1/worker.pb.h"
#include "rpc/work_types.h"

namespace lodestar {

v1::JobSpec ToProto(const JobSpec& spec);
v1::SceneManifest ToProto(const SceneManifest& manifest);
v1::JobSubmission ToProto(const JobSubmission& submission);
v1::JobStatus ToProto(const JobStatus& status);
v1::WorkerStatus ToProto(const WorkerStatus& status);
v1::Round ToProto(const Round& round);
v1::TreeNode ToProto(TreeNode node);
v1::Lease ToProto(const LeasedUnit& lease);
v1::ContributionHeader ToProto(const ContributionHeader& header);
v1::RegisterRequest ToProto(const WorkerInfo& info);
v1::SubmitSurveyRequest ToProto(const SurveyResult& result);
v1::SubmitShardRequest ToProto(const ShardAnswer& answer);
v1::ReportFailureRequest ToProto(const UnitFailure& failure);

JobSpec FromProto(const v1::JobSpec& message);
SceneManifest FromProto(const v1::SceneManifest& message);  // validated
JobSubmission FromProto(const v1::JobSubmission& message);
JobStatus FromProto(const v1::JobStatus& message);
WorkerStatus FromProto(const v1::WorkerStatus& message);
Round FromProto(const v1::Round& message);
TreeNode FromProto(const v1::TreeNode& message);
LeasedUnit FromProto(const v1::Lease& message);
ContributionHeader FromProto(const v1::ContributionHeader& message);
WorkerInfo FromProto(const v1::RegisterRequest& message);
SurveyResult FromProto(const v1::SubmitSurveyRequest& message);
ShardAnswer FromProto(const v1::SubmitShardRequest& message);
UnitFailure FromProto(const v1::ReportFailureRequest& message);

// Throws Error(kInvalidInput) naming the first field, at any depth, that this build does not know: a newer peer must
// not be half understood.
void RefuseUnknownFields(const google::protobuf::Message& message);

}  // namespace lodestar
