// Linear RGB with Rec. 709 / sRGB primaries and D65 white; radiance, reflectance or importance by context.
#pragma once

#include <algorithm>
#include <cmath>

namespace lodestar {

struct Rgb {
  float r = 0, g = 0, b = 0;
  constexpr Rgb() = default;
  constexpr Rgb(float r, float g, float b) : r(r), g(g), b(b) {}
  explicit constexpr Rgb(float v) : r(v), g(v), b(v) {}
  float operator[](int c) const { return c == 0 ? r : c == 1 ? g : b; }
  float& operator[](int c) { return c == 0 ? r : c == 1 ? g : b; }
  friend Rgb operator+(Rgb a, Rgb b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
  friend Rgb operator-(Rgb a, Rgb b) { return {a.r - b.r, a.g - b.g, a.b - b.b}; }
  friend Rgb operator*(Rgb a, Rgb b) { return {a.r * b.r, a.g * b.g, a.b * b.b}; }
  friend Rgb operator/(Rgb a, Rgb b) { return {a.r / b.r, a.g / b.g, a.b / b.b}; }
  friend Rgb operator*(Rgb a, float s) { return {a.r * s, a.g * s, a.b * s}; }
  friend Rgb operator*(float s, Rgb a) { return a * s; }
  friend Rgb operator/(Rgb a, float s) { return a * (1 / s); }
  Rgb& operator+=(Rgb b) { return *this = *this + b; }
  Rgb& operator*=(Rgb b) { return *this = *this * b; }
  Rgb& operator*=(float s) { return *this = *this * s; }
  friend bool operator==(Rgb, Rgb) = default;
};

// Rec. 709 luminance.
inline float Luminance(Rgb c) {
  return 0.212671f * c.r + 0.715160f * c.g + 0.072169f * c.b;
}
inline float MaxComponent(Rgb c) {
  return std::max(c.r, std::max(c.g, c.b));
}
inline float MinComponent(Rgb c) {
  return std::min(c.r, std::min(c.g, c.b));
}
inline bool IsBlack(Rgb c) {
  return c.r == 0 && c.g == 0 && c.b == 0;
}
inline bool IsFinite(Rgb c) {
  return std::isfinite(c.r) && std::isfinite(c.g) && std::isfinite(c.b);
}
inline Rgb Clamp(Rgb c, float low, float high) {
  return {std::clamp(c.r, low, high), std::clamp(c.g, low, high), std::clamp(c.b, low, high)};
}

}  // namespace lodestar
