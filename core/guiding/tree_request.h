// D-trees whose dense matrices another process is to blur: what was recorded in their cells, and how; and what it
// answers. Making a tree is a pure function, so who makes it does not show. Trees of other kinds take about as long to
// hand over as to make (docs/decisions/0022-shards-of-an-advance.md).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/stop.h"
#include "core/guiding/reconstruction.h"

namespace lodestar {

// Of directional::ReconstructDense.
struct DenseRecipe {
  float sigma = 0.5f;
  double flux_threshold = 0.01;
  int max_depth = directional::kMaxDepth;
};

directional::Tree MakeTree(const DenseRecipe& recipe, const directional::CellMasses& masses);

// Trees of one recipe to be made.
class TreeRequest {
 public:
  explicit TreeRequest(const DenseRecipe& recipe);
  // `place`: the asker's number for it, ascending.
  void Add(uint32_t place, const directional::CellMasses& masses);
  // Empty where no tree was added.
  Bytes Take();

 private:
  ByteWriter out_;
  bool any_ = false;
};

// The answer to a request, its trees made in parallel; empty where `stop` was requested. Throws Error(kCorrupt) where
// the bytes are no request.
Bytes AnswerTreeRequest(std::string_view request, const StopToken& stop = {});

struct PlacedTree {
  uint32_t place;
  directional::Tree tree;
};
// Of an answer, by place. Throws Error(kCorrupt) where they are not trees of at most `max_depth` for places below
// `places`.
std::vector<PlacedTree> ReadTreeAnswer(std::string_view answer, uint32_t places, int max_depth);

// A hash of the trees that this process makes of fixed masses: processes whose canaries differ must not make trees for
// each other.
std::string TreeCanary();

}  // namespace lodestar
