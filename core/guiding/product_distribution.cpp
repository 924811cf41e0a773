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

// The tree's probabilities of the block's cells. A tree that ends earlier is uniform below.
void GatherFlux(const DirectionalNode* nodes, Block& flux) {
  const auto spread = [&](uint32_t x, uint32_t y, uint32_t size, float share) {
    for (uint32_t j = y; j < y + size; ++j) {
      for (uint32_t i = x; i < x + size; ++i) flux[j * kSide + i] = share;
    }
  };
  for (uint32_t a = 0; a < 4; ++a) {
    const uint32_t ax = (a & 1) * 4, ay = (a >> 1) * 4;
    const float in_a = nodes[0].Probability(a);
    const DirectionalNode* const node_a = nodes + nodes[0].child[a];
    if (node_a == nodes) {
      spread(ax, ay, 4, in_a * 0x1p-4f);
      continue;
    }
    for (uint32_t b = 0; b < 4; ++b) {
      const uint32_t bx = ax + (b & 1) * 2, by = ay + (b >> 1) * 2;
      const float in_b = in_a * node_a->Probability(b);
      const DirectionalNode* const node_b = nodes + node_a->child[b];
      if (node_b == nodes) {
        spread(bx, by, 2, in_b * 0x1p-2f);
        continue;
      }
      for (uint32_t c = 0; c < 4; ++c) flux[(by + (c >> 1)) * kSide + bx + (c & 1)] = in_b * node_b->Probability(c);
    }
  }
}

// a / (a + b) in units of 1 / kOne.
uint16_t Portion(float a, float b) {
  return static_cast<uint16_t>(a / (a + b) * static_cast<float>(DirectionalNode::kOne) + 0.5f);
}

// A node whose children are weighted by d. Where all products vanish, the node itself.
DirectionalNode Weighted(const DirectionalNode& node, const std::array<float, 4>& d) {
  std::array<float, 4> p;
  for (uint32_t c = 0; c < 4; ++c) p[c] = node.Probability(c) * d[c];
  const float left = p[0] + p[2], right = p[1] + p[3];
  if (!(left + right > 0)) return node;
  DirectionalNode weighted;
  weighted.left = Portion(left, right);
  if (left > 0) weighted.lower[0] = Portion(p[0], p[2]);
  if (right > 0) weighted.lower[1] = Portion(p[1], p[3]);
  return weighted;
}

float Share(const DirectionalNode& node, uint32_t c) {
  return static_cast<float>(static_cast<int32_t>(node.Share(c))) * 0x1p-28f;
}

// The first level whose cells the lobe does not vary much in.
int LevelOf(const Ltc& ltc) {
  constexpr float kCellPerWidth = 1.0f;
  int level = kBlockLevel;
  for (float size = 3.545f / kSide; level < product::kFinest && size > kCellPerWidth * ltc.Width(); size *= 0.5f)
    ++level;
  return level;
}

}  // namespace

ProductDistribution::ProductDistribution(const DirectionalNode* nodes, const ProductLobes& lobes)
    : nodes_(nodes), lobes_(lobes) {
  directional::Prefetch(nodes);
  if (lobes.none()) return;
  broad_.fill(0);
  narrow_.fill(0);
  if (lobes.diffuse() > 0) product::AddCosine(lobes.normal(), lobes.diffuse(), broad_);
  if (lobes.transmission() > 0) product::AddCosine(-lobes.normal(), lobes.transmission(), broad_);
  for (int i = 0; i < lobes.glossy_count(); ++i) {
    const int level = LevelOf(lobes.glossy(i));
    deep_level_ = std::max(deep_level_, level);
    product::AddGlossy(lobes.glossy(i), lobes.normal(), lobes.glossy_weight(i), level > kBlockLevel ? narrow_ : broad_);
  }
  Block flux;
  GatherFlux(nodes, flux);
  float sum = 0;
  for (int i = 0; i < kBlock; ++i) {
    share_[i] = (broad_[i] + narrow_[i]) * flux[i];
    sum += share_[i];
  }
  mass_ = sum * kBlock * kUniformSpherePdf;
  usable_ = sum > 1e-12f;
  if (!usable_) return;
  const float scale = (1 - kBlockDefence) / sum;
  for (int i = 0; i < kBlock; ++i) share_[i] = share_[i] * scale + kBlockDefence * flux[i];
  columns_.fill(0);
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) columns_[i] += share_[j * kSide + i];
  }
  for (int i = 1; i < kSide; ++i) columns_[i] += columns_[i - 1];
  density_ = kBlock * kUniformSpherePdf / columns_[kSide - 1];
}

// The walk below the block, in step with the tree's nodes while they last.
struct ProductDistribution::Descent {
  Descent(const ProductDistribution& of, uint32_t x, uint32_t y) : of(of), x(x), y(y) {
    const uint32_t cell = y * kSide + x;
    for (int shift = kBlockLevel - 1; shift >= 0; --shift) {
      node = of.nodes_[node].child[((x >> shift) & 1) + 2 * ((y >> shift) & 1)];
      if (node == 0) break;
    }
    broad = of.broad_[cell];
    density = of.density_ * of.share_[cell];
    deep = of.deep_level_ > kBlockLevel && of.narrow_[cell] > kLeastNarrow * broad;
  }
  // A cell with less of the narrow lobes than this, relative to the others, is left to the flux.
  static constexpr float kLeastNarrow = 0.1f;

  bool Ends() const { return node == 0 && !Deep(); }
  bool Deep() const { return deep && level < of.deep_level_; }
  const DirectionalNode& Node() const { return node == 0 ? kUniform : of.nodes_[node]; }
  // The node's probabilities times the lobes'.
  DirectionalNode Product() {
    broad *= 0.25f;
    std::array<float, 4> d;
    d.fill(broad);
    const ProductLobes& lobes = of.lobes_;
    for (int i = 0; i < lobes.glossy_count(); ++i) {
      if (LevelOf(lobes.glossy(i)) > level)
        product::AddChildren(lobes.glossy(i), lobes.glossy_weight(i), level, x, y, d);
    }
    return Weighted(Node(), d);
  }
  // `by_tree` and `by_product`: the child's probabilities; the latter counts where the product still decides.
  void Enter(uint32_t c, float by_tree, float by_product) {
    if (Deep()) {
      tree *= by_tree;
      lobe *= by_product;
    } else {
      density *= by_tree;
    }
    node = Node().child[c];
    x = 2 * x + (c & 1);
    y = 2 * y + (c >> 1);
    ++level;
  }
  float Density() const { return deep ? density * ((1 - kDeepDefence) * lobe + kDeepDefence * tree) : density; }

  const ProductDistribution& of;
  uint32_t x, y, node = 0;
  int level = kBlockLevel;
  float density, broad, tree = 1, lobe = 1;
  bool deep;
};

float ProductDistribution::Locate(uint32_t x, uint32_t y) const {
  constexpr int kTop = kBits - kBlockLevel;
  Descent descent(*this, x >> kTop, y >> kTop);
  for (int shift = kTop - 1; !descent.Ends(); --shift) {
    const uint32_t c = ((x >> shift) & 1) | (((y >> shift) & 1) << 1);
    const float by_tree = Share(descent.Node(), c);
    descent.Enter(c, by_tree, descent.Deep() ? Share(descent.Product(), c) : by_tree);
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
    while (i < kSide - 1 && !(target < sums[i])) ++i;
    const float before = i > 0 ? sums[i - 1] : 0, share = sums[i] - before;
    u = share > 0 ? std::clamp((target - before) / share, 0.0f, kOneMinusEpsilon) : 0;
    return i;
  };
  const uint64_t low = ((uint64_t{ToInteger(u.x)} << 32) | ToInteger(u.y)) * 0x9e3779b97f4a7c15ULL;
  const uint32_t column = choose(columns_, u.x);
  std::array<float, kSide> rows;
  float sum = 0;
  for (uint32_t j = 0; j < kSide; ++j) rows[j] = sum += share_[j * kSide + column];
  const uint32_t row = choose(rows, u.y);

  // Step 2: down from there, as directional::Sample does.
  Descent descent(*this, column, row);
  bool by_lobes = false;
  if (descent.deep) {
    by_lobes = u.x >= kDeepDefence;
    u.x = by_lobes ? std::min((u.x - kDeepDefence) * (1 / (1 - kDeepDefence)), kOneMinusEpsilon)
                   : u.x * (1 / kDeepDefence);
  }
  uint64_t x = (uint64_t{ToInteger(u.x)} << 24) | (low >> 40),
           y = (uint64_t{ToInteger(u.y)} << 24) | ((low >> 16) & 0xffffff);
  uint64_t x_range = uint64_t{1} << 48, y_range = uint64_t{1} << 48;
  while (!descent.Ends()) {
    const DirectionalNode& tree = descent.Node();
    const DirectionalNode lobes = descent.Deep() ? descent.Product() : tree;
    const DirectionalNode& n = by_lobes ? lobes : tree;
    const uint64_t x_split = (x_range * n.left) >> 15;
    const uint64_t bx = x >= x_split, x_mask = -bx;
    const uint64_t y_split = (y_range * n.lower[bx]) >> 15;
    const uint64_t by = y >= y_split, y_mask = -by;
    x -= x_split & x_mask;
    x_range = x_split + ((x_range - 2 * x_split) & x_mask);
    y -= y_split & y_mask;
    y_range = y_split + ((y_range - 2 * y_split) & y_mask);
    const uint32_t c = static_cast<uint32_t>(bx + 2 * by);
    descent.Enter(c, Share(tree, c), Share(lobes, c));
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
