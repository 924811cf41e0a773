#include "core/guiding/product_distribution.h"

namespace lodestar {
namespace {

using directional::kBits;
using directional::ToInteger;
using product::Block;
using product::kBlock;
using product::kBlockLevel;
using product::kSide;

constexpr DirectionalNode kUniform;

// P(child) of a node, child by child. Adds up to 1 but for rounding.
struct Quarters {
  explicit Quarters(const DirectionalNode& node) {
    const float left = static_cast<float>(node.left) * 0x1p-15f, right = 1 - left;
    p[0] = left * (static_cast<float>(node.lower[0]) * 0x1p-15f);
    p[1] = right * (static_cast<float>(node.lower[1]) * 0x1p-15f);
    p[2] = left - p[0];
    p[3] = right - p[1];
  }
  float p[4];
};

// The tree's probabilities of the block's cells. A tree that ends earlier is uniform below.
void GatherFlux(const DirectionalNode* nodes, Block& flux) {
  const auto spread = [&](uint32_t at, uint32_t size, float share) {
    for (uint32_t j = 0; j < size; ++j) {
      for (uint32_t i = 0; i < size; ++i) flux[at + j * kSide + i] = share;
    }
  };
  const auto corner = [](uint32_t c, uint32_t size) { return (c & 1) * size + (c >> 1) * size * kSide; };
  const Quarters root(nodes[0]);
  for (uint32_t a = 0; a < 4; ++a) {
    const uint32_t at_a = corner(a, 4), index_a = nodes[0].child[a];
    if (index_a == 0) {
      spread(at_a, 4, root.p[a] * 0x1p-4f);
      continue;
    }
    const DirectionalNode& node_a = nodes[index_a];
    const Quarters in_a(node_a);
    for (uint32_t b = 0; b < 4; ++b) {
      const uint32_t at = at_a + corner(b, 2), index_b = node_a.child[b];
      const float share = root.p[a] * in_a.p[b];
      const Quarters in_b(index_b == 0 ? kUniform : nodes[index_b]);
      flux[at] = share * in_b.p[0];
      flux[at + 1] = share * in_b.p[1];
      flux[at + kSide] = share * in_b.p[2];
      flux[at + kSide + 1] = share * in_b.p[3];
    }
  }
}

// A node whose children are weighted by d, with probabilities rounded to integers as the node's own are. Where all
// products vanish, the node itself.
class WeightedNode {
 public:
  WeightedNode(const DirectionalNode& node, const std::array<float, 4>& d) {
    const Quarters flux(node);
    float sum = 0;
    for (uint32_t c = 0; c < 4; ++c) sum += p_[c] = flux.p[c] * d[c];
    if (!(sum > 0)) std::copy_n(flux.p, 4, p_);
    left_ = Portion(p_[0] + p_[2], p_[1] + p_[3]);
  }
  // As DirectionalNode::left and lower.
  uint32_t left() const { return left_; }
  uint32_t Lower(uint32_t x) const { return Portion(p_[x], p_[x + 2]); }

 private:
  static uint32_t Portion(float a, float b) {
    const float sum = a + b;
    return sum > 0 ? static_cast<uint32_t>(a / sum * static_cast<float>(DirectionalNode::kOne) + 0.5f)
                   : DirectionalNode::kOne / 2;
  }

  float p_[4];
  uint32_t left_;
};

// Four times a child's probability, from the halves' as integers.
float FourTimes(uint32_t left, uint32_t lower, uint32_t x, uint32_t y) {
  constexpr uint32_t kOne = DirectionalNode::kOne;
  return static_cast<float>(static_cast<int32_t>((x ? kOne - left : left) * (y ? kOne - lower : lower))) * 0x1p-28f;
}

// How far down the product goes for the cosine lobes' sake, and for any lobe where it matters: until the cells are half
// as wide as it.
constexpr int kSmoothLevel = 5;
int LevelOf(const Ltc& ltc) {
  int level = kSmoothLevel;
  while (level < product::kFinest && 2 * product::CellSize(level) > ltc.width()) ++level;
  return level;
}

}  // namespace

ProductDistribution::ProductDistribution(const DirectionalNode* nodes, const ProductLobes& lobes)
    : nodes_(nodes), lobes_(lobes) {
  directional::Prefetch(nodes);
  if (lobes.none()) return;
  broad_.fill(0);
  narrow_.fill(0);
  deep_level_ = kSmoothLevel;
  if (lobes.diffuse() > 0) product::AddCosine(lobes.normal(), lobes.diffuse(), broad_);
  if (lobes.transmission() > 0) product::AddCosine(-lobes.normal(), lobes.transmission(), broad_);
  for (int i = 0; i < lobes.glossy_count(); ++i) {
    const int level = LevelOf(lobes.glossy(i));
    deep_level_ = std::max(deep_level_, level);
    product::AddGlossy(lobes.glossy(i), lobes.normal(), lobes.glossy_weight(i),
                       level > kSmoothLevel ? narrow_ : broad_);
  }
  GatherFlux(nodes, flux_);
  std::array<float, kSide> product{}, flux{};
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      const int c = j * kSide + i;
      product_[c] = (broad_[c] + narrow_[c]) * flux_[c];
      product[i] += product_[c];
      flux[i] += flux_[c];
    }
  }
  const auto total = [](const std::array<float, kSide>& v) {
    return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
  };
  mass_ = total(product) * kBlock * kUniformSpherePdf;
  usable_ = mass_ > 1e-12f;
  if (!usable_) return;
  scale_ = (1 - kBlockDefence) / total(product);
  float sum = 0;
  for (int i = 0; i < kSide; ++i) columns_[i] = sum += product[i] * scale_ + flux[i] * kBlockDefence;
  density_ = kBlock * kUniformSpherePdf / sum;
}

// The walk below the block, in step with the tree's nodes while they last.
struct ProductDistribution::Descent {
  Descent(const ProductDistribution& of, uint32_t x, uint32_t y) : of(of), x(x), y(y) {
    const uint32_t cell = y * kSide + x;
    for (int shift = kBlockLevel - 1; shift >= 0; --shift) {
      node = of.nodes_[node].child[((x >> shift) & 1) + 2 * ((y >> shift) & 1)];
      if (node == 0) break;
    }
    density = of.density_ * of.Share(cell);
    if (of.narrow_[cell] > kLeastNarrow * of.broad_[cell]) deepest = of.deep_level_;
  }
  // A cell with less of the narrow lobes than this, relative to the others, is left to the flux sooner.
  static constexpr float kLeastNarrow = 0.1f;

  bool Ends() const { return node == 0 && !Deep(); }
  bool Deep() const { return level < deepest; }
  const DirectionalNode& Node() const { return node == 0 ? kUniform : of.nodes_[node]; }
  // The node's probabilities times the lobes'.
  WeightedNode Product() const { return WeightedNode(Node(), product::Children(of.lobes_, level, x, y)); }
  // by_tree, by_product: the child's probabilities times four; the latter counts where the product still decides.
  void Enter(uint32_t bx, uint32_t by, float by_tree, float by_product) {
    if (Deep()) {
      tree *= by_tree;
      lobe *= by_product;
    } else {
      density *= by_tree;
    }
    node = Node().child[bx + 2 * by];
    x = 2 * x + bx;
    y = 2 * y + by;
    ++level;
  }
  float Density() const { return density * ((1 - kDeepDefence) * lobe + kDeepDefence * tree); }

  const ProductDistribution& of;
  uint32_t x, y, node = 0;
  int level = kBlockLevel, deepest = kSmoothLevel;
  float density, tree = 1, lobe = 1;
};

float ProductDistribution::Locate(uint32_t x, uint32_t y) const {
  constexpr int kTop = kBits - kBlockLevel;
  Descent descent(*this, x >> kTop, y >> kTop);
  for (int shift = kTop - 1; !descent.Ends(); --shift) {
    const uint32_t bx = (x >> shift) & 1, by = (y >> shift) & 1;
    const DirectionalNode& tree = descent.Node();
    float by_product = 1;
    if (descent.Deep()) {
      const WeightedNode lobes = descent.Product();
      by_product = FourTimes(lobes.left(), lobes.Lower(bx), bx, by);
    }
    descent.Enter(bx, by, FourTimes(tree.left, tree.lower[bx], bx, by), by_product);
  }
  return descent.Density();
}

float ProductDistribution::Pdf(Vec3 w) const {
  const Vec2 square = DirectionToCylindrical(w);
  return Locate(ToInteger(square.x), ToInteger(square.y));
}

GuidedSample ProductDistribution::Sample(Vec2 u) const {
  // Step 1: a column of the block by u.x, a cell of it by u.y; each is then uniform again.
  const auto choose = [](const std::array<float, kSide>& sums, float& u) {
    const float target = u * sums[kSide - 1];
    uint32_t i = 0;
    for (uint32_t k = 0; k < kSide - 1; ++k) i += !(target < sums[k]);  // no branches: the outcome is random by design
    const float before = i > 0 ? sums[i - 1] : 0, share = sums[i] - before;
    u = share > 0 ? std::clamp((target - before) / share, 0.0f, kOneMinusEpsilon) : 0;
    return i;
  };
  const uint64_t low = ((uint64_t{ToInteger(u.x)} << 32) | ToInteger(u.y)) * 0x9e3779b97f4a7c15ULL;
  const uint32_t column = choose(columns_, u.x);
  std::array<float, kSide> rows;
  float sum = 0;
  for (uint32_t j = 0; j < kSide; ++j) rows[j] = sum += Share(j * kSide + column);
  const uint32_t row = choose(rows, u.y);

  // Step 2: down from there, as directional::Sample does.
  Descent descent(*this, column, row);
  const bool by_lobes = u.x >= kDeepDefence;
  u.x =
      by_lobes ? std::min((u.x - kDeepDefence) * (1 / (1 - kDeepDefence)), kOneMinusEpsilon) : u.x * (1 / kDeepDefence);
  uint64_t x = (uint64_t{ToInteger(u.x)} << 24) | (low >> 40),
           y = (uint64_t{ToInteger(u.y)} << 24) | ((low >> 16) & 0xffffff);
  uint64_t x_range = uint64_t{1} << 48, y_range = uint64_t{1} << 48;
  const auto below = [](uint64_t& value, uint64_t& range, uint32_t portion) {
    const uint64_t split = (range * portion) >> 15, upper = value >= split, mask = -upper;
    value -= split & mask;
    range = split + ((range - 2 * split) & mask);
    return static_cast<uint32_t>(upper);
  };
  while (!descent.Ends()) {
    const DirectionalNode& tree = descent.Node();
    uint32_t bx, by;
    float by_product = 1;
    if (descent.Deep()) {
      const WeightedNode lobes = descent.Product();
      bx = below(x, x_range, by_lobes ? lobes.left() : tree.left);
      const uint32_t lower = lobes.Lower(bx);
      by = below(y, y_range, by_lobes ? lower : tree.lower[bx]);
      by_product = FourTimes(lobes.left(), lower, bx, by);
    } else {
      bx = below(x, x_range, tree.left);
      by = below(y, y_range, tree.lower[bx]);
    }
    descent.Enter(bx, by, FourTimes(tree.left, tree.lower[bx], bx, by), by_product);
  }

  // Step 3: a point of the cell, safely inside where a direction and back would leave it (as SdTree::Sample).
  const float size = std::bit_cast<float>(static_cast<uint32_t>(127 - descent.level) << 23);
  const float fx = static_cast<float>(static_cast<int64_t>(x)) / static_cast<float>(static_cast<int64_t>(x_range));
  const float fy = static_cast<float>(static_cast<int64_t>(y)) / static_cast<float>(static_cast<int64_t>(y_range));
  const float cx = static_cast<float>(descent.x), cy = static_cast<float>(descent.y);
  const Vec3 w = CylindricalToDirection(
      {std::min((cx + fx) * size, kOneMinusEpsilon), std::min((cy + fy) * size, kOneMinusEpsilon)});
  const float margin = std::min(std::min(fx, 1 - fx), std::min(fy, 1 - fy)) * size;
  const float density = descent.Density();
  if (margin > directional::kRoundTrip) [[likely]]
    return {w, density};
  if (Pdf(w) == density) return {w, density};
  const Vec3 inner = CylindricalToDirection({(cx + 0.25f + 0x1p-9f * static_cast<float>(low & 0xff)) * size,
                                             (cy + 0.25f + 0x1p-9f * static_cast<float>((low >> 8) & 0xff)) * size});
  return {inner, Pdf(inner)};
}

}  // namespace lodestar
