// Small vectors. Vec3 serves for points, directions and normals: the names of variables say which.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace lodestar {

inline constexpr float kPi = 3.14159265358979323846f;
inline constexpr float kInvPi = 0.31830988618379067154f;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;  // the largest float below 1

struct Vec2 {
  float x = 0, y = 0;
  friend Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
  friend Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
  friend Vec2 operator*(Vec2 a, float s) { return {a.x * s, a.y * s}; }
  friend bool operator==(Vec2, Vec2) = default;
};

struct Vec3 {
  float x = 0, y = 0, z = 0;
  float operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  float& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  friend Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
  friend Vec3 operator*(Vec3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
  friend Vec3 operator*(float s, Vec3 a) { return a * s; }
  friend Vec3 operator*(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
  friend Vec3 operator/(Vec3 a, float s) { return a * (1 / s); }
  Vec3& operator+=(Vec3 b) { return *this = *this + b; }
  Vec3& operator*=(float s) { return *this = *this * s; }
  friend bool operator==(Vec3, Vec3) = default;
};

inline float Dot(Vec3 a, Vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline float AbsDot(Vec3 a, Vec3 b) {
  return std::fabs(Dot(a, b));
}
inline Vec3 Cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float LengthSquared(Vec3 a) {
  return Dot(a, a);
}
inline float Length(Vec3 a) {
  return std::sqrt(LengthSquared(a));
}
inline Vec3 Normalize(Vec3 a) {
  return a * (1 / Length(a));
}
inline Vec3 Min(Vec3 a, Vec3 b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
inline Vec3 Max(Vec3 a, Vec3 b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
inline Vec3 Abs(Vec3 a) {
  return {std::fabs(a.x), std::fabs(a.y), std::fabs(a.z)};
}
inline float MaxComponent(Vec3 a) {
  return std::max(a.x, std::max(a.y, a.z));
}
inline bool IsFinite(Vec3 a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}
inline Vec3 FaceForward(Vec3 n, Vec3 towards) {
  return Dot(n, towards) < 0 ? -n : n;
}
inline float Lerp(float t, float a, float b) {
  return (1 - t) * a + t * b;
}
inline Vec3 Lerp(float t, Vec3 a, Vec3 b) {
  return a * (1 - t) + b * t;
}
inline float Sqr(float x) {
  return x * x;
}
inline float SafeSqrt(float x) {
  return std::sqrt(std::max(x, 0.0f));
}

}  // namespace lodestar
