#include "core/guiding/tree_request.h"

#include <algorithm>
#include <cmath>

#include "core/base/hash.h"
#include "core/base/parallel.h"
#include "core/base/sealed_bytes.h"
#include "core/guiding/directional_tree_io.h"

namespace lodestar {
namespace {

using Reconstruction = SdTreeOptions::Reconstruction;
using directional::CellMasses;

constexpr uint32_t kRequestMagic = DocumentMagic("DTRQ"), kAnswerMagic = DocumentMagic("DTRA"), kVersion = 1;

// Slots with a child hold nothing and are not sent.
void PutCells(ByteWriter& out, const CellMasses& masses, const std::vector<double>& slots) {
  std::vector<double> cells;
  cells.reserve(slots.size());
  for (size_t slot = 0; slot < slots.size(); ++slot)
    if (masses.nodes[slot / 4].child[slot % 4] == 0) cells.push_back(slots[slot]);
  out.PutVector(cells);
}

// With `sum` the sum of the masses.
std::vector<double> GetCells(ByteReader& in, const directional::Tree& tree, double* sum) {
  const auto cells = in.GetVector<double>();
  if (cells.size() != 3 * tree.nodes.size() + 1) in.Fail("has masses of another number of cells");
  std::vector<double> slots(tree.nodes.size() * 4, 0);
  *sum = 0;
  for (size_t slot = 0, cell = 0; slot < slots.size(); ++slot) {
    if (tree.nodes[slot / 4].child[slot % 4] != 0) continue;
    slots[slot] = cells[cell++];
    if (!(slots[slot] >= 0)) in.Fail("has a mass that is none");
    *sum += slots[slot];
  }
  if (!std::isfinite(*sum)) in.Fail("has masses beyond all measure");
  return slots;
}

TreeRecipe ReadRecipe(ByteReader& in) {
  TreeRecipe recipe;
  recipe.reconstruction = in.Get<Reconstruction>();
  recipe.dense_sigma = in.Get<float>();
  recipe.flux_threshold = in.Get<double>();
  recipe.max_depth = in.Get<int32_t>();
  if (recipe.reconstruction > Reconstruction::kDenseUnlimited || !(recipe.dense_sigma > 0) ||
      !std::isfinite(recipe.dense_sigma) || !(recipe.flux_threshold > 0 && recipe.flux_threshold <= 1) ||
      recipe.max_depth < 1 || recipe.max_depth > directional::kMaxDepth)
    in.Fail("has settings out of range");
  return recipe;
}

// Places ascend, and each is below the limit.
uint32_t ReadPlace(ByteReader& in, uint64_t* least, uint64_t limit) {
  const auto place = in.Get<uint32_t>();
  if (place < *least || place >= limit) in.Fail("has a tree out of its place");
  *least = uint64_t{place} + 1;
  return place;
}

struct Asked {
  uint32_t place;
  directional::Tree recorded;
  CellMasses masses;  // points into `recorded`
};

}  // namespace

directional::Tree MakeTree(const TreeRecipe& recipe, const CellMasses& masses) {
  switch (recipe.reconstruction) {
    case Reconstruction::kDense:
    case Reconstruction::kDenseUnlimited:
      return directional::ReconstructDense(masses, recipe.dense_sigma, recipe.flux_threshold, recipe.max_depth);
    case Reconstruction::kNative:
      return directional::ReconstructNative(masses, recipe.flux_threshold, recipe.max_depth);
    case Reconstruction::kNone:
      break;
  }
  return directional::Rebuild(masses.nodes, masses.node_count, masses.total, recipe.flux_threshold, recipe.max_depth);
}

TreeRequest::TreeRequest(const TreeRecipe& recipe) : out_(OpenDocument(kRequestMagic, kVersion)) {
  out_.Put(recipe.reconstruction);
  out_.Put(recipe.dense_sigma);
  out_.Put(recipe.flux_threshold);
  out_.Put<int32_t>(recipe.max_depth);
}

void TreeRequest::Add(uint32_t place, const CellMasses& masses) {
  any_ = true;
  out_.Put(place);
  directional::Write(out_, {masses.nodes, masses.node_count});
  PutCells(out_, masses, masses.total);
  const bool halves = !masses.halves[0].empty();
  out_.Put<uint8_t>(halves);
  if (!halves) return;
  for (const auto& half : masses.halves) PutCells(out_, masses, half);
}

Bytes TreeRequest::Take() {
  return any_ ? Seal(std::move(out_)) : Bytes();
}

Bytes AnswerTreeRequest(std::string_view request) {
  constexpr const char* kWhat = "a request for trees";
  ByteReader in(OpenSealed(request, kRequestMagic, kVersion, kWhat), kWhat);
  const TreeRecipe recipe = ReadRecipe(in);
  std::vector<Asked> asked;
  for (uint64_t least = 0; in.remaining() > 0;) {
    Asked& next = asked.emplace_back();
    next.place = ReadPlace(in, &least, uint64_t{1} << 32);
    next.recorded = directional::Read(in, directional::kMaxDepth);
    double sum = 0;
    next.masses.total = GetCells(in, next.recorded, &sum);
    if (!(sum > 0)) in.Fail("has a tree without mass");
    if (in.GetFlag())
      for (auto& half : next.masses.halves) half = GetCells(in, next.recorded, &sum);
  }
  std::vector<directional::Tree> made(asked.size());
  ParallelFor(static_cast<uint32_t>(asked.size()), [&](uint32_t i) {
    CellMasses& masses = asked[i].masses;
    masses.nodes = asked[i].recorded.nodes.data();
    masses.node_count = static_cast<uint32_t>(asked[i].recorded.nodes.size());
    made[i] = MakeTree(recipe, masses);
  });
  ByteWriter out = OpenDocument(kAnswerMagic, kVersion);
  for (size_t i = 0; i < made.size(); ++i) {
    out.Put(asked[i].place);
    directional::Write(out, made[i].nodes);
  }
  return Seal(std::move(out));
}

std::vector<PlacedTree> ReadTreeAnswer(std::string_view answer, uint32_t places, int max_depth) {
  constexpr const char* kWhat = "an answer with trees";
  ByteReader in(OpenSealed(answer, kAnswerMagic, kVersion, kWhat), kWhat);
  std::vector<PlacedTree> trees;
  for (uint64_t least = 0; in.remaining() > 0;) {
    const uint32_t place = ReadPlace(in, &least, places);
    trees.push_back({place, directional::Read(in, max_depth)});
  }
  return trees;
}

std::string TreeCanary() {
  // A chain of nodes with all that rounding could touch: masses over many scales, halves that differ, depths at which
  // both methods blur.
  constexpr int kDepth = 8;
  std::vector<DirectionalNode> nodes(kDepth);
  for (int depth = 0; depth + 1 < kDepth; ++depth) nodes[depth].child[depth % 4] = static_cast<uint16_t>(depth + 1);
  CellMasses masses;
  masses.nodes = nodes.data();
  masses.node_count = kDepth;
  uint64_t bits = 0x9e3779b97f4a7c15ULL;
  const auto next = [&] {
    bits ^= bits << 13, bits ^= bits >> 7, bits ^= bits << 17;
    return std::ldexp(static_cast<double>(bits >> 11), -53 - static_cast<int>(bits % 16));
  };
  for (int slot = 0; slot < kDepth * 4; ++slot) {
    const bool cell = nodes[slot / 4].child[slot % 4] == 0;
    for (auto& half : masses.halves) half.push_back(cell ? next() : 0);
    masses.total.push_back(masses.halves[0].back() + masses.halves[1].back());
  }
  Bytes answers;
  for (const auto reconstruction : {Reconstruction::kNative, Reconstruction::kDenseUnlimited}) {
    TreeRequest request({.reconstruction = reconstruction, .flux_threshold = 0.001});
    request.Add(0, masses);
    answers += AnswerTreeRequest(request.Take());
  }
  return Sha256(answers).hex.substr(0, 16);
}

}  // namespace lodestar
