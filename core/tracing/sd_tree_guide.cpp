#include "core/tracing/sd_tree_guide.h"

namespace lodestar {

// Radiance arriving along each vertex's wi, from the path's end to its start. Walking backwards needs neither a division by the throughput nor a
// difference of sums, so dim light behind a bright vertex keeps its precision.
void SdTreeGuide::Record(std::span<const PathVertex> vertices, const PixelSample& sample, Scratch* records, Statistics* statistics) const {
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
                          .tree_pdf = vertex.guide_pdf,
                          .product = vertex.product * radiance,
                          .leaf = vertex.leaf});
    }
    incident = vertex.local + vertex.weight * incident;
  }
  static_cast<SdTreeGuidingStatistics*>(statistics)->sums().Record(*records, sample.key);
}

}  // namespace lodestar
