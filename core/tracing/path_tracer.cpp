#include "core/tracing/path_tracer.h"

#include <array>
#include <utility>

namespace lodestar {
namespace {

PixelFilter MakeFilter(const PixelFilterDescription& d) {
  PixelFilter::Parameters parameters;
  parameters.kind = static_cast<PixelFilter::Kind>(d.kind);
  parameters.radius_x = d.radius_x;
  parameters.radius_y = d.radius_y;
  parameters.sigma = d.sigma;
  parameters.b = d.b;
  parameters.c = d.c;
  return PixelFilter(parameters);
}
static_assert(static_cast<int>(PixelFilter::Kind::kMitchell) == static_cast<int>(PixelFilterDescription::Kind::kMitchell));

// Radiance arriving along each vertex's wi, from the path's end to its start, into the tree's statistics. Walking backwards needs neither a
// division by the throughput nor a difference of sums, so dim light behind a bright vertex keeps its precision.
void RecordPath(const std::vector<PathVertex>& vertices, uint64_t key, std::vector<SdTreeRecord>* records, SdTreeStatistics* statistics) {
  records->clear();
  Rgb incident;
  for (size_t i = vertices.size(); i-- > 0;) {
    const PathVertex& vertex = vertices[i];
    incident *= vertex.roulette;
    if (vertex.recorded) {
      const float radiance = Luminance(incident);
      records->push_back({.position = vertex.p,
                          .direction = vertex.wi,
                          .radiance = radiance,
                          .pdf = vertex.pdf,
                          .bsdf_pdf = vertex.bsdf_pdf,
                          .tree_pdf = vertex.tree_pdf,
                          .product = vertex.product * radiance,
                          .leaf = vertex.leaf});
    }
    incident = vertex.local + vertex.weight * incident;
  }
  statistics->Record(*records, key);
}

// Sees that a sample is fit to be added; what is not counts as zero and is reported with the pixel and pass that replay it.
bool Accept(Rgb sample, const Round& round, uint32_t x, uint32_t y, uint32_t pass, HealthReport* health) {
  if (IsFinite(sample) && MinComponent(sample) >= 0) [[likely]] return true;
  const bool nan = std::isnan(sample.r) || std::isnan(sample.g) || std::isnan(sample.b);
  health->Count(nan ? HealthEvent::kNan : !IsFinite(sample) ? HealthEvent::kInfinite : HealthEvent::kNegative, x, y, pass, round.iteration);
  return false;
}

}  // namespace

PathTracer::PathTracer(std::shared_ptr<const Scene> scene, uint64_t seed, const PathSettings& settings, std::shared_ptr<const SdTreeState> state)
    : scene_(std::move(scene)),
      seed_(seed),
      settings_(settings),
      state_(std::move(state)),
      filter_(MakeFilter(scene_->filter())),
      grid_(static_cast<uint32_t>(scene_->resolution_x()), static_cast<uint32_t>(scene_->resolution_y())) {}

unsigned PathTracer::Features(bool record) const {
  unsigned features = scene_->needs().environment ? kEnvironment : 0u;
  if (state_) {
    if (state_->tree().iteration() > 0) features |= kGuide;
    if (record) features |= kRecord;
  }
  return features;
}

template <unsigned kFeatures>
Rgb PathTracer::Sample(const PathKernel<kFeatures>& kernel, uint32_t x, uint32_t y, uint32_t pass, Sampler& sampler, float* filter_weight,
                       PathCounters* counters, std::vector<PathVertex>* vertices) const {
  const FilterSample filter = filter_.Sample(sampler.Next2D());
  const Vec2 film{static_cast<float>(x) + 0.5f + filter.offset.x, static_cast<float>(y) + 0.5f + filter.offset.y};
  *filter_weight = filter.weight;
  return kernel.Trace(scene_->camera().Generate(film, scene_->camera().has_lens() ? sampler.Next2D() : Vec2{}), sampler, counters, vertices);
}

template <unsigned kFeatures>
bool PathTracer::ExecuteWith(const Round& round, uint32_t unit, const StopToken& stop, Contribution* into) const {
  const PathKernel<kFeatures> kernel(*scene_, settings_, state_ ? &state_->tree() : nullptr);
  SdTreeStatistics* statistics = nullptr;
  if constexpr ((kFeatures & kRecord) != 0) statistics = &static_cast<SdTreeGuidingStatistics&>(*into->statistics).sums();
  const TileRect rect = grid_.Rect(unit);
  FilmTile tile;
  tile.tile = unit;
  tile.pixels.resize(rect.pixels());
  PathCounters counters;
  std::vector<PathVertex> vertices;
  std::vector<SdTreeRecord> records;
  for (uint32_t y = rect.y0; y < rect.y1; ++y) {
    for (uint32_t x = rect.x0; x < rect.x1; ++x) {
      if (stop.Requested()) return false;
      PixelSum& sum = tile.pixels[(y - rect.y0) * rect.width() + (x - rect.x0)];
      for (uint32_t pass = round.first_pass; pass < round.first_pass + round.passes; ++pass) {
        Sampler sampler(seed_, x, y, pass);
        float filter_weight;
        const Rgb sample = Sample(kernel, x, y, pass, sampler, &filter_weight, &counters, &vertices);
        if (!Accept(sample, round, x, y, pass, &into->health)) continue;
        sum.Add(sample * filter_weight);
        if constexpr ((kFeatures & kRecord) != 0) RecordPath(vertices, sampler.key(), &records, statistics);
      }
    }
  }
  into->tiles.push_back(std::move(tile));
  into->paths += counters.paths;
  into->rays += counters.rays;
  into->vertices += counters.vertices;
  return true;
}

bool PathTracer::Execute(const Round& round, uint32_t unit, const StopToken& stop, Contribution* into) const {
  using Function = bool (PathTracer::*)(const Round&, uint32_t, const StopToken&, Contribution*) const;
  static constexpr auto kTable = []<unsigned... kF>(std::integer_sequence<unsigned, kF...>) {
    return std::array<Function, sizeof...(kF)>{&PathTracer::ExecuteWith<kF>...};
  }(std::make_integer_sequence<unsigned, kKernelVariants>{});
  return (this->*kTable[Features(round.record)])(round, unit, stop, into);
}

template <unsigned kFeatures>
Rgb PathTracer::TraceWith(uint32_t x, uint32_t y, uint32_t pass) const {
  const PathKernel<kFeatures> kernel(*scene_, settings_, state_ ? &state_->tree() : nullptr);
  Sampler sampler(seed_, x, y, pass);
  PathCounters counters;
  std::vector<PathVertex> vertices;
  float filter_weight;
  return Sample(kernel, x, y, pass, sampler, &filter_weight, &counters, &vertices);
}

Rgb PathTracer::TraceSample(uint32_t x, uint32_t y, uint32_t pass, bool record) const {
  using Function = Rgb (PathTracer::*)(uint32_t, uint32_t, uint32_t) const;
  static constexpr auto kTable = []<unsigned... kF>(std::integer_sequence<unsigned, kF...>) {
    return std::array<Function, sizeof...(kF)>{&PathTracer::TraceWith<kF>...};
  }(std::make_integer_sequence<unsigned, kKernelVariants>{});
  return (this->*kTable[Features(record)])(x, y, pass);
}

}  // namespace lodestar
