#include "core/tracing/sd_tree_guide.h"

#include <array>
#include <cmath>

namespace lodestar {

namespace {

// The share of a vertex' emission that the vertex before it learns of.
float LearnedEmission(SdTreeMethod::Learn learn, float emission_weight) {
  switch (learn) {
    case SdTreeMethod::Learn::kAll:
      return 1;
    case SdTreeMethod::Learn::kIndirect:
      return emission_weight < 1 ? 0.0f : 1.0f;
    case SdTreeMethod::Learn::kWeighted:
      break;
  }
  return emission_weight;
}

}  // namespace

ProductLobes MakeProductLobes(const SurfaceInteraction& si, const Bsdf& bsdf, Vec3 wo) {
  const BsdfLobes lobes = bsdf.Lobes(wo);
  std::array<ProductLobe, std::tuple_size_v<decltype(lobes.lobes)>> out;
  int count = 0;
  for (const BsdfLobe& lobe : lobes) {
    const auto kind = static_cast<ProductLobe::Kind>(lobe.kind);
    // The table is of isotropic lobes: the geometric mean keeps an anisotropic one's solid angle.
    out[count++] = {kind, lobe.alpha.x == lobe.alpha.y ? lobe.alpha.x : std::sqrt(lobe.alpha.x * lobe.alpha.y),
                    lobe.weight};
  }
  return ProductLobes(si.shading, si.shading.ToWorld(wo), {out.data(), static_cast<size_t>(count)});
}
static_assert(static_cast<int>(ProductLobe::Kind::kDiffuseTransmission) ==
                  static_cast<int>(BsdfLobe::Kind::kDiffuseTransmission) &&
              static_cast<int>(ProductLobe::Kind::kGgxReflection) == static_cast<int>(BsdfLobe::Kind::kGgxReflection));

// Radiance arriving along each vertex's wi, from the path's end to its start. Walking backwards needs neither a
// division by the throughput nor a difference of sums, so dim light behind a bright vertex keeps its precision.
template <bool kProduct>
void SdTreeGuide<kProduct>::Record(std::span<const PathVertex> vertices, const PixelSample& sample, Scratch* records,
                                   Statistics* statistics) const {
  SdTreeStatistics& sums = static_cast<SdTreeGuidingStatistics*>(statistics)->sums();
  const bool relative = tree_.target() == SdTreeOptions::Target::kFull, learn_nee = tree_.options().learn_nee,
             learn_lights = !tree_.lights_by_power().empty();
  const float per_pixel = relative ? 1 / PixelLuminance(sample.x, sample.y) : 0;
  records->clear();
  for (const PathVertex& vertex : vertices)
    if (vertex.smooth) sums.Prefetch(vertex.leaf);
  Rgb incident, learned;  // as the estimate has it, and as the tree learns it
  for (size_t i = vertices.size(); i-- > 0;) {
    const PathVertex& vertex = vertices[i];
    incident *= vertex.roulette;
    learned *= vertex.roulette;
    if (vertex.recorded) {
      const Rgb reflected = vertex.weight * learned;
      records->push_back({.position = vertex.p,
                          .direction = vertex.wi,
                          .radiance = Luminance(learned),
                          .pdf = vertex.pdf,
                          .bsdf_pdf = vertex.bsdf_pdf,
                          .tree_pdf = vertex.guide_pdf,
                          .product = Luminance(reflected) * vertex.pdf,
                          .relative = relative ? Luminance(vertex.beta * reflected) * per_pixel * vertex.pdf : 0.0f,
                          .leaf = vertex.leaf});
    }
    const Rgb rest = vertex.weight * incident;
    if (learn_nee && vertex.smooth)
      sums.Record(NeeRecord{Luminance(vertex.direct), Luminance(rest), static_cast<uint32_t>(vertices.size() - i),
                            vertex.leaf});
    if (learn_lights && vertex.smooth && !IsBlack(vertex.direct)) {
      const float probability = static_cast<float>(tree_.Lights(vertex.leaf)[vertex.light_group]) * 0x1p-16f *
                                tree_.leaf(vertex.leaf).nee_probability;
      sums.Record(LightRecord{Luminance(vertex.direct), probability, vertex.leaf, vertex.light_group});
    }
    const Rgb leaving = vertex.direct + rest;
    incident = vertex.emitted * vertex.emission_weight + leaving;
    learned = vertex.emitted * LearnedEmission(learn_, vertex.emission_weight) + leaving;
  }
  sums.Record(*records, sample.key);
}

template class SdTreeGuide<false>;
template class SdTreeGuide<true>;

}  // namespace lodestar
