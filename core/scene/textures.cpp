#include "core/scene/textures.h"

#include <cmath>
#include <map>
#include <tuple>

#include "core/base/error.h"
#include "core/base/overloaded.h"

namespace lodestar {
namespace {

Vec2 Map(const UvMapping& m, Vec2 uv) {
  return {m.su * uv.x + m.du, m.sv * uv.y + m.dv};
}

}  // namespace

TextureTable::TextureTable(const std::vector<TextureDescription>& textures) {
  using Key = std::tuple<std::string, ImageTexture::Encoding, float>;
  std::map<Key, const TexelImage*> loaded;
  const auto load = [&](const ImageTexture& t, const SourceLocation& where) {
    const Key key{t.path, t.encoding, t.encoding == ImageTexture::Encoding::kGamma ? t.gamma : 1.0f};
    auto [entry, fresh] = loaded.try_emplace(key, nullptr);
    if (fresh) {
      try {
        images_.push_back(TexelImage::Load(t.path, static_cast<TexelImage::Encoding>(t.encoding), t.gamma));
      } catch (const Error& e) {
        throw Error(e.kind(), where.ToString() + ": " + e.what());
      }
      entry->second = images_.back().get();
    }
    return entry->second;
  };
  for (const TextureDescription& description : textures) {
    Node node;
    // A texture may only use those before it, which is how the format declares them; so evaluation ends.
    const auto child = [&](const RgbValue& v) {
      if (v.texture >= static_cast<int>(nodes_.size()))
        throw Error(ErrorKind::kInvalidInput, description.where.ToString() + ": texture '" + description.name +
                                                  "' uses a texture that is declared after it");
      return Fold(v);
    };
    std::visit(Overloaded{
                   [&](const ConstantTexture& t) {
                     node.a.value = t.value;
                     node.constant = true;
                   },
                   [&](const ImageTexture& t) {
                     node.kind = Kind::kImage;
                     node.image = load(t, description.where);
                     node.wrap = static_cast<TexelImage::Wrap>(t.wrap);
                     node.nearest = t.filter == ImageTexture::Filter::kPoint;
                     node.invert = t.invert;
                     node.scale = t.scale;
                     node.mapping = t.mapping;
                   },
                   [&](const ScaleTexture& t) {
                     node.kind = Kind::kScale;
                     node.a = child(t.tex);
                     node.b = child(t.scale);
                     node.constant = node.a.texture < 0 && node.b.texture < 0;
                   },
                   [&](const MixTexture& t) {
                     node.kind = Kind::kMix;
                     node.a = child(t.a);
                     node.b = child(t.b);
                     node.amount = child(t.amount);
                     node.constant = node.a.texture < 0 && node.b.texture < 0 && node.amount.texture < 0;
                   },
                   [&](const CheckerboardTexture& t) {
                     node.kind = Kind::kCheckerboard;
                     node.a = child(t.a);
                     node.b = child(t.b);
                     node.mapping = t.mapping;
                   },
               },
               description.kind);
    nodes_.push_back(node);
  }
}

Rgb TextureTable::EvaluateNode(int index, Vec2 uv) const {
  const Node& n = nodes_[index];
  switch (n.kind) {
    case Kind::kConstant:
      return n.a.value;
    case Kind::kImage: {
      const Vec2 st = Map(n.mapping, uv);
      Rgb c = n.image->LookupRgb({st.x, 1 - st.y}, n.wrap, n.nearest) * n.scale;  // v points up, rows run down
      if (n.invert) c = {std::max(1 - c.r, 0.0f), std::max(1 - c.g, 0.0f), std::max(1 - c.b, 0.0f)};
      return c;
    }
    case Kind::kScale:
      return Evaluate(n.a, uv) * Evaluate(n.b, uv);
    case Kind::kMix: {
      const Rgb t = Evaluate(n.amount, uv);
      return Evaluate(n.a, uv) * (Rgb(1) - t) + Evaluate(n.b, uv) * t;
    }
    case Kind::kCheckerboard: {
      const Vec2 st = Map(n.mapping, uv);
      const bool odd = std::fmod(std::floor(st.x) + std::floor(st.y), 2.0f) != 0;
      return Evaluate(odd ? n.b : n.a, uv);
    }
  }
  return {};
}

float TextureTable::EvaluateFloatNode(int index, Vec2 uv) const {
  const Node& n = nodes_[index];
  const auto value = [&](const RgbValue& v) { return v.texture < 0 ? v.value.r : EvaluateFloatNode(v.texture, uv); };
  switch (n.kind) {
    case Kind::kConstant:
      return n.a.value.r;
    case Kind::kImage: {
      const Vec2 st = Map(n.mapping, uv);
      const float v = n.image->LookupFloat({st.x, 1 - st.y}, n.wrap, n.nearest) * n.scale;
      return n.invert ? std::max(1 - v, 0.0f) : v;
    }
    case Kind::kScale:
      return value(n.a) * value(n.b);
    case Kind::kMix:
      return Lerp(value(n.amount), value(n.a), value(n.b));
    case Kind::kCheckerboard: {
      const Vec2 st = Map(n.mapping, uv);
      return value(std::fmod(std::floor(st.x) + std::floor(st.y), 2.0f) != 0 ? n.b : n.a);
    }
  }
  return 0;
}

RgbValue TextureTable::Fold(const RgbValue& value) const {
  if (value.texture < 0 || !nodes_[value.texture].constant) return value;
  return {EvaluateNode(value.texture, {}), -1};
}
FloatValue TextureTable::Fold(const FloatValue& value) const {
  if (value.texture < 0 || !nodes_[value.texture].constant) return value;
  return {EvaluateFloatNode(value.texture, {}), -1};
}

size_t TextureTable::memory_bytes() const {
  size_t bytes = nodes_.size() * sizeof(Node);
  for (const auto& image : images_) bytes += image->memory_bytes();
  return bytes;
}

}  // namespace lodestar
