#include "core/tracing/grid_guide.h"

namespace lodestar {
namespace {

// The share of what the BSDF scatters that is diffuse or nearly, above and below.
struct DiffuseShares {
  float above = 0, below = 0;
};

DiffuseShares SharesOf(const Bsdf& bsdf, Vec3 wo) {
  if (bsdf.kind() == Bsdf::Kind::kDiffuse) return {1, 0};
  DiffuseShares shares;
  for (const BsdfLobe& lobe : bsdf.Lobes(wo)) {
    const bool broad =
        lobe.kind == BsdfLobe::Kind::kDiffuseReflection ||
        (lobe.kind == BsdfLobe::Kind::kGgxReflection && std::min(lobe.alpha.x, lobe.alpha.y) >= GridGuide::kBroadAlpha);
    if (broad) shares.above += lobe.weight;
    if (lobe.kind == BsdfLobe::Kind::kDiffuseTransmission) shares.below += lobe.weight;
  }
  return shares;
}

}  // namespace

GridGuide::Local GridGuide::At(const SurfaceInteraction& si, const Bsdf& bsdf, Vec3 wo) const {
  Local local;
  const DiffuseShares shares = SharesOf(bsdf, wo);
  const float share = std::max(shares.above, shares.below);
  const Vec3 n = (wo.z > 0) == (shares.above >= shares.below) ? si.shading.n : -si.shading.n;
  Place place{grid_->CellAt(si.p), 0, Place::kNoAlbedo};
  if (learn_ == GridMethod::Learn::kExpectedSarsa) {
    place.normal = GridHemispheres::NormalAt(n);
    if (bsdf.kind() == Bsdf::Kind::kDiffuse)
      place.albedo = static_cast<uint32_t>(std::clamp(Luminance(bsdf.Albedo(wo)), 0.0f, 1.0f) * 254 + 0.5f);
  }
  local.leaf = place.leaf();
  if (!guides_ || !(share > 0)) return local;
  local.at = sampling_->At(place.cell, n);
  if (local.at.usable) local.bsdf_fraction = 1 - (1 - bsdf_fraction_) * std::min(share, 1.0f);
  return local;
}

// From the path's end to its start, so that what arrives along a vertex' direction is known before the vertex is met.
// Where a rule of the table's own takes over from the path, roulette no longer matters: it only decides the rest.
void GridGuide::Record(std::span<const PathVertex> vertices, const PixelSample&, Scratch*,
                       Statistics* statistics) const {
  GridStatistics& sums = static_cast<GridGuidingStatistics*>(statistics)->sums();
  Rgb arriving;
  for (size_t i = vertices.size(); i-- > 0;) {
    const PathVertex& vertex = vertices[i];
    Rgb reflected = vertex.weight * (arriving * vertex.roulette);
    const Place place = Place::Of(vertex.leaf);
    if (vertex.recorded) {
      const uint32_t direction = grid_->DirectionAt(vertex.wi);
      if (learn_ == GridMethod::Learn::kMonteCarlo) {
        sums.Record(place.cell, direction, Luminance(arriving * vertex.roulette));
      } else {
        // A path that ended here has not seen what arrives.
        if (vertex.roulette > 0) sums.Record(place.cell, direction, Luminance(arriving));
        if (grid_->Fluence(place.cell) > 0) reflected = vertex.weight * grid_->Radiance(place.cell, direction);
      }
    }
    // Expected SARSA needs no direction of the path's, and so none that came to something.
    if (vertex.smooth && learn_ == GridMethod::Learn::kExpectedSarsa && place.albedo != Place::kNoAlbedo &&
        grid_->Fluence(place.cell) > 0) {
      const float albedo = static_cast<float>(place.albedo) * (1.0f / 254);
      reflected = Rgb(albedo * sampling_->MeanRadiance(place.cell, place.normal));
    }
    arriving = vertex.emitted * vertex.emission_weight + vertex.direct + reflected;
  }
}

}  // namespace lodestar
