#include "core/guiding/grid_bias.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/math/sampler.h"

namespace lodestar {
namespace {

constexpr uint32_t kPlaces = 2048;
constexpr int kSide = 32;  // points of a quadrature, over each coordinate of the hemisphere's square

// The density over that of cosine-weighted directions, at the square's even points.
double Integral(const GridSampling& sampling, const GridSampling::Local& local) {
  double sum = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2 at{(static_cast<float>(i / kSide) + 0.5f) / kSide, (static_cast<float>(i % kSide) + 0.5f) / kSide};
    const Vec3 w = HemisphereToDirection(at);
    sum += sampling.Pdf(local, local.frame.ToWorld(w)) * kPi / w.z;
  }
  return sum / (kSide * kSide);
}

}  // namespace

std::optional<GridIntegrals> MeasureIntegrals(const GridSampling& sampling) {
  LODESTAR_CHECK(!sampling.rules().on_sphere());
  double sum = 0, squares = 0, count = 0;
  for (uint32_t place = 0; place < kPlaces; ++place) {
    Sampler sampler(0, place, 0, 0);
    const Vec3 n = SquareToSphere(sampler.Next2D());
    const uint32_t cells = sampling.grid().cell_count();
    const auto cell = static_cast<uint32_t>(sampler.Next2D().x * static_cast<float>(cells));
    const GridSampling::Local local = sampling.At(std::min(cell, cells - 1), n);
    if (!local.usable) continue;
    const double integral = Integral(sampling, local);
    sum += integral;
    squares += integral * integral;
    ++count;
  }
  if (count == 0) return std::nullopt;
  const double mean = sum / count;
  return GridIntegrals{mean, std::sqrt(std::max(0.0, squares / count - mean * mean))};
}

}  // namespace lodestar
