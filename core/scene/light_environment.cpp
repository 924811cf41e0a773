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

EnvironmentLight::EnvironmentLight(const std::vector<Rgb>& pixels, int size, const Transform& world_from_light)
    : size_(size) {
  LODESTAR_CHECK(size > 0 && pixels.size() == size_t(size) * size);
  std::vector<float> weights;
  weights.reserve(pixels.size());
  double sum[3] = {0, 0, 0};
  for (const Rgb& p : pixels) {
    weights.push_back((p.r + p.g + p.b) * (1 / 3.0f));
    for (int c = 0; c < 3; ++c) sum[c] += p[c];
  }
  distribution_ = PiecewiseConstant2D(weights, size, size);
  for (size_t i = 0; i < pixels.size(); ++i)
    texels_.push_back({pixels[i], distribution_.Density(weights[i]) * kUniformSpherePdf});
  for (int c = 0; c < 3; ++c) mean_[c] = static_cast<float>(sum[c] / double(pixels.size()));
  // A rotation (and perhaps a mirror): made orthonormal, since files carry scales and rounding.
  const Vec3 x = Normalize(world_from_light.Vector({1, 0, 0}));
  const Vec3 y0 = world_from_light.Vector({0, 1, 0}), y = Normalize(y0 - x * Dot(x, y0));
  const Vec3 z0 = world_from_light.Vector({0, 0, 1}), z = FaceForward(Cross(x, y), z0);
  world_from_light_ = {x, y, z};
  light_from_world_ = {Vec3{x.x, y.x, z.x}, Vec3{x.y, y.y, z.y}, Vec3{x.z, y.z, z.z}};
}

EnvironmentLight::Value EnvironmentLight::Evaluate(Vec3 wi) const {
  if (size_ == 0) return {mean_, kUniformSpherePdf};
  const Vec3 local = light_from_world_[0] * wi.x + light_from_world_[1] * wi.y + light_from_world_[2] * wi.z;
  const Vec2 square = DirectionToOctahedral(local);
  const auto x = std::min(static_cast<uint32_t>(square.x * float(size_)), uint32_t(size_ - 1));
  const auto y = std::min(static_cast<uint32_t>(square.y * float(size_)), uint32_t(size_ - 1));
  return texels_[size_t{y} * size_ + x];
}

Vec3 EnvironmentLight::Sample(Vec2 u, Value* value) const {
  if (size_ == 0) {
    *value = {mean_, kUniformSpherePdf};
    return SquareToSphere(u);
  }
  const auto sampled = distribution_.Sample(u);
  *value = texels_[size_t{sampled.cell_y} * size_ + sampled.cell_x];
  const Vec3 local = OctahedralToDirection(sampled.p);
  return Normalize(world_from_light_[0] * local.x + world_from_light_[1] * local.y + world_from_light_[2] * local.z);
}

}  // namespace lodestar
