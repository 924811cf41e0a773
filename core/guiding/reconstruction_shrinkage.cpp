#include "core/guiding/reconstruction_shrinkage.h"

#include <algorithm>
#include <cstring>

#include "core/base/check.h"

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

struct NodeState {
  Lanes belief;   // upward: likelihood of what lies in and below the node; downward: posterior, but for a factor
  Lanes message;  // what the node tells its parent
  Quad x, y;      // children's masses from either half, as parts of both halves' total; later in effective records
  float mass;     // share of the total
  float noise;    // sum of the squared differences of the halves over the cells
  float cells;
};
using States = std::unique_ptr<NodeState[]>;

DoubleQuad Load(const std::vector<double>& masses, uint32_t node) {
  DoubleQuad m;
  std::memcpy(&m, &masses[size_t{node} * 4], sizeof(m));
  return m;
}

// Places the nodes, with the shares of their cells.
std::unique_ptr<LevelNode[]> Place(const CellMasses& masses) {
  DoubleQuad sum = {};
  for (uint32_t node = 0; node < masses.node_count; ++node) sum += Load(masses.total, node);
  const double to_share = 1 / Sum(sum);
  auto nodes = std::make_unique_for_overwrite<LevelNode[]>(masses.node_count + 1);  // one more is written to
  nodes[0].node = nodes[0].parent = 0;
  uint32_t count = 1;
  for (uint32_t i = 0; i < masses.node_count; ++i) {
    LevelNode& n = nodes[i];
    n.share = Load(masses.total, n.node) * to_share;
    for (uint32_t c = 0; c < 4; ++c) {
      const uint32_t child = masses.nodes[n.node].child[c];
      nodes[count].node = child;
      nodes[count].parent = i * 4 + c;
      n.child[c] = child != 0 ? count : 0;
      count += child != 0;
    }
  }
  return nodes;
}

// Sums over subtrees, of all that is kept. Returns the states with masses, noise and cells.
States SumUp(const CellMasses& masses, LevelNode* nodes) {
  DoubleQuad sums = {};
  for (uint32_t node = 0; node < masses.node_count; ++node)
    sums += Load(masses.halves[0], node) + Load(masses.halves[1], node);
  const double sum = Sum(sums), to_part = sum > 0 ? 1 / sum : 0;
  auto states = std::make_unique_for_overwrite<NodeState[]>(masses.node_count);
  for (uint32_t i = 0; i < masses.node_count; ++i) {
    NodeState& s = states[i];
    s.x = __builtin_convertvector(Load(masses.halves[0], nodes[i].node) * to_part, Quad);
    s.y = __builtin_convertvector(Load(masses.halves[1], nodes[i].node) * to_part, Quad);
    const Quad difference = s.x - s.y;  // none in slots that have a child
    s.noise = Sum(difference * difference);
    s.cells = 4;
  }
  for (uint32_t i = masses.node_count; i-- > 0;) {
    NodeState& s = states[i];
    const double mass = Sum(nodes[i].share);
    s.mass = static_cast<float>(mass);
    if (i == 0) break;
    const uint32_t parent = nodes[i].parent / 4, c = nodes[i].parent % 4;
    NodeState& above = states[parent];
    nodes[parent].share[c] = mass;
    above.x[c] = Sum(s.x);
    above.y[c] = Sum(s.y);
    above.noise += s.noise;
    above.cells += s.cells - 1;
  }
  return states;
}

// Mass per effective record, from the root down. Returns the expected divergence that noise causes: three free shares a
// node, 3 / (2 records) nats each, and no more than if all were lost.
double EstimateNoise(LevelNode* nodes, const NodeState* states, uint32_t count) {
  double divergence = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const NodeState& s = states[i];
    const float inherited = i == 0 ? 0 : nodes[nodes[i].parent / 4].per_record;
    const float own = s.mass > 0 ? s.noise / s.mass : inherited;
    nodes[i].per_record = i == 0 ? own : (s.cells * own + kParentCells * inherited) / (s.cells + kParentCells);
    divergence += 1.5 * std::min(nodes[i].per_record, s.mass);
  }
  return divergence;
}

// Half the log likelihood of each half given the other, under each concentration; x and y in effective records. The
// prediction is a quarter each here.
Lanes LogPredictive(const Quad& x, const Quad& y) {
  const Lanes quarter = kConcentration * 0.25f;
  Lanes given_x = Log(kConcentration + Sum(x)) * -Sum(y), given_y = Log(kConcentration + Sum(y)) * -Sum(x);
  for (int c = 0; c < 4; ++c) {
    given_x = MultiplyAdd(Log(quarter + x[c]), Broadcast(y[c]), given_x);
    given_y = MultiplyAdd(Log(quarter + y[c]), Broadcast(x[c]), given_y);
  }
  return (given_x + given_y) * 0.5f;
}

// Belief propagation on the tree of concentrations (a hidden Markov tree; exact, since it has no cycles).
void Propagate(const LevelNode* nodes, NodeState* states, uint32_t count) {
  // Short loops, in which the processor sees several nodes at once.
  for (uint32_t i = 0; i < count; ++i) {
    states[i].x /= nodes[i].per_record;
    states[i].y /= nodes[i].per_record;
  }
  for (uint32_t i = 0; i < count; ++i) states[i].belief = LogPredictive(states[i].x, states[i].y);
  for (uint32_t i = 0; i < count; ++i) states[i].belief = Exp(states[i].belief - Max(states[i].belief));
  for (uint32_t i = count; i-- > 1;) {
    NodeState& s = states[i];
    s.belief *= 1 / Sum(s.belief);
    s.message = s.belief * kKeep + (1 - kKeep) * kPrior;
    states[nodes[i].parent / 4].belief *= s.message;
  }
  states[0].belief *= 1 / Sum(states[0].belief);
  for (uint32_t i = 1; i < count; ++i) {
    // A level changes the sum by less than a factor of ten, and there are kMaxDepth at most.
    NodeState& s = states[i];
    const Lanes elsewhere = states[nodes[i].parent / 4].belief / s.message;
    s.belief *= elsewhere * kKeep + Sum(elsewhere) * (kPrior * (1 - kKeep));
  }
}

}  // namespace

Shrinkage InferShrinkage(const CellMasses& masses) {
  LODESTAR_CHECK(masses.halves[0].size() == masses.total.size() && masses.halves[1].size() == masses.total.size());
  const uint32_t count = masses.node_count;
  Shrinkage out = {Place(masses)};
  LevelNode* const nodes = out.nodes.get();
  const States states = SumUp(masses, nodes);
  if (EstimateNoise(nodes, states.get(), count) < kLeastGain) {
    out.needless = true;
    return out;
  }
  Propagate(nodes, states.get(), count);
  for (uint32_t i = 0; i < count; ++i) {
    const NodeState& s = states[i];
    const float records = s.mass / nodes[i].per_record;
    nodes[i].weight = (Sum(s.belief * (kConcentration / (kConcentration + records))) / Sum(s.belief))[0];
  }
  return out;
}

}  // namespace lodestar::directional
