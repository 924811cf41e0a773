// A renderer without a scene: pixels and records are hashes of (seed, pixel, pass) and depend on the state, as those of
// a real one. Tests choose the order, the partition into nodes and the detours by which a round's units arrive.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <ostream>
#include <string>
#include <utility>

#include "core/base/hash.h"
#include "core/learning/contribution.h"
#include "core/learning/grid_guiding.h"
#include "core/learning/loop.h"
#include "core/learning/mixed_guiding.h"
#include "core/learning/reduction.h"
#include "core/math/sampler.h"
#include "tests/support/statistical.h"

namespace lodestar::test {

inline Survey SyntheticSurvey(uint32_t width = 40, uint32_t height = 24) {
  Survey survey;
  survey.bounds = {{0, 0, 0}, {1, 1, 1}};
  survey.resolution_x = width;
  survey.resolution_y = height;
  survey.max_depth = 5;
  survey.scene_spp = 12;
  survey.scene_hash = std::string(64, 'a');
  survey.needs = "nothing";
  survey.not_needed = "environment (left out of the path kernel)";
  return survey;
}

inline JobSpec SyntheticJob(const std::string& method, uint64_t spp) {
  JobSpec job;
  job.method = method;
  job.budget.spp = spp;
  job.seed = 7;
  return job;
}

inline Rgb SyntheticMean(uint32_t x, uint32_t y) {
  return {0.5f + 0.01f * static_cast<float>(x), 0.7f, 0.2f + 0.02f * static_cast<float>(y)};
}

// One record of a training round, made with the guide of its state, at a place and in a direction of the sampler's.
// Returns what the state adds to the sample, so that another state shows in the image. `learned` is null outside of
// training.
inline float RecordOne(const SdTreeState& state, SdTreeGuidingStatistics* learned, Sampler& sampler) {
  const SdTree& tree = state.tree();
  const Vec2 p = sampler.Next2D();
  const Vec3 position{p.x, p.y, sampler.Next2D().x};
  const uint32_t leaf = tree.LeafAt(position);
  const auto [w, pdf] = tree.Sample(leaf, sampler.Next2D());
  if (learned != nullptr) {
    const float radiance = w.z > 0.5f ? 1 + position.x : 0;
    learned->sums().Record({.position = position,
                            .direction = w,
                            .radiance = radiance,
                            .pdf = pdf,
                            .bsdf_pdf = 0.08f,
                            .tree_pdf = pdf,
                            .product = radiance * 0.1f,
                            .leaf = leaf},
                           {p.y, p.x, position.z});
  }
  return 1e-3f * w.z * pdf;
}
inline float RecordOne(const FocalState& state, FocalGuidingStatistics* learned, Sampler& sampler) {
  const Vec2 p = sampler.Next2D();
  const Vec3 position{p.x, p.y, sampler.Next2D().x};
  const auto [w, pdf] = state.field().Sample(position, sampler.Next2D());
  if (learned != nullptr)
    learned->sums().Record({.position = position,
                            .direction = w,
                            .distance = 0.3f + 0.2f * p.y,
                            .value = w.z > 0.5f ? 1 + position.x : 0.1f,
                            .pdf = pdf,
                            .bsdf_pdf = 0.08f,
                            .guide_pdf = pdf});
  return 1e-3f * w.z;
}
inline float RecordOne(const GridState& state, GridGuidingStatistics* learned, Sampler& sampler) {
  const RadianceGrid& grid = *state.grid();
  const Vec2 p = sampler.Next2D();
  const uint32_t cell = grid.CellAt({p.x, p.y, sampler.Next2D().x});
  const uint32_t direction = grid.DirectionAt(SquareToSphere(sampler.Next2D()));
  if (learned != nullptr) learned->sums().Record(cell, direction, 1 + p.x);
  return 1e-3f * grid.Radiance(cell, direction);
}
inline float RecordOne(const State& state, Statistics* learned, Sampler& sampler) {
  if (const auto* tree = dynamic_cast<const SdTreeState*>(&state))
    return RecordOne(*tree, dynamic_cast<SdTreeGuidingStatistics*>(learned), sampler);
  if (const auto* focal = dynamic_cast<const FocalState*>(&state))
    return RecordOne(*focal, dynamic_cast<FocalGuidingStatistics*>(learned), sampler);
  if (const auto* grid = dynamic_cast<const GridState*>(&state))
    return RecordOne(*grid, dynamic_cast<GridGuidingStatistics*>(learned), sampler);
  if (const auto* mixed = dynamic_cast<const MixedState*>(&state)) {
    auto* both = dynamic_cast<MixedStatistics*>(learned);
    return RecordOne(*mixed->tree(), both != nullptr ? &both->tree() : nullptr, sampler) +
           RecordOne(*mixed->focal(), both != nullptr ? &both->focal() : nullptr, sampler);
  }
  return 0;  // no guide
}

// One unit. Every pass of a pixel is a sample of mean SyntheticMean and relative variance 1/12 * noise^2, and one
// record in a training round; unit 1 also has one of no density, which is refused.
inline Contribution RenderUnit(const JobSpec& job, const Method& method, const std::shared_ptr<const State>& state,
                               const TileGrid& grid, const Round& round, uint32_t unit, float noise = 1) {
  Contribution result;
  const TileRect rect = grid.Rect(unit);
  FilmTile tile{unit, std::vector<PixelSum>(rect.pixels())};
  if (round.record) result.statistics = method.NewStatistics(state);
  for (uint32_t i = 0; i < rect.pixels(); ++i) {
    const uint32_t x = rect.x0 + i % rect.width(), y = rect.y0 + i / rect.width();
    for (uint32_t pass = round.first_pass; pass < round.first_pass + round.passes; ++pass) {
      Sampler sampler(job.seed, x, y, pass);
      sampler.StartAt(Sampler::kSobolPairs);
      const float value = 1 + noise * (sampler.Next2D().x - 0.5f);
      tile.pixels[i].Add(SyntheticMean(x, y) * (value + RecordOne(*state, result.statistics.get(), sampler)));
    }
  }
  result.tiles.push_back(std::move(tile));
  result.paths = uint64_t{rect.pixels()} * round.passes;
  result.rays = result.paths * 3;
  result.vertices = result.paths * 2;
  if (unit == 1 && round.first_pass <= 5)
    result.health.Count(HealthEvent::kClamped, rect.x0, rect.y0, round.first_pass, round.iteration);
  if (auto* tree = dynamic_cast<SdTreeGuidingStatistics*>(result.statistics.get()); unit == 1 && tree != nullptr)
    tree->sums().Record({{}, {0, 0, 1}, 1, 0}, {});
  return result;
}

class SyntheticExecutor final : public Executor {
 public:
  struct Options {
    uint64_t shuffle = 0;  // 0: in order, unit by unit; else the seed of order and partition
    bool detours = false;  // duplicates, late submits, covered nodes, ancestors of what is there
    float noise = 1;
    double seconds_per_pass = 1;  // moved on `clock`
    ManualClock* clock = nullptr;
    std::function<void()> before_round = {};
    StopToken* stop = nullptr;   // requested ...
    int stop_before_round = -1;  // ... when this many rounds are done
  };
  SyntheticExecutor(const Loop& loop, Options options)
      : job_(loop.job()), method_(loop.method()), grid_(loop.grid()), options_(options), random_(options.shuffle) {}

  std::optional<Contribution> Execute(const std::shared_ptr<const State>& state, const Round& round,
                                      const StopToken& stop) override {
    if (options_.stop != nullptr && static_cast<int>(rounds.size()) == options_.stop_before_round)
      options_.stop->Request();
    if (stop.Requested()) return std::nullopt;
    if (options_.before_round) options_.before_round();
    // What was announced before the last round must be this one; nothing was where the state advanced in between.
    if (expected_) {
      EXPECT_EQ(*expected_, round);
    }
    if (!expected_ && !rounds.empty()) {
      EXPECT_NE(round.iteration, rounds.back().iteration);
    }
    expected_ = std::exchange(announced_, std::nullopt);
    rounds.push_back(round);
    RoundReduction reduction(method_, state, grid_, round);
    for (const TreeNode node : Partition(round.unit_count)) Submit(&reduction, state, round, node);
    EXPECT_TRUE(reduction.Complete());
    if (options_.detours) {
      EXPECT_EQ(Commit(&reduction, state, round, {0, 0}), RoundReduction::Outcome::kCovered);  // late
    }
    if (options_.clock != nullptr) {
      options_.clock->Advance(std::chrono::duration_cast<Clock::Duration>(
          std::chrono::duration<double>(options_.seconds_per_pass * round.passes)));
    }
    return reduction.Take();
  }
  void Announce(const std::shared_ptr<const State>&, const Round& next) override { announced_ = next; }

  std::vector<Round> rounds;

 private:
  // Leaves of a random cut through the tree, in random order.
  std::vector<TreeNode> Partition(uint32_t units) {
    std::vector<TreeNode> nodes;
    const auto split = [&](auto&& self, TreeNode node) -> void {
      if (!node.ValidIn(units)) return;
      if (node.level == 0 || (options_.shuffle != 0 && random_.Next1D() < 0.4f)) {
        nodes.push_back(node);
      } else {
        self(self, node.Child(0));
        self(self, node.Child(1));
      }
    };
    split(split, TreeNode::Root(units));
    if (options_.shuffle != 0) {
      for (size_t i = nodes.size(); i > 1; --i) std::swap(nodes[i - 1], nodes[random_.Next() % i]);
    }
    return nodes;
  }

  Contribution RenderNode(const std::shared_ptr<const State>& state, const Round& round, TreeNode node) {
    Contribution sum;
    std::vector<uint32_t> units;
    for (uint32_t unit = node.first(); unit < node.end(round.unit_count); ++unit) units.push_back(unit);
    if (options_.shuffle != 0) std::reverse(units.begin(), units.end());
    for (const uint32_t unit : units) sum.Merge(RenderUnit(job_, method_, state, grid_, round, unit, options_.noise));
    return sum;
  }

  RoundReduction::Outcome Commit(RoundReduction* reduction, const std::shared_ptr<const State>& state,
                                 const Round& round, TreeNode node) {
    return reduction->Commit({&node, 1}, SerializeContribution(RenderNode(state, round, node)));
  }

  void Submit(RoundReduction* reduction, const std::shared_ptr<const State>& state, const Round& round, TreeNode node) {
    using enum RoundReduction::Outcome;
    if (options_.detours && node.level > 0) {
      // A descendant comes first, twice; its ancestor is dropped then, and the other descendant has to come by itself.
      const TreeNode child = node.Child(0), other = node.Child(1);
      EXPECT_EQ(Commit(reduction, state, round, child), kCommitted);
      EXPECT_EQ(Commit(reduction, state, round, child), kCovered);
      EXPECT_EQ(Commit(reduction, state, round, node), kCovered);
      if (other.ValidIn(round.unit_count)) {
        EXPECT_EQ(Commit(reduction, state, round, other), kCommitted);
      }
    } else {
      EXPECT_EQ(Commit(reduction, state, round, node), kCommitted);
    }
  }

  const JobSpec job_;
  const Method& method_;
  const TileGrid grid_;
  const Options options_;
  Random random_;
  std::optional<Round> announced_, expected_;
};

// Everything of a run that must not depend on how it was run.
struct Result {
  ContentHash image, state;
  uint64_t passes = 0, paths = 0, health = 0;
  int training_iterations = 0;
  friend bool operator==(const Result&, const Result&) = default;
  friend void PrintTo(const Result& r, std::ostream* out) {
    *out << "image " << r.image.hex << ", state " << r.state.hex << ", " << r.passes << " passes, " << r.paths
         << " paths, " << r.health << " events, " << r.training_iterations << " training iterations";
  }
};

inline Result ResultOf(const Loop& loop) {
  const JobReport report = FinalReport(loop, loop.Develop());
  return {report.image_hash, report.state_hash,     report.passes,
          report.paths,      report.health.total(), report.training_iterations};
}

}  // namespace lodestar::test
