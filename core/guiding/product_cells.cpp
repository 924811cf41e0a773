#include "core/guiding/product_cells.h"

#include <xsimd/xsimd.hpp>

namespace lodestar::product {
namespace {

// One row of the block, whatever the machine: eight lanes, or two times four.
using Lanes = xsimd::batch<float>;
constexpr int kLanes = Lanes::size;
static_assert(kSide % kLanes == 0);

// Four points resolve lobes down to a quarter of the cell's size, as well as the variance can tell.
constexpr float kWidestCell = 4;

struct Lanes3 {
  Lanes x, y, z;
};

Lanes Dot(const Lanes3& a, const Lanes3& b) {
  return xsimd::fma(a.x, b.x, xsimd::fma(a.y, b.y, a.z * b.z));
}

// theta / sin theta, given cos theta and a function for sin theta, theta in [0, pi]. Minimax for acute angles, absolute
// error below 1e-6; the sine, small where the cosine cannot tell, matters for others only.
template <class Sine>
Lanes AngleOverSine(Lanes cos, Sine&& sine) {
  const Lanes c = xsimd::abs(cos);
  Lanes v = -0.0273540324f;
  for (const float a :
       {0.138489635f, -0.327471013f, 0.511508693f, -0.649504233f, 0.783448103f, -0.9999133f, 1.57079568f}) {
    v = xsimd::fma(v, c, Lanes(a));
  }
  const auto obtuse = cos < Lanes(0.0f);
  if (!xsimd::any(obtuse)) [[likely]]
    return v;
  return xsimd::select(obtuse, kPi / xsimd::max(sine(), Lanes(1e-20f)) - v, v);
}

// 1 / sqrt, large but finite at 0.
Lanes InverseRoot(Lanes x) {
  return 1.0f / xsimd::sqrt(xsimd::max(x, Lanes(1e-30f)));
}

// 2 pi times what the arcs from a to b contribute to the cosine's integral; both of unit length.
Lanes ArcIntegral(const Lanes3& a, const Lanes3& b) {
  const auto arc = [](const Lanes3& p, const Lanes3& q) {
    const Lanes3 c{p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
    return c.z * AngleOverSine(Dot(p, q), [&] { return xsimd::sqrt(Dot(c, c)); });
  };
  const Lanes zero = 0.0f;
  const auto a_above = a.z >= zero, b_above = b.z >= zero;
  if (xsimd::all(a_above & b_above)) return arc(a, b);
  // Where the arc's circle meets the horizon between a and b; of no consequence where it does not.
  Lanes mx = xsimd::fma(a.x, xsimd::abs(b.z), b.x * xsimd::abs(a.z)),
        my = xsimd::fma(a.y, xsimd::abs(b.z), b.y * xsimd::abs(a.z));
  const Lanes scale = InverseRoot(xsimd::fma(mx, mx, my * my));
  mx *= scale;
  my *= scale;
  const Lanes above = arc({xsimd::select(a_above, a.x, mx), xsimd::select(a_above, a.y, my), xsimd::max(a.z, zero)},
                          {xsimd::select(b_above, b.x, mx), xsimd::select(b_above, b.y, my), xsimd::max(b.z, zero)});
  const Lanes ax = xsimd::select(a_above, mx, a.x), ay = xsimd::select(a_above, my, a.y),
              bx = xsimd::select(b_above, mx, b.x), by = xsimd::select(b_above, my, b.y);
  const Lanes unit = InverseRoot(xsimd::fma(ax, ax, ay * ay) * xsimd::fma(bx, bx, by * by));
  const Lanes sin = (ax * by - ay * bx) * unit;
  return above + sin * AngleOverSine(xsimd::fma(ax, bx, ay * by) * unit, [&] { return xsimd::abs(sin); });
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
  // Grid lines as fine as the points of the finest cells.
  static constexpr int kLines = 1 << (kFinest + 2);
  std::array<float, kLines + 1> cos_phi, sin_phi;
  // Of the block's rows: cos theta and sin theta of two lines of points in each cell.
  alignas(32) std::array<std::array<float, kSide>, 2> z, r;
  // The azimuths of the block's meridians, and those between them.
  alignas(32) std::array<float, kSide> cos_side, sin_side, cos_middle, sin_middle;
  // The integral of w / pi over each cell; its length times the sine of a cap of the same size is half the range of
  // n.F over which the cell goes under.
  alignas(32) Block fx, fy, fz, softness;

  Geometry() {
    for (int i = 0; i <= kLines; ++i) {
      const auto [sin, cos] = SinCos(2 * kPi * static_cast<float>(i) / kLines);
      cos_phi[i] = cos;
      sin_phi[i] = sin;
    }
    for (int i = 0; i < kSide; ++i) {
      for (int half = 0; half < 2; ++half) {
        z[half][i] = (static_cast<float>(i) + 0.25f + 0.5f * static_cast<float>(half)) * (2.0f / kSide) - 1;
        r[half][i] = SafeSqrt(1 - Sqr(z[half][i]));
      }
      const int line = i * (kLines / kSide), middle = line + kLines / (2 * kSide);
      cos_side[i] = cos_phi[line], sin_side[i] = sin_phi[line];
      cos_middle[i] = cos_phi[middle], sin_middle[i] = sin_phi[middle];
    }
    for (int c = 0; c < kBlock; ++c) {
      const double z0 = 2.0 * (c % kSide) / kSide - 1, z1 = z0 + 2.0 / kSide;
      const int p0 = c / kSide * (kLines / kSide), p1 = p0 + kLines / kSide;
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

namespace {

// 0 for cells under the horizon, soon 1 for those that reach over it: grazing lobes hug it from above.
Lanes Above(Vec3 normal, int cell) {
  const Lanes height = Height(normal, cell) / Lanes::load_aligned(&kGeometry.softness[cell]);
  return xsimd::min(xsimd::max(height * 4.0f + 4.0f, Lanes(0.0f)), Lanes(1.0f));
}

// pi / determinant times the density, of two points each: one division.
struct Points {
  Lanes value, square;
};
Points At(const Lanes3& p) {
  const Lanes square = Dot(p, p);
  return {xsimd::max(p.z, Lanes(0.0f)), square * square};
}
Lanes Sum(const Points& a, const Points& b) {
  return xsimd::fma(a.value, b.square, b.value * a.square) / (a.square * b.square);
}

// Integrals over the block, by four points a cell.
void ByPoints(const Ltc& ltc, Block& d) {
  const Geometry& g = kGeometry;
  const float scale = ltc.determinant() * 4 / (4 * kBlock);
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; i += kLanes) {
      Lanes sum = 0.0f;
      for (int half = 0; half < 2; ++half) {
        const int phi = (j * 4 + 1 + 2 * half) * (Geometry::kLines / (4 * kSide));
        const auto point = [&](int line) {
          const Lanes r = Lanes::load_aligned(&g.r[line][i]), z = Lanes::load_aligned(&g.z[line][i]);
          const auto along = [&](Vec3 row) {
            return xsimd::fma(Lanes(row.x * g.cos_phi[phi] + row.y * g.sin_phi[phi]), r, Lanes(row.z) * z);
          };
          return At({along(ltc.x()), along(ltc.y()), along(ltc.z())});
        };
        sum += Sum(point(0), point(1));
      }
      (sum * scale).store_aligned(&d[j * kSide + i]);
    }
  }
}

// Integrals over the two rings of the block around the lobe's axis, by their edges, in place of others. Lanes go
// around.
void RingsByEdges(const Ltc& ltc, Block& d) {
  const Geometry& g = kGeometry;
  const Vec3 axis = Cross(ltc.x(), ltc.y());
  const int first = std::clamp(static_cast<int>((axis.z / Length(axis) + 1) * (kSide / 2) + 0.5f) - 1, 0, kSide - 2);
  alignas(32) float meridians[2][2 * kSide], parallels[3][kSide];
  float x[3][2 * kSide], y[3][2 * kSide], z[3][2 * kSide];
  const auto corners = [&](int line, int j) {
    return Lanes3{Lanes::load_unaligned(&x[line][j]), Lanes::load_unaligned(&y[line][j]),
                  Lanes::load_unaligned(&z[line][j])};
  };
  for (int line = 0; line < 3; ++line) {
    const float cos = static_cast<float>(first + line) * (2.0f / kSide) - 1, sin = SafeSqrt(1 - cos * cos);
    const auto at = [&](const std::array<float, kSide>& cosines, const std::array<float, kSide>& sines, int j) {
      return ToCosine(ltc, {sin * Lanes::load_aligned(&cosines[j]), sin * Lanes::load_aligned(&sines[j]), Lanes(cos)});
    };
    for (int j = 0; j < kSide; j += kLanes) {
      const Lanes3 p = at(g.cos_side, g.sin_side, j);
      p.x.store_unaligned(&x[line][j]);
      p.y.store_unaligned(&y[line][j]);
      p.z.store_unaligned(&z[line][j]);
    }
    x[line][kSide] = x[line][0], y[line][kSide] = y[line][0], z[line][kSide] = z[line][0];
    for (int j = 0; j < kSide; j += kLanes) {
      Lanes arcs = 0.0f;
      if (first + line > 0 && first + line < kSide) {
        const Lanes3 middle = at(g.cos_middle, g.sin_middle, j);
        arcs = ArcIntegral(corners(line, j), middle) + ArcIntegral(middle, corners(line, j + 1));
      }
      arcs.store_aligned(&parallels[line][j]);
      if (line > 0) ArcIntegral(corners(line - 1, j), corners(line, j)).store_aligned(&meridians[line - 1][j]);
    }
  }
  for (int ring = 0; ring < 2; ++ring) {
    meridians[ring][kSide] = meridians[ring][0];
    alignas(32) float cells[kSide];
    for (int j = 0; j < kSide; j += kLanes) {
      CellIntegral(Lanes::load_aligned(&parallels[ring][j]) - Lanes::load_aligned(&parallels[ring + 1][j]) +
                   Lanes::load_unaligned(&meridians[ring][j + 1]) - Lanes::load_aligned(&meridians[ring][j]))
          .store_aligned(&cells[j]);
    }
    for (int j = 0; j < kSide; ++j) d[j * kSide + first + ring] = cells[j];
  }
}

}  // namespace

void AddGlossy(const Ltc& ltc, Vec3 normal, float weight, Block& sum) {
  Block d;
  ByPoints(ltc, d);
  // Away from its axis any lobe is smooth.
  if (CellSize(kBlockLevel) > kWidestCell * ltc.width()) RingsByEdges(ltc, d);
  for (int c = 0; c < kBlock; c += kLanes) {
    (Lanes::load_aligned(&sum[c]) + weight * Above(normal, c) * Lanes::load_aligned(&d[c])).store_aligned(&sum[c]);
  }
}

namespace {

void ChildrenByPoints(const Ltc& ltc, float weight, int level, uint32_t x, uint32_t y, std::array<float, 4>& sum) {
  const Geometry& g = kGeometry;
  // Point 4 i + j, i in cos theta and j in phi; the halves of rows come in pairs for the sake of the division.
  const float size = 1 / static_cast<float>(1 << level);
  const uint32_t step = static_cast<uint32_t>(Geometry::kLines >> (level + 3));
  alignas(32) float px[16], py[16], pz[16], d[8];
  for (uint32_t i = 0; i < 4; ++i) {
    const float z = 2 * (static_cast<float>(x) + (static_cast<float>(i) + 0.5f) * 0.25f) * size - 1;
    const float r = SafeSqrt(1 - z * z);
    const uint32_t row = (i & 1) * 8 + (i >> 1) * 4;
    for (uint32_t j = 0; j < 4; ++j) {
      const uint32_t phi = (8 * y + 2 * j + 1) * step;
      px[row + j] = r * g.cos_phi[phi];
      py[row + j] = r * g.sin_phi[phi];
      pz[row + j] = z;
    }
  }
  const auto point = [&](int i) {
    const Lanes3 w{Lanes::load_aligned(&px[i]), Lanes::load_aligned(&py[i]), Lanes::load_aligned(&pz[i])};
    const auto along = [&](Vec3 row) { return Dot({Lanes(row.x), Lanes(row.y), Lanes(row.z)}, w); };
    return At({along(ltc.x()), along(ltc.y()), along(ltc.z())});
  };
  for (int i = 0; i < 8; i += kLanes) Sum(point(i), point(i + 8)).store_aligned(&d[i]);
  const float scale = weight * ltc.determinant() * (0.25f * size * size);
  for (int c = 0; c < 4; ++c) sum[c] += scale * (d[(c & 1) * 4 + (c >> 1) * 2] + d[(c & 1) * 4 + (c >> 1) * 2 + 1]);
}

void ChildrenByEdges(const Ltc& ltc, float weight, int level, uint32_t x, uint32_t y, std::array<float, 4>& sum) {
  const Geometry& g = kGeometry;
  // Corner 3 i + j. Arcs to the next j and to the next i; those that leave the grid are not used.
  alignas(32) float wx[16] = {}, wy[16] = {}, wz[16], parallels[8], meridians[8];
  std::fill_n(wz, 16, 1.0f);
  for (uint32_t i = 0; i < 3; ++i) {
    const float z = static_cast<float>(2 * x + i) / static_cast<float>(1 << level) - 1, r = SafeSqrt(1 - z * z);
    for (uint32_t j = 0; j < 3; ++j) {
      const uint32_t phi = (2 * y + j) * static_cast<uint32_t>(Geometry::kLines >> (level + 1));
      wx[3 * i + j] = r * g.cos_phi[phi];
      wy[3 * i + j] = r * g.sin_phi[phi];
      wz[3 * i + j] = z;
    }
  }
  for (int i = 0; i < 16; i += kLanes) {
    const Lanes3 p =
        ToCosine(ltc, {Lanes::load_aligned(&wx[i]), Lanes::load_aligned(&wy[i]), Lanes::load_aligned(&wz[i])});
    p.x.store_aligned(&wx[i]);
    p.y.store_aligned(&wy[i]);
    p.z.store_aligned(&wz[i]);
  }
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

}  // namespace

std::array<float, 4> Children(const ProductLobes& lobes, int level, uint32_t x, uint32_t y) {
  using Four = xsimd::make_sized_batch_t<float, 4>;
  const Geometry& g = kGeometry;
  const float size = CellSize(level + 1), area = size * size;
  // The children's centres.
  const float step = 1 / static_cast<float>(1 << level), z0 = (static_cast<float>(2 * x) + 0.5f) * step - 1;
  const Four wz{z0, z0 + step, z0, z0 + step};
  const Four r = xsimd::sqrt(xsimd::max(1.0f - wz * wz, Four(0.0f)));
  const uint32_t line = static_cast<uint32_t>(Geometry::kLines >> (level + 2)), phi0 = (4 * y + 1) * line,
                 phi1 = phi0 + 2 * line;
  const Four wx = r * Four{g.cos_phi[phi0], g.cos_phi[phi0], g.cos_phi[phi1], g.cos_phi[phi1]};
  const Four wy = r * Four{g.sin_phi[phi0], g.sin_phi[phi0], g.sin_phi[phi1], g.sin_phi[phi1]};
  const auto along = [&](Vec3 row) { return xsimd::fma(Four(row.x), wx, xsimd::fma(Four(row.y), wy, row.z * wz)); };
  // A child on the horizon: the parabola again, as if it were as high as wide.
  const Four cos = along(lobes.normal()), zero = 0.0f;
  const float soft = 0.5f * size, bend = 1 / (4 * soft);
  const auto wet = [&](Four height) {
    const Four in = xsimd::min(xsimd::max(height + soft, zero), Four(2 * soft));
    return xsimd::fma(in * in, Four(bend), xsimd::max(height - soft, zero));
  };
  Four sum = lobes.diffuse() * area * kInvPi * wet(cos);
  if (lobes.transmission() > 0) sum += lobes.transmission() * area * kInvPi * wet(-cos);
  const auto visible = cos > Four(-soft);
  for (int k = 0; k < lobes.glossy_count(); ++k) {
    const Ltc& ltc = lobes.glossy(k);
    Four d;
    if (size > ltc.width()) {
      alignas(16) std::array<float, 4> children{};
      (size > kWidestCell * ltc.width() ? ChildrenByEdges : ChildrenByPoints)(ltc, lobes.glossy_weight(k), level, x, y,
                                                                              children);
      d = Four::load_aligned(children.data());
    } else {
      const Four px = along(ltc.x()), py = along(ltc.y()), pz = along(ltc.z());
      const Four square = xsimd::fma(px, px, xsimd::fma(py, py, pz * pz));
      d = lobes.glossy_weight(k) * ltc.determinant() * area * kInvPi * xsimd::max(pz, zero) / (square * square);
    }
    sum += xsimd::select(visible, d, zero);
  }
  alignas(16) std::array<float, 4> result;
  sum.store_aligned(result.data());
  return result;
}

}  // namespace lodestar::product
