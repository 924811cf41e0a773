// A job as the coordinator holds it in memory. All members are guarded by the farm's mutex unless they say otherwise.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

#include "coordinator/job_store.h"
#include "coordinator/lease_table.h"
#include "coordinator/shard_table.h"
#include "core/base/stop.h"
#include "core/learning/loop.h"
#include "core/learning/reduction.h"

namespace lodestar {

// A round that is being leased out: what is merged of it, and who should work on the rest.
struct OpenRound {
  OpenRound(const ContentHash& of, RoundReduction nothing_yet, const Round& r, const LeaseTable::Options& options,
            const Clock& clock, BusyClock& busy)
      : round(r), state_hash(of), reduction(std::move(nothing_yet)), leases(r.unit_count, options, clock, busy) {}
  const Round round;
  const ContentHash state_hash;
  std::mutex merge;  // guards `reduction`; taken without the farm's mutex, so that merging blocks nobody
  RoundReduction reduction;
  LeaseTable leases;
};

// What exists while a driver thread runs the job's loop.
struct JobRun {
  JobRun(const Loop& loop, const Clock& clock)
      : method(MakeMethod(loop.job(), loop.survey())), grid(loop.grid()), busy(clock) {}
  const std::unique_ptr<Method> method;  // its own: a late contribution may outlive the loop
  const TileGrid grid;
  BusyClock busy;  // while a lease is out or the loop itself works: waiting for workers costs a job none of its time
  std::shared_ptr<const State> state;
  ContentHash state_hash;
  std::shared_ptr<const Bytes> state_bytes;      // as they are sent
  std::vector<std::shared_ptr<OpenRound>> open;  // the round under way, and the announced one that may follow it
  std::shared_ptr<ShardTable> shards;            // of the advance under way, once workers may share in it
  // For lease sizes only; 0: unknown.
  std::map<WorkerId, double> pass_seconds;  // of one pass over one unit
  double mean_pass_seconds = 0, bytes_per_unit = 0;
  // What the farm itself cost, for the log.
  double merging_seconds = 0, publishing_seconds = 0;
  uint64_t contributions = 0, contribution_bytes = 0, states = 0, largest_state = 0;
  uint64_t shards_offered = 0, shards_taken = 0;
};

struct SurveyLease {
  WorkerId worker;
  Clock::Duration expires{};
};

struct Job {
  StoredJob stored;
  JobSpec spec;
  JobProgress progress;
  uint32_t width = 0, height = 0;
  std::deque<std::string> log;

  std::map<LeaseId, SurveyLease> surveys;
  std::set<WorkerId> asked;  // to survey
  std::set<WorkerId> lost;   // workers lost on it since something was last committed
  Clock::Duration last_loss{};
  std::set<WorkerId> gave_back;  // workers that could not do its work, for a reason of their own

  std::shared_ptr<JobRun> run;
  std::thread driver;
  bool driving = false, driven = false;  // now; at some time in this process
  StopToken stop;
  bool cancelled = false;
  std::string failure;  // set by others than the driver, which then ends

  // A client wants to see; answered at the next round's edge.
  bool snapshot_wanted = false;
  std::shared_ptr<const Image> image;
  std::string report;

  // Taken before the farm's mutex by whoever changes `stored` and writes it, so that writes come in order.
  std::mutex persist;

  void Log(const std::string& line) {
    log.push_back(line);
    if (log.size() > 50) log.pop_front();
  }
};

}  // namespace lodestar
