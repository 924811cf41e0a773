#include "core/scene/light_environment.h"

#include "core/base/check.h"
#include "core/math/warp.h"

namespace lodestar {

Vec3 OctahedralToDirection(Vec2 square) {
  const float u = 2 * square.x - 1, v = 2 * square.y - 1;
  const float au = std::fabs(u), av = std::fabs(v);
  const float signed_distance = 1 - (au + av);  // > 0: upper hemisphere
  const float r = 1 - std::fabs(signed_distance);
  const auto [sin, cos] = SinCos(r == 0 ? 0.0f : ((av - au) / r + 1) * (kPi / 4));
  const float side = r * std::sqrt(2 - r * r);
  return {std::copysign(cos, u) * side, std::copysign(sin, v) * side, std::copysign(1 - r * r, signed_distance)};
}

Vec2 DirectionToOctahedral(Vec3 w) {
  const float x = std::fabs(w.x), y = std::fabs(w.y), z = std::fabs(w.z);
  // sqrt(1 - z), by the other coordinates: no cancellation near the poles.
  const float r = std::sqrt((x * x + y * y) / (1 + z));
  const float phi = Atan2(y, x) * (2 * kInvPi);  // [0, 1] over the quadrant
  float v = phi * r, u = r - v;
  if (w.z < 0) {
    const float swap = u;
    u = 1 - v;
    v = 1 - swap;
  }
  const auto unit = [](float t) { return std::clamp(0.5f * t + 0.5f, 0.0f, kOneMinusEpsilon); };
  return {unit(std::copysign(u, w.x)), unit(std::copysign(v, w.y))};
}

EnvironmentLight::EnvironmentLight(std::vector<Rgb> pixels, int size, const Transform& world_from_light)
    : size_(size), pixels_(std::move(pixels)) {
  LODESTAR_CHECK(size > 0 && pixels_.size() == size_t(size) * size);
  std::vector<float> weights;
  weights.reserve(pixels_.size());
  for (const Rgb& p : pixels_) weights.push_back((p.r + p.g + p.b) * (1 / 3.0f));
  distribution_ = PiecewiseConstant2D(weights, size, size);
  // A rotation (and perhaps a mirror): made orthonormal, since files carry scales and rounding.
  const Vec3 x = Normalize(world_from_light.Vector({1, 0, 0}));
  const Vec3 y0 = world_from_light.Vector({0, 1, 0}), y = Normalize(y0 - x * Dot(x, y0));
  const Vec3 z0 = world_from_light.Vector({0, 0, 1}), z = FaceForward(Cross(x, y), z0);
  world_from_light_ = {x, y, z};
  light_from_world_ = {Vec3{x.x, y.x, z.x}, Vec3{x.y, y.y, z.y}, Vec3{x.z, y.z, z.z}};
}

EnvironmentLight::Value EnvironmentLight::Evaluate(Vec3 wi) const {
  if (size_ == 0) return {constant_, kUniformSpherePdf};
  const Vec3 local = light_from_world_[0] * wi.x + light_from_world_[1] * wi.y + light_from_world_[2] * wi.z;
  const Vec2 square = DirectionToOctahedral(local);
  const auto x = std::min(static_cast<uint32_t>(square.x * float(size_)), uint32_t(size_ - 1));
  const auto y = std::min(static_cast<uint32_t>(square.y * float(size_)), uint32_t(size_ - 1));
  return {pixels_[size_t{y} * size_ + x], distribution_.PdfOfCell(x, y) * kUniformSpherePdf};
}

Vec3 EnvironmentLight::Sample(Vec2 u, Value* value) const {
  if (size_ == 0) {
    *value = {constant_, kUniformSpherePdf};
    return SquareToSphere(u);
  }
  const auto sampled = distribution_.Sample(u);
  *value = {pixels_[size_t{sampled.cell_y} * size_ + sampled.cell_x], sampled.pdf * kUniformSpherePdf};
  const Vec3 local = OctahedralToDirection(sampled.p);
  return Normalize(world_from_light_[0] * local.x + world_from_light_[1] * local.y + world_from_light_[2] * local.z);
}

Rgb EnvironmentLight::mean() const {
  if (size_ == 0) return constant_;
  double sum[3] = {0, 0, 0};
  for (const Rgb& p : pixels_)
    for (int c = 0; c < 3; ++c) sum[c] += p[c];
  const double n = double(pixels_.size());
  return {float(sum[0] / n), float(sum[1] / n), float(sum[2] / n)};
}

}  // namespace lodestar
