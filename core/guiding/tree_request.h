// D-trees that another process is to make: what was recorded in their cells, and how; and what it answers. Making a
// tree is a pure function, so who makes it does not show (docs/decisions/0008-reconstruction.md).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/bytes.h"
#include "core/guiding/reconstruction.h"
#include "core/guiding/sd_tree_options.h"

namespace lodestar {

// How a D-tree is made from the masses in its cells.
struct TreeRecipe {
  SdTreeOptions::Reconstruction reconstruction = SdTreeOptions::Reconstruction::kNone;
  float dense_sigma = 0.5f;
  double flux_threshold = 0.01;
  int max_depth = directional::kMaxDepth;
};
// kNative needs the masses of halves to do anything.
directional::Tree MakeTree(const TreeRecipe& recipe, const directional::CellMasses& masses);

// Trees of one recipe to be made.
class TreeRequest {
 public:
  explicit TreeRequest(const TreeRecipe& recipe);
  // `place`: the asker's number for it, ascending. Only the links of the nodes are sent.
  void Add(uint32_t place, const directional::CellMasses& masses);
  // Empty where no tree was added.
  Bytes Take();

 private:
  ByteWriter out_;
  bool any_ = false;
};

// The answer to a request, its trees made in parallel. Throws Error(kCorrupt) where the bytes are no request.
Bytes AnswerTreeRequest(std::string_view request);

struct PlacedTree {
  uint32_t place;
  directional::Tree tree;
};
// Of an answer, by place. Throws Error(kCorrupt) where they are not trees of at most `max_depth` for places below
// `places`.
std::vector<PlacedTree> ReadTreeAnswer(std::string_view answer, uint32_t places, int max_depth);

// A hash of how this process answers a fixed request of both methods: processes whose canaries differ must not make
// trees for each other.
std::string TreeCanary();

}  // namespace lodestar
