#include "coordinator/lease_table.h"

#include <algorithm>
#include <bit>
#include <functional>

#include "core/base/check.h"

namespace lodestar {

LeaseTable::LeaseTable(uint32_t unit_count, const Options& options, const Clock& clock, BusyClock& busy)
    : options_(options), clock_(clock), busy_(busy), units_(unit_count), uncovered_(unit_count), free_(unit_count) {
  LODESTAR_CHECK(unit_count > 0);
}

LeaseTable::~LeaseTable() {
  for (size_t i = 0; i < leases_.size(); ++i) busy_.End();
}

LeaseEntry LeaseTable::Add(LeaseId id, const WorkerId& worker, TreeNode node) {
  LeaseEntry lease{id, worker, node, clock_.Now(), clock_.Now() + options_.duration};
  for (uint32_t u = node.first(); u < node.end(unit_count()); ++u) {
    if (units_[u].free()) --free_;
    ++units_[u].holders;
    ++leased_units_;
  }
  LODESTAR_CHECK(leases_.emplace(id, lease).second);
  busy_.Begin();
  return lease;
}

// The units go back, except those that are covered; the entry itself is erased by the caller.
void LeaseTable::Remove(const LeaseEntry& lease) {
  busy_.End();
  for (uint32_t u = lease.node.first(); u < lease.node.end(unit_count()); ++u) {
    --units_[u].holders;
    --leased_units_;
    if (units_[u].free()) {
      ++free_;
      lowest_free_ = std::min(lowest_free_, u);
    }
  }
}

template <class Condition>
std::vector<LeaseEntry> LeaseTable::RemoveIf(Condition&& condition) {
  std::vector<LeaseEntry> removed;
  for (auto it = leases_.begin(); it != leases_.end();) {
    if (condition(it->second)) {
      Remove(it->second);
      removed.push_back(it->second);
      it = leases_.erase(it);
    } else {
      ++it;
    }
  }
  return removed;
}

std::optional<LeaseEntry> LeaseTable::Grant(LeaseId id, const WorkerId& worker, uint32_t max_units) {
  if (free_ == 0) return std::nullopt;
  // Step 1: the lowest free unit, inside the byte budget.
  while (!units_[lowest_free_].free()) ++lowest_free_;
  if (leased_units_ > 0 &&
      static_cast<double>(leased_units_ + 1) * bytes_per_unit_ > static_cast<double>(options_.byte_budget))
    return std::nullopt;
  // Step 2: the largest aligned block from there on that is free and not too large.
  TreeNode node{0, lowest_free_};
  const uint32_t top = TreeNode::Root(unit_count()).level;
  while (node.level < top && node.index % 2 == 0) {
    const TreeNode parent = node.Parent();
    if (parent.end(unit_count()) == node.end(unit_count())) break;  // the same units under a larger name
    if (parent.end(unit_count()) - parent.first() > max_units) break;
    bool all_free = true;
    for (uint32_t u = node.end(unit_count()); u < parent.end(unit_count()) && all_free; ++u)
      all_free = units_[u].free();
    if (!all_free) break;
    node = parent;
  }
  return Add(id, worker, node);
}

std::optional<LeaseEntry> LeaseTable::GrantCopy(LeaseId id, const WorkerId& worker, double seconds_per_unit) {
  // Step 1: the worker that is latest against what was expected of all that it holds: it may deliver that as one.
  struct Holding {
    Clock::Duration since = Clock::Duration::max();
    uint32_t units = 0;
  };
  std::map<WorkerId, Holding> holdings;
  for (const auto& [other, lease] : leases_) {
    if (lease.worker == worker) continue;
    Holding& holding = holdings[lease.worker];
    holding.since = std::min(holding.since, lease.granted);
    holding.units += lease.node.end(unit_count()) - lease.node.first();
  }
  const auto now = clock_.Now();
  std::vector<std::pair<double, WorkerId>> late;
  for (const auto& [other, holding] : holdings) {
    const double allowed = seconds_per_unit > 0 ? options_.straggler_factor * seconds_per_unit * holding.units +
                                                      Seconds(options_.straggler_grace)
                                                : Seconds(options_.unknown_grace);
    const double by = Seconds(now - holding.since) - allowed;
    if (by >= 0) late.emplace_back(by, other);
  }
  std::ranges::sort(late, std::greater<>());
  // Step 2: of its last lease the upper half first (it may be through with the lower one), then the lower.
  const auto takeable = [&](TreeNode node) {
    bool any = false;
    for (uint32_t u = node.first(); u < node.end(unit_count()); ++u) {
      if (units_[u].covered) continue;
      if (units_[u].holders >= options_.max_copies) return false;
      any = true;
    }
    return any;
  };
  for (const auto& [by, straggler] : late) {
    for (auto it = leases_.rbegin(); it != leases_.rend(); ++it) {
      const LeaseEntry& lease = it->second;
      if (lease.worker != straggler) continue;
      std::vector<TreeNode> candidates{lease.node};
      if (lease.node.level > 0) candidates = {lease.node.Child(1), lease.node.Child(0)};
      for (const TreeNode node : candidates) {
        if (node.ValidIn(unit_count()) && takeable(node)) return Add(id, worker, node);
      }
    }
  }
  return std::nullopt;
}

bool LeaseTable::Renew(LeaseId id, const WorkerId& worker) {
  const auto it = leases_.find(id);
  if (it == leases_.end() || it->second.worker != worker) return false;
  it->second.expires = clock_.Now() + options_.duration;
  return true;
}

std::vector<LeaseEntry> LeaseTable::Commit(TreeNode node) {
  LODESTAR_CHECK(node.ValidIn(unit_count()));
  for (uint32_t u = node.first(); u < node.end(unit_count()); ++u) {
    if (units_[u].covered) continue;
    if (units_[u].free()) --free_;
    units_[u].covered = true;
    --uncovered_;
  }
  return RemoveIf([&](const LeaseEntry& lease) { return Covered(lease.node); });
}

void LeaseTable::Release(LeaseId id) {
  const auto it = leases_.find(id);
  if (it == leases_.end()) return;
  Remove(it->second);
  leases_.erase(it);
}

std::vector<LeaseEntry> LeaseTable::Expire() {
  const auto now = clock_.Now();
  return RemoveIf([&](const LeaseEntry& lease) { return lease.expires <= now; });
}

bool LeaseTable::Covered(TreeNode node) const {
  for (uint32_t u = node.first(); u < node.end(unit_count()); ++u) {
    if (!units_[u].covered) return false;
  }
  return true;
}

uint32_t LeaseUnits(uint32_t free_units, uint32_t unit_count, double share, double seconds_per_unit,
                    bool more_follows) {
  constexpr double kSeconds = 2, kLeastSeconds = 0.02;
  const double part = share * (more_follows ? unit_count : free_units);
  double units = part / 12;
  if (seconds_per_unit > 0) {
    units = std::min(part / (more_follows ? 2 : 4), kSeconds / seconds_per_unit);
    units = std::max(units, std::min(part, kLeastSeconds / seconds_per_unit));
  }
  // The nearest power of two: blocks are aligned.
  const auto whole = static_cast<uint32_t>(std::max(1.0, units * 1.4));
  return std::bit_floor(whole);
}

}  // namespace lodestar
