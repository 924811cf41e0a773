// The box that the focal field and the radiance grid divide: the scene's bounds, no side vanishing, nothing of the
// scene on its faces.
#pragma once

#include <string>

#include "core/base/bytes.h"
#include "core/math/bounds.h"

namespace lodestar {

struct GuideBox {
  Vec3 corner, sides;

  // Each side at least an eighth of the longest, and 1/1024 of the longest wider on either face. Throws
  // Error(kInvalidInput) naming `who` for bounds that are empty, not finite or above 1e30 in extent.
  static GuideBox Around(const Bounds3& bounds, const std::string& who);
  void Write(ByteWriter& out) const;
  // Fails the reader (Error kCorrupt) for what no bounds give.
  static GuideBox Read(ByteReader& in);
};

}  // namespace lodestar
