// How near to the truth are reconstructed directional trees? On what a scene's own paths recorded, leaf by leaf, so
// that neither the noise of images nor the rest of the renderer shows.
//
//   build/release/bin/reconstruction_quality WIDTHxHEIGHT SCENE.pbrt [OPTION=VALUE of sdtree]...
//
// After 15 training samples a pixel, trees are made from 16 more, and compared with what 256 further samples recorded
// in the same cells. chi-square is the second moment of guiding by (0.7 tree + 0.3 uniform) towards that, 1 at best;
// the geometric mean over leaves, and its ratio to the tree as recorded. Then what making them costs, on one thread,
// and what leaving those of `dense` to another process would.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "bench/studied_method.h"
#include "bench/study_main.h"
#include "core/guiding/tree_request.h"
#include "core/scene/pbrt_parser.h"
#include "core/tracing/local_executor.h"

namespace lodestar {
namespace {

using directional::CellMasses;

constexpr uint32_t kIteration = 4;
constexpr uint64_t kPasses = 16, kTruthPasses = 256;
constexpr double kUniform = 0.3;
constexpr float kSigmas[] = {0.5f, 0.8f};  // of dense reconstruction

struct Recording {
  std::shared_ptr<const SdTree> tree;  // what the masses' nodes belong to
  std::vector<CellMasses> masses;
  std::vector<double> records;
};

// Of iteration kIteration, lengthened to `passes`.
Recording Record(const CompiledJob& compiled, JobSpec job, uint64_t passes) {
  Recording out;
  job.training_iterations = kIteration + 1;
  job.budget.spp = (uint64_t{1} << kIteration) - 1 + passes + 1;
  const auto make_method = [&](const JobSpec& spec, const Survey& survey) {
    return std::make_unique<StudiedMethod>(
        spec, survey, [](const IterationResult&) { return SdTreeOptions::Reconstruction::kNone; },
        [&](const std::shared_ptr<const SdTree>& tree, const SdTreeStatistics& sums, const IterationResult& result) {
          if (result.iteration != kIteration) return;
          out.tree = tree;
          for (uint32_t leaf = 0; leaf < tree->leaf_count(); ++leaf) {
            out.masses.push_back(RecordedMasses(*tree, sums, leaf));
            out.records.push_back(sums.leaf(leaf).records());
          }
        },
        [&](uint32_t k) { return k == kIteration ? passes : uint64_t{1} << k; });
  };
  Loop loop(job, compiled.survey, make_method);
  const std::unique_ptr<Method> method = MakeMethod(job, compiled.survey);
  LocalExecutor executor(compiled.scene, job, *method);
  loop.Run(executor, {}, {});
  return out;
}

// What a tree (from node `at`, of mass `mass`; null: evenly) gives to each recorded cell below `node`.
void Spread(const DirectionalNode* recorded, uint32_t node, const DirectionalNode* tree, uint32_t at, double mass,
            std::vector<double>* out) {
  for (uint32_t c = 0; c < 4; ++c) {
    const double part = mass * (tree != nullptr ? double{tree[at].Probability(c)} : 0.25);
    const uint32_t below = tree != nullptr ? tree[at].child[c] : 0, child = recorded[node].child[c];
    if (child != 0) {
      Spread(recorded, child, below != 0 ? tree : nullptr, below, part, out);
    } else {
      (*out)[node * 4 + c] = part;
    }
  }
}

// Masses of the truth alone: sums add up, and so do the squares of masses that are roots of sums.
std::vector<double> Further(const CellMasses& all, const CellMasses& first, bool roots) {
  std::vector<double> masses(all.total.size());
  for (size_t slot = 0; slot < masses.size(); ++slot) {
    const double a = all.total[slot], b = first.total[slot];
    masses[slot] = roots ? std::sqrt(std::max(a * a - b * b, 0.0)) : std::max(a - b, 0.0);
  }
  return masses;
}

double ChiSquare(const std::vector<double>& truth, const std::vector<double>& guide, const std::vector<double>& area) {
  double total = 0, sum = 0;
  for (const double mass : truth) total += mass;
  for (size_t slot = 0; slot < truth.size(); ++slot) {
    const double p = truth[slot] / total;
    if (p > 0) sum += p * p / ((1 - kUniform) * guide[slot] + kUniform * area[slot]);
  }
  return sum;
}

bool IsEmpty(const std::vector<double>& masses) {
  return std::none_of(masses.begin(), masses.end(), [](double mass) { return mass > 0; });
}

// CPU time of a run, the least of five.
template <class Run>
double LeastCpuSeconds(const Run& run) {
  double least = 1e300;
  for (int pass = 0; pass < 5; ++pass) {
    const double begin = CpuSeconds();
    run();
    least = std::min(least, CpuSeconds() - begin);
  }
  return least;
}

// CPU time of a tree, the least of five passes over all trees and over the deep ones, which dense matrices are slow
// for. `dense` blurs trees of kMinDenseDepth to kMaxDenseDepth levels and only rebuilds the others; within the
// document's workload it blurs some of these.
void PrintCost(const Recording& recording, double threshold, int max_depth) {
  struct Tree {
    const CellMasses* masses;
    bool blurred, within;
  };
  std::vector<int> depths;
  for (uint32_t leaf = 0; leaf < recording.tree->leaf_count(); ++leaf)
    depths.push_back(recording.tree->leaf(leaf).depth);
  const std::vector<uint8_t> within = directional::WithinWorkload(depths, static_cast<int>(kIteration));
  std::printf(
      "\n| trees | number | blurred | within the workload | rebuild, us | native, us | dense, us | dense / native "
      "| dense within, us | / native |\n| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  for (const int least_depth : {1, 10}) {
    std::vector<Tree> trees;
    int blurred = 0, taken = 0;
    for (uint32_t leaf = 0; leaf < depths.size(); ++leaf) {
      const int depth = depths[leaf];
      if (depth < least_depth || IsEmpty(recording.masses[leaf].total)) continue;
      trees.push_back({&recording.masses[leaf],
                       depth >= directional::kMinDenseDepth && depth <= directional::kMaxDenseDepth,
                       within[leaf] != 0});
      blurred += trees.back().blurred;
      taken += trees.back().within;
    }
    if (trees.empty()) continue;
    const auto microseconds = [&](const auto& make) {
      const double seconds = LeastCpuSeconds([&] {
        for (const Tree& tree : trees) make(tree);
      });
      return 1e6 * seconds / static_cast<double>(trees.size());
    };
    const auto rebuild = [&](const Tree& tree) {
      const CellMasses& m = *tree.masses;
      return directional::Rebuild(m.nodes, m.node_count, m.total, threshold, max_depth);
    };
    const auto native = [&](const Tree& tree) {
      return directional::ReconstructNative(*tree.masses, threshold, max_depth);
    };
    const auto dense = [&](const Tree& tree) {
      return directional::ReconstructDense(*tree.masses, kSigmas[0], threshold, max_depth);
    };
    const auto dense_within = [&](const Tree& tree) { return tree.within ? dense(tree) : rebuild(tree); };
    const double native_cost = microseconds(native), dense_cost = microseconds(dense),
                 within_cost = microseconds(dense_within);
    std::printf("| depth %d and more | %zu | %d | %d | %.1f | %.1f | %.1f | %.1f | %.1f | %.1f |\n", least_depth,
                trees.size(), blurred, taken, microseconds(rebuild), native_cost, dense_cost, dense_cost / native_cost,
                within_cost, within_cost / native_cost);
  }
}

// CPU time of a dense tree that is left to another process: to ask for it, and to read it back; beside that of making
// it here.
void PrintSharing(const Recording& recording, double threshold, int max_depth) {
  constexpr uint32_t kTogether = 100;
  std::vector<const CellMasses*> all;
  for (const CellMasses& masses : recording.masses)
    if (!IsEmpty(masses.total)) all.push_back(&masses);
  const auto number = static_cast<uint32_t>(all.size());
  const auto microseconds = [&](const auto& run) { return 1e6 * LeastCpuSeconds(run) / number; };
  const double made = microseconds([&] {
    for (const CellMasses* masses : all) (void)directional::ReconstructDense(*masses, kSigmas[0], threshold, max_depth);
  });
  std::vector<Bytes> requests, answers;
  const double asked = microseconds([&] {
    requests.clear();
    for (uint32_t i = 0; i < number;) {
      TreeRequest request({kSigmas[0], threshold, max_depth});
      for (const uint32_t end = std::min(i + kTogether, number); i < end; ++i) request.Add(i, *all[i]);
      requests.push_back(request.Take());
    }
  });
  for (const Bytes& request : requests) answers.push_back(AnswerTreeRequest(request));
  const double read = microseconds([&] {
    for (const Bytes& answer : answers) (void)ReadTreeAnswer(answer, number, max_depth);
  });
  const auto bytes = [&](const std::vector<Bytes>& documents) {
    double sum = 0;
    for (const Bytes& document : documents) sum += static_cast<double>(document.size());
    return sum / number;
  };
  std::printf(
      "\n| dense, made here, us | asked for, us | read back, us | a request, bytes a tree | an answer |\n"
      "| ---: | ---: | ---: | ---: | ---: |\n| %.1f | %.1f | %.1f | %.0f | %.0f |\n",
      made, asked, read, bytes(requests), bytes(answers));
}

void Study(const char* path, const JobSpec& job) {
  const CompiledJob compiled = CompileJob(ParsePbrtFile(path), job);
  const Recording first = Record(compiled, job, kPasses), all = Record(compiled, job, kPasses + kTruthPasses);
  const SdTreeOptions& options = first.tree->options();
  const bool roots = first.tree->target() != SdTreeOptions::Target::kRadiance;
  const double threshold = double{options.flux_threshold};
  const int depth = options.max_directional_depth;

  struct Sums {
    int leaves = 0;
    std::array<double, 4> log{};
  };
  std::map<int, Sums> by_records;  // by powers of 4
  for (uint32_t leaf = 0; leaf < first.tree->leaf_count(); ++leaf) {
    const CellMasses& masses = first.masses[leaf];
    const std::vector<double> truth = Further(all.masses[leaf], masses, roots);
    if (IsEmpty(masses.total) || IsEmpty(truth)) continue;
    std::vector<double> area(truth.size()), guide(truth.size());
    Spread(masses.nodes, 0, nullptr, 0, 1, &area);
    const directional::Tree trees[] = {
        directional::Rebuild(masses.nodes, masses.node_count, masses.total, threshold, depth),
        directional::ReconstructDense(masses, kSigmas[0], threshold, depth),
        directional::ReconstructDense(masses, kSigmas[1], threshold, depth),
        directional::ReconstructNative(masses, threshold, depth)};
    Sums& sums = by_records[static_cast<int>(std::log2(std::max(first.records[leaf], 1.0)) / 2)];
    ++sums.leaves;
    for (size_t kind = 0; kind < std::size(trees); ++kind) {
      Spread(masses.nodes, 0, trees[kind].nodes.data(), 0, 1, &guide);
      sums.log[kind] += std::log(ChiSquare(truth, guide, area));
    }
  }
  std::printf(
      "\n%s, %ux%u\n\n| records | leaves | as recorded | dense 0.5 | dense 0.8 | native |\n"
      "| ---: | ---: | ---: | ---: | ---: | ---: |\n",
      path, job.resolution_x, job.resolution_y);
  for (const auto& [power, sums] : by_records) {
    const auto mean = [&](size_t kind) { return std::exp(sums.log[kind] / sums.leaves); };
    std::printf("| %d to %d | %d | %.2f |", 1 << (2 * power), 4 << (2 * power), sums.leaves, mean(0));
    for (const size_t kind : {1, 2, 3}) std::printf(" %.2f |", mean(kind) / mean(0));
    std::printf("\n");
  }
  PrintCost(first, threshold, depth);
  PrintSharing(first, threshold, depth);
}

int Run(int argc, char** argv) {
  JobSpec job;
  job.method = "sdtree";
  job.filter = "box";
  if (argc < 3 || std::sscanf(argv[1], "%ux%u", &job.resolution_x, &job.resolution_y) != 2) {
    std::fprintf(stderr, "usage: reconstruction_quality WIDTHxHEIGHT SCENE.pbrt [OPTION=VALUE]...\n");
    return 2;
  }
  job.options = {{"combine", "discard"}, {"reconstruction", "native"}};  // native: two halves are kept
  for (int i = 3; i < argc; ++i) {
    const std::string option = argv[i];
    const size_t equals = option.find('=');
    job.options[option.substr(0, equals)] = equals == std::string::npos ? "" : option.substr(equals + 1);
  }
  Study(argv[2], job);
  return 0;
}

}  // namespace
}  // namespace lodestar

int main(int argc, char** argv) {
  return lodestar::StudyMain(lodestar::Run, argc, argv);
}
