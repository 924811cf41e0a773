#include <algorithm>
#include <memory>

#include "core/base/check.h"
#include "core/guiding/reconstruction.h"
#include "core/guiding/reconstruction_blur.h"

namespace lodestar::directional {
namespace {

// A square matrix of 2^depth rows; row y is the coordinate in phi, column x that in cos theta.
struct Matrix {
  explicit Matrix(int depth)
      : depth(depth), values(std::make_unique_for_overwrite<float[]>(size_t{1} << (2 * depth))) {}
  int size() const { return 1 << depth; }
  float* Row(int y) { return values.get() + (static_cast<size_t>(y) << depth); }
  float At(int x, int y) const { return values[(static_cast<size_t>(y) << depth) + x]; }

  int depth;
  std::unique_ptr<float[]> values;
};

// Per slot: the mass in and below it as a share of the total, and how many levels lie below (0: a cell).
struct Sums {
  std::vector<float> share;
  std::vector<uint8_t> levels;
  int depth = 0;  // of the tree
};

Sums SumUp(const CellMasses& masses) {
  std::vector<double> sum = masses.total;
  Sums out;
  out.levels.resize(sum.size());
  for (uint32_t node = masses.node_count; node-- > 0;) {
    for (uint32_t slot = node * 4; slot < node * 4 + 4; ++slot) {
      const uint32_t child = masses.nodes[node].child[slot & 3];
      if (child == 0) continue;
      sum[slot] += sum[child * 4] + sum[child * 4 + 1] + sum[child * 4 + 2] + sum[child * 4 + 3];
      out.levels[slot] = 1 + *std::max_element(&out.levels[child * 4], &out.levels[child * 4] + 4);
    }
  }
  const double total = sum[0] + sum[1] + sum[2] + sum[3];
  for (double s : sum) out.share.push_back(static_cast<float>(s / total));
  out.depth = 1 + *std::max_element(out.levels.begin(), out.levels.begin() + 4);
  return out;
}

class Layer {
 public:
  Layer(const CellMasses& masses, const Sums& sums, int depth)
      : masses_(masses), sums_(sums), depth_(depth), matrix_(depth), tiles_((1 << depth) / kBlurTile) {
    same_.resize(static_cast<size_t>(tiles_) * tiles_, 0);
    Flatten(0, 0, 0, 0);
  }
  Matrix Blurred(const std::array<float, kBlurRadius + 1>& kernel) const {
    Matrix blurred(depth_);
    Blur(matrix_, same_, kernel, blurred.values.get());
    return blurred;
  }

 private:
  void Flatten(uint32_t node, int depth, int x, int y) {
    const int size = matrix_.size() >> (depth + 1);  // of the node's cells
    for (uint32_t c = 0; c < 4; ++c) {
      const uint32_t slot = node * 4 + c, child = masses_.nodes[node].child[c];
      const int cx = x + (c & 1 ? size : 0), cy = y + (c & 2 ? size : 0);
      if (child != 0 && size > 1) {
        Flatten(child, depth + 1, cx, cy);
        continue;
      }
      // A cell spreads over the elements it covers; a subtree below the layer counts as its sum times 4^-levels.
      const int spread = 2 * (depth_ - depth - 1) + 2 * sums_.levels[slot];
      const float value = std::ldexp(sums_.share[slot], -spread);
      for (int row = cy; row < cy + size; ++row) std::fill_n(matrix_.Row(row) + cx, size, value);
      MarkSame(cx, cy, size);
    }
  }
  // The tiles that lie in the cell with all that the Gaussian reaches from them.
  void MarkSame(int x, int y, int size) {
    const auto first = [](int from) { return (from + kBlurRadius + kBlurTile - 1) / kBlurTile; };
    const auto last = [size](int from) { return (from + size - kBlurRadius) / kBlurTile; };
    for (int ty = first(y); ty < last(y); ++ty) {
      for (int tx = first(x); tx < last(x); ++tx) same_[static_cast<size_t>(ty) * tiles_ + tx] = 1;
    }
  }

  const CellMasses& masses_;
  const Sums& sums_;
  int depth_;
  FramedMatrix matrix_;
  int tiles_;
  SameTiles same_;
};

// to = max(to, from expanded by two in both directions).
void MaximumWith(Matrix& from, Matrix& to) {
  std::vector<float> expanded(to.size());
  for (int y = 0; y < to.size(); ++y) {
    const float* const row = from.Row(y / 2);
    if (y % 2 == 0) {
      for (int x = 0; x < from.size(); ++x) expanded[2 * x] = expanded[2 * x + 1] = 0.25f * row[x];
    }
    float* const out = to.Row(y);
    for (int x = 0; x < to.size(); ++x) out[x] = out[x] > expanded[x] ? out[x] : expanded[x];
  }
}

Matrix Halved(Matrix& fine) {
  Matrix coarse(fine.depth - 1);
  for (int y = 0; y < coarse.size(); ++y) {
    const float *const upper = fine.Row(2 * y), *const lower = fine.Row(2 * y + 1);
    float* const to = coarse.Row(y);
    for (int x = 0; x < coarse.size(); ++x)
      to[x] = (upper[2 * x] + upper[2 * x + 1]) + (lower[2 * x] + lower[2 * x + 1]);
  }
  return coarse;
}

// The quadtree over a matrix in which every element above the threshold has a node around it.
Tree RebuildFrom(Matrix finest, double flux_threshold, int max_depth) {
  std::vector<Matrix> levels;  // sums, finest first
  levels.push_back(std::move(finest));
  while (levels.back().depth > 1) levels.push_back(Halved(levels.back()));
  std::reverse(levels.begin(), levels.end());  // [d]: depth d + 1
  double total = 0;
  for (int i = 0; i < 4; ++i) total += levels[0].values[i];

  struct Place {
    int x, y, depth;
  };
  std::vector<DirectionalNode> nodes(1);
  std::vector<Place> places = {{0, 0, 0}};
  std::vector<double> masses;
  for (size_t node = 0; node < nodes.size(); ++node) {
    const Place p = places[node];
    for (uint32_t c = 0; c < 4; ++c) {
      const int x = 2 * p.x + static_cast<int>(c & 1), y = 2 * p.y + static_cast<int>(c >> 1);
      const double mass = levels[p.depth].At(x, y);
      const bool split =
          mass > flux_threshold * total && p.depth + 1 < static_cast<int>(levels.size()) && nodes.size() < kMaxNodes;
      masses.push_back(split ? 0 : mass);
      if (!split) continue;
      nodes[node].child[c] = static_cast<uint16_t>(nodes.size());
      nodes.emplace_back();
      places.push_back({x, y, p.depth + 1});
    }
  }
  return Rebuild(nodes.data(), static_cast<uint32_t>(nodes.size()), std::move(masses), flux_threshold, max_depth);
}

}  // namespace

Tree ReconstructDense(const CellMasses& masses, float sigma, double flux_threshold, int max_depth) {
  LODESTAR_CHECK(sigma > 0);
  LODESTAR_CHECK(masses.total.size() == size_t{masses.node_count} * 4);
  const Sums sums = SumUp(masses);
  if (sums.depth < kMinDenseDepth || sums.depth > kMaxDenseDepth)
    return Rebuild(masses.nodes, masses.node_count, masses.total, flux_threshold, max_depth);
  const auto kernel = Gaussian(sigma);
  Matrix result(0);
  for (int depth = kMinDenseDepth; depth <= sums.depth; ++depth) {
    Matrix layer = Layer(masses, sums, depth).Blurred(kernel);
    if (depth > kMinDenseDepth) MaximumWith(result, layer);
    result = std::move(layer);
  }
  return RebuildFrom(std::move(result), flux_threshold, max_depth);
}

}  // namespace lodestar::directional
