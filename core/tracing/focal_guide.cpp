#include "core/tracing/focal_guide.h"

namespace lodestar {

// From the path's end to its start, as for the SD-tree. What counts is what a segment brings to the pixel: the light
// arriving along it, times the throughput with the segment's own vertex included.
void FocalGuide::Record(std::span<const PathVertex> vertices, const PixelSample&, Scratch*,
                        Statistics* statistics) const {
  FocalStatistics& sums = static_cast<FocalGuidingStatistics*>(statistics)->sums();
  const bool images = field_.options().images;
  Rgb incident;
  float distance = 0;  // to the next hit
  // that hit mirrors or refracts almost without blur: where the light seems to come from lies behind it
  bool image = false;
  for (size_t i = vertices.size(); i-- > 0;) {
    const PathVertex& vertex = vertices[i];
    incident *= vertex.roulette;
    const bool segment = vertex.recorded && distance > 0;  // 0: the path ended there
    if (segment && IsBlack(incident)) {
      sums.RecordNothing();  // behind the last light, where densities were never asked for
    } else if (segment) {
      sums.Record({.position = vertex.p,
                   .direction = vertex.wi,
                   .distance = image && images ? kInfinity : distance,
                   .value = Luminance(vertex.beta * vertex.weight * incident),
                   .pdf = vertex.pdf,
                   .bsdf_pdf = vertex.bsdf_pdf,
                   .guide_pdf = vertex.guide_pdf});
    }
    incident = vertex.emitted * vertex.emission_weight + vertex.direct + vertex.weight * incident;
    distance = vertex.distance;
    image = vertex.alpha < FocalOptions::kImageRoughness;
  }
}

}  // namespace lodestar
