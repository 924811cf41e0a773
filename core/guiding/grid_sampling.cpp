#include "core/guiding/grid_sampling.h"

#include "core/base/check.h"

namespace lodestar {
namespace {

using Sampling = GridRules::Sampling;

// Attempts before a rejection gives up. An exact table is then inverted instead, which has the same density; with a
// memo there is nothing to fall back on.
constexpr int kMostAttempts = 1 << 14;
constexpr float kInvTwoPi = 0.5f * kInvPi;

// Eq. 5.2: the share of even samples that makes accepted samples of the table the most frequent.
float DocumentsMix(float acceptance) {
  return acceptance < 0.5f ? (1 - 2 * acceptance) / (2 - 2 * acceptance) : 0.0f;
}

}  // namespace

GridSampling::GridSampling(std::shared_ptr<const RadianceGrid> grid, const GridRules& rules)
    : grid_(std::move(grid)),
      rules_(rules),
      hemispheres_(GridHemispheres::Of(grid_->options().directions)),
      products_(grid_->cell_count(), kMostRemembered),
      sums_(grid_->cell_count(), kMostRemembered * 16) {
  LODESTAR_CHECK(!rules_.memo || rules_.sampling == Sampling::kRejection ||
                 rules_.sampling == Sampling::kRejectionMixed);
}

const GridSampling::Product* GridSampling::ProductAt(uint32_t cell, uint32_t normal,
                                                     std::unique_ptr<const Product>* own) const {
  return products_.Get(cell, normal, own, [&] { return MakeProduct(cell, normal); });
}

GridSampling::Product GridSampling::MakeProduct(uint32_t cell, uint32_t normal) const {
  const std::span<const float> radiances = grid_->Radiances(cell);
  const uint32_t rows = hemispheres_.rows(), columns = normal == kSphere ? 2 * rows : hemispheres_.columns();
  std::vector<double> weights(radiances.begin(), radiances.end());
  if (normal != kSphere) {
    weights.resize(size_t{rows} * columns);
    hemispheres_.Gather(normal, radiances, weights);
  }
  double sum = 0;
  for (const double w : weights) sum += w;
  const double mean = sum / static_cast<double>(weights.size());
  Product product;
  product.mean = static_cast<float>(mean);
  if (!(product.mean > 0)) return product;
  if (rules_.sampling == Sampling::kMetropolis) {
    product.target.assign(weights.begin(), weights.end());
    product.square.emplace(ChainDistribution(product.target, rows, columns), rows, columns);
    return product;
  }
  product.square.emplace(weights, rows, columns);
  if (rules_.sampling == Sampling::kRejectionMixed) {
    const double mix = rules_.mix >= 0 ? rules_.mix : DocumentsMix(1 / product.square->greatest());
    for (double& w : weights) w = (1 - mix) * (w / mean) + mix;
    product.square.emplace(weights, rows, columns);
  }
  return product;
}

GridSampling::Sums GridSampling::MakeSums(uint32_t cell, uint32_t direction) const {
  const Vec3 n = grid_->DirectionCenter(direction);
  double sum = 0;
  float greatest = 0;
  for (uint32_t d = 0; d < grid_->direction_count(); ++d) {
    const float value = grid_->Radiance(cell, d) * std::max(Dot(n, grid_->DirectionCenter(d)), 0.0f);
    sum += value;
    greatest = std::max(greatest, value);
  }
  return {static_cast<float>(std::min(sum * (4 * double{kPi} / grid_->direction_count()), 3e38)), greatest};
}

GridSampling::Local GridSampling::At(uint32_t cell, Vec3 n) const {
  Local local;
  if (rules_.memo) {
    local.cell = cell;
    local.frame = Frame::FromNormal(n);
    const uint32_t direction = grid_->DirectionAt(n);
    std::unique_ptr<const Sums> own;
    local.sums = *sums_.Get(cell, direction, &own, [&] { return MakeSums(cell, direction); });
    local.usable = local.sums.integral > 0;
    if (local.usable && rules_.sampling == Sampling::kRejectionMixed) {
      const float acceptance = local.sums.integral * kInvTwoPi / local.sums.greatest;
      local.mix = rules_.mix >= 0 ? rules_.mix : DocumentsMix(acceptance);
    }
    return local;
  }
  const uint32_t normal = rules_.on_sphere() ? kSphere : GridHemispheres::NormalAt(n);
  local.product = ProductAt(cell, normal, &local.own);
  local.usable = local.product->square.has_value();
  if (local.usable && normal != kSphere) local.frame = hemispheres_.FrameOf(normal, n);
  return local;
}

Vec3 GridSampling::Reject(const Local& local, GridRandom random, Vec2 fallback) const {
  const GridSquare& square = *local.product->square;
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    const Vec2 at = random.Next2D();
    if (random.Next2D().x * square.greatest() < square.Density(at))
      return local.frame.ToWorld(HemisphereToDirection(at));
  }
  return local.frame.ToWorld(HemisphereToDirection(square.Sample(fallback).at));
}

// Algorithms 3 and 4.
Vec3 GridSampling::RejectByMemo(const Local& local, GridRandom random) const {
  const float bound = (1 - local.mix) * (local.sums.greatest / local.sums.integral) + local.mix * kInvTwoPi;
  Vec3 w;
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    const Vec2 u = random.Next2D();
    const float z = 1 - u.x, r = SafeSqrt(1 - z * z);
    const auto [sin, cos] = SinCos(2 * kPi * u.y);
    w = local.frame.ToWorld({r * cos, r * sin, z});
    if (random.Next2D().x * bound < Pdf(local, w)) break;
  }
  return w;
}

GuidedSample GridSampling::Sample(const Local& local, Vec2 u, float u_more) const {
  Vec3 w;
  switch (rules_.sampling) {
    case Sampling::kInversionSphere:
      w = CylindricalToDirection(local.product->square->Sample(u).at);
      break;
    case Sampling::kInversionHemisphere: {
      const GridSquare::Drawn drawn = local.product->square->Sample(u);
      w = local.frame.ToWorld(HemisphereToDirection(drawn.at));
      // What Pdf(w) would say, to the bit, without looking for the cell again.
      if (drawn.inside) [[likely]]
        return {w, drawn.density * (Dot(w, local.frame.n) * kInvPi)};
      break;
    }
    case Sampling::kRejection:
    case Sampling::kRejectionMixed:
      w = rules_.memo ? RejectByMemo(local, GridRandom(u, u_more)) : Reject(local, GridRandom(u, u_more), u);
      break;
    case Sampling::kMetropolis: {
      GridRandom random(u, u_more);
      const GridSquare& square = *local.product->square;
      const uint32_t cell = RunChain(local.product->target, square.rows(), square.columns(), random);
      w = local.frame.ToWorld(HemisphereToDirection(square.PointIn(cell, random.Next2D())));
      break;
    }
  }
  return {w, Pdf(local, w)};
}

float GridSampling::MeanRadiance(uint32_t cell, uint32_t normal) const {
  std::unique_ptr<const Product> own;
  return ProductAt(cell, normal, &own)->mean;
}

}  // namespace lodestar
