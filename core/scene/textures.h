// The compiled textures: expression nodes over images, indexed as SceneDescription::textures. Constants are folded when
// materials are compiled.
#pragma once

#include <memory>
#include <vector>

#include "core/image/texel_image.h"
#include "core/scene/description.h"

namespace lodestar {

class TextureTable {
 public:
  TextureTable() = default;
  // Loads every image once. Throws Error with the directive's place for a missing or damaged file and for a texture
  // that refers to itself.
  explicit TextureTable(const std::vector<TextureDescription>& textures);

  Rgb Evaluate(const RgbValue& value, Vec2 uv) const {
    return value.texture < 0 ? value.value : EvaluateNode(value.texture, uv);
  }
  float Evaluate(const FloatValue& value, Vec2 uv) const {
    return value.texture < 0 ? value.value : EvaluateFloatNode(value.texture, uv);
  }
  // The value itself where it does not depend on uv: its texture becomes -1.
  RgbValue Fold(const RgbValue& value) const;
  FloatValue Fold(const FloatValue& value) const;

  size_t memory_bytes() const;

 private:
  enum class Kind : uint8_t { kConstant, kImage, kScale, kMix, kCheckerboard };
  struct Node {
    Kind kind = Kind::kConstant;
    TexelImage::Wrap wrap = TexelImage::Wrap::kRepeat;
    bool nearest = false, invert = false, constant = false;
    const TexelImage* image = nullptr;
    float scale = 1;
    UvMapping mapping;
    RgbValue a, b, amount;
  };
  Rgb EvaluateNode(int index, Vec2 uv) const;
  float EvaluateFloatNode(int index, Vec2 uv) const;

  std::vector<Node> nodes_;
  std::vector<std::unique_ptr<TexelImage>> images_;
};

}  // namespace lodestar
