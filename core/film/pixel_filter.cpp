#include "core/film/pixel_filter.h"

#include "core/math/distribution.h"
#include "core/math/elementary.h"

namespace lodestar {
namespace {

using Parameters = PixelFilter::Parameters;

constexpr int kCells = 512;
constexpr int kStepsPerCell = 8;

// Normalized Gaussian minus its value at the radius, so that it ends continuously. A far wider one than the radius is
// its limit, a parabola, as the difference would be lost to rounding; none is narrower than half a cell of the table.
float Gaussian1D(float x, float radius, float sigma) {
  if (radius < 0.01f * sigma) return 1 - Sqr(x / radius);
  sigma = std::max(sigma, radius / kCells);
  const auto value = [sigma](float d) {
    return Exp(-d * d / (2 * sigma * sigma)) / std::sqrt(2 * kPi * sigma * sigma);
  };
  return std::max(value(x) - value(radius), 0.0f);
}

// Mitchell and Netravali 1988, on [-2, 2].
float Mitchell1D(float x, float b, float c) {
  x = std::fabs(x);
  if (x >= 2) return 0;
  if (x > 1)
    return ((-b - 6 * c) * x * x * x + (6 * b + 30 * c) * x * x + (-12 * b - 48 * c) * x + (8 * b + 24 * c)) *
           (1 / 6.0f);
  return ((12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x + (6 - 2 * b)) * (1 / 6.0f);
}

float Evaluate1D(const Parameters& f, float x, float radius) {
  if (std::fabs(x) > radius) return 0;
  switch (f.kind) {
    case PixelFilter::Kind::kBox:
      return 1;
    case PixelFilter::Kind::kTriangle:
      return radius - std::fabs(x);
    case PixelFilter::Kind::kGaussian:
      return Gaussian1D(x, radius, f.sigma);
    case PixelFilter::Kind::kMitchell:
      return Mitchell1D(2 * x / radius, f.b, f.c);
  }
  return 0;
}

}  // namespace

float PixelFilter::Evaluate(const Parameters& f, Vec2 offset) {
  return Evaluate1D(f, offset.x, f.radius_x) * Evaluate1D(f, offset.y, f.radius_y);
}

PixelFilter::PixelFilter(const Parameters& parameters) : box_(parameters.kind == Kind::kBox) {
  const auto build = [&parameters, this](float radius) {
    Axis axis;
    axis.radius = radius;
    if (box_) return axis;
    std::vector<double> mass(kCells);
    std::vector<float> absolute(kCells);
    double total = 0;
    for (int i = 0; i < kCells; ++i) {
      for (int s = 0; s < kStepsPerCell; ++s) {
        const double x = ((i + (s + 0.5) / kStepsPerCell) / kCells * 2 - 1) * radius;
        mass[i] += Evaluate1D(parameters, float(x), radius);
      }
      total += mass[i];
      absolute[i] = static_cast<float>(std::fabs(mass[i]));
      axis.sign.push_back(mass[i] < 0 ? -1.0f : 1.0f);
    }
    axis.ends.resize(kCells);
    axis.guide.resize(GuidedCdf<>::Slots(kCells));
    axis.weight_scale = static_cast<float>(GuidedCdf<>::Build(absolute, axis.ends.data(), axis.guide.data()) / total);
    return axis;
  };
  x_ = build(parameters.radius_x);
  y_ = build(parameters.radius_y);
}

Vec2 PixelFilter::Axis::Sample(float u) const {
  const uint32_t cell = GuidedCdf<>::Find(ends.data(), guide.data(), kCells, u);
  return {(2 * GuidedCdf<>::Position(ends.data(), cell, kCells, u) - 1) * radius, sign[cell] * weight_scale};
}

FilterSample PixelFilter::Sample(Vec2 u) const {
  if (box_) return {{(2 * u.x - 1) * x_.radius, (2 * u.y - 1) * y_.radius}, 1};
  const Vec2 x = x_.Sample(u.x), y = y_.Sample(u.y);
  return {{x.x, y.x}, x.y * y.y};
}

}  // namespace lodestar
