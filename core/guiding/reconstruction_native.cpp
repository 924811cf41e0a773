#include <cstring>

#include "core/base/check.h"
#include "core/guiding/reconstruction_shrinkage.h"

namespace lodestar::directional {
namespace {

// The weight of the unsmoothed tree: sqrt(kRawWeight) / (sqrt(kRawWeight) + sqrt(1 - kRawWeight)) = 0.37 is the least
// part of any cell's density that smoothing can leave.
constexpr double kRawWeight = 0.25;

// A cell of the tree as seen from a neighbour: the square next to it at its own depth, or the larger cell that holds
// that square. The slot (4 place + child) times two, plus one if it is seen across a pole: x runs the other way.
using Square = uint32_t;
constexpr uint32_t kSide = 4;
// The squares of the size of a node's children, of the four and around them: x runs first.
using Surroundings = std::array<Square, kSide * kSide>;

// Of the root: squares wrap around in phi; across a pole phi is turned by half a circle, the first bit of y.
constexpr Surroundings kAroundRoot = [] {
  Surroundings around;
  for (uint32_t i = 0; i < around.size(); ++i) {
    const uint32_t x = i % kSide, y = i / kSide;
    const bool across = x == 0 || x == 3;
    around[i] = ((x >= 2) + 2 * ((y + 1 + across) % 2)) * 2 + across;
  }
  return around;
}();

class Smoother {
 public:
  Smoother(const LevelNode* nodes, uint32_t count)
      : nodes_(nodes),
        count_(count),
        smooth_(std::make_unique_for_overwrite<Smooth[]>(count)),
        density_(std::make_unique_for_overwrite<float[]>(size_t{count} * 4)) {}

  // Masses of the cells, by the recorded tree's slots; zero above them.
  std::vector<double> Masses() {
    // Level by level: what is around a node is known before what lies in it.
    smooth_[0].around = kAroundRoot;
    for (uint32_t i = 1; i < count_; ++i) {
      if (HasNodes(nodes_[i])) smooth_[i].around = Around(nodes_[i].parent);
    }
    SmoothNode(0, 1, 4, Quad{} + 0.25f);
    for (uint32_t i = 1; i < count_; ++i) {
      const uint32_t parent = nodes_[i].parent;
      const Smooth& above = smooth_[parent / 4];
      SmoothNode(i, above.mass[parent % 4], 4 * above.per_area, Predict(parent));
    }
    std::vector<double> masses(size_t{count_} * 4);
    for (uint32_t i = 0; i < count_; ++i) {
      const DoubleQuad raw = nodes_[i].share, smooth = smooth_[i].mass;
      const DoubleQuad mass = _mm256_sqrt_pd(kRawWeight * raw * raw + (1 - kRawWeight) * smooth * smooth);
      const DoubleQuad cells = __builtin_convertvector(nodes_[i].child == 0, MaskQuad) ? mass : DoubleQuad{};
      std::memcpy(&masses[size_t{nodes_[i].node} * 4], &cells, sizeof(cells));
    }
    return masses;
  }

 private:
  static bool HasNodes(const LevelNode& n) { return (n.child[0] | n.child[1] | n.child[2] | n.child[3]) != 0; }

  struct Smooth {
    DoubleQuad mass;      // of the children
    float per_area;       // density over mass
    Surroundings around;  // where a child is a node
  };

  // The 3 x 3 squares of a node's size around it begin here in its parent's surroundings.
  const Square* SquaresAround(uint32_t parent) const {
    return &smooth_[parent / 4].around[parent % 2 + kSide * (parent % 4 / 2)];
  }

  // Of the node in slot `parent`.
  Surroundings Around(uint32_t parent) const {
    const Square* const square = SquaresAround(parent);
    Surroundings around;
    for (uint32_t y = 0; y < kSide; ++y) {
      for (uint32_t x = 0; x < kSide; ++x) {
        // In children, from two before the node.
        const Square of = square[(y + 1) / 2 * kSide + (x + 1) / 2], across = of % 2;
        const uint32_t child = nodes_[of / 8].child[of / 2 % 4];
        const Square within = (child * 4 + (((x + 1) % 2) ^ across) + 2 * ((y + 1) % 2)) * 2 + across;
        // All bits if it is a node: by arithmetic, since a branch could not be guessed.
        const Square is_node = static_cast<Square>(-static_cast<int32_t>(child) >> 31);
        around[y * kSide + x] = of ^ ((of ^ within) & is_node);
      }
    }
    return around;
  }

  void SmoothNode(uint32_t i, double mass, float per_area, Quad predicted) {
    const LevelNode& n = nodes_[i];
    Smooth& s = smooth_[i];
    const double recorded = Sum(n.share);
    const double keep = recorded > 0 ? (1 - n.weight) / recorded : 0;
    const double shrink = recorded > 0 ? n.weight : 1;
    s.mass = mass * (keep * n.share + shrink * __builtin_convertvector(predicted, DoubleQuad));
    const Quad density = __builtin_convertvector(s.mass, Quad) * per_area;
    std::memcpy(&density_[size_t{i} * 4], &density, sizeof(density));
    s.per_area = per_area;
  }

  // The shares of a node's children if the density were bilinear between the centres of the squares around it.
  Quad Predict(uint32_t parent) const {
    const Square* const square = SquaresAround(parent);
    const auto row = [&](int y) {  // between the columns: the left and the right children's, twice
      const auto density = [&](int x) { return density_[square[y * kSide + x] / 2]; };
      const float left = density(0), centre = 3 * density(1), right = density(2);
      return Quad{left, right, left, right} + centre;
    };
    const Quad above = row(0), below = row(2);
    const Quad predicted = 3 * row(1) + __builtin_shufflevector(above, below, 0, 1, 6, 7);
    const float sum = Sum(predicted);
    return sum > 0 ? predicted / sum : Quad{} + 0.25f;
  }

  const LevelNode* nodes_;
  uint32_t count_;
  std::unique_ptr<Smooth[]> smooth_;
  std::unique_ptr<float[]> density_;  // by slot, of the unit square
};

}  // namespace

Tree ReconstructNative(const CellMasses& masses, double flux_threshold, int max_depth) {
  LODESTAR_CHECK(masses.total.size() == size_t{masses.node_count} * 4);
  if (!masses.halves[0].empty()) {
    const Shrinkage shrinkage = InferShrinkage(masses);
    if (!shrinkage.needless)
      return Rebuild(masses.nodes, masses.node_count, Smoother(shrinkage.nodes.get(), masses.node_count).Masses(),
                     flux_threshold, max_depth);
  }
  return Rebuild(masses.nodes, masses.node_count, masses.total, flux_threshold, max_depth);
}

}  // namespace lodestar::directional
