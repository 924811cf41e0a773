#include "core/guiding/product_cells.h"

#include <xsimd/xsimd.hpp>

#include "core/math/warp.h"

namespace lodestar::product {
namespace {

// One row of the block, whatever the machine: eight lanes, or two times four.
using Lanes = xsimd::batch<float>;
constexpr int kLanes = Lanes::size;
static_assert(kSide % kLanes == 0);
// One row of a patch.
using Four = xsimd::make_sized_batch_t<float, kPatchSide>;

// Four points resolve lobes down to a quarter of the cell's size, as well as the variance can tell.
constexpr float kWidestCell = 4;
constexpr int kOwnPoints = 24;

struct Geometry {
  // Grid lines as fine as the points of the finest cells.
  static constexpr int kLines = 1 << (kFinest + 2);
  std::array<float, kLines> cos_phi, sin_phi;
  // Of the block's columns, at two lines of points in each cell: r^2, r z, z^2, r and z; z is cos theta, r its sine.
  struct alignas(32) Line {
    std::array<float, kSide> rr, rz, zz, r, z;
  };
  std::array<Line, 2> lines;
  // The azimuths of the points in the block's rows.
  alignas(32) std::array<float, 2 * kSide> cos_point, sin_point;
  // The integral of w / pi over a cell is (ring cos, ring sin, height), of cosine and sine integrated over the cell's
  // azimuths. Its length times the sine of a cap of the same size is half the range of n.F over which the cell goes
  // under: `softness`.
  alignas(32) std::array<float, kSide> ring, height, softness, bend, inverse_softness;
  std::array<float, kSide> cos_range, sin_range;
  // Points that follow a cosine lobe.
  alignas(32) std::array<float, kOwnPoints> own_x, own_y, own_z;

  Geometry() {
    const auto turn = [](float t) { return SinCos(2 * kPi * t); };
    for (int i = 0; i < kLines; ++i) {
      const auto [sin, cos] = turn(static_cast<float>(i) / kLines);
      cos_phi[i] = cos;
      sin_phi[i] = sin;
    }
    for (int i = 0; i < 2 * kSide; ++i) {
      const auto [sin, cos] = turn((static_cast<float>(i) + 0.5f) / (2 * kSide));
      cos_point[i] = cos;
      sin_point[i] = sin;
    }
    for (int i = 0; i < kSide; ++i) {
      for (int half = 0; half < 2; ++half) {
        const float z = (static_cast<float>(2 * i + half) + 0.5f) * (1.0f / kSide) - 1, r = SafeSqrt(1 - z * z);
        Line& line = lines[half];
        line.rr[i] = r * r, line.rz[i] = r * z, line.zz[i] = z * z, line.r[i] = r, line.z[i] = z;
      }
      const auto [sin0, cos0] = turn(static_cast<float>(i) / kSide);
      const auto [sin1, cos1] = turn(static_cast<float>(i + 1) / kSide);
      cos_range[i] = sin1 - sin0;
      sin_range[i] = cos0 - cos1;
    }
    const float chord_squared = Sqr(cos_range[0]) + Sqr(sin_range[0]);
    for (int i = 0; i < kSide; ++i) {
      const double z0 = 2.0 * i / kSide - 1, z1 = z0 + 2.0 / kSide;
      // The integral of sin theta over cos theta, by midpoints: this is done once.
      double sum = 0;
      constexpr int kSteps = 4096;
      for (int s = 0; s < kSteps; ++s) sum += std::sqrt(1 - Sqr(z0 + (z1 - z0) * (s + 0.5) / kSteps));
      ring[i] = static_cast<float>(sum * (z1 - z0) / kSteps) * kInvPi;
      height[i] = static_cast<float>((z1 * z1 - z0 * z0) / kSide);
      const float length = std::sqrt(Sqr(ring[i]) * chord_squared + Sqr(height[i]));
      softness[i] = length * std::sqrt(std::min(length, 1.0f));
      bend[i] = 1 / (4 * softness[i]);
      inverse_softness[i] = 1 / softness[i];
    }
    for (int i = 0; i < kOwnPoints; ++i) {
      // Points of Roberts' additive recurrence on the generalised golden ratio: well spread at any number.
      const auto fraction = [&](double step) {
        const double t = 0.5 + step * (i + 1);
        return static_cast<float>(t - std::floor(t));
      };
      const Vec3 w = SquareToCosineHemisphere({fraction(0.7548776662466927), fraction(0.5698402909980532)});
      own_x[i] = w.x, own_y[i] = w.y, own_z[i] = w.z;
    }
  }
};
const Geometry kGeometry;

// n.F of row j's cells in the lanes from i on: below -softness where they are under the horizon, above softness where
// they are over it.
Lanes Height(Vec3 normal, int i, int j) {
  const Geometry& g = kGeometry;
  return xsimd::fma(Lanes(normal.x * g.cos_range[j] + normal.y * g.sin_range[j]), Lanes::load_aligned(&g.ring[i]),
                    normal.z * Lanes::load_aligned(&g.height[i]));
}

}  // namespace

void AddCosine(Vec3 normal, float weight, Block& sum) {
  const Geometry& g = kGeometry;
  for (int i = 0; i < kSide; i += kLanes) {
    const Lanes soft = Lanes::load_aligned(&g.softness[i]), bend = Lanes::load_aligned(&g.bend[i]), zero = 0.0f;
    for (int j = 0; j < kSide; ++j) {
      const Lanes height = Height(normal, i, j);
      // Between under and over, the parabola that joins them smoothly.
      const Lanes wet = xsimd::min(xsimd::max(height + soft, zero), soft + soft);
      const Lanes d = xsimd::fma(wet * wet, bend, xsimd::max(height - soft, zero));
      float* const cells = &sum[j * kSide + i];
      xsimd::fma(Lanes(weight), d, Lanes::load_aligned(cells)).store_aligned(cells);
    }
  }
}

namespace {

// By four points a cell. |M^-1 w|^2 is a quadratic form in (r cos phi, r sin phi, z), so at one azimuth three numbers
// and a fourth for the height over the lobe's plane are all there is of the lobe.
void ByPoints(const Ltc& ltc, Vec3 normal, float weight, Block& sum) {
  const Geometry& g = kGeometry;
  const Vec3 x = ltc.x(), y = ltc.y(), z = ltc.z();
  const auto product = [&](float Vec3::*a, float Vec3::*b) { return x.*a * x.*b + y.*a * y.*b + z.*a * z.*b; };
  const float xx = product(&Vec3::x, &Vec3::x), xy = 2 * product(&Vec3::x, &Vec3::y), yy = product(&Vec3::y, &Vec3::y),
              xz = 2 * product(&Vec3::x, &Vec3::z), yz = 2 * product(&Vec3::y, &Vec3::z),
              zz = product(&Vec3::z, &Vec3::z);
  alignas(32) float in_rr[2 * kSide], in_rz[2 * kSide], in_r[2 * kSide];
  for (int k = 0; k < 2 * kSide; k += kLanes) {
    const Lanes cos = Lanes::load_aligned(&g.cos_point[k]), sin = Lanes::load_aligned(&g.sin_point[k]);
    xsimd::fma(xsimd::fma(Lanes(xx), cos, xy * sin), cos, yy * sin * sin).store_aligned(&in_rr[k]);
    xsimd::fma(Lanes(xz), cos, yz * sin).store_aligned(&in_rz[k]);
    xsimd::fma(Lanes(z.x), cos, z.y * sin).store_aligned(&in_r[k]);
  }
  const Lanes scale = weight * ltc.determinant() / kBlock, zero = 0.0f, one = 1.0f, four = 4.0f;
  for (int i = 0; i < kSide; i += kLanes) {
    Lanes rr[2], rz[2], r[2], zz_term[2], z_term[2];
    for (int half = 0; half < 2; ++half) {
      const Geometry::Line& line = g.lines[half];
      rr[half] = Lanes::load_aligned(&line.rr[i]), rz[half] = Lanes::load_aligned(&line.rz[i]);
      r[half] = Lanes::load_aligned(&line.r[i]);
      zz_term[half] = zz * Lanes::load_aligned(&line.zz[i]);
      z_term[half] = z.z * Lanes::load_aligned(&line.z[i]);
    }
    const Lanes inverse_soft = Lanes::load_aligned(&g.inverse_softness[i]);
    for (int j = 0; j < kSide; ++j) {
      // pi / determinant times the sum of the densities, with one division for two points.
      Lanes d = zero;
      for (int k = 2 * j; k < 2 * j + 2; ++k) {
        const auto point = [&](int half, Lanes& value, Lanes& square) {
          value = xsimd::max(xsimd::fma(Lanes(in_r[k]), r[half], z_term[half]), zero);
          square = xsimd::fma(Lanes(in_rr[k]), rr[half], xsimd::fma(Lanes(in_rz[k]), rz[half], zz_term[half]));
          square *= square;
        };
        Lanes a, aa, b, bb;
        point(0, a, aa);
        point(1, b, bb);
        d += xsimd::fma(a, bb, b * aa) / (aa * bb);
      }
      // 0 for cells under the horizon, soon 1 for those that reach over it: grazing lobes hug it from above.
      const Lanes above =
          xsimd::min(xsimd::max(xsimd::fma(Height(normal, i, j) * inverse_soft, four, four), zero), one);
      float* const cells = &sum[j * kSide + i];
      xsimd::fma(d * above, scale, Lanes::load_aligned(cells)).store_aligned(cells);
    }
  }
}

// By points that follow the lobe.
void ByOwnPoints(const Ltc& ltc, Vec3 normal, float weight, Block& sum) {
  const Geometry& g = kGeometry;
  // The columns of M, but for a factor.
  const Vec3 mx = Cross(ltc.y(), ltc.z()), my = Cross(ltc.z(), ltc.x()), mz = Cross(ltc.x(), ltc.y());
  alignas(32) float wx[kOwnPoints], wy[kOwnPoints], column[kOwnPoints], above[kOwnPoints];
  for (int i = 0; i < kOwnPoints; i += kLanes) {
    const Lanes cx = Lanes::load_aligned(&g.own_x[i]), cy = Lanes::load_aligned(&g.own_y[i]),
                cz = Lanes::load_aligned(&g.own_z[i]);
    const auto to = [&](float a, float b, float c) {
      return xsimd::fma(Lanes(a), cx, xsimd::fma(Lanes(b), cy, c * cz));
    };
    const Lanes x = to(mx.x, my.x, mz.x), y = to(mx.y, my.y, mz.y), z = to(mx.z, my.z, mz.z);
    const Lanes length = xsimd::sqrt(xsimd::fma(x, x, xsimd::fma(y, y, z * z)));
    x.store_aligned(&wx[i]);
    y.store_aligned(&wy[i]);
    xsimd::fma(z / length, Lanes(kSide / 2), Lanes(kSide / 2)).store_aligned(&column[i]);
    const Lanes height = xsimd::fma(Lanes(normal.x), x, xsimd::fma(Lanes(normal.y), y, normal.z * z));
    xsimd::select(height > Lanes(0.0f), Lanes(weight / kOwnPoints), Lanes(0.0f)).store_aligned(&above[i]);
  }
  for (int i = 0; i < kOwnPoints; ++i) {
    // The eighth of a turn that (x, y) lies in.
    const int below = wy[i]<0, left = (wx[i] < 0) != (below != 0), steep = std::fabs(wy[i])> std::fabs(wx[i]);
    const int row = 4 * below + (left ? 3 - steep : steep);
    sum[row * kSide + std::min(static_cast<int>(column[i]), kSide - 1)] += above[i];
  }
}

}  // namespace

void AddGlossy(const Ltc& ltc, Vec3 normal, float weight, Block& sum) {
  (kWidestCell * ltc.width() < CellSize(kBlockLevel) ? ByOwnPoints : ByPoints)(ltc, normal, weight, sum);
}

PatchDensities Densities(const ProductLobes& lobes, int level, uint32_t x, uint32_t y) {
  const Geometry& g = kGeometry;
  const int fine = level + kPatchLevels;
  const float size = CellSize(fine), step = 2 / static_cast<float>(1 << fine);
  const Four zero = 0.0f;
  // Cells' centres; and points a quarter of a cell before and behind them.
  const Four z = (Four{0.5f, 1.5f, 2.5f, 3.5f} + static_cast<float>(kPatchSide * x)) * step - 1.0f;
  const auto radius = [&](Four z) { return xsimd::sqrt(xsimd::max(1.0f - z * z, zero)); };
  const Four r = radius(z);
  const Four z_before = z - 0.25f * step, z_behind = z + 0.25f * step;
  Four r_before = zero, r_behind = zero;
  // Azimuths in quarters of a cell, from the first cell's side.
  const uint32_t quarter = static_cast<uint32_t>(Geometry::kLines >> (fine + 2)), first = 4 * kPatchSide * y * quarter;

  PatchDensities out;
  Four narrow[kPatchSide];
  float lobe_scale[ProductLobes::kMaxGlossy];
  enum class By : uint8_t { kCentre, kNarrowCentre, kNarrowPoints } by[ProductLobes::kMaxGlossy];
  for (int k = 0; k < lobes.glossy_count(); ++k) {
    const Ltc& ltc = lobes.glossy(k);
    lobe_scale[k] = lobes.glossy_weight(k) * ltc.determinant() * kInvPi;
    by[k] = !IsNarrow(ltc, fine) ? By::kCentre : ltc.width() >= size ? By::kNarrowCentre : By::kNarrowPoints;
    out.has_narrow |= by[k] != By::kCentre;
    if (by[k] == By::kNarrowPoints) {
      r_before = radius(z_before);
      r_behind = radius(z_behind);
    }
  }
  // A cell on the horizon: the parabola again, as if it were as high as wide.
  const float soft = 0.5f * size, bend = 1 / (4 * soft);
  const auto wet = [&](Four height) {
    const Four in = xsimd::min(xsimd::max(height + soft, zero), Four(2 * soft));
    return xsimd::fma(in * in, Four(bend), xsimd::max(height - soft, zero));
  };
  for (int row = 0; row < kPatchSide; ++row) {
    const auto along = [&](Vec3 v, uint32_t phi, Four r, Four z) {
      return xsimd::fma(Four(v.x * g.cos_phi[phi] + v.y * g.sin_phi[phi]), r, v.z * z);
    };
    const auto density = [&](const Ltc& ltc, uint32_t phi, Four r, Four z) {
      const Four px = along(ltc.x(), phi, r, z), py = along(ltc.y(), phi, r, z), pz = along(ltc.z(), phi, r, z);
      const Four square = xsimd::fma(px, px, xsimd::fma(py, py, pz * pz));
      return xsimd::max(pz, zero) / (square * square);
    };
    const uint32_t phi = first + (4 * static_cast<uint32_t>(row) + 2) * quarter;
    const Four cos = along(lobes.normal(), phi, r, z);
    Four all = (lobes.diffuse() * kInvPi) * wet(cos);
    if (lobes.transmission() > 0) all += (lobes.transmission() * kInvPi) * wet(-cos);
    narrow[row] = zero;
    const auto visible = cos > Four(-soft);
    for (int k = 0; k < lobes.glossy_count(); ++k) {
      const Ltc& ltc = lobes.glossy(k);
      Four d;
      if (by[k] == By::kNarrowPoints) {
        d = zero;
        for (const uint32_t at : {phi - quarter, phi + quarter})
          d += density(ltc, at, r_before, z_before) + density(ltc, at, r_behind, z_behind);
        d *= 0.25f;
      } else {
        d = density(ltc, phi, r, z);
      }
      d = xsimd::select(visible, d * lobe_scale[k], zero);
      all += d;
      if (by[k] != By::kCentre) narrow[row] += d;
    }
    all.store_aligned(&out.all[row * kPatchSide]);
  }
  if (out.has_narrow) {
    for (int row = 0; row < kPatchSide; ++row) narrow[row].store_aligned(&out.narrow[row * kPatchSide]);
  }
  return out;
}

}  // namespace lodestar::product
