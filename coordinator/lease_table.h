// Who should work on which nodes of one round. Pure: time comes from a clock, nothing blocks, nothing is sent. A lease
// decides who should work, never who may answer. Not thread-safe.
//
//   free --Grant--> leased --Commit--> covered
//                     |  '--Release, Expire--> free
//                     '--GrantCopy--> leased twice (a straggler's block, in halves)
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "coordinator/busy_clock.h"
#include "core/base/clock.h"
#include "core/learning/round.h"
#include "rpc/types.h"

namespace lodestar {

struct LeaseEntry {
  LeaseId id;
  WorkerId worker;
  TreeNode node;
  Clock::Duration granted{}, expires{};
};

class LeaseTable {
 public:
  struct Options {
    Clock::Duration duration = std::chrono::seconds(10);
    // Leases beyond this many bytes of expected results wait (0 bytes a unit: unknown).
    uint64_t byte_budget = uint64_t{1} << 30;
    // A worker is a straggler at `straggler_factor` times the time expected of all that it holds plus the grace; with
    // no expectation, after `unknown_grace`.
    double straggler_factor = 3;
    Clock::Duration straggler_grace = std::chrono::milliseconds(250), unknown_grace = std::chrono::seconds(2);
    uint32_t max_copies = 2;  // of one unit, the first included
  };
  // `busy` runs while a lease is out. Both clocks live longer.
  LeaseTable(uint32_t unit_count, const Options& options, const Clock& clock, BusyClock& busy);
  ~LeaseTable();
  LeaseTable(const LeaseTable&) = delete;
  LeaseTable& operator=(const LeaseTable&) = delete;

  // The lowest free aligned block of at most `max_units`.
  std::optional<LeaseEntry> Grant(LeaseId id, const WorkerId& worker, uint32_t max_units);
  // Half of a straggler's last block (the whole of a single unit) for a worker that does not hold it already.
  std::optional<LeaseEntry> GrantCopy(LeaseId id, const WorkerId& worker, double seconds_per_unit);
  // False: void, to be given up.
  bool Renew(LeaseId id, const WorkerId& worker);
  // The node's units are covered. Returns the leases that have nothing left to do.
  std::vector<LeaseEntry> Commit(TreeNode node);
  void Release(LeaseId id);
  std::vector<LeaseEntry> Expire();

  bool Covered(TreeNode node) const;
  bool complete() const { return uncovered_ == 0; }
  uint32_t unit_count() const { return static_cast<uint32_t>(units_.size()); }
  uint32_t free_units() const { return free_; }
  void set_bytes_per_unit(double bytes) { bytes_per_unit_ = bytes; }
  const std::map<LeaseId, LeaseEntry>& leases() const { return leases_; }

 private:
  struct Unit {
    bool covered = false;
    uint16_t holders = 0;
    bool free() const { return !covered && holders == 0; }
  };
  LeaseEntry Add(LeaseId id, const WorkerId& worker, TreeNode node);
  void Remove(const LeaseEntry& lease);
  template <class Condition>
  std::vector<LeaseEntry> RemoveIf(Condition&& condition);

  Options options_;
  const Clock& clock_;
  BusyClock& busy_;
  std::vector<Unit> units_;
  uint32_t uncovered_, free_;
  uint32_t lowest_free_ = 0;
  uint64_t leased_units_ = 0;
  double bytes_per_unit_ = 0;
  std::map<LeaseId, LeaseEntry> leases_;
};

// How many units a fresh lease should have: two seconds of work, or half of its worker's part of the round (`share` of
// it, by its speed) where the round is short; a quarter of the same part of what is left where no more work follows at
// once, so that all end together (guided self-scheduling, Polychronopoulos and Kuck 1987; each worker has one more
// lease waiting). But not less than 20 ms of work: a lease costs a call, though not a delivery of its own.
// `seconds_per_unit`: of rendering, by the worker that asks; while it is unknown (0), a twelfth of the part. For
// scheduling only.
uint32_t LeaseUnits(uint32_t free_units, uint32_t unit_count, double share, double seconds_per_unit, bool more_follows);

}  // namespace lodestar
