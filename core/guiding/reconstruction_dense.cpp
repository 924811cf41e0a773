#include <algorithm>
#include <numeric>

#include "core/base/check.h"
#include "core/guiding/reconstruction.h"
#include "core/math/elementary.h"

namespace lodestar::directional {
namespace {

constexpr int kRadius = 3;  // of the Gaussian: 7 x 7

// A square matrix of 2^depth rows; row y is the coordinate in phi, column x that in cos theta.
struct Matrix {
  explicit Matrix(int depth) : depth(depth), size(1 << depth), values(size_t{1} << (2 * depth)) {}
  float& At(int x, int y) { return values[(size_t{static_cast<uint32_t>(y)} << depth) + x]; }

  int depth, size;
  std::vector<float> values;
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

void Flatten(const CellMasses& masses, const Sums& sums, uint32_t node, int depth, int x, int y, Matrix& to) {
  const int size = to.size >> (depth + 1);  // of the node's cells
  for (uint32_t c = 0; c < 4; ++c) {
    const uint32_t slot = node * 4 + c, child = masses.nodes[node].child[c];
    const int cx = x + (c & 1 ? size : 0), cy = y + (c & 2 ? size : 0);
    if (child != 0 && size > 1) {
      Flatten(masses, sums, child, depth + 1, cx, cy, to);
      continue;
    }
    // A cell spreads over the elements it covers; a subtree below the layer counts as its sum times 4^-levels.
    const int spread = 2 * (to.depth - depth - 1) + 2 * sums.levels[slot];
    const float value = std::ldexp(sums.share[slot], -spread);
    for (int row = cy; row < cy + size; ++row) std::fill_n(&to.At(cx, row), size, value);
  }
}

std::array<float, 2 * kRadius + 1> Gaussian(float sigma) {
  std::array<float, 2 * kRadius + 1> kernel;
  for (int i = -kRadius; i <= kRadius; ++i)
    kernel[i + kRadius] = Exp(-0.5f * static_cast<float>(i * i) / (sigma * sigma));
  const float sum = std::accumulate(kernel.begin(), kernel.end(), 0.0f);
  for (float& k : kernel) k /= sum;
  return kernel;
}

// In place; zero outside.
void Blur(Matrix& m, const std::array<float, 2 * kRadius + 1>& kernel) {
  std::vector<float> padded(m.size + 2 * kRadius);
  for (int y = 0; y < m.size; ++y) {
    std::copy_n(&m.At(0, y), m.size, padded.begin() + kRadius);
    for (int x = 0; x < m.size; ++x) {
      float sum = 0;
      for (int i = 0; i <= 2 * kRadius; ++i) sum += kernel[i] * padded[x + i];
      m.At(x, y) = sum;
    }
  }
  for (int x = 0; x < m.size; ++x) {
    for (int y = 0; y < m.size; ++y) padded[y + kRadius] = m.At(x, y);
    for (int y = 0; y < m.size; ++y) {
      float sum = 0;
      for (int i = 0; i <= 2 * kRadius; ++i) sum += kernel[i] * padded[y + i];
      m.At(x, y) = sum;
    }
  }
}

// to = max(to, from expanded by two in both directions).
void MaximumWith(Matrix& from, Matrix& to) {
  for (int y = 0; y < to.size; ++y) {
    for (int x = 0; x < to.size; ++x) to.At(x, y) = std::max(to.At(x, y), 0.25f * from.At(x / 2, y / 2));
  }
}

// The quadtree over a matrix in which every element above the threshold has a node around it.
Tree RebuildFrom(Matrix finest, double flux_threshold, int max_depth) {
  std::vector<Matrix> levels = {std::move(finest)};  // sums, finest first
  while (levels.back().depth > 1) {
    Matrix& fine = levels.back();
    Matrix coarse(fine.depth - 1);
    for (int y = 0; y < coarse.size; ++y) {
      for (int x = 0; x < coarse.size; ++x) {
        coarse.At(x, y) = (fine.At(2 * x, 2 * y) + fine.At(2 * x + 1, 2 * y)) +
                          (fine.At(2 * x, 2 * y + 1) + fine.At(2 * x + 1, 2 * y + 1));
      }
    }
    levels.push_back(std::move(coarse));
  }
  std::reverse(levels.begin(), levels.end());  // [d]: depth d + 1
  double total = 0;
  for (float v : levels[0].values) total += v;

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

Tree ReconstructDense(const CellMasses& masses, const DenseReconstruction& options, double flux_threshold,
                      int max_depth) {
  LODESTAR_CHECK(options.sigma > 0);
  LODESTAR_CHECK(masses.total.size() == size_t{masses.node_count} * 4);
  const Sums sums = SumUp(masses);
  if (sums.depth < kMinDenseDepth || sums.depth > kMaxDenseDepth)
    return Rebuild(masses.nodes, masses.node_count, masses.total, flux_threshold, max_depth);
  const auto kernel = Gaussian(options.sigma);
  Matrix result(0);
  for (int depth = kMinDenseDepth; depth <= sums.depth; ++depth) {
    Matrix layer(depth);
    Flatten(masses, sums, 0, 0, 0, 0, layer);
    Blur(layer, kernel);
    if (depth > kMinDenseDepth) MaximumWith(result, layer);
    result = std::move(layer);
  }
  return RebuildFrom(std::move(result), flux_threshold, max_depth);
}

}  // namespace lodestar::directional
