// Affine and projective 4x4 transforms, column vectors (p' = M p), with the inverse kept beside the matrix.
#pragma once

#include <array>

#include "core/math/bounds.h"
#include "core/math/vec.h"

namespace lodestar {

class Transform {
 public:
  using Matrix = std::array<std::array<double, 4>, 4>;  // [row][column]

  Transform();                          // identity
  explicit Transform(const Matrix& m);  // inverse is all zero where m is singular: see Invertible()
  Transform(const Matrix& m, const Matrix& inverse) : m_(m), inverse_(inverse) {}

  static Transform Translate(Vec3 delta);
  static Transform Scale(Vec3 scale);
  static Transform Rotate(float degrees, Vec3 axis);
  // Camera-from-world, as pbrt's LookAt: left-handed, +z looks from eye to target.
  static Transform LookAt(Vec3 eye, Vec3 target, Vec3 up);

  friend Transform operator*(const Transform& a, const Transform& b);  // first b, then a
  Transform Inverse() const { return Transform(inverse_, m_); }
  bool Invertible() const;
  bool IsIdentity() const;
  // True where the upper 3x3 has a negative determinant.
  bool SwapsHandedness() const;

  Vec3 Point(Vec3 p) const;
  Vec3 Vector(Vec3 v) const;
  Vec3 Normal(Vec3 n) const;  // by the inverse transpose; not normalized
  Bounds3 Bounds(const Bounds3& b) const;

  const Matrix& matrix() const { return m_; }
  const Matrix& inverse_matrix() const { return inverse_; }
  friend bool operator==(const Transform&, const Transform&) = default;

 private:
  Matrix m_, inverse_;
};

}  // namespace lodestar
