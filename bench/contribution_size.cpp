// What a worker sends: each round of a render with SD-tree guiding as two workers would deliver it, half each, in the
// bytes of the wire. The film, with all headers, is divided by pixels; the statistics by the nodes, the cells and the
// sums that hold anything. A cell is what a D-tree refines by the light in it, a node has four, and a cell has two sums
// where the halves of the paths are kept apart. Bits are those between a sum's first and last that are set, which no
// lossless code spares.
//
//   build/release/bin/contribution_size SCENE.pbrt [WIDTH HEIGHT SPP]
#include <bit>
#include <cstdio>
#include <cstdlib>

#include "bench/study_main.h"
#include "core/learning/contribution.h"
#include "core/learning/sd_tree_guiding.h"
#include "core/scene/pbrt_parser.h"
#include "core/tracing/local_executor.h"

namespace lodestar {
namespace {

struct Touched {
  uint64_t nodes = 0, cells = 0, sums = 0, bits = 0;
};

// From the highest to the lowest that is set.
uint64_t SignificantBits(unsigned __int128 units) {
  const auto low = static_cast<uint64_t>(units), high = static_cast<uint64_t>(units >> 64);
  const int lowest = low != 0 ? std::countr_zero(low) : 64 + std::countr_zero(high);
  const int highest = high != 0 ? 127 - std::countl_zero(high) : 63 - std::countl_zero(low);
  return static_cast<uint64_t>(highest - lowest + 1);
}

Touched CountTouched(const SdTreeStatistics& statistics) {
  Touched touched;
  for (uint32_t leaf = 0; leaf < statistics.tree()->leaf_count(); ++leaf) {
    if (!statistics.touched(leaf)) continue;
    const std::span<const ExactSum> sums = statistics.slots(leaf);
    const size_t of_cell = statistics.halves(), of_node = 4 * of_cell;
    for (size_t node = 0; node < sums.size(); node += of_node) {
      const uint64_t cells_before = touched.cells;
      for (size_t cell = node; cell < node + of_node; cell += of_cell) {
        uint64_t there = 0;
        for (const ExactSum& sum : sums.subspan(cell, of_cell)) {
          if (sum.zero()) continue;
          ++there;
          touched.bits += SignificantBits(sum.Units());
        }
        touched.sums += there;
        touched.cells += there > 0;
      }
      touched.nodes += touched.cells > cells_before;
    }
  }
  return touched;
}

class MeasuringExecutor final : public Executor {
 public:
  explicit MeasuringExecutor(LocalExecutor& inner) : inner_(inner) {}
  std::optional<Contribution> Execute(const std::shared_ptr<const State>& state, const Round& round,
                                      const StopToken& stop) override {
    Contribution whole;
    for (const int half : {0, 1}) {
      Contribution part;
      if (!inner_.ExecuteNode(state, round, TreeNode::Root(round.unit_count).Child(half), stop, &part))
        return std::nullopt;
      Print(round, part);
      whole.Merge(std::move(part));
    }
    return whole;
  }

 private:
  static void Print(const Round& round, const Contribution& part) {
    const auto all = static_cast<double>(SerializeContribution(part).size());
    double pixels = 0;
    for (const FilmTile& tile : part.tiles) pixels += static_cast<double>(tile.pixels.size());
    if (!part.statistics) {
      std::printf("%9u %6u %9.0f %9.2f\n", round.iteration, round.passes, all / 1024, all / pixels);
      return;
    }
    const auto learned = static_cast<double>(part.statistics->Serialize().size());
    const Touched touched = CountTouched(dynamic_cast<const SdTreeGuidingStatistics&>(*part.statistics).sums());
    std::printf("%9u %6u %9.0f %9.2f %9.2f %9.2f %9.2f %9.1f %9llu\n", round.iteration, round.passes, all / 1024,
                (all - learned) / pixels, learned / static_cast<double>(touched.nodes),
                learned / static_cast<double>(touched.cells), learned / static_cast<double>(touched.sums),
                static_cast<double>(touched.bits) / static_cast<double>(touched.sums),
                static_cast<unsigned long long>(touched.nodes));
  }

  LocalExecutor& inner_;
};

int Run(int argc, char** argv) {
  if (argc != 2 && argc != 5) {
    std::fprintf(stderr, "usage: contribution_size SCENE.pbrt [WIDTH HEIGHT SPP]\n");
    return 2;
  }
  JobSpec job;
  job.method = "sdtree";
  if (argc == 5) {
    job.resolution_x = static_cast<uint32_t>(std::atoi(argv[2]));
    job.resolution_y = static_cast<uint32_t>(std::atoi(argv[3]));
    job.budget.spp = static_cast<uint64_t>(std::atoi(argv[4]));
  }
  const CompiledJob compiled = CompileJob(ParsePbrtFile(argv[1]), job);
  Loop loop(job, compiled.survey);
  if (loop.grid().tile_count() < 2) throw Error(ErrorKind::kInvalidInput, "the image is one tile: there are no halves");
  LocalExecutor executor(compiled.scene, job, loop.method());
  MeasuringExecutor measuring(executor);
  std::printf("iteration passes       KiB  B/pixel    B/node    B/cell     B/sum  bits/sum     nodes\n");
  loop.Run(measuring, StopToken(), {});
  return 0;
}

}  // namespace
}  // namespace lodestar

int main(int argc, char** argv) {
  return lodestar::StudyMain(lodestar::Run, argc, argv);
}
