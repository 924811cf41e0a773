#include "core/guiding/sd_tree_options.h"

#include "core/guiding/bsdf_fraction.h"
#include "core/guiding/setting_bytes.h"

namespace lodestar {
namespace {

void Require(bool holds, const char* what) {
  RequireSetting(holds, "SD-tree", what);
}

}  // namespace

SdTreeOptions SdTreeOptions::Recommended() {
  SdTreeOptions options;
  options.spatial_threshold = 700;
  options.target = Target::kSwitching;
  options.reconstruction = Reconstruction::kNative;
  options.learn_nee = true;
  return options;
}

SdTreeOptions SdTreeOptions::Paper2017() {
  SdTreeOptions options;
  options.spatial_threshold = 12000;
  options.spatial_filter = SpatialFilter::kNearest;
  options.directional_filter = DirectionalFilter::kNearest;
  options.bsdf_fraction_loss = BsdfFractionLoss::kNone;
  options.min_records = 1;
  return options;
}

SdTreeOptions SdTreeOptions::Paper2019() {
  SdTreeOptions options;
  options.spatial_threshold = 4000;
  options.spatial_filter = SpatialFilter::kStochastic;
  options.directional_filter = DirectionalFilter::kBox;
  options.bsdf_fraction_loss = BsdfFractionLoss::kKl;
  options.min_records = 1;
  return options;
}

void SdTreeOptions::Validate() const {
  Require(spatial_threshold >= 1 && spatial_threshold <= 1e12f, "spatial_threshold must be in [1, 1e12]");
  Require(flux_threshold >= 1e-3f && flux_threshold <= 1, "flux_threshold must be in [0.001, 1]");
  Require(max_directional_depth >= 1 && max_directional_depth <= 20, "max_directional_depth must be in [1, 20]");
  Require(max_spatial_depth >= 0 && max_spatial_depth <= 63, "max_spatial_depth must be in [0, 63]");
  Require(spatial_filter <= SpatialFilter::kBox, "spatial_filter must be nearest, stochastic or box");
  Require(directional_filter <= DirectionalFilter::kBox, "directional_filter must be nearest or box");
  Require(bsdf_fraction_loss <= BsdfFractionLoss::kVariance, "bsdf_fraction_loss must be none, kl or variance");
  Require(initial_bsdf_fraction >= kMinBsdfFraction && initial_bsdf_fraction <= kMaxBsdfFraction,
          "initial_bsdf_fraction must be in [0.05, 0.95]");
  Require(target <= Target::kSwitching, "target must be radiance, simple, full or switching");
  Require(reconstruction <= Reconstruction::kDenseUnlimited,
          "reconstruction must be none, dense, native or dense-unlimited");
  Require(dense_sigma >= 0.1f && dense_sigma <= 3, "dense_sigma must be in [0.1, 3]");
  Require(min_records >= 1 && min_records <= 1e9f, "min_records must be in [1, 1e9]");
  Require(max_nodes >= 1 && max_nodes <= (uint64_t{1} << 29), "max_nodes must be in [1, 2^29]");
}

void SdTreeOptions::Write(ByteWriter& out) const {
  out.Put(spatial_threshold);
  out.Put(flux_threshold);
  out.Put<int32_t>(max_directional_depth);
  out.Put<int32_t>(max_spatial_depth);
  out.Put(spatial_filter);
  out.Put(directional_filter);
  out.Put(bsdf_fraction_loss);
  out.Put(initial_bsdf_fraction);
  out.Put(target);
  out.Put(reconstruction);
  out.Put(dense_sigma);
  out.Put<uint8_t>(learn_nee);
  out.Put(min_records);
  out.Put(max_nodes);
}

SdTreeOptions SdTreeOptions::Read(ByteReader& in) {
  SdTreeOptions options;
  options.spatial_threshold = in.Get<float>();
  options.flux_threshold = in.Get<float>();
  options.max_directional_depth = in.Get<int32_t>();
  options.max_spatial_depth = in.Get<int32_t>();
  options.spatial_filter = in.Get<SpatialFilter>();
  options.directional_filter = in.Get<DirectionalFilter>();
  options.bsdf_fraction_loss = in.Get<BsdfFractionLoss>();
  options.initial_bsdf_fraction = in.Get<float>();
  options.target = in.Get<Target>();
  options.reconstruction = in.Get<Reconstruction>();
  options.dense_sigma = in.Get<float>();
  options.learn_nee = in.GetFlag();
  options.min_records = in.Get<float>();
  options.max_nodes = in.Get<uint64_t>();
  return Validated(options, in);
}

}  // namespace lodestar
