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

Rgb IrradianceFromAbove(const std::vector<Rgb>& pixels, int size) {
  // Cosines at the middles of 4 x 4 parts of each pixel: one in the middle of all is 0.1 % off at 64 x 64 pixels.
  constexpr int kParts = 4;
  const float scale = 2 / static_cast<float>(size * kParts);
  double sum[3] = {0, 0, 0};
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      float cosine = 0;
      for (int part = 0; part < kParts * kParts; ++part) {
        const float u = (static_cast<float>(x * kParts + part % kParts) + 0.5f) * scale - 1,
                    v = (static_cast<float>(y * kParts + part / kParts) + 0.5f) * scale - 1;
        const float r = std::fabs(u) + std::fabs(v);  // above 1: the lower hemisphere
        cosine += std::max(1 - r * r, 0.0f);
      }
      for (int c = 0; c < 3; ++c) sum[c] += double{cosine} * double{pixels[size_t(y) * size_t(size) + size_t(x)][c]};
    }
  }
  const double solid_angle = 4 * double{kPi} / (double{kParts * kParts} * size * size);  // of a part
  return {static_cast<float>(sum[0] * solid_angle), static_cast<float>(sum[1] * solid_angle),
          static_cast<float>(sum[2] * solid_angle)};
}

EnvironmentLight::EnvironmentLight(const std::vector<Rgb>& pixels, int size, const Transform& world_from_light)
    : size_(static_cast<uint32_t>(size)),
      texels_(pixels.size()),
      row_ends_(size_),
      row_guide_(GuidedCdf<>::Slots(size_)),
      column_guides_(size_ * size_t{RowCdf::Slots(size_)}) {
  LODESTAR_CHECK(size > 0 && pixels.size() == size_t{size_} * size_);
  double sum[3] = {0, 0, 0};
  for (size_t i = 0; i < pixels.size(); ++i) {
    texels_[i].radiance = pixels[i];
    for (int c = 0; c < 3; ++c) sum[c] += pixels[i][c];
  }
  const auto n = static_cast<double>(pixels.size());
  for (int c = 0; c < 3; ++c) mean_[c] = static_cast<float>(sum[c] / n);
  floor_ = Mean(mean_);
  // One that is the same everywhere has nothing above its mean (but rounding).
  const auto uneven = [this](const Texel& texel) { return Weight(texel.radiance) > 1e-3f * floor_; };
  if (std::none_of(texels_.begin(), texels_.end(), uneven)) floor_ = 0;
  std::vector<float> weights(size_), rows(size_);
  for (uint32_t y = 0; y < size_; ++y) {
    Texel* texels = &texels_[size_t{y} * size_];
    for (uint32_t x = 0; x < size_; ++x) weights[x] = Weight(texels[x].radiance);
    rows[y] =
        static_cast<float>(RowCdf::Build(weights, &texels[0].end, &column_guides_[y * size_t{RowCdf::Slots(size_)}]));
  }
  const double total = GuidedCdf<>::Build(rows, row_ends_.data(), row_guide_.data());
  density_ = total > 0 ? static_cast<float>(n / total * double{kUniformSpherePdf}) : 0;
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
  const auto x = std::min(static_cast<uint32_t>(square.x * float(size_)), size_ - 1);
  const auto y = std::min(static_cast<uint32_t>(square.y * float(size_)), size_ - 1);
  return ValueOf(texels_[size_t{y} * size_ + x]);
}

Vec3 EnvironmentLight::Sample(Vec2 u, Value* value) const {
  if (size_ == 0) {
    *value = {mean_, kUniformSpherePdf};
    return SquareToSphere(u);
  }
  const uint32_t y = GuidedCdf<>::Find(row_ends_.data(), row_guide_.data(), size_, u.y);
  const Texel* row = &texels_[size_t{y} * size_];
  const uint32_t x = RowCdf::Find(&row->end, &column_guides_[y * size_t{RowCdf::Slots(size_)}], size_, u.x);
  *value = ValueOf(row[x]);
  const Vec3 local = OctahedralToDirection(
      {RowCdf::Position(&row->end, x, size_, u.x), GuidedCdf<>::Position(row_ends_.data(), y, size_, u.y)});
  return Normalize(world_from_light_[0] * local.x + world_from_light_[1] * local.y + world_from_light_[2] * local.z);
}

size_t EnvironmentLight::memory_bytes() const {
  return texels_.size() * sizeof(Texel) + row_ends_.size() * sizeof(float) +
         (row_guide_.size() + column_guides_.size()) * sizeof(uint16_t);
}

}  // namespace lodestar
