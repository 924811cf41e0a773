#include "core/tracing/mixed_guide.h"

namespace lodestar {

// Each part is told of its own density, and of what it is mixed with as of the BSDF.
void MixedGuide::Record(std::span<const PathVertex> vertices, const PixelSample& sample, Scratch* scratch,
                        Statistics* statistics) const {
  auto& learned = static_cast<MixedStatistics&>(*statistics);
  const bool narrowing = field_.iteration() < field_.options().iterations();
  std::vector<PathVertex>& own = scratch->vertices;
  own.assign(vertices.begin(), vertices.end());
  for (PathVertex& vertex : own) {
    if (vertex.recorded) vertex.guide_pdf = tree_.TreePdf(vertex.leaf, vertex.wi);
  }
  tree_.Record(own, sample, &scratch->tree, &learned.tree());
  if (!narrowing) return;
  for (size_t i = 0; i < own.size(); ++i) {
    PathVertex& vertex = own[i];
    if (!vertex.recorded) continue;
    const float alpha = tree_.BsdfFraction(vertex.leaf), tree = vertex.guide_pdf;
    const Shares shares = SharesAt(alpha, vertex.p);
    vertex.bsdf_pdf = Lerp(alpha, tree, vertex.bsdf_pdf);
    // What the kernel took for the guide's density, less the tree's part of it.
    vertex.guide_pdf =
        shares.tree < 1 ? std::max(0.0f, (vertices[i].guide_pdf - shares.tree * tree) / (1 - shares.tree)) : 0;
  }
  focal_.Record(own, sample, nullptr, &learned.focal());
}

}  // namespace lodestar
