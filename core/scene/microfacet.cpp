#include "core/scene/microfacet.h"

#include <array>

namespace lodestar {
namespace {

constexpr int kMus = 64, kAlphas = 32;

// Rows over alpha (linear), columns over mu (linear).
struct AlbedoTable {
  std::array<float, kMus * kAlphas> albedo;
  std::array<float, kAlphas> mean;

  AlbedoTable() {
    constexpr int kPhis = 16, kCaps = 32;
    for (int row = 0; row < kAlphas; ++row) {
      const float alpha = std::max(static_cast<float>(row) / (kAlphas - 1), 1e-4f);
      const Ggx ggx{{alpha, alpha}};
      double mean_sum = 0, weight_sum = 0;
      for (int column = 0; column < kMus; ++column) {
        const float mu = std::max(static_cast<float>(column) / (kMus - 1), 1e-4f);
        const Vec3 wo{SafeSqrt(1 - mu * mu), 0, mu};
        float sum = 0;
        for (int n = 0; n < kPhis * kCaps; ++n) {
          const VisibleNormalNode node = VisibleNormalQuadrature(n, kPhis, kCaps);
          const Vec3 m = ggx.SampleVisible(wo, node.u);
          const Vec3 wi = m * (2 * Dot(wo, m)) - wo;
          if (wi.z > 0) sum += node.weight * MaskingWeight(ggx.Stretch(wo), wo.z, ggx.Stretch(wi), wi.z);
        }
        const float value = std::min(sum, 1.0f);
        albedo[row * kMus + column] = value;
        const double weight = mu * (column == kMus - 1 ? 0.5 : 1.0);  // trapezoid; the end at mu = 0 weighs nothing
        mean_sum += weight * value;
        weight_sum += weight;
      }
      mean[row] = static_cast<float>(mean_sum / weight_sum);
    }
  }
};

const AlbedoTable& Table() {
  static const AlbedoTable table;
  return table;
}

struct Node {
  int index;
  float t;
};
Node NodeOf(float x01, int count) {
  const float x = std::clamp(x01, 0.0f, 1.0f) * static_cast<float>(count - 1);
  const int index = std::min(static_cast<int>(x), count - 2);
  return {index, x - static_cast<float>(index)};
}

}  // namespace

float GgxAlbedo(float mu, float alpha) {
  const Node row = NodeOf(alpha, kAlphas), column = NodeOf(mu, kMus);
  const float* low = Table().albedo.data() + row.index * kMus + column.index;
  return Lerp(row.t, Lerp(column.t, low[0], low[1]), Lerp(column.t, low[kMus], low[kMus + 1]));
}

float GgxMeanAlbedo(float alpha) {
  const Node row = NodeOf(alpha, kAlphas);
  return Lerp(row.t, Table().mean[row.index], Table().mean[row.index + 1]);
}

}  // namespace lodestar
