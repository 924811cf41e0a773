// A worker that does what a test tells it, lease by lease, and nothing else.
#pragma once

#include "core/learning/contribution.h"
#include "core/scene/pbrt_parser.h"
#include "core/tracing/local_executor.h"
#include "rpc/farm_client.h"
#include "rpc/work_client.h"

namespace lodestar {

class HandWorker {
 public:
  HandWorker(const std::string& address, const SceneBundle& scene, const JobSpec& spec,
             const std::string& name = "hand", const std::string& canary = "", const std::string& tree_canary = "")
      : client_(address),
        spec_(spec),
        compiled_(CompileJob(ParsePbrtFile(scene.files.front().path), spec)),
        method_(MakeMethod(spec, compiled_.survey)),
        executor_(compiled_.scene, spec, *method_, 1) {
    WorkerInfo info;
    info.build_id = "by hand";
    info.canary = canary;
    info.tree_canary = tree_canary;
    info.name = name;
    id_ = client_.Register(info).id;
  }
  const WorkerId& id() const { return id_; }
  std::optional<LeasedUnit> Lease(std::chrono::milliseconds wait = std::chrono::seconds(5)) {
    return client_.Lease(id_, wait);
  }
  void Survey(const LeasedUnit& unit) {
    client_.SubmitSurvey({id_, unit.id, unit.job, compiled_.survey.Serialize(), "", {}});
  }
  void Answer(const LeasedUnit& shard, const Bytes& trees) { client_.SubmitShard({id_, shard.id, shard.job, trees}); }
  void Fail(const LeasedUnit& unit, const std::string& why) {
    client_.ReportFailure({UnitFailure::Kind::kWorker, id_, unit.id, unit.job, why});
  }
  ContributionOutcome Render(const LeasedUnit& unit) {
    const RenderUnit& r = *unit.render;
    if (state_hash_ != r.state) {
      state_ = method_->ParseState(client_.FetchState(r.state));
      state_hash_ = r.state;
    }
    Contribution contribution;
    executor_.ExecuteNode(state_, r.round, r.node, StopToken(), &contribution);
    return client_.SubmitContribution({id_, {unit.id}, unit.job, r.round, {r.node}, r.state, 0, 0.01},
                                      SerializeContribution(contribution));
  }

 private:
  WorkClient client_;
  const JobSpec spec_;
  const CompiledJob compiled_;
  const std::unique_ptr<Method> method_;
  LocalExecutor executor_;
  WorkerId id_;
  ContentHash state_hash_;
  std::shared_ptr<const State> state_;
};

}  // namespace lodestar
