#include "core/guiding/grid_hemisphere.h"

#include "core/base/check.h"
#include "core/math/warp.h"

namespace lodestar {

uint32_t GridHemispheres::NormalAt(Vec3 n) {
  const Vec3 a = Abs(n);
  const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
  const float scale = 0.5f * kNormalSide / a[axis];
  const auto along = [&](float v) {
    return static_cast<uint32_t>(std::clamp(v * scale + 0.5f * kNormalSide, 0.0f, kNormalSide - 1.0f));
  };
  const uint32_t face = static_cast<uint32_t>(2 * axis) + (n[axis] < 0);
  return (face * kNormalSide + along(n[(axis + 1) % 3])) * kNormalSide + along(n[(axis + 2) % 3]);
}

Vec3 GridHemispheres::NormalCenter(uint32_t normal) {
  const uint32_t face = normal / (kNormalSide * kNormalSide);
  const auto along = [](uint32_t i) { return (2 * static_cast<float>(i) + 1) / kNormalSide - 1; };
  Vec3 n;
  const int axis = static_cast<int>(face / 2);
  n[axis] = face % 2 == 0 ? 1.0f : -1.0f;
  n[(axis + 1) % 3] = along(normal / kNormalSide % kNormalSide);
  n[(axis + 2) % 3] = along(normal % kNormalSide);
  return Normalize(n);
}

const GridHemispheres& GridHemispheres::Of(int directions) {
  switch (directions) {
    case 4: {
      static const GridHemispheres kFour(4);
      return kFour;
    }
    case 8: {
      static const GridHemispheres kEight(8);
      return kEight;
    }
    case 16: {
      static const GridHemispheres kSixteen(16);
      return kSixteen;
    }
    default: {
      LODESTAR_CHECK(directions == 32);
      static const GridHemispheres kThirtyTwo(32);
      return kThirtyTwo;
    }
  }
}

GridHemispheres::GridHemispheres(int directions)
    : rows_(static_cast<uint32_t>(directions)), entries_(size_t{kNormals} * rows_ * columns() * kPoints) {
  const auto side = static_cast<float>(rows_);
  auto* out = entries_.data();
  for (uint32_t normal = 0; normal < kNormals; ++normal) {
    const Frame frame = Frame::FromNormal(NormalCenter(normal));
    frames_.push_back(frame);
    for (float row = 0; row < side; ++row)
      for (float column = 0; column < side; ++column)
        for (uint32_t point = 0; point < kPoints; ++point) {
          const Vec2 in{point % 2 == 0 ? 0.25f : 0.75f, point < 2 ? 0.25f : 0.75f};
          const Vec3 w = frame.ToWorld(HemisphereToDirection({(row + in.x) / side, (column + in.y) / side}));
          const Vec2 square = DirectionToCylindrical(w);
          *out++ = static_cast<uint16_t>(static_cast<uint32_t>(square.x * side) * 2 * rows_ +
                                         static_cast<uint32_t>(square.y * 2 * side));
        }
  }
}

void GridHemispheres::Gather(uint32_t normal, std::span<const float> radiances, std::span<double> out) const {
  LODESTAR_CHECK(out.size() == size_t{rows_} * columns() && radiances.size() == 2 * out.size());
  const uint16_t* entry = &entries_[normal * out.size() * kPoints];
  for (double& mean : out) {
    double sum = 0;
    for (uint32_t point = 0; point < kPoints; ++point) sum += radiances[*entry++];
    mean = sum * (1.0 / kPoints);
  }
}

}  // namespace lodestar
