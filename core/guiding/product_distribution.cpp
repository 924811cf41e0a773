#include "core/guiding/product_distribution.h"

#include <xsimd/xsimd.hpp>

namespace lodestar {
namespace {

using directional::kBits;
using directional::ToInteger;
using product::Block;
using product::kBlock;
using product::kBlockLevel;
using product::kPatch;
using product::kPatchLevels;
using product::kPatchSide;
using product::kSide;
using product::Patch;

// A cell with less of the narrow lobes than this is left to the flux.
constexpr float kLeastNarrow = 0.1f;

using Four = xsimd::make_sized_batch_t<float, kPatchSide>;
static_assert(kPatchSide == 4);

// The tree's probabilities of the cells two levels below a node, 0 for none, by rows.
std::array<Four, kPatchSide> GatherFlux(const DirectionalNode* nodes, uint32_t node) {
  const DirectionalNode& parent = node == 0 ? kUniformNode : nodes[node];
  alignas(16) std::array<int32_t, 4> left, lower0, lower1;
  for (int c = 0; c < 4; ++c) {
    const DirectionalNode& child = parent.child[c] == 0 ? kUniformNode : nodes[parent.child[c]];
    left[c] = child.left, lower0[c] = child.lower[0], lower1[c] = child.lower[1];
  }
  const auto portion = [](const std::array<int32_t, 4>& p) {
    return xsimd::batch_cast<float>(xsimd::batch<int32_t, Four::arch_type>::load_aligned(p.data())) * 0x1p-15f;
  };
  const QuarterShares quarters(parent);
  const Four all{quarters.p[0], quarters.p[1], quarters.p[2], quarters.p[3]};
  const Four in_left = all * portion(left), in_right = all - in_left;
  const Four p0 = in_left * portion(lower0), p1 = in_right * portion(lower1), p2 = in_left - p0, p3 = in_right - p1;
  // A row of the patch runs through two children, and in each through both halves.
  return {xsimd::zip_lo(p0, p1), xsimd::zip_lo(p2, p3), xsimd::zip_hi(p0, p1), xsimd::zip_hi(p2, p3)};
}

// Chooses among running sums by u, which is then uniform again.
template <size_t kCount>
uint32_t Choose(const std::array<float, kCount>& sums, double& u) {
  const double target = u * static_cast<double>(sums[kCount - 1]);
  uint32_t i = 0;
  double before = 0;
  // No branches: the outcome is random by design.
  for (size_t k = 0; k + 1 < kCount; ++k) {
    const double sum = static_cast<double>(sums[k]);
    i += target >= sum;
    before = std::max(before, target >= sum ? sum : 0.0);
  }
  u = std::min((target - before) / (static_cast<double>(sums[i]) - before), 1 - 0x1p-48);
  return i;
}

}  // namespace

ProductDistribution::ProductDistribution(const DirectionalNode* nodes, const TreeTop& top, const ProductLobes& lobes)
    : nodes_(nodes), top_(&top), lobes_(lobes) {
  directional::Prefetch(nodes);
  if (lobes.none()) return;
  product_.fill(0);
  if (lobes.diffuse() > 0) product::AddCosine(lobes.normal(), lobes.diffuse(), product_);
  if (lobes.transmission() > 0) product::AddCosine(-lobes.normal(), lobes.transmission(), product_);
  for (int i = 0; i < lobes.glossy_count(); ++i)
    product::AddGlossy(lobes.glossy(i), lobes.normal(), lobes.glossy_weight(i), product_);
  std::array<float, kSide> columns{};
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) columns[i] += product_[j * kSide + i] *= top.flux[j * kSide + i];
  }
  const float total =
      ((columns[0] + columns[1]) + (columns[2] + columns[3])) + ((columns[4] + columns[5]) + (columns[6] + columns[7]));
  mass_ = total * kBlock * kUniformSpherePdf;
  usable_ = mass_ > 1e-12f;
  if (!usable_) return;
  scale_ = (1 - kBlockDefence) / total;
  float sum = 0;
  for (int i = 0; i < kSide; ++i) columns_[i] = sum += columns[i] * scale_ + top.columns[i] * kBlockDefence;
  density_ = kBlock * kUniformSpherePdf / sum;
}

int ProductDistribution::finest_level() const {
  constexpr int kPatchLevel = kBlockLevel + kPatchLevels;
  for (int i = 0; i < lobes_.glossy_count(); ++i) {
    if (product::IsNarrow(lobes_.glossy(i), kPatchLevel)) return product::kFinest;
  }
  return kPatchLevel;
}

// The cells two levels below (x, y) of `level`, whose subtree is `node` (0: none).
struct ProductDistribution::Step {
  Step(const ProductDistribution& of, int level, uint32_t x, uint32_t y, uint32_t node) : nodes(of.nodes_), node(node) {
    const std::array<Four, kPatchSide> flux = GatherFlux(nodes, node);
    lobes = product::Densities(of.lobes_, level, x, y);
    std::array<Four, kPatchSide> products;
    for (int j = 0; j < kPatchSide; ++j) products[j] = flux[j] * Four::load_aligned(&lobes.all[j * kPatchSide]);
    const float sum = xsimd::hadd((products[0] + products[1]) + (products[2] + products[3]));
    const float scale = sum > 0 ? (1 - kPatchDefence) / sum : 0, rest = sum > 0 ? kPatchDefence : 1.0f;
    Four in_columns = 0.0f;
    for (int j = 0; j < kPatchSide; ++j) {
      const Four row = xsimd::fma(products[j], Four(scale), flux[j] * rest);
      in_columns += row;
      row.store_aligned(&shares[j * kPatchSide]);
    }
    in_columns.store_aligned(columns.data());
    for (int i = 1; i < kPatchSide; ++i) columns[i] += columns[i - 1];
    scale_to_density = kPatch / columns[kPatchSide - 1];
  }
  // The density in cell i, relative to the mean of all.
  float Density(uint32_t i) const { return shares[i] * scale_to_density; }
  // The subtree of cell i.
  uint32_t Node(uint32_t i) const {
    const uint32_t x = i % kPatchSide, y = i / kPatchSide;
    const uint32_t child = node == 0 ? 0 : nodes[node].child[(x >> 1) + 2 * (y >> 1)];
    return child == 0 ? 0 : nodes[child].child[(x & 1) + 2 * (y & 1)];
  }
  // Whether the lobes matter below cell i, too.
  bool GoesOn(uint32_t i) const { return lobes.has_narrow && lobes.narrow[i] > kLeastNarrow * lobes.all[i]; }

  const DirectionalNode* nodes;
  uint32_t node;
  product::PatchDensities lobes;
  Patch shares;
  alignas(16) std::array<float, kPatchSide> columns;  // running sums
  float scale_to_density;
};

float ProductDistribution::Locate(uint32_t x, uint32_t y) const {
  const auto bits = [&](uint32_t v, int level, int count) {
    return (v >> (kBits - level - count)) & ((1u << count) - 1);
  };
  const uint32_t cell = bits(y, 0, kBlockLevel) * kSide + bits(x, 0, kBlockLevel);
  float density = density_ * Share(cell);
  uint32_t node = top_->node[cell];
  int level = kBlockLevel;
  for (bool more = true; more; level += kPatchLevels) {
    const Step step(*this, level, x >> (kBits - level), y >> (kBits - level), node);
    const uint32_t i = bits(y, level, kPatchLevels) * kPatchSide + bits(x, level, kPatchLevels);
    density *= step.Density(i);
    node = step.Node(i);
    more = level + 2 * kPatchLevels <= product::kFinest && step.GoesOn(i);
  }
  for (; node != 0; ++level) {
    const uint32_t c = bits(x, level, 1) + 2 * bits(y, level, 1);
    density *= static_cast<float>(static_cast<int32_t>(nodes_[node].Share(c))) * 0x1p-28f;
    node = nodes_[node].child[c];
  }
  return density;
}

float ProductDistribution::Pdf(Vec3 w) const {
  const Vec2 square = DirectionToCylindrical(w);
  return Locate(ToInteger(square.x), ToInteger(square.y));
}

GuidedSample ProductDistribution::Sample(Vec2 u) const {
  // A hash fills the bits that a deep descent would otherwise find empty (directional_tree.h).
  const uint64_t low = ((uint64_t{ToInteger(u.x)} << 32) | ToInteger(u.y)) * 0x9e3779b97f4a7c15ULL;
  const auto fill = [](float u, uint64_t bits) {
    return (static_cast<double>(ToInteger(u)) + static_cast<double>(bits & 0xffffff) * 0x1p-24) * 0x1p-24;
  };
  double ux = fill(u.x, low >> 40), uy = fill(u.y, low >> 16);

  // A column of the block by u.x, a cell of it by u.y.
  uint32_t x = Choose(columns_, ux);
  std::array<float, kSide> rows;
  float sum = 0;
  for (uint32_t j = 0; j < kSide; ++j) rows[j] = sum += Share(j * kSide + x);
  uint32_t y = Choose(rows, uy);
  float density = density_ * Share(y * kSide + x);
  uint32_t node = top_->node[y * kSide + x];
  int level = kBlockLevel;

  // The same in what is below it.
  for (bool more = true; more; level += kPatchLevels) {
    const Step step(*this, level, x, y, node);
    const uint32_t column = Choose(step.columns, ux);
    std::array<float, kPatchSide> in_column;
    float running = 0;
    for (uint32_t j = 0; j < kPatchSide; ++j) in_column[j] = running += step.shares[j * kPatchSide + column];
    const uint32_t row = Choose(in_column, uy), i = row * kPatchSide + column;
    density *= step.Density(i);
    node = step.Node(i);
    more = level + 2 * kPatchLevels <= product::kFinest && step.GoesOn(i);
    x = kPatchSide * x + column;
    y = kPatchSide * y + row;
  }

  // By the flux alone, as directional::Sample does.
  uint64_t ix = static_cast<uint64_t>(ux * 0x1p48), iy = static_cast<uint64_t>(uy * 0x1p48);
  uint64_t x_range = uint64_t{1} << 48, y_range = uint64_t{1} << 48;
  const auto below = [](uint64_t& value, uint64_t& range, uint32_t portion) {
    const uint64_t split = (range * portion) >> 15, upper = value >= split, mask = -upper;
    value -= split & mask;
    range = split + ((range - 2 * split) & mask);
    return static_cast<uint32_t>(upper);
  };
  for (; node != 0; ++level) {
    const DirectionalNode& n = nodes_[node];
    const uint32_t bx = below(ix, x_range, n.left), by = below(iy, y_range, n.lower[bx]), c = bx + 2 * by;
    density *= static_cast<float>(static_cast<int32_t>(n.Share(c))) * 0x1p-28f;
    node = n.child[c];
    x = 2 * x + bx;
    y = 2 * y + by;
  }

  // A point of the cell, safely inside where a direction and back would leave it (as SdTree::Sample).
  const float size = std::bit_cast<float>(static_cast<uint32_t>(127 - level) << 23);
  const float fx = static_cast<float>(static_cast<int64_t>(ix)) / static_cast<float>(static_cast<int64_t>(x_range));
  const float fy = static_cast<float>(static_cast<int64_t>(iy)) / static_cast<float>(static_cast<int64_t>(y_range));
  const float cx = static_cast<float>(x), cy = static_cast<float>(y);
  const Vec3 w = CylindricalToDirection(
      {std::min((cx + fx) * size, kOneMinusEpsilon), std::min((cy + fy) * size, kOneMinusEpsilon)});
  const float margin = std::min(std::min(fx, 1 - fx), std::min(fy, 1 - fy)) * size;
  if (margin > directional::kRoundTrip) [[likely]]
    return {w, density};
  if (Pdf(w) == density) return {w, density};
  const Vec3 inner = CylindricalToDirection({(cx + 0.25f + 0x1p-9f * static_cast<float>(low & 0xff)) * size,
                                             (cy + 0.25f + 0x1p-9f * static_cast<float>((low >> 8) & 0xff)) * size});
  return {inner, Pdf(inner)};
}

}  // namespace lodestar
