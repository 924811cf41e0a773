#include "core/math/transform.h"

#include "core/math/elementary.h"

namespace lodestar {
namespace {

constexpr Transform::Matrix kIdentity{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};

Transform::Matrix Multiply(const Transform::Matrix& a, const Transform::Matrix& b) {
  Transform::Matrix c{};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 4; ++k) c[i][j] += a[i][k] * b[k][j];
  return c;
}

// Gauss-Jordan with partial pivoting; all zero when singular.
Transform::Matrix InvertMatrix(const Transform::Matrix& m) {
  Transform::Matrix a = m, inverse = kIdentity;
  for (int column = 0; column < 4; ++column) {
    int pivot = column;
    for (int row = column + 1; row < 4; ++row)
      if (std::fabs(a[row][column]) > std::fabs(a[pivot][column])) pivot = row;
    if (!(std::fabs(a[pivot][column]) > 0)) return {};
    std::swap(a[pivot], a[column]);
    std::swap(inverse[pivot], inverse[column]);
    const double scale = 1 / a[column][column];
    for (int j = 0; j < 4; ++j) {
      a[column][j] *= scale;
      inverse[column][j] *= scale;
    }
    for (int row = 0; row < 4; ++row) {
      if (row == column) continue;
      const double factor = a[row][column];
      for (int j = 0; j < 4; ++j) {
        a[row][j] -= factor * a[column][j];
        inverse[row][j] -= factor * inverse[column][j];
      }
    }
  }
  return inverse;
}

}  // namespace

Transform::Transform() : m_(kIdentity), inverse_(kIdentity) {}
Transform::Transform(const Matrix& m) : m_(m), inverse_(InvertMatrix(m)) {}

Transform Transform::Translate(Vec3 d) {
  Matrix m = kIdentity, inverse = kIdentity;
  for (int i = 0; i < 3; ++i) {
    m[i][3] = d[i];
    inverse[i][3] = -static_cast<double>(d[i]);
  }
  return {m, inverse};
}

Transform Transform::Scale(Vec3 s) {
  Matrix m = kIdentity;
  for (int i = 0; i < 3; ++i) m[i][i] = s[i];
  return Transform(m);
}

Transform Transform::Rotate(float degrees, Vec3 axis) {
  const Vec3 a = Normalize(axis);
  const auto [s, c] = SinCos(Radians(degrees));
  Matrix m = kIdentity;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m[i][j] = double(a[i]) * a[j] * (1.0 - c) + (i == j ? double(c) : 0.0);
  m[0][1] -= double(a.z) * s;
  m[0][2] += double(a.y) * s;
  m[1][0] += double(a.z) * s;
  m[1][2] -= double(a.x) * s;
  m[2][0] -= double(a.y) * s;
  m[2][1] += double(a.x) * s;
  return Transform(m);
}

Transform Transform::LookAt(Vec3 eye, Vec3 target, Vec3 up) {
  const Vec3 dir = Normalize(target - eye);
  const Vec3 right = Normalize(Cross(Normalize(up), dir));
  const Vec3 new_up = Cross(dir, right);
  Matrix world_from_camera = kIdentity;
  for (int i = 0; i < 3; ++i) {
    world_from_camera[i][0] = right[i];
    world_from_camera[i][1] = new_up[i];
    world_from_camera[i][2] = dir[i];
    world_from_camera[i][3] = eye[i];
  }
  return Transform(world_from_camera).Inverse();
}

Transform operator*(const Transform& a, const Transform& b) {
  return {Multiply(a.m_, b.m_), Multiply(b.inverse_, a.inverse_)};
}

bool Transform::Invertible() const {
  return inverse_ != Matrix{};
}
bool Transform::IsIdentity() const {
  return m_ == kIdentity;
}

bool Transform::SwapsHandedness() const {
  const auto& m = m_;
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
             m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]) <
         0;
}

Vec3 Transform::Point(Vec3 p) const {
  double out[4];
  for (int i = 0; i < 4; ++i) out[i] = m_[i][0] * p.x + m_[i][1] * p.y + m_[i][2] * p.z + m_[i][3];
  const double w = out[3] == 1 ? 1 : 1 / out[3];
  return {float(out[0] * w), float(out[1] * w), float(out[2] * w)};
}

Vec3 Transform::Vector(Vec3 v) const {
  double out[3];
  for (int i = 0; i < 3; ++i) out[i] = m_[i][0] * v.x + m_[i][1] * v.y + m_[i][2] * v.z;
  return {float(out[0]), float(out[1]), float(out[2])};
}

Vec3 Transform::Normal(Vec3 n) const {
  double out[3];
  for (int i = 0; i < 3; ++i) out[i] = inverse_[0][i] * n.x + inverse_[1][i] * n.y + inverse_[2][i] * n.z;
  return {float(out[0]), float(out[1]), float(out[2])};
}

Bounds3 Transform::Bounds(const Bounds3& b) const {
  Bounds3 out;
  if (b.empty()) return out;
  for (int corner = 0; corner < 8; ++corner)
    out.Extend(Point({corner & 1 ? b.max.x : b.min.x, corner & 2 ? b.max.y : b.min.y, corner & 4 ? b.max.z : b.min.z}));
  return out;
}

}  // namespace lodestar
