// The tracing half of the methods that trace paths from the camera: plain path tracing and SD-tree guiding.
#pragma once

#include "core/film/pixel_filter.h"
#include "core/learning/sd_tree_guiding.h"
#include "core/tracing/path_kernel.h"
#include "core/tracing/tracer.h"

namespace lodestar {

class PathTracer final : public Tracer {
 public:
  // `state` is null for plain path tracing.
  PathTracer(std::shared_ptr<const Scene> scene, uint64_t seed, const PathSettings& settings, std::shared_ptr<const SdTreeState> state);
  bool Execute(const Round& round, uint32_t unit, const StopToken& stop, Contribution* into) const override;

  // One pixel sample as Execute renders it, for replaying what the health report names. `record` as in the round it belongs to.
  Rgb TraceSample(uint32_t x, uint32_t y, uint32_t pass, bool record) const;

 private:
  template <unsigned kFeatures>
  bool ExecuteWith(const Round& round, uint32_t unit, const StopToken& stop, Contribution* into) const;
  template <unsigned kFeatures>
  Rgb TraceWith(uint32_t x, uint32_t y, uint32_t pass) const;
  template <unsigned kFeatures>
  Rgb Sample(const PathKernel<kFeatures>& kernel, uint32_t x, uint32_t y, uint32_t pass, Sampler& sampler, float* filter_weight, PathCounters* counters,
             std::vector<PathVertex>* vertices) const;
  unsigned Features(bool record) const;

  std::shared_ptr<const Scene> scene_;
  uint64_t seed_;
  PathSettings settings_;
  std::shared_ptr<const SdTreeState> state_;
  PixelFilter filter_;
  TileGrid grid_;
};

}  // namespace lodestar
