#include "core/guiding/guide_box.h"

#include <algorithm>

#include "core/base/error.h"

namespace lodestar {
namespace {

constexpr float kMargin = 0x1p-10f;    // of the longest side: what lies on the box's faces lies inside
constexpr float kLeastSide = 0x1p-3f;  // of the longest side

}  // namespace

GuideBox GuideBox::Around(const Bounds3& bounds, const std::string& who) {
  const float longest = bounds.empty() ? 0 : MaxComponent(bounds.Diagonal());
  if (bounds.empty() || !IsFinite(bounds.min) || !IsFinite(bounds.max) || !(longest <= 1e30f)) {
    throw Error(ErrorKind::kInvalidInput, who + " needs bounds that are finite, not empty and below 1e30 in extent");
  }
  GuideBox box;
  const float side = std::max(longest, 1e-30f);  // a single point
  for (int axis = 0; axis < 3; ++axis) {
    box.sides[axis] = std::max(bounds.Diagonal()[axis], side * kLeastSide) + 2 * kMargin * side;
    box.corner[axis] = bounds.Center()[axis] - box.sides[axis] * 0.5f;
  }
  return box;
}

void GuideBox::Write(ByteWriter& out) const {
  for (int axis = 0; axis < 3; ++axis) {
    out.Put(corner[axis]);
    out.Put(sides[axis]);
  }
}

GuideBox GuideBox::Read(ByteReader& in) {
  GuideBox box;
  for (int axis = 0; axis < 3; ++axis) {
    box.corner[axis] = in.Get<float>();
    box.sides[axis] = in.Get<float>();
  }
  const float longest = MaxComponent(box.sides);
  for (int axis = 0; axis < 3; ++axis) {
    if (!(box.sides[axis] >= 0.1f * longest && longest <= 2e30f && longest >= 1e-31f)) in.Fail("has invalid bounds");
  }
  if (!IsFinite(box.corner)) in.Fail("has invalid bounds");
  return box;
}

}  // namespace lodestar
