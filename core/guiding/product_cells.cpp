#include "core/guiding/product_cells.h"

#include <xsimd/xsimd.hpp>

namespace lodestar::product {
namespace {

// One row of the block, whatever the machine: eight lanes, or two times four.
using Lanes = xsimd::batch<float>;
constexpr int kLanes = Lanes::size;
static_assert(kSide % kLanes == 0);

struct Lanes3 {
  Lanes x, y, z;
};

// theta / sin theta, given both functions of theta in [0, pi]. Minimax for acute angles, absolute error below 1e-6.
Lanes AngleOverSine(Lanes cos, Lanes sin) {
  const Lanes c = xsimd::abs(cos);
  Lanes v = -0.0273540324f;
  for (const float a :
       {0.138489635f, -0.327471013f, 0.511508693f, -0.649504233f, 0.783448103f, -0.9999133f, 1.57079568f}) {
    v = xsimd::fma(v, c, Lanes(a));
  }
  const auto obtuse = cos < Lanes(0.0f);
  if (!xsimd::any(obtuse)) return v;
  return xsimd::select(obtuse, kPi / xsimd::max(sin, Lanes(1e-20f)) - v, v);
}

Lanes Dot(const Lanes3& a, const Lanes3& b) {
  return xsimd::fma(a.x, b.x, xsimd::fma(a.y, b.y, a.z * b.z));
}

// 2 pi times what the arcs from a to b contribute to the cosine's integral; both of unit length.
Lanes ArcIntegral(const Lanes3& a, const Lanes3& b) {
  const auto arc = [](const Lanes3& p, const Lanes3& q) {
    const Lanes3 c{p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
    return c.z * AngleOverSine(Dot(p, q), xsimd::sqrt(Dot(c, c)));
  };
  const Lanes zero = 0.0f;
  const auto a_above = a.z >= zero, b_above = b.z >= zero;
  if (xsimd::all(a_above & b_above)) return arc(a, b);
  const auto unit = [](Lanes& x, Lanes& y) {
    const Lanes scale = 1.0f / xsimd::sqrt(xsimd::max(xsimd::fma(x, x, y * y), Lanes(1e-30f)));
    x *= scale;
    y *= scale;
  };
  // Where the arc's circle meets the horizon between a and b; of no consequence where it does not.
  Lanes mx = xsimd::fma(a.x, xsimd::abs(b.z), b.x * xsimd::abs(a.z)),
        my = xsimd::fma(a.y, xsimd::abs(b.z), b.y * xsimd::abs(a.z));
  unit(mx, my);
  const Lanes above = arc({xsimd::select(a_above, a.x, mx), xsimd::select(a_above, a.y, my), xsimd::max(a.z, zero)},
                          {xsimd::select(b_above, b.x, mx), xsimd::select(b_above, b.y, my), xsimd::max(b.z, zero)});
  Lanes ax = a.x, ay = a.y, bx = b.x, by = b.y;
  unit(ax, ay);
  unit(bx, by);
  ax = xsimd::select(a_above, mx, ax), ay = xsimd::select(a_above, my, ay);
  bx = xsimd::select(b_above, mx, bx), by = xsimd::select(b_above, my, by);
  const Lanes sin = ax * by - ay * bx;
  return above + sin * AngleOverSine(xsimd::fma(ax, bx, ay * by), xsimd::abs(sin));
}

// From the sum of a cell's arcs. A cell around the nadir has its boundary wound once around the whole horizon,
// backwards: one is missing. No such cell can hold more than half of the lobe, so the two cases lie far apart.
Lanes CellIntegral(Lanes arcs) {
  const Lanes d = arcs * (0.5f * kInvPi);
  return xsimd::max(xsimd::select(d < Lanes(-0.25f), d + 1.0f, d), Lanes(0.0f));
}

Lanes3 ToCosine(const Ltc& ltc, const Lanes3& w) {
  const auto row = [&](Vec3 r) { return Dot({Lanes(r.x), Lanes(r.y), Lanes(r.z)}, w); };
  const Lanes3 p{row(ltc.x()), row(ltc.y()), row(ltc.z())};
  const Lanes scale = 1.0f / xsimd::sqrt(Dot(p, p));
  return {p.x * scale, p.y * scale, p.z * scale};
}

struct Geometry {
  static constexpr int kFineSide = 1 << kFinest;
  // Of the finest level's grid lines.
  std::array<float, kFineSide + 1> cos_theta, sin_theta, cos_phi, sin_phi;
  // The block's corners from pole to pole along the 16 meridians at and between its own.
  alignas(32) std::array<std::array<float, 16>, 2 * kSide> x, y, z;
  // The integral of w / pi over each cell, its length times the sine of a cap of the same size: half the range of
  // normals over which the cell goes under.
  alignas(32) Block fx, fy, fz, softness;

  Geometry() {
    for (int i = 0; i <= kFineSide; ++i) {
      const float t = static_cast<float>(i) / kFineSide;
      cos_theta[i] = 2 * t - 1;
      sin_theta[i] = SafeSqrt(1 - Sqr(cos_theta[i]));
      const auto [sin, cos] = SinCos(2 * kPi * t);
      cos_phi[i] = cos;
      sin_phi[i] = sin;
    }
    for (int j = 0; j < 2 * kSide; ++j) {
      const int phi = j * kFineSide / (2 * kSide);
      for (int i = 0; i < 16; ++i) {
        const int theta = std::min(i, kSide) * kFineSide / kSide;
        x[j][i] = sin_theta[theta] * cos_phi[phi];
        y[j][i] = sin_theta[theta] * sin_phi[phi];
        z[j][i] = cos_theta[theta];
      }
    }
    for (int c = 0; c < kBlock; ++c) {
      const double z0 = cos_theta[c % kSide * kFineSide / kSide], z1 = cos_theta[(c % kSide + 1) * kFineSide / kSide];
      const int p0 = c / kSide * kFineSide / kSide, p1 = p0 + kFineSide / kSide;
      // The integral of sin theta over cos theta, by midpoints: this is done once.
      double ring = 0;
      constexpr int kSteps = 4096;
      for (int s = 0; s < kSteps; ++s) ring += std::sqrt(1 - Sqr(z0 + (z1 - z0) * (s + 0.5) / kSteps));
      ring *= (z1 - z0) / kSteps;
      fx[c] = static_cast<float>(ring * (sin_phi[p1] - sin_phi[p0])) * kInvPi;
      fy[c] = static_cast<float>(ring * (cos_phi[p0] - cos_phi[p1])) * kInvPi;
      fz[c] = static_cast<float>((z1 * z1 - z0 * z0) / kSide);
      const float length = Length(Vec3{fx[c], fy[c], fz[c]});
      softness[c] = length * std::sqrt(std::min(length, 1.0f));
    }
  }
};
const Geometry kGeometry;

// n.F of a row's cells: below -softness where they are under the horizon, above softness where they are over it.
Lanes Height(Vec3 normal, int cell) {
  const Geometry& g = kGeometry;
  return Dot({Lanes(normal.x), Lanes(normal.y), Lanes(normal.z)},
             {Lanes::load_aligned(&g.fx[cell]), Lanes::load_aligned(&g.fy[cell]), Lanes::load_aligned(&g.fz[cell])});
}

}  // namespace

void AddCosine(Vec3 normal, float weight, Block& sum) {
  for (int c = 0; c < kBlock; c += kLanes) {
    const Lanes height = Height(normal, c), soft = Lanes::load_aligned(&kGeometry.softness[c]);
    // Between under and over, the parabola that joins them smoothly.
    const Lanes wet = xsimd::min(xsimd::max(height + soft, Lanes(0.0f)), 2.0f * soft);
    const Lanes d = xsimd::max(height - soft, Lanes(0.0f)) + wet * wet / (4.0f * soft);
    (Lanes::load_aligned(&sum[c]) + weight * d).store_aligned(&sum[c]);
  }
}

void AddGlossy(const Ltc& ltc, Vec3 normal, float weight, Block& sum) {
  constexpr int kStride = 16;
  const Geometry& g = kGeometry;
  alignas(32) float x[2 * kSide][kStride], y[2 * kSide][kStride], z[2 * kSide][kStride];
  for (int j = 0; j < 2 * kSide; ++j) {
    for (int i = 0; i < kSide; i += kLanes) {
      const Lanes3 p = ToCosine(
          ltc, {Lanes::load_aligned(&g.x[j][i]), Lanes::load_aligned(&g.y[j][i]), Lanes::load_aligned(&g.z[j][i])});
      p.x.store_aligned(&x[j][i]);
      p.y.store_aligned(&y[j][i]);
      p.z.store_aligned(&z[j][i]);
    }
    // The other pole is opposite to the first.
    x[j][kSide] = -x[j][0], y[j][kSide] = -y[j][0], z[j][kSide] = -z[j][0];
  }
  const auto corners = [&](int j, int i) {
    return Lanes3{Lanes::load_unaligned(&x[j][i]), Lanes::load_unaligned(&y[j][i]), Lanes::load_unaligned(&z[j][i])};
  };
  alignas(32) float meridians[kSide + 1][kSide], parallels[kSide][kStride];
  for (int j = 0; j < kSide; ++j) {
    const int here = 2 * j, next = (here + 2) % (2 * kSide);
    for (int i = 0; i < kSide; i += kLanes) {
      const Lanes3 from = corners(here, i), middle = corners(here + 1, i), to = corners(next, i);
      ArcIntegral(from, corners(here, i + 1)).store_aligned(&meridians[j][i]);
      (ArcIntegral(from, middle) + ArcIntegral(middle, to)).store_aligned(&parallels[j][i]);
    }
    parallels[j][kSide] = 0;  // the poles have no extent
    parallels[j][0] = 0;
  }
  std::copy_n(meridians[0], kSide, meridians[kSide]);
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; i += kLanes) {
      const int c = j * kSide + i;
      const Lanes d = CellIntegral(Lanes::load_aligned(&parallels[j][i]) - Lanes::load_unaligned(&parallels[j][i + 1]) +
                                   Lanes::load_aligned(&meridians[j + 1][i]) - Lanes::load_aligned(&meridians[j][i]));
      const Lanes height = Height(normal, c) / Lanes::load_aligned(&g.softness[c]);
      // Grazing lobes hug the horizon from above: half a cell under it may have the whole of its share.
      const Lanes above = xsimd::min(xsimd::max(height + 1.0f, Lanes(0.0f)), Lanes(1.0f));
      (Lanes::load_aligned(&sum[c]) + weight * above * d).store_aligned(&sum[c]);
    }
  }
}

void AddChildren(const Ltc& ltc, float weight, int level, uint32_t x, uint32_t y, std::array<float, 4>& sum) {
  const Geometry& g = kGeometry;
  const int shift = kFinest - level - 1;
  alignas(32) float wx[16] = {}, wy[16] = {}, wz[16];
  std::fill_n(wz, 16, 1.0f);
  for (uint32_t i = 0; i < 3; ++i) {
    const uint32_t theta = (2 * x + i) << shift;
    for (uint32_t j = 0; j < 3; ++j) {
      const uint32_t phi = (2 * y + j) << shift;
      wx[3 * i + j] = g.sin_theta[theta] * g.cos_phi[phi];
      wy[3 * i + j] = g.sin_theta[theta] * g.sin_phi[phi];
      wz[3 * i + j] = g.cos_theta[theta];
    }
  }
  for (int i = 0; i < 16; i += kLanes) {
    const Lanes3 p =
        ToCosine(ltc, {Lanes::load_aligned(&wx[i]), Lanes::load_aligned(&wy[i]), Lanes::load_aligned(&wz[i])});
    p.x.store_aligned(&wx[i]);
    p.y.store_aligned(&wy[i]);
    p.z.store_aligned(&wz[i]);
  }
  // Corner 3 i + j. Arcs to the next j and to the next i; those that leave the grid are not used.
  alignas(32) float parallels[16], meridians[16];
  const auto corners = [&](int i) {
    return Lanes3{Lanes::load_unaligned(&wx[i]), Lanes::load_unaligned(&wy[i]), Lanes::load_unaligned(&wz[i])};
  };
  for (int i = 0; i < 8; i += kLanes) {
    const Lanes3 from = corners(i);
    ArcIntegral(from, corners(i + 1)).store_aligned(&parallels[i]);
    ArcIntegral(from, corners(i + 3)).store_aligned(&meridians[i]);
  }
  for (int c = 0; c < 4; ++c) {
    const int q = 3 * (c & 1) + (c >> 1);
    const float d = (parallels[q] + meridians[q + 1] - parallels[q + 3] - meridians[q]) * (0.5f * kInvPi);
    sum[c] += weight * std::max(d < -0.25f ? d + 1 : d, 0.0f);
  }
}

}  // namespace lodestar::product
