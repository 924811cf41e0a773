#include "core/tracing/path_tracer.h"

namespace lodestar {

PixelFilter MakePixelFilter(const Scene& scene) {
  const PixelFilterDescription& d = scene.filter();
  PixelFilter::Parameters parameters;
  parameters.kind = static_cast<PixelFilter::Kind>(d.kind);
  parameters.radius_x = d.radius_x;
  parameters.radius_y = d.radius_y;
  parameters.sigma = d.sigma;
  parameters.b = d.b;
  parameters.c = d.c;
  return PixelFilter(parameters);
}
static_assert(static_cast<int>(PixelFilter::Kind::kMitchell) ==
              static_cast<int>(PixelFilterDescription::Kind::kMitchell));

bool AcceptSample(Rgb sample, const Round& round, const PixelSample& pixel, uint32_t pass, HealthReport* health) {
  if (IsFinite(sample) && MinComponent(sample) >= 0) [[likely]]
    return true;
  const bool nan = std::isnan(sample.r) || std::isnan(sample.g) || std::isnan(sample.b);
  const HealthEvent event = nan                 ? HealthEvent::kNan
                            : !IsFinite(sample) ? HealthEvent::kInfinite
                                                : HealthEvent::kNegative;
  health->Count(event, pixel.x, pixel.y, pass, round.iteration);
  return false;
}

template class PathTracer<NoGuide>;

}  // namespace lodestar
