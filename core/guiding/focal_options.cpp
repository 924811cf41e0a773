#include "core/guiding/focal_options.h"

#include "core/guiding/bsdf_fraction.h"
#include "core/guiding/setting_bytes.h"

namespace lodestar {
namespace {

void Require(bool holds, const char* what) {
  RequireSetting(holds, "focal guiding", what);
}

}  // namespace

void FocalOptions::Validate() const {
  Require(start_depth >= 1 && start_depth <= 6, "start_depth must be in [1, 6]");
  Require(initial_iterations >= 1 && initial_iterations <= 30, "initial_iterations must be in [1, 30]");
  Require(narrowing_iterations >= 0 && narrowing_iterations <= 30, "narrowing_iterations must be in [0, 30]");
  Require(narrow_factor >= 0.25f && narrow_factor <= 8, "narrow_factor must be in [0.25, 8]");
  Require(split_threshold >= 1e-5f && split_threshold <= 1, "split_threshold must be in [1e-5, 1]");
  Require(prune_ratio >= 0 && prune_ratio <= 1e6f, "prune_ratio must be in [0, 1e6]");
  Require(decay >= 0 && decay <= 1, "decay must be in [0, 1]");
  Require(bsdf_fraction >= kMinBsdfFraction && bsdf_fraction <= kMaxBsdfFraction,
          "bsdf_fraction must be in [0.05, 0.95]");
  // The octree of start_depth must fit.
  Require(max_nodes >= 37449 && max_nodes <= (1u << 24), "max_nodes must be in [37449, 2^24]");
}

void FocalOptions::Write(ByteWriter& out) const {
  out.Put<int32_t>(start_depth);
  out.Put<int32_t>(initial_iterations);
  out.Put<int32_t>(narrowing_iterations);
  out.Put(narrow_factor);
  out.Put<uint8_t>(by_mixture);
  out.Put(split_threshold);
  out.Put(prune_ratio);
  out.Put(decay);
  out.Put<uint8_t>(images);
  out.Put<uint8_t>(diverging);
  out.Put(bsdf_fraction);
  out.Put<uint8_t>(learn_fraction);
  out.Put(max_nodes);
}

FocalOptions FocalOptions::Read(ByteReader& in) {
  FocalOptions options;
  options.start_depth = in.Get<int32_t>();
  options.initial_iterations = in.Get<int32_t>();
  options.narrowing_iterations = in.Get<int32_t>();
  options.narrow_factor = in.Get<float>();
  options.by_mixture = in.GetFlag();
  options.split_threshold = in.Get<float>();
  options.prune_ratio = in.Get<float>();
  options.decay = in.Get<float>();
  options.images = in.GetFlag();
  options.diverging = in.GetFlag();
  options.bsdf_fraction = in.Get<float>();
  options.learn_fraction = in.GetFlag();
  options.max_nodes = in.Get<uint32_t>();
  return Validated(options, in);
}

}  // namespace lodestar
