// The spherical half of statistical.h: adaptive bins, adaptive quadrature.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "tests/support/statistical.h"

namespace lodestar::test {
namespace {

constexpr double kPiD = std::numbers::pi;

// Gauss-Legendre, four points on [-1, 1].
constexpr std::array<double, 4> kNodes = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563,
                                          0.8611363115940526};
constexpr std::array<double, 4> kWeights = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461,
                                            0.3478548451374538};

struct Rectangle {
  double x0, x1, y0, y1;
};

using Integrand = std::function<double(double, double)>;

double Quadrature(const Integrand& f, const Rectangle& r) {
  const double hx = (r.x1 - r.x0) / 2, hy = (r.y1 - r.y0) / 2, cx = (r.x0 + r.x1) / 2, cy = (r.y0 + r.y1) / 2;
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) sum += kWeights[i] * kWeights[j] * f(cx + hx * kNodes[i], cy + hy * kNodes[j]);
  }
  return sum * hx * hy;
}

// `forced` levels are refined whatever the estimates say: a narrow peak can hide between the points of the first few.
double Refine(const Integrand& f, const Rectangle& r, double whole, double tolerance, int depth, int forced) {
  const double cx = (r.x0 + r.x1) / 2, cy = (r.y0 + r.y1) / 2;
  const std::array<Rectangle, 4> parts = {
      Rectangle{r.x0, cx, r.y0, cy}, {cx, r.x1, r.y0, cy}, {r.x0, cx, cy, r.y1}, {cx, r.x1, cy, r.y1}};
  std::array<double, 4> values;
  double sum = 0;
  for (int i = 0; i < 4; ++i) sum += values[i] = Quadrature(f, parts[i]);
  if (depth <= 0 || (forced <= 0 && std::fabs(sum - whole) <= tolerance)) return sum;
  double refined = 0;
  // Halving, not quartering: errors of neighbours partly cancel, and discontinuities occupy ever fewer cells.
  for (int i = 0; i < 4; ++i) refined += Refine(f, parts[i], values[i], tolerance / 2, depth - 1, forced - 1);
  return refined;
}

// z from x and y: near the poles the float z has lost what x and y still know.
struct ZPhi {
  double z, phi;
};
ZPhi ToZPhi(Vec3 w) {
  const double x = w.x, y = w.y;
  const double s2 = x * x + y * y;
  const double z =
      s2 < 0.5 ? std::copysign(std::sqrt(std::max(1 - s2, 0.0)), w.z) : w.z / std::sqrt(s2 + double{w.z} * w.z);
  return {z, std::atan2(y, x)};
}
Vec3 FromZPhi(double z, double phi) {
  const double s = std::sqrt(std::max((1 - z) * (1 + z), 0.0));
  return {static_cast<float>(s * std::cos(phi)), static_cast<float>(s * std::sin(phi)), static_cast<float>(z)};
}

struct Cell {
  Rectangle area;
  size_t bin;
  size_t pilot_points;
};

// A kd-tree over (z, phi). Its upper levels are the bins; below them it goes on to cells of a few pilot points each,
// for the quadrature, which would miss a lobe much narrower than a bin. Nodes are split at the medians of the pilot
// sample, in turn along the axis in which the cell is wider in the pilot's own spread.
class AdaptiveBins {
 public:
  static constexpr size_t kPointsPerCell = 32;

  AdaptiveBins(std::vector<ZPhi> pilot, int bins) {
    // The equator first: most densities are discontinuous there.
    auto middle = std::partition(pilot.begin(), pilot.end(), [](const ZPhi& p) { return p.z < 0; });
    std::vector<ZPhi> lower(pilot.begin(), middle), upper(middle, pilot.end());
    nodes_.push_back({.split = 0, .axis = 0});
    nodes_[0].left = Build(lower, {-1, 0, -kPiD, kPiD},
                           std::max(1, bins * static_cast<int>(lower.size()) / std::max<int>(1, pilot.size())));
    nodes_[0].right = Build(upper, {0, 1, -kPiD, kPiD},
                            std::max(1, bins * static_cast<int>(upper.size()) / std::max<int>(1, pilot.size())));
  }
  const std::vector<Cell>& cells() const { return cells_; }
  size_t count() const { return bins_; }
  size_t Find(const ZPhi& p) const {
    int node = 0;
    while (nodes_[node].axis >= 0)
      node = (nodes_[node].axis == 0 ? p.z : p.phi) < nodes_[node].split ? nodes_[node].left : nodes_[node].right;
    return nodes_[node].bin;
  }

 private:
  struct Node {
    double split = 0;
    int axis = -1, left = 0, right = 0;
    size_t bin = 0;
  };
  int Build(std::vector<ZPhi>& points, Rectangle r, int bins, std::optional<size_t> bin = std::nullopt) {
    const int index = static_cast<int>(nodes_.size());
    nodes_.emplace_back();
    if (!bin && (bins < 2 || points.size() < kPointsPerCell)) bin = bins_++;
    if (bin && points.size() >= kPointsPerCell / 4) {
      // Cut off empty space: what is left follows the lobe closely.
      for (int axis = 0; axis < 2; ++axis) {
        const auto [low, high] = std::minmax_element(points.begin(), points.end(), [&](const ZPhi& a, const ZPhi& b) {
          return axis == 0 ? a.z < b.z : a.phi < b.phi;
        });
        const double from = axis == 0 ? low->z : low->phi, to = axis == 0 ? high->z : high->phi,
                     margin = 0.5 * (to - from) + 1e-7;
        const double lo = axis == 0 ? r.x0 : r.y0, hi = axis == 0 ? r.x1 : r.y1;
        const bool below = from - lo > hi - to;
        const double split = below ? from - margin : to + margin;
        if ((below ? split - lo : hi - split) < 0.3 * (hi - lo)) continue;
        Rectangle a = r, b = r;
        (axis == 0 ? a.x1 : a.y1) = split;
        (axis == 0 ? b.x0 : b.y0) = split;
        std::vector<ZPhi> none;
        const int l = Build(below ? none : points, a, 1, bin), rr = Build(below ? points : none, b, 1, bin);
        nodes_[index] = {.split = split, .axis = axis, .left = l, .right = rr};
        return index;
      }
    }
    if (points.size() < kPointsPerCell) {
      nodes_[index].bin = *bin;
      cells_.push_back({r, *bin, points.size()});
      return index;
    }
    // The axis along which the middle half of the points fills less of the cell: quantiles, since lobes have heavy
    // tails.
    double fill[2];
    for (int a = 0; a < 2; ++a) {
      std::vector<double> v;
      for (const ZPhi& p : points) v.push_back(a == 0 ? p.z : p.phi);
      const auto quarter = static_cast<std::ptrdiff_t>(v.size() / 4);
      std::nth_element(v.begin(), v.begin() + quarter, v.end());
      const double low = v[quarter];
      std::nth_element(v.begin(), v.begin() + 3 * quarter, v.end());
      fill[a] = (v[3 * quarter] - low) / (a == 0 ? r.x1 - r.x0 : r.y1 - r.y0);
    }
    const int axis = fill[0] < fill[1] ? 0 : 1;
    auto key = [axis](const ZPhi& p) { return axis == 0 ? p.z : p.phi; };
    auto middle = points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2);
    std::nth_element(points.begin(), middle, points.end(),
                     [&](const ZPhi& a, const ZPhi& b) { return key(a) < key(b); });
    double split = key(*middle);
    const double lo = axis == 0 ? r.x0 : r.y0, hi = axis == 0 ? r.x1 : r.y1;
    if (!(split > lo && split < hi)) split = (lo + hi) / 2;
    std::vector<ZPhi> left, right;
    for (const ZPhi& p : points) (key(p) < split ? left : right).push_back(p);
    Rectangle a = r, b = r;
    (axis == 0 ? a.x1 : a.y1) = split;
    (axis == 0 ? b.x0 : b.y0) = split;
    const int l = Build(left, a, bins / 2, bin);
    const int rr = Build(right, b, bins / 2, bin);
    nodes_[index] = {.split = split, .axis = axis, .left = l, .right = rr};
    return index;
  }
  std::vector<Node> nodes_;
  std::vector<Cell> cells_;
  size_t bins_ = 0;
};

}  // namespace

double IntegrateRectangle(const Integrand& f, double x0, double x1, double y0, double y1, double tolerance,
                          int max_depth, int forced_depth) {
  const Rectangle r{x0, x1, y0, y1};
  return Refine(f, r, Quadrature(f, r), tolerance, max_depth, forced_depth);
}

TestResult ChiSquareOnSphere(const SphereSampler& sampler, const SphereDensity& density,
                             const SphereTestOptions& options) {
  Random random(options.seed);
  std::vector<ZPhi> pilot;
  for (int64_t i = 0; i < options.pilot_samples; ++i) {
    if (const auto w = sampler(random)) pilot.push_back(ToZPhi(*w));
  }
  if (pilot.empty()) return {.message = "the sampler produced nothing"};
  const AdaptiveBins bins(std::move(pilot), options.bins);

  // The last bin takes what the sampler did not turn into a direction.
  const size_t count = bins.count();
  std::vector<double> observed(count + 1, 0.0), expected(count + 1, 0.0);
  for (int64_t i = 0; i < options.samples; ++i) {
    const auto w = sampler(random);
    observed[w ? bins.Find(ToZPhi(*w)) : count] += 1;
  }
  double integral = 0;
  const double tolerance = 5e-4 / static_cast<double>(bins.cells().size());
  for (const Cell& cell : bins.cells()) {
    const Rectangle& r = cell.area;
    // Where the quadrature and the pilot sample disagree, try harder before believing it: a ridge between the first
    // points looks like nothing at all. The pilot decides only on the effort; the value is the density's.
    const double n = static_cast<double>(cell.pilot_points), pilot = static_cast<double>(options.pilot_samples);
    double mass = 0;
    for (int forced = 1; forced <= 5; ++forced) {
      mass = IntegrateRectangle([&](double z, double phi) { return density(FromZPhi(z, phi)); }, r.x0, r.x1, r.y0, r.y1,
                                tolerance, 8, forced);
      if (std::fabs(mass * pilot - n) < 3 * std::sqrt(n) + 3) break;
    }
    integral += mass;
    expected[cell.bin] += mass * static_cast<double>(options.samples);
  }
  char text[64];
  std::snprintf(text, sizeof(text), "; density integrates to %.6g", integral);
  if (!(integral < 1 + 1e-3)) return {.message = std::string("not a density") + text};
  expected[count] = std::max(1 - integral, 0.0) * static_cast<double>(options.samples);
  // Failures rarer than the quadrature's error are not evidence.
  if (expected[count] < 10 && observed[count] < 1e-3 * static_cast<double>(options.samples)) {
    expected[count] = observed[count];
  }
  TestResult r = ChiSquareTest(observed, expected, options.level);
  r.message += text;
  return r;
}

SphereIntegral IntegrateSphere(const SphereDensity& f, std::optional<Vec3> focus, double tolerance) {
  const auto integrand = [&](double z, double phi) { return f(FromZPhi(z, phi)); };
  // Cuts around the focus, in geometric steps, so that the first level of the quadrature cannot miss a narrow lobe.
  std::vector<double> zs = {-1, -0.5, 0, 0.5, 1}, phis = {-kPiD, -kPiD / 2, 0, kPiD / 2, kPiD};
  if (focus) {
    const ZPhi c = ToZPhi(*focus);
    for (double step = 0.4; step > 1e-3; step /= 4) {
      for (double sign : {-1.0, 1.0}) {
        const double z = c.z + sign * step, phi = c.phi + sign * step;
        if (z > -1 && z < 1) zs.push_back(z);
        if (phi > -kPiD && phi < kPiD) phis.push_back(phi);
      }
    }
    zs.push_back(c.z), phis.push_back(c.phi);
    std::sort(zs.begin(), zs.end());
    std::sort(phis.begin(), phis.end());
  }
  SphereIntegral result;
  const double per_cell = tolerance / static_cast<double>(zs.size() + phis.size());
  for (size_t i = 0; i + 1 < zs.size(); ++i) {
    for (size_t j = 0; j + 1 < phis.size(); ++j) {
      const double value = IntegrateRectangle(integrand, zs[i], zs[i + 1], phis[j], phis[j + 1], per_cell, 8, 1);
      (zs[i] >= 0 ? result.upper : result.lower) += value;
    }
  }
  return result;
}

}  // namespace lodestar::test
