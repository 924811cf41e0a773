// What workers and the coordinator speak about, as plain values.
#pragma once

#include <optional>

#include "core/base/clock.h"
#include "core/learning/round.h"
#include "rpc/types.h"

namespace lodestar {

struct WorkerInfo {
  uint32_t protocol_version = kProtocolVersion;
  std::string build_id, canary, name;
  uint32_t threads = 1;
  std::string tree_canary;  // TreeCanary(): only a worker that makes trees as its coordinator does is asked to
  // A job runs on workers of one fingerprint.
  std::string Fingerprint() const { return build_id + "/" + canary; }
};
struct Registration {
  WorkerId id;
  uint64_t epoch = 0;
  Clock::Duration lease_duration{};
};

struct RenderUnit {
  Round round;
  TreeNode node;
  ContentHash state;
  Bytes survey;  // Survey::Serialize() of the job's survey
  friend bool operator==(const RenderUnit&, const RenderUnit&) = default;
};
// D-trees to be made for a coordinator that advances a state.
struct ShardUnit {
  Bytes request;  // core/guiding/tree_request.h
  friend bool operator==(const ShardUnit&, const ShardUnit&) = default;
};
struct LeasedUnit {
  LeaseId id;
  JobId job;
  ContentHash description;  // of JobDescription::Serialize()
  Clock::Duration duration{};
  // One of them; both absent: a survey.
  std::optional<RenderUnit> render;
  std::optional<ShardUnit> shard;
};

// What a worker must know of a job, as one content-addressed document.
struct JobDescription {
  JobSpec spec;
  SceneManifest scene;
  uint32_t threads = 0;  // JobSubmission's
  Bytes Serialize() const;
  static JobDescription Parse(std::string_view bytes);
};

// Of one contribution: what one or more leases of a round brought.
struct ContributionHeader {
  WorkerId worker;
  std::vector<LeaseId> leases;
  JobId job;
  Round round;
  std::vector<TreeNode> nodes;  // ascending
  ContentHash state;
  uint64_t size = 0;  // bytes
  double seconds = 0;

  // Whether what the unit brings can be added: of the same job, round and state, and nothing of it there yet. (A
  // coordinator that has forgotten a lease may give out its units again, to the same worker too.)
  bool Takes(const LeasedUnit& unit) const;
  // A unit that it takes.
  void Add(const LeasedUnit& unit);
};
enum class ContributionOutcome { kCommitted = 1, kCovered, kStale, kJobEnded };

struct SurveyResult {
  WorkerId worker;
  LeaseId lease;
  JobId job;
  Bytes survey;  // empty where the scene is in error
  std::string scene_error;
  std::vector<std::string> log;
};
struct ShardAnswer {
  WorkerId worker;
  LeaseId lease;
  JobId job;
  Bytes trees;  // AnswerTreeRequest()
};
struct UnitFailure {
  enum class Kind { kReturned = 1, kJob, kWorker } kind = Kind::kReturned;
  WorkerId worker;
  LeaseId lease;
  JobId job;
  std::string message;
};

}  // namespace lodestar
