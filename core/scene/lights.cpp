#include "core/scene/lights.h"

#include "core/math/warp.h"

namespace lodestar {
namespace {

// Small emission must not vanish in the table, nor huge emission overflow its sum.
double Power(Rgb c) {
  return double(c.r) + double(c.g) + double(c.b);
}

}  // namespace

// ---- compile ----

int32_t LightTable::AddArea(Light light, const Emission& emission, double area) {
  light.two_sided = emission.two_sided;
  light.hidden = emission.hidden;
  light.radiance = emission.radiance;
  light.power = Power(emission.radiance) * double(kPi) * area * (emission.two_sided ? 2 : 1);
  has_area_lights_ |= !emission.hidden;
  lights_.push_back(light);
  return static_cast<int32_t>(lights_.size()) - 1;
}

int32_t LightTable::AddTriangle(const LightTriangle& triangle, const Emission& emission, const TriangleUvs& uvs) {
  Light light(Kind::kTriangle);
  light.triangle = triangle;
  light.extent = std::max(MaxComponent(Abs(triangle.e1)), MaxComponent(Abs(triangle.e2)));
  if (!emission.hidden && (emission.alpha.texture >= 0 || emission.alpha.value < 1)) {
    light.side = static_cast<int32_t>(alphas_.size());
    alphas_.push_back({emission.alpha, uvs});
  }
  return AddArea(light, emission, triangle.area);
}

int32_t LightTable::AddSphere(const Quadric& q, const Emission& emission) {
  Light light(Kind::kSphere);
  const auto& m = q.group_from_object.m;
  light.triangle.p0 = ToVec3(q.group_from_object.Point(0, 0, 0));
  light.extent = q.scale;
  light.reversed = q.reverse;
  // A similarity keeps the sphere a sphere.
  const Vec3 x{float(m[0]), float(m[4]), float(m[8])}, y{float(m[1]), float(m[5]), float(m[9])},
      z{float(m[2]), float(m[6]), float(m[10])};
  const float xx = Dot(x, x), yy = Dot(y, y), zz = Dot(z, z), tolerance = 1e-5f * xx;
  const bool similar = std::fabs(xx - yy) < tolerance && std::fabs(xx - zz) < tolerance && AbsDot(x, y) < tolerance &&
                       AbsDot(y, z) < tolerance && AbsDot(z, x) < tolerance;
  double area = 4 * double(kPi) * q.radius * q.radius * xx;
  if (!similar) {
    light.kind = Kind::kEllipsoid;
    light.side = static_cast<int32_t>(quadrics_.size());
    quadrics_.push_back(q);
    // Thomsen's formula for the surface, within about a per cent: it only steers the picking.
    const float p = 1.6075f, a = Pow(std::sqrt(xx), p), b = Pow(std::sqrt(yy), p), c = Pow(std::sqrt(zz), p);
    area = 4 * double(kPi) * q.radius * q.radius * Pow((a * b + b * c + c * a) / 3, 1 / p);
  }
  return AddArea(light, emission, area);
}

int32_t LightTable::AddDisk(const Quadric& q, const Emission& emission) {
  Light light(Kind::kDisk);
  LightTriangle& t = light.triangle;
  t.p0 = ToVec3(q.group_from_object.Point(0, 0, q.height));
  t.e1 = ToVec3(q.group_from_object.Vector(q.radius, 0, 0));
  t.e2 = ToVec3(q.group_from_object.Vector(0, q.radius, 0));
  t.n = Normalize(ToVec3(q.object_from_group.Transposed(0, 0, q.reverse ? -1 : 1)));
  light.cos_start = static_cast<float>(q.inner_radius / q.radius);
  t.area = kPi * Length(Cross(t.e1, t.e2)) * (1 - Sqr(light.cos_start));
  light.extent = q.scale;
  return AddArea(light, emission, t.area);
}

void LightTable::AddPoint(const PointLight& l) {
  Light light(Kind::kPoint);
  light.radiance = l.intensity;
  light.triangle.p0 = l.from;
  light.power = 4 * double(kPi) * Power(l.intensity);
  lights_.push_back(light);
}

void LightTable::AddSpot(const SpotLight& l) {
  Light light(Kind::kSpot);
  light.radiance = l.intensity;
  light.triangle.p0 = l.from;
  light.triangle.n = Normalize(l.to - l.from);
  light.cos_total = SinCos(Radians(l.cone_angle)).cos;
  light.cos_start = SinCos(Radians(std::max(l.cone_angle - l.cone_delta, 0.0f))).cos;
  // The smooth step averages a half between the two cosines.
  light.power = 2 * double(kPi) * Power(l.intensity) * (1 - 0.5 * (double(light.cos_total) + light.cos_start));
  lights_.push_back(light);
}

void LightTable::AddDistant(const DistantLight& l) {
  Light light(Kind::kDistant);
  light.radiance = l.radiance;
  light.triangle.n = Normalize(l.to_light);
  light.power = Power(l.radiance);  // times the scene's disk in Finish
  lights_.push_back(light);
}

void LightTable::AddEnvironment(EnvironmentLight environment) {
  Light light(Kind::kEnvironment);
  light.side = static_cast<int32_t>(environments_.size());
  light.power = 4 * double(kPi) * Power(environment.mean());
  environments_.push_back(std::move(environment));
  lights_.push_back(light);
}

void LightTable::Finish(const Bounds3& bounds) {
  if (lights_.empty()) return;
  const double radius = bounds.empty() ? 1 : 0.5 * double(Length(bounds.Diagonal()));
  double total = 0;
  size_t shining = 0;
  for (Light& l : lights_) {
    if (l.kind == Kind::kDistant || l.kind == Kind::kEnvironment) l.power *= double(kPi) * radius * radius;
    total += l.power;
    shining += l.power > 0;
  }
  environment_pick_.assign(environments_.size(), 0);
  if (shining == 0) {  // black lights only: nothing to sample
    table_ = {};
    groups_ = {};
    return;
  }
  std::vector<double> weights;
  for (const Light& l : lights_) weights.push_back(l.power > 0 ? 0.99 * (l.power / total) + 0.01 / double(shining) : 0);
  table_ = AliasTable(weights);
  for (size_t i = 0; i < lights_.size(); ++i) {
    lights_[i].pick = table_.Pmf(static_cast<uint32_t>(i));
    if (lights_[i].kind == Kind::kEnvironment) environment_pick_[lights_[i].side] = lights_[i].pick;
  }
  weights.clear();
  for (size_t i = 0; i < lights_.size(); ++i) {
    const Light& l = lights_[i];
    const bool delta = l.kind == Kind::kPoint || l.kind == Kind::kSpot || l.kind == Kind::kDistant;
    if (!(l.power > 0) || !(delta || l.hidden)) continue;
    unseen_.push_back(static_cast<uint32_t>(i));
    weights.push_back(l.pick);
  }
  if (!unseen_.empty()) unseen_table_ = AliasTable(weights);
  using Place = LightGroups::Light::Place;
  std::vector<LightGroups::Light> placed;
  for (const Light& l : lights_) {
    const LightTriangle& t = l.triangle;
    placed.push_back({l.kind == Kind::kEnvironment ? Place::kEnvironment
                      : l.kind == Kind::kDistant   ? Place::kDistant
                                                   : Place::kSpatial,
                      l.kind == Kind::kTriangle ? t.p0 + (t.e1 + t.e2) / 3 : t.p0, l.extent, l.pick});
  }
  groups_ = LightGroups(placed);
}

// ---- use ----

std::optional<LightSample> LightTable::Sample(const TextureTable& textures, Vec3 p, double u_pick, Vec2 u,
                                              LightGroupWeights weights) const {
  if (table_.size() == 0) return {};
  if (weights.empty()) return SampleOne(lights_[table_.Sample(u_pick)], textures, p, u);
  const LightGroups::Choice choice = groups_.Sample(weights, u_pick);
  auto sample = SampleOne(lights_[choice.light], textures, p, u);
  if (sample) {
    sample->pdf *= choice.ratio;
    sample->group = choice.group;
  }
  return sample;
}

std::optional<LightSample> LightTable::SampleUnseen(const TextureTable& textures, Vec3 p, double u_pick, Vec2 u) const {
  if (unseen_.empty()) return {};
  const uint32_t at = unseen_table_.Sample(u_pick);
  const Light& light = lights_[unseen_[at]];
  auto sample = SampleOne(light, textures, p, u);
  if (sample) sample->pdf *= unseen_table_.Pmf(at) / light.pick;
  return sample;
}

std::optional<LightSample> LightTable::SampleOne(const Light& light, const TextureTable& textures, Vec3 p,
                                                 Vec2 u) const {
  switch (light.kind) {
    case Kind::kTriangle:
    case Kind::kSphere:
    case Kind::kEllipsoid:
    case Kind::kDisk:
      return SampleArea(light, textures, p, u);
    case Kind::kEnvironment:
      return SampleEnvironment(light, u);
    case Kind::kPoint:
    case Kind::kSpot:
    case Kind::kDistant:
      return SampleDelta(light, p);
  }
  return {};
}

std::optional<LightSample> LightTable::SampleArea(const Light& light, const TextureTable& textures, Vec3 p,
                                                  Vec2 u) const {
  const LightTriangle& t = light.triangle;
  std::optional<DirectionSample> d;
  Vec3 n = t.n;
  switch (light.kind) {
    case Kind::kTriangle:
      if (!light.two_sided && !(Dot(n, p - t.p0) > 0)) return {};
      d = SampleLightTriangle(t, p, u);
      break;
    case Kind::kSphere:
      d = SampleLightSphere(t.p0, light.extent, p, u, &n);
      if (light.reversed) n = -n;
      break;
    case Kind::kEllipsoid:
      d = SampleEllipsoid(light, p, u, &n);
      break;
    default: {  // disk, by area; the hole widens the map's radius
      Vec2 x = SquareToDisk(u);
      if (light.cos_start > 0) {
        const float r2 = x.x * x.x + x.y * x.y, hole = Sqr(light.cos_start);
        x = r2 > 0 ? x * std::sqrt((hole + (1 - hole) * r2) / r2) : Vec2{light.cos_start, 0};
      }
      const Vec3 point = t.p0 + t.e1 * x.x + t.e2 * x.y, offset = point - p;
      const float d2 = LengthSquared(offset), distance = std::sqrt(d2), cos_d = AbsDot(n, offset);
      if (!(cos_d > 0)) return {};
      d = DirectionSample{offset / distance, point, d2 * distance / (cos_d * t.area)};
    }
  }
  if (!d || !std::isfinite(d->pdf)) return {};
  const float cosine = -Dot(n, d->wi);
  if (!light.two_sided && !(cosine > 0)) return {};
  LightSample sample;
  sample.wi = d->wi;
  sample.radiance = light.radiance;
  sample.pdf = d->pdf * light.pick;
  sample.delta = light.hidden;
  if (light.kind == Kind::kTriangle && light.side >= 0) {
    const Alpha& alpha = alphas_[light.side];
    // Barycentrics of the point, for its opacity.
    const Vec3 q = d->point - t.p0;
    const float d11 = Dot(t.e1, t.e1), d12 = Dot(t.e1, t.e2), d22 = Dot(t.e2, t.e2), q1 = Dot(q, t.e1),
                q2 = Dot(q, t.e2);
    const float inverse = 1 / (d11 * d22 - d12 * d12), b = (d22 * q1 - d12 * q2) * inverse,
                c = (d11 * q2 - d12 * q1) * inverse;
    const Vec2 uv = alpha.uvs.a * (1 - b - c) + alpha.uvs.b * b + alpha.uvs.c * c;
    sample.radiance *= std::clamp(textures.Evaluate(alpha.alpha, uv), 0.0f, 1.0f);
    if (IsBlack(sample.radiance)) return {};
  }
  // Off the light by its own error and what a test along the whole way there rounds.
  const float pull =
      kPointFactor * MaxComponent(Abs(d->point)) + kExtentFactor * light.extent + 8 * kRound * Length(d->point - p);
  sample.target = d->point + n * (cosine > 0 ? pull : -pull);
  return sample;
}

std::optional<DirectionSample> LightTable::SampleEllipsoid(const Light& light, Vec3 p, Vec2 u, Vec3* n) const {
  const Quadric& q = quadrics_[light.side];
  const Vec3 unit = SquareToSphere(u);
  const Vec3 point = ToVec3(q.group_from_object.Point(unit.x * q.radius, unit.y * q.radius, unit.z * q.radius));
  *n = Normalize(ToVec3(q.object_from_group.Transposed(unit.x, unit.y, unit.z)));
  if (light.reversed) *n = -*n;
  const Vec3 offset = point - p;
  const float pdf = EllipsoidPdf(light, offset, point, *n);
  if (!(pdf > 0) || !std::isfinite(pdf)) return {};
  return DirectionSample{Normalize(offset), point, pdf};
}

// Uniform on the object's sphere; an area element stretches by |det M| |M^-T n|.
float LightTable::EllipsoidPdf(const Light& light, Vec3 offset, Vec3 point, Vec3 n) const {
  const Quadric& q = quadrics_[light.side];
  const auto object = q.object_from_group.Point(point.x, point.y, point.z);
  const double length = std::sqrt(object[0] * object[0] + object[1] * object[1] + object[2] * object[2]);
  const auto cofactor = q.object_from_group.Transposed(object[0] / length, object[1] / length, object[2] / length);
  const auto& m = q.group_from_object.m;
  const double determinant =
      m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
  const double stretch = std::fabs(determinant) *
                         std::sqrt(cofactor[0] * cofactor[0] + cofactor[1] * cofactor[1] + cofactor[2] * cofactor[2]);
  const double pdf_area = 1 / (4 * double(kPi) * q.radius * q.radius * stretch);
  const float d2 = LengthSquared(offset);
  return static_cast<float>(pdf_area) * d2 * std::sqrt(d2) / AbsDot(n, offset);
}

std::optional<LightSample> LightTable::SampleDelta(const Light& light, Vec3 p) const {
  LightSample sample;
  sample.delta = true;
  sample.pdf = light.pick;
  if (light.kind == Kind::kDistant) {
    sample.wi = light.triangle.n;
    sample.radiance = light.radiance;
    sample.infinite = true;
    return sample;
  }
  const Vec3 offset = light.triangle.p0 - p;
  const float d2 = LengthSquared(offset);
  if (!(d2 > 0)) return {};
  sample.wi = offset * (1 / std::sqrt(d2));
  sample.target = light.triangle.p0;
  float falloff = 1;
  if (light.kind == Kind::kSpot) {
    const float cosine = -Dot(sample.wi, light.triangle.n);
    const float x = light.cos_start > light.cos_total
                        ? std::clamp((cosine - light.cos_total) / (light.cos_start - light.cos_total), 0.0f, 1.0f)
                        : (cosine >= light.cos_total ? 1.0f : 0.0f);
    falloff = x * x * (3 - 2 * x);
    if (falloff == 0) return {};
  }
  sample.radiance = light.radiance * (falloff / d2);
  return sample;
}

LightSample LightTable::SampleEnvironment(const Light& light, Vec2 u) const {
  LightSample sample;
  EnvironmentLight::Value value;
  sample.wi = environments_[light.side].Sample(u, &value);
  sample.infinite = true;
  sample.radiance = value.radiance;
  sample.pdf = value.pdf * light.pick;
  // Several infinite lights are one strategy: their sum, and the density of reaching the direction through any.
  for (size_t i = 0; environments_.size() > 1 && i < environments_.size(); ++i) {
    if (static_cast<int32_t>(i) == light.side) continue;
    const auto other = environments_[i].Evaluate(sample.wi);
    sample.radiance += other.radiance;
    sample.pdf += other.pdf * environment_pick_[i];
  }
  return sample;
}

float LightTable::Pdf(Vec3 from, const SurfaceInteraction& si) const {
  const Light& light = lights_[si.light];
  const Vec3 offset = si.p - from;
  switch (light.kind) {
    case Kind::kTriangle:
      return LightTrianglePdf(light.triangle, from, offset) * light.pick;
    case Kind::kSphere:
      return LightSpherePdf(light.triangle.p0, light.extent, from, offset, si.ng) * light.pick;
    case Kind::kEllipsoid:
      return EllipsoidPdf(light, offset, si.p, si.ng) * light.pick;
    case Kind::kDisk: {
      const float d2 = LengthSquared(offset);
      return d2 * std::sqrt(d2) / (AbsDot(si.ng, offset) * light.triangle.area) * light.pick;
    }
    default:
      return 0;
  }
}

EnvironmentSample LightTable::Environment(Vec3 wi) const {
  EnvironmentSample sum;
  for (size_t i = 0; i < environments_.size(); ++i) {
    const auto value = environments_[i].Evaluate(wi);
    sum.radiance += value.radiance;
    sum.pdf += value.pdf * environment_pick_[i];
  }
  return sum;
}

size_t LightTable::memory_bytes() const {
  size_t bytes = lights_.capacity() * sizeof(Light) + alphas_.capacity() * sizeof(Alpha) + table_.size() * 12 +
                 groups_.memory_bytes();
  for (const auto& e : environments_) bytes += e.memory_bytes();
  return bytes;
}

}  // namespace lodestar
