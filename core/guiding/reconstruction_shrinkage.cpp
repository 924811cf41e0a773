#include "core/guiding/reconstruction_shrinkage.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/guiding/reconstruction_lanes.h"

namespace lodestar::directional {
namespace {

// The candidates: Dirichlet concentrations, in records, from a prediction that is all but ignored to one that outweighs
// 256 records.
constexpr Lanes kConcentration = {1.0f / 64, 1.0f / 16, 1.0f / 4, 1, 4, 16, 64, 256};
// The concentration's scale is unknown: uniform in its logarithm.
constexpr float kPrior = 1.0f / 8;
// Probability that a child has its parent's concentration, else it draws its own: even odds.
constexpr float kKeep = 0.5f;
// Cells that the parent's estimate of the mass per record counts as: one node's.
constexpr float kParentCells = 4;

struct alignas(32) NodeState {
  Lanes belief;            // upward: likelihood of what lies in and below the node; downward: posterior
  Lanes message;           // what the node tells its parent, sum 1
  std::array<float, 4> x;  // children's masses from either half, as parts of both halves' total;
  std::array<float, 4> y;  // later in effective records
  float mass = 0;          // share of the total
  float noise = 0;         // sum of the squared differences of the halves over the cells
  float cells = 0;
  float per_record = 0;  // mass per effective record
  uint32_t parent = 0;
};

Lanes Normalized(Lanes x) {
  return x * (1 / Sum(x));
}

// Half the log likelihood of each half given the other, under each concentration. The prediction is a quarter each
// here.
Lanes LogPredictive(const NodeState& n) {
  const float x = (n.x[0] + n.x[1]) + (n.x[2] + n.x[3]), y = (n.y[0] + n.y[1]) + (n.y[2] + n.y[3]);
  const Lanes quarter = kConcentration * 0.25f;
  Lanes sum = {};
  for (int c = 0; c < 4; ++c) {
    if (n.y[c] > 0) sum += Log(quarter + n.x[c]) * n.y[c];
    if (n.x[c] > 0) sum += Log(quarter + n.y[c]) * n.x[c];
  }
  if (y > 0) sum -= Log(kConcentration + x) * y;
  if (x > 0) sum -= Log(kConcentration + y) * x;
  return sum * 0.5f;
}

// Sums over subtrees, of all that is kept. Returns the states with masses, noise and cells.
std::vector<NodeState> SumUp(const CellMasses& masses, std::vector<double>& share) {
  double total = 0, halves = 0;
  for (size_t slot = 0; slot < masses.total.size(); ++slot) {
    total += masses.total[slot];
    halves += masses.halves[0][slot] + masses.halves[1][slot];
  }
  const double to_share = 1 / total, to_part = halves > 0 ? 1 / halves : 0;
  share.resize(masses.total.size());
  std::vector<NodeState> states(masses.node_count);
  for (uint32_t node = masses.node_count; node-- > 0;) {
    NodeState& n = states[node];
    double mass = 0;
    for (uint32_t c = 0; c < 4; ++c) {
      const uint32_t slot = node * 4 + c, child = masses.nodes[node].child[c];
      if (child != 0) {
        NodeState& below = states[child];
        below.parent = node;
        n.x[c] = (below.x[0] + below.x[1]) + (below.x[2] + below.x[3]);
        n.y[c] = (below.y[0] + below.y[1]) + (below.y[2] + below.y[3]);
        n.noise += below.noise;
        n.cells += below.cells;
        share[slot] = (share[child * 4] + share[child * 4 + 1]) + (share[child * 4 + 2] + share[child * 4 + 3]);
      } else {
        n.x[c] = static_cast<float>(masses.halves[0][slot] * to_part);
        n.y[c] = static_cast<float>(masses.halves[1][slot] * to_part);
        n.noise += (n.x[c] - n.y[c]) * (n.x[c] - n.y[c]);
        n.cells += 1;
        share[slot] = masses.total[slot] * to_share;
      }
      mass += share[slot];
    }
    n.mass = static_cast<float>(mass);
  }
  return states;
}

// Mass per effective record, from the root down. Returns the expected divergence that noise causes: three free shares a
// node, 3 / (2 records) nats each, and no more than if all were lost.
double EstimateNoise(std::vector<NodeState>& states) {
  double divergence = 0;
  for (size_t node = 0; node < states.size(); ++node) {
    NodeState& n = states[node];
    const float inherited = node == 0 ? 0 : states[n.parent].per_record;
    const float own = n.mass > 0 ? n.noise / n.mass : inherited;
    n.per_record = node == 0 ? own : (n.cells * own + kParentCells * inherited) / (n.cells + kParentCells);
    divergence += 1.5 * std::min(n.per_record, n.mass);
  }
  return divergence;
}

// Belief propagation on the tree of concentrations (a hidden Markov tree; exact, since it has no cycles).
void Propagate(std::vector<NodeState>& states) {
  for (NodeState& n : states) {
    const float records = 1 / n.per_record;
    for (int c = 0; c < 4; ++c) {
      n.x[c] *= records;
      n.y[c] *= records;
    }
    const Lanes log = LogPredictive(n);
    n.belief = Exp(log - Max(log));
  }
  for (size_t node = states.size(); node-- > 1;) {
    NodeState& n = states[node];
    n.belief = Normalized(n.belief);
    n.message = n.belief * kKeep + (1 - kKeep) * kPrior;
    states[n.parent].belief *= n.message;
  }
  states[0].belief = Normalized(states[0].belief);
  for (size_t node = 1; node < states.size(); ++node) {
    NodeState& n = states[node];
    const Lanes elsewhere = Normalized(states[n.parent].belief / n.message);
    n.belief = Normalized(n.belief * (elsewhere * kKeep + kPrior * (1 - kKeep)));
  }
}

}  // namespace

Shrinkage InferShrinkage(const CellMasses& masses) {
  Shrinkage out;
  LODESTAR_CHECK(masses.halves[0].size() == masses.total.size() && masses.halves[1].size() == masses.total.size());
  std::vector<NodeState> states = SumUp(masses, out.share);
  if (EstimateNoise(states) < kLeastGain) return out;
  Propagate(states);
  out.weight.reserve(states.size());
  for (const NodeState& n : states) {
    const float records = n.mass / n.per_record;
    out.weight.push_back(Sum(n.belief * kConcentration / (kConcentration + records)));
  }
  return out;
}

}  // namespace lodestar::directional
