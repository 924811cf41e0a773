#include "core/math/primaries.h"

#include <algorithm>
#include <cmath>

namespace lodestar {
namespace {

using Matrix = std::array<double, 9>;  // rows
using Column = std::array<double, 3>;

Column operator*(const Matrix& m, const Column& v) {
  Column product{};
  for (int row = 0; row < 3; ++row) product[row] = m[3 * row] * v[0] + m[3 * row + 1] * v[1] + m[3 * row + 2] * v[2];
  return product;
}
Matrix operator*(const Matrix& a, const Matrix& b) {
  Matrix product{};
  for (int column = 0; column < 3; ++column) {
    const Column c = a * Column{b[column], b[3 + column], b[6 + column]};
    for (int row = 0; row < 3; ++row) product[3 * row + column] = c[row];
  }
  return product;
}
Matrix Diagonal(const Column& d) {
  return {d[0], 0, 0, 0, d[1], 0, 0, 0, d[2]};
}

std::optional<Matrix> Inverse(const Matrix& m) {
  const auto minor = [&m](int r0, int c0, int r1, int c1) {
    return m[3 * r0 + c0] * m[3 * r1 + c1] - m[3 * r0 + c1] * m[3 * r1 + c0];
  };
  const double determinant = m[0] * minor(1, 1, 2, 2) - m[1] * minor(1, 0, 2, 2) + m[2] * minor(1, 0, 2, 1);
  if (!(std::abs(determinant) > 1e-9)) return std::nullopt;
  Matrix inverse{minor(1, 1, 2, 2),  -minor(0, 1, 2, 2), minor(0, 1, 1, 2),  -minor(1, 0, 2, 2), minor(0, 0, 2, 2),
                 -minor(0, 0, 1, 2), minor(1, 0, 2, 1),  -minor(0, 0, 2, 1), minor(0, 0, 1, 1)};
  for (double& v : inverse) v /= determinant;
  return inverse;
}

// XYZ of unit luminance.
std::optional<Column> WhiteOf(const Chromaticities& space) {
  const double x = space[6], y = space[7];
  if (!(y > 1e-6) || !std::isfinite(x)) return std::nullopt;
  return Column{x / y, 1, (1 - x - y) / y};
}

// SMPTE RP 177-1993: the primaries weighted so that their sum is white.
std::optional<Matrix> XyzFromRgb(const Chromaticities& space) {
  Matrix primaries{};
  for (int c = 0; c < 3; ++c) {
    const double x = space[2 * c], y = space[2 * c + 1];
    primaries[c] = x;
    primaries[3 + c] = y;
    primaries[6 + c] = 1 - x - y;
  }
  const auto white = WhiteOf(space);
  const auto inverse = Inverse(primaries);
  if (!white || !inverse) return std::nullopt;
  return primaries * Diagonal(*inverse * *white);
}

Matrix Adaptation(const Column& from, const Column& to) {
  constexpr Matrix kCones{0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296};
  const Column a = kCones * from, b = kCones * to;
  return *Inverse(kCones) * Diagonal({b[0] / a[0], b[1] / a[1], b[2] / a[2]}) * kCones;
}

}  // namespace

Rgb PrimariesMatrix::operator()(Rgb c) const {
  const Column v = m_ * Column{c.r, c.g, c.b};
  return {std::max(static_cast<float>(v[0]), 0.0f), std::max(static_cast<float>(v[1]), 0.0f),
          std::max(static_cast<float>(v[2]), 0.0f)};
}

std::optional<PrimariesMatrix> ToRec709(const Chromaticities& from, WhitePoint white) {
  const auto xyz = XyzFromRgb(from);
  if (!xyz) return std::nullopt;
  const Matrix ours = *Inverse(*XyzFromRgb(kRec709));
  PrimariesMatrix result;
  result.m_ = white == WhitePoint::kKept ? ours * *xyz : ours * Adaptation(*WhiteOf(from), *WhiteOf(kRec709)) * *xyz;
  return result;
}

}  // namespace lodestar
