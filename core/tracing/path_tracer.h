// The tracing half of the methods that trace paths from the camera, each with its guide (guide.h). The template is
// instantiated once a guide, in the guide's *_tracer.cpp.
#pragma once

#include <utility>

#include "core/film/pixel_filter.h"
#include "core/tracing/path_kernel.h"
#include "core/tracing/tracer.h"

namespace lodestar {

PixelFilter MakePixelFilter(const Scene& scene);
// Sees that a sample is fit to be added; what is not counts as zero and is reported with the pixel and pass that replay
// it.
bool AcceptSample(Rgb sample, const Round& round, const PixelSample& pixel, uint32_t pass, HealthReport* health);

template <class Guide>
class PathTracer final : public Tracer {
 public:
  PathTracer(std::shared_ptr<const Scene> scene, uint64_t seed, const PathSettings& settings, Guide guide)
      : scene_(std::move(scene)),
        seed_(seed),
        settings_(settings),
        guide_(std::move(guide)),
        filter_(MakePixelFilter(*scene_)),
        grid_(static_cast<uint32_t>(scene_->resolution_x()), static_cast<uint32_t>(scene_->resolution_y())) {}

  bool Execute(const Round& round, uint32_t unit, const StopToken& stop, Contribution* into) const override {
    return WithFeatures<kMask>(Features(round.record),
                               [&](auto features) { return ExecuteWith<features.value>(round, unit, stop, into); });
  }
  Rgb TraceSample(const Round& round, uint32_t x, uint32_t y, uint32_t pass) const override {
    return WithFeatures<kMask>(Features(round.record),
                               [&](auto features) { return TraceWith<features.value>(round, x, y, pass); });
  }

 private:
  template <unsigned kFeatures>
  bool ExecuteWith(const Round& round, uint32_t unit, const StopToken& stop, Contribution* into) const;
  template <unsigned kFeatures>
  Rgb TraceWith(const Round& round, uint32_t x, uint32_t y, uint32_t pass) const;
  template <unsigned kFeatures>
  Rgb Sample(const PathKernel<kFeatures, Guide>& kernel, uint32_t x, uint32_t y, Sampler& sampler, float* filter_weight,
             PathCounters* counters, std::vector<PathVertex>* vertices) const;

  static constexpr unsigned kMask = Guide::kRecords ? kKernelVariants - 1 : (kKernelVariants - 1) & ~kRecord;
  unsigned Features(bool record) const { return KernelFeatures(scene_->needs()) | (record ? kRecord : 0u); }

  std::shared_ptr<const Scene> scene_;
  uint64_t seed_;
  PathSettings settings_;
  Guide guide_;
  PixelFilter filter_;
  TileGrid grid_;
};

template <class Guide>
template <unsigned kFeatures>
Rgb PathTracer<Guide>::Sample(const PathKernel<kFeatures, Guide>& kernel, uint32_t x, uint32_t y, Sampler& sampler,
                              float* filter_weight, PathCounters* counters, std::vector<PathVertex>* vertices) const {
  const FilterSample filter = filter_.Sample(sampler.Next2D());
  const Vec2 film{static_cast<float>(x) + 0.5f + filter.offset.x, static_cast<float>(y) + 0.5f + filter.offset.y};
  *filter_weight = filter.weight;
  return kernel.Trace(scene_->camera().Generate(film, scene_->camera().has_lens() ? sampler.Next2D() : Vec2{}),
                      guide_.PixelLuminance(x, y), sampler, counters, vertices);
}

template <class Guide>
template <unsigned kFeatures>
bool PathTracer<Guide>::ExecuteWith(const Round& round, uint32_t unit, const StopToken& stop,
                                    Contribution* into) const {
  const PathKernel<kFeatures, Guide> kernel(*scene_, settings_, guide_);
  const TileRect rect = grid_.Rect(unit);
  FilmTile tile;
  tile.tile = unit;
  tile.pixels.resize(rect.pixels());
  PathCounters counters;
  std::vector<PathVertex> vertices;
  typename Guide::Scratch scratch;
  for (uint32_t y = rect.y0; y < rect.y1; ++y) {
    for (uint32_t x = rect.x0; x < rect.x1; ++x) {
      if (stop.Requested()) return false;
      PixelSum& sum = tile.pixels[(y - rect.y0) * rect.width() + (x - rect.x0)];
      for (uint32_t pass = round.first_pass; pass < round.first_pass + round.passes; ++pass) {
        Sampler sampler(seed_, x, y, pass, round.iteration);
        const PixelSample pixel{x, y, sampler.key()};
        float filter_weight;
        const Rgb sample = Sample(kernel, x, y, sampler, &filter_weight, &counters, &vertices);
        if (counters.zero_pdf > 0) [[unlikely]] {
          into->health.Count(HealthEvent::kZeroPdf, x, y, pass, round.iteration);
          counters.zero_pdf = 0;
        }
        if (!AcceptSample(sample, round, pixel, pass, &into->health)) continue;
        if (!sum.Add(sample * filter_weight)) [[unlikely]]
          into->health.Count(HealthEvent::kClamped, x, y, pass, round.iteration);
        if constexpr ((kFeatures & kRecord) != 0) guide_.Record(vertices, pixel, &scratch, into->statistics.get());
      }
    }
  }
  into->tiles.push_back(std::move(tile));
  into->paths += counters.paths;
  into->rays += counters.rays;
  into->vertices += counters.vertices;
  return true;
}

template <class Guide>
template <unsigned kFeatures>
Rgb PathTracer<Guide>::TraceWith(const Round& round, uint32_t x, uint32_t y, uint32_t pass) const {
  const PathKernel<kFeatures, Guide> kernel(*scene_, settings_, guide_);
  Sampler sampler(seed_, x, y, pass, round.iteration);
  PathCounters counters;
  std::vector<PathVertex> vertices;
  float filter_weight;
  return Sample(kernel, x, y, sampler, &filter_weight, &counters, &vertices);
}

}  // namespace lodestar
