#include "core/tracing/mixed_guide.h"

namespace lodestar {

// The tree is told what it would be told without the focal field, densities in proportion: were it told of the mixture,
// it would give up what the field is thought to cover (its targets weigh by its own share), and both would be worse for
// it (docs/decisions/0020-mixture.md). The field is told of the tree's mixture as of the BSDF.
void MixedGuide::Record(std::span<const PathVertex> vertices, const PixelSample& sample, Scratch* scratch,
                        Statistics* statistics) const {
  auto& learned = static_cast<MixedStatistics&>(*statistics);
  std::vector<PathVertex>& own = scratch->vertices;
  own.assign(vertices.begin(), vertices.end());
  for (PathVertex& vertex : own) {
    if (!vertex.recorded) continue;
    const float tree = tree_.TreePdf(vertex.leaf, vertex.wi);
    const float inner = Lerp(tree_.BsdfFraction(vertex.leaf), tree, vertex.bsdf_pdf);
    // Divided first: the quotients are bounded by the shares, whatever the densities.
    vertex.guide_pdf = inner > 0 ? tree / inner * vertex.pdf : 0;
    vertex.bsdf_pdf = inner > 0 ? vertex.bsdf_pdf / inner * vertex.pdf : 0;
  }
  tree_.Record(own, sample, &scratch->tree, &learned.tree());
  if (field_.iteration() >= field_.options().iterations()) return;
  for (size_t i = 0; i < own.size(); ++i) {
    PathVertex& vertex = own[i];
    if (!vertex.recorded) continue;
    const float alpha = tree_.BsdfFraction(vertex.leaf), tree = tree_.TreePdf(vertex.leaf, vertex.wi);
    const Shares shares = SharesAt(alpha, vertex.p);
    vertex.bsdf_pdf = Lerp(alpha, tree, vertices[i].bsdf_pdf);
    // What the kernel took for the guide's density, less the tree's part of it.
    vertex.guide_pdf =
        shares.tree < 1 ? std::max(0.0f, (vertices[i].guide_pdf - shares.tree * tree) / (1 - shares.tree)) : 0;
  }
  focal_.Record(own, sample, nullptr, &learned.focal());
}

}  // namespace lodestar
