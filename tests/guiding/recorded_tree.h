// D-trees with what was recorded into them, as a renderer's would be: from a known distribution over the directions,
// with heavy-tailed weights, over rounds in which each tree guides the next.
#pragma once

#include <cstring>
#include <functional>

#include "core/guiding/reconstruction.h"
#include "tests/guiding/synthetic.h"

namespace lodestar::synthetic {

struct Recording {
  std::function<double(Vec3)> radiance;
  int records = 1000;          // of the last round
  int rounds = 7;              // each with half as many again as the one before, and at least 128
  double log_spread = 1;       // sigma of the log-normal factor, of mean 1, on each record
  bool second_moment = false;  // masses are sqrt(sum of squares * area), as under the variance-aware targets
  uint64_t seed = 1;
  double flux_threshold = 0.01;
  int max_depth = directional::kMaxDepth;
};

struct RecordedTree {
  directional::Tree tree;
  directional::CellMasses masses;  // points into `tree`
};

using Reconstruct =
    std::function<directional::Tree(const directional::CellMasses&, double flux_threshold, int max_depth)>;

inline directional::Tree Plain(const directional::CellMasses& m, double flux_threshold, int max_depth) {
  return directional::Rebuild(m.nodes, m.node_count, m.total, flux_threshold, max_depth);
}

// To the bit.
inline bool SameNodes(const directional::Tree& a, const directional::Tree& b) {
  return a.nodes.size() == b.nodes.size() &&
         std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.size() * sizeof(DirectionalNode)) == 0;
}

inline double Normal(uint64_t& rng) {
  const double radius = std::sqrt(-2 * std::log(1 - static_cast<double>(Unit(rng))));
  return radius * std::cos(2 * static_cast<double>(kPi) * Unit(rng));
}

inline void ForEachCell(const directional::Tree& tree,
                        const std::function<void(uint32_t slot, uint32_t x, uint32_t y, int depth)>& visit) {
  const auto walk = [&](auto& self, uint32_t node, uint32_t x, uint32_t y, int depth) -> void {
    for (uint32_t c = 0; c < 4; ++c) {
      const uint32_t child = tree.nodes[node].child[c], cx = 2 * x + (c & 1), cy = 2 * y + (c >> 1);
      if (child != 0) {
        self(self, child, cx, cy, depth + 1);
      } else {
        visit(node * 4 + c, cx, cy, depth + 1);
      }
    }
  };
  walk(walk, 0, 0, 0, 0);
}

// One round into `to.tree`, half of the records from the uniform sphere and half from the tree, which the box filter
// spreads.
inline void RecordRound(const Recording& r, int records, uint64_t& rng, RecordedTree& to) {
  const DirectionalNode* const nodes = to.tree.nodes.data();
  directional::CellMasses& m = to.masses;
  m = {nodes, static_cast<uint32_t>(to.tree.nodes.size()), std::vector<double>(to.tree.nodes.size() * 4, 0.0), {}};
  m.halves.fill(m.total);
  for (int i = 0; i < records; ++i) {
    Vec2 square = Unit2(rng);
    if (Unit(rng) < 0.5f) square = directional::Sample(nodes, Unit2(rng)).square;
    const directional::Cell cell = directional::Locate(nodes, square);
    const double pdf = 0.5 * kUniformSpherePdf + 0.5 * cell.density;
    double value = r.radiance(CylindricalToDirection(square)) *
                   std::exp(r.log_spread * Normal(rng) - 0.5 * r.log_spread * r.log_spread) / pdf;
    if (r.second_moment) value *= value * pdf;
    directional::ForFootprint(nodes, directional::ToInteger(square.x), directional::ToInteger(square.y), cell,
                              [&](uint32_t slot, float share) {
                                m.total[slot] += value * share;
                                m.halves[i & 1][slot] += value * share;
                              });
  }
  if (!r.second_moment) return;
  ForEachCell(to.tree, [&](uint32_t slot, uint32_t, uint32_t, int depth) {
    const double area = std::ldexp(1.0, -2 * depth);
    m.total[slot] = std::sqrt(m.total[slot] * area);
    for (auto& half : m.halves) half[slot] = std::sqrt(half[slot] * area);
  });
}

// Rounds but for the last use `reconstruct` to make the next tree.
inline RecordedTree Record(const Recording& r, const Reconstruct& reconstruct = Plain) {
  RecordedTree t;
  t.tree = {{DirectionalNode{}}, 1};
  uint64_t rng = Mix64(r.seed);
  for (int round = 0; round < r.rounds; ++round) {
    RecordRound(r, std::max(128, static_cast<int>(r.records * std::pow(1.5, round - r.rounds + 1))), rng, t);
    if (round + 1 < r.rounds) t.tree = reconstruct(t.masses, r.flux_threshold, r.max_depth);
  }
  t.masses.nodes = t.tree.nodes.data();
  return t;
}

}  // namespace lodestar::synthetic
