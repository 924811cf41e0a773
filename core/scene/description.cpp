#include "core/scene/description.h"

#include "core/base/error.h"

namespace lodestar {

std::string SourceLocation::ToString() const {
  return file + ":" + std::to_string(line) + ":" + std::to_string(column);
}

PixelFilterDescription PixelFilterDescription::Named(const std::string& name) {
  PixelFilterDescription filter;
  const auto set = [&](Kind kind, float radius) {
    filter.kind = kind;
    filter.radius_x = filter.radius_y = radius;
  };
  if (name == "box")
    set(Kind::kBox, 0.5f);
  else if (name == "triangle")
    set(Kind::kTriangle, 2);
  else if (name == "gaussian")
    set(Kind::kGaussian, 1.5f);
  else if (name == "mitchell")
    set(Kind::kMitchell, 2);
  else
    throw Error(ErrorKind::kInvalidInput,
                "there is no pixel filter '" + name + "': choose box, triangle, gaussian or mitchell");
  return filter;
}

}  // namespace lodestar
