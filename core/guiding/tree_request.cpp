#include "core/guiding/tree_request.h"

#include <algorithm>
#include <cmath>

#include "core/base/hash.h"
#include "core/base/parallel.h"
#include "core/base/sealed_bytes.h"
#include "core/guiding/directional_tree_io.h"

namespace lodestar {
namespace {

using directional::CellMasses;

constexpr uint32_t kRequestMagic = DocumentMagic("DTRQ"), kAnswerMagic = DocumentMagic("DTRA"), kVersion = 1;

// Slots with a child hold nothing and are not sent.
void PutCells(ByteWriter& out, const CellMasses& masses) {
  std::vector<double> cells;
  cells.reserve(masses.total.size());
  for (size_t slot = 0; slot < masses.total.size(); ++slot)
    if (masses.nodes[slot / 4].child[slot % 4] == 0) cells.push_back(masses.total[slot]);
  out.PutVector(cells);
}

std::vector<double> GetCells(ByteReader& in, const directional::Tree& tree) {
  const auto cells = in.GetVector<double>();
  if (cells.size() != 3 * tree.nodes.size() + 1) in.Fail("has masses of another number of cells");
  std::vector<double> slots(tree.nodes.size() * 4, 0);
  double sum = 0;
  for (size_t slot = 0, cell = 0; slot < slots.size(); ++slot) {
    if (tree.nodes[slot / 4].child[slot % 4] != 0) continue;
    slots[slot] = cells[cell++];
    if (!(slots[slot] >= 0)) in.Fail("has a mass that is none");
    sum += slots[slot];
  }
  if (!(sum > 0) || !std::isfinite(sum)) in.Fail("has a tree without mass, or of too much");
  return slots;
}

DenseRecipe ReadRecipe(ByteReader& in) {
  DenseRecipe recipe;
  recipe.sigma = in.Get<float>();
  recipe.flux_threshold = in.Get<double>();
  recipe.max_depth = in.Get<int32_t>();
  if (!(recipe.sigma > 0) || !std::isfinite(recipe.sigma) || !(recipe.flux_threshold > 0) ||
      !std::isfinite(recipe.flux_threshold) || recipe.max_depth < 1 || recipe.max_depth > directional::kMaxDepth)
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

directional::Tree MakeTree(const DenseRecipe& recipe, const CellMasses& masses) {
  return directional::ReconstructDense(masses, recipe.sigma, recipe.flux_threshold, recipe.max_depth);
}

TreeRequest::TreeRequest(const DenseRecipe& recipe) : out_(OpenDocument(kRequestMagic, kVersion)) {
  out_.Put(recipe.sigma);
  out_.Put(recipe.flux_threshold);
  out_.Put<int32_t>(recipe.max_depth);
}

void TreeRequest::Add(uint32_t place, const CellMasses& masses) {
  any_ = true;
  out_.Put(place);
  directional::Write(out_, {masses.nodes, masses.node_count});
  PutCells(out_, masses);
}

Bytes TreeRequest::Take() {
  return any_ ? Seal(std::move(out_)) : Bytes();
}

Bytes AnswerTreeRequest(std::string_view request, const StopToken& stop) {
  constexpr const char* kWhat = "a request for trees";
  ByteReader in(OpenSealed(request, kRequestMagic, kVersion, kWhat), kWhat);
  const DenseRecipe recipe = ReadRecipe(in);
  std::vector<Asked> asked;
  for (uint64_t least = 0; in.remaining() > 0;) {
    Asked& next = asked.emplace_back();
    next.place = ReadPlace(in, &least, uint64_t{1} << 32);
    next.recorded = directional::Read(in, directional::kMaxDepth);
    next.masses.total = GetCells(in, next.recorded);
  }
  std::vector<directional::Tree> made(asked.size());
  ParallelFor(static_cast<uint32_t>(asked.size()), [&](uint32_t i) {
    if (stop.Requested()) return;
    CellMasses& masses = asked[i].masses;
    masses.nodes = asked[i].recorded.nodes.data();
    masses.node_count = static_cast<uint32_t>(asked[i].recorded.nodes.size());
    made[i] = MakeTree(recipe, masses);
  });
  if (stop.Requested()) return {};
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
  uint64_t bits = 0x9e3779b97f4a7c15ULL;
  const auto next = [&](uint64_t below) {
    bits ^= bits << 13, bits ^= bits >> 7, bits ^= bits << 17;
    return (bits >> 11) % below;
  };
  // Trees of many shapes, with masses over many scales: a chain to the depths at which matrices are blurred, and what
  // grows at random.
  ByteWriter out;
  for (const float sigma : {0.5f, 1.5f}) {
    for (const auto& [count, in_a_chain] : {std::pair(1u, false), {9u, true}, {60u, false}, {400u, false}}) {
      std::vector<DirectionalNode> nodes(1);
      while (nodes.size() < count) {
        uint16_t& link = nodes[in_a_chain ? nodes.size() - 1 : next(nodes.size())].child[next(4)];
        if (link != 0) continue;
        link = static_cast<uint16_t>(nodes.size());
        nodes.emplace_back();
      }
      CellMasses masses;
      masses.nodes = nodes.data();
      masses.node_count = count;
      for (uint32_t slot = 0; slot < count * 4; ++slot) {
        const double mass = std::ldexp(static_cast<double>(next(uint64_t{1} << 53)), -53 - static_cast<int>(next(24)));
        masses.total.push_back(nodes[slot / 4].child[slot % 4] == 0 ? mass : 0);
      }
      const int max_depth = count == 400 ? 6 : directional::kMaxDepth;
      directional::Write(out, MakeTree({sigma, 1.0 / count, max_depth}, masses).nodes);
    }
  }
  // And what those need not show: whether numbers too small to be normal are kept, or flushed to zero by a library that
  // was built so.
  volatile float tiny = 1e-30f;
  for (const float factor : {1e-9f, 3e-12f, 7e-15f}) out.Put(tiny * factor);
  return Sha256(out.bytes()).hex.substr(0, 16);
}

}  // namespace lodestar
