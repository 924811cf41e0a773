#include "core/guiding/product_lobes.h"

#include <limits>

namespace lodestar {

ProductLobes::ProductLobes(const Frame& frame, Vec3 wo, std::span<const ProductLobe> lobes) {
  const float cos = Dot(frame.n, wo);
  normal_ = cos < 0 ? -frame.n : frame.n;
  const float cos_o = std::fabs(cos);
  float sum = 0;
  for (const ProductLobe& lobe : lobes) sum += lobe.weight;
  // 1 / sum must be finite, too.
  if (!(sum >= std::numeric_limits<float>::min()) || !std::isfinite(sum)) return;
  const float least = kLeastShare * sum;
  float kept = 0;
  for (const ProductLobe& lobe : lobes) {
    if (lobe.weight < least) continue;
    kept += lobe.weight;
    if (lobe.kind == ProductLobe::Kind::kDiffuseTransmission) {
      transmission_ += lobe.weight;
    } else if (lobe.kind == ProductLobe::Kind::kDiffuseReflection || glossy_count_ == kMaxGlossy ||
               cos_o < LtcTable::kMinCos) {
      diffuse_ += lobe.weight;
    } else {
      // Any tangent does where wo is the normal: the lobe is round.
      const Frame local = Frame::FromNormalAndTangent(normal_, -wo);
      diffuse_ += kTailShare * lobe.weight;
      weight_[glossy_count_] = (1 - kTailShare) * lobe.weight;
      glossy_[glossy_count_++] = Ltc(LtcTable::GgxReflection(lobe.alpha, cos_o), local);
    }
  }
  const float scale = 1 / kept;
  diffuse_ *= scale;
  transmission_ *= scale;
  for (int i = 0; i < glossy_count_; ++i) weight_[i] *= scale;
}

}  // namespace lodestar
