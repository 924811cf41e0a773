#include <cstring>
#include <limits>

#include "core/base/check.h"
#include "core/guiding/reconstruction_shrinkage.h"

namespace lodestar::directional {
namespace {

// The weight of the unsmoothed tree: sqrt(kRawWeight) / (sqrt(kRawWeight) + sqrt(1 - kRawWeight)) = 0.37 is the least
// part of any cell's density that smoothing can leave.
constexpr double kRawWeight = 0.25;
// The coarsest layer of the maximum over layers: 2^4 x 2^4 squares of the sphere, 0.05 sr each.
constexpr float kFirstLayerSquares = 256;
// How much of that maximum a tree may have.
constexpr float kLayerWeights[] = {0, 0.25f, 0.5f, 1, 2, 4};
// Samples beside the tree's, which are the BSDF's; nothing is known of where they go.
constexpr float kUniform = 0.3f;

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
    SmoothAll();
    const float weight = LayerWeight();
    std::vector<double> masses(size_t{count_} * 4);
    for (uint32_t i = 0; i < count_; ++i) {
      const DoubleQuad cells = __builtin_convertvector(Mass(smooth_[i], weight), DoubleQuad);
      std::memcpy(&masses[size_t{nodes_[i].node} * 4], &cells, sizeof(cells));
    }
    return masses;
  }

 private:
  static bool HasNodes(const LevelNode& n) { return (n.child[0] | n.child[1] | n.child[2] | n.child[3]) != 0; }

  struct Smooth {
    DoubleQuad mass;  // of the children
    // Of the children that are cells, else 0. `moment`: of the mass's square, as far as it is known.
    Quad blend, layers, moment;
    Quad above;           // of the children: the greatest density that the layers above them have there
    float per_area;       // density over mass
    Surroundings around;  // where a child is a node
  };

  void SmoothAll() {
    // Level by level: what is around a node is known before what lies in it.
    smooth_[0].around = kAroundRoot;
    for (uint32_t i = 1; i < count_; ++i) {
      if (HasNodes(nodes_[i])) smooth_[i].around = Around(nodes_[i].parent);
    }
    SmoothNode(0, 1, 4, Quad{} + 1, 0);
    for (uint32_t i = 1; i < count_; ++i) {
      const uint32_t parent = nodes_[i].parent;
      const Smooth& s = smooth_[parent / 4];
      SmoothNode(i, s.mass[parent % 4], 4 * s.per_area, Interpolate(parent), s.above[parent % 4]);
    }
  }

  static Quad Mass(const Smooth& s, float layer_weight) {
    const Quad layers = layer_weight * s.layers;
    return s.blend > layers ? s.blend : layers;
  }

  // The part of the maximum over layers whose second moment is expected to be least: the cells' masses are known up to
  // their noise.
  float LayerWeight() const {
    float best = 0, least = std::numeric_limits<float>::infinity();
    for (const float weight : kLayerWeights) {
      Quad sums = {};
      for (uint32_t i = 0; i < count_; ++i) sums += Mass(smooth_[i], weight);
      const float scale = (1 - kUniform) / Sum(sums);
      Quad moments = {};
      for (uint32_t i = 0; i < count_; ++i) {
        const Smooth& s = smooth_[i];
        moments += s.moment / (scale * Mass(s, weight) + kUniform / s.per_area);
      }
      const float moment = Sum(moments);
      if (moment < least) {
        least = moment;
        best = weight;
      }
    }
    return best;
  }

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

  // interpolated: of the squares of the node's size, at the centres of its children; layers: what the layers above have
  // in the node's own slot.
  void SmoothNode(uint32_t i, double mass, float per_area, Quad interpolated, float layers) {
    const LevelNode& n = nodes_[i];
    Smooth& s = smooth_[i];
    const double recorded = Sum(n.share);
    const double keep = recorded > 0 ? (1 - n.weight) / recorded : 0;
    const double shrink = recorded > 0 ? n.weight : 1;
    const float sum = Sum(interpolated);
    const Quad predicted = sum > 0 ? interpolated / sum : Quad{} + 0.25f;
    s.mass = mass * (keep * n.share + shrink * __builtin_convertvector(predicted, DoubleQuad));
    const Quad smooth = __builtin_convertvector(s.mass, Quad), density = smooth * per_area;
    std::memcpy(&density_[size_t{i} * 4], &density, sizeof(density));
    s.per_area = per_area;

    const Quad inherited = Quad{} + layers;
    s.above = per_area < 4 * kFirstLayerSquares ? Quad{} : interpolated > inherited ? interpolated : inherited;
    const auto in_cells = [&n](Quad x) { return n.child == 0 ? x : Quad{}; };
    const DoubleQuad blend = _mm256_sqrt_pd(kRawWeight * n.share * n.share + (1 - kRawWeight) * s.mass * s.mass);
    s.blend = in_cells(__builtin_convertvector(blend, Quad));
    s.layers = in_cells(s.above / per_area);
    s.moment = in_cells(smooth * (smooth + n.per_record));
  }

  // Densities at the centres of the children of the node in slot `parent`, if they were bilinear between the centres of
  // the squares around it.
  Quad Interpolate(uint32_t parent) const {
    const Square* const square = SquaresAround(parent);
    const auto row = [&](int y) {  // between the columns: the left and the right children's, twice
      const auto density = [&](int x) { return density_[square[y * kSide + x] / 2]; };
      const float left = density(0), centre = 3 * density(1), right = density(2);
      return Quad{left, right, left, right} + centre;
    };
    const Quad above = row(0), below = row(2);
    return (3 * row(1) + __builtin_shufflevector(above, below, 0, 1, 6, 7)) * 0.0625f;
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
