#include "core/image/texel_image.h"

#include "core/base/check.h"
#include "core/image/image.h"
#include "core/image/image_file.h"
#include "core/math/elementary.h"
#include "core/math/srgb.h"

namespace lodestar {
namespace {

float Decode(float encoded, TexelImage::Encoding encoding, float gamma) {
  switch (encoding) {
    case TexelImage::Encoding::kSrgb:
      return SrgbToLinear(encoded);
    case TexelImage::Encoding::kLinear:
      return encoded;
    case TexelImage::Encoding::kGamma:
      return Pow(encoded, gamma);
  }
  return encoded;
}

// Channels to keep of a file's: 1, 3, or 4 where the alpha says something.
template <class T>
int UsefulChannels(const std::vector<T>& raw, int channels, T opaque) {
  if (channels <= 2) return 1;
  if (channels == 3) return 3;
  for (size_t i = 3; i < raw.size(); i += channels)
    if (raw[i] != opaque) return 4;
  return 3;
}

int WrapIndex(int i, int n, TexelImage::Wrap wrap) {
  if (static_cast<unsigned>(i) < static_cast<unsigned>(n)) return i;
  if (wrap == TexelImage::Wrap::kRepeat) {
    i %= n;
    return i < 0 ? i + n : i;
  }
  if (wrap == TexelImage::Wrap::kClamp) return std::clamp(i, 0, n - 1);
  return -1;
}

}  // namespace

std::unique_ptr<TexelImage> TexelImage::Load(const std::string& path, Encoding encoding, float gamma) {
  RawImage info;
  const auto input = OpenImage(path, &info);
  if (info.stored != OIIO::TypeDesc::UINT8) {
    auto raw = ReadPixels<float>(*input, info, path);
    const int keep = UsefulChannels(raw, info.channels, 1.0f);
    if (const auto to_rec709 = Conversion(info, WhitePoint::kAdapted, path)) {
      for (size_t i = 0; i < raw.size(); i += info.channels) {
        const Rgb c = (*to_rec709)({raw[i], raw[i + 1], raw[i + 2]});
        for (int k = 0; k < 3; ++k) raw[i + k] = c[k];
      }
    }
    std::vector<float> values;
    values.reserve(size_t(info.width) * info.height * keep);
    for (size_t i = 0; i < raw.size(); i += info.channels)
      for (int c = 0; c < keep; ++c)
        values.push_back(info.integer && c < 3 ? Decode(raw[i + c], encoding, gamma) : raw[i + c]);
    return FromFloats(info.width, info.height, keep, std::move(values));
  }
  const auto raw = ReadPixels<uint8_t>(*input, info, path);
  auto image = std::make_unique<TexelImage>();
  image->width_ = info.width;
  image->height_ = info.height;
  image->channels_ = UsefulChannels(raw, info.channels, uint8_t{255});
  image->tiles_x_ = (info.width + 3) / 4;
  image->bytes_.resize(size_t(image->tiles_x_) * ((info.height + 3) / 4) * 16);
  for (int v = 0; v < 256; ++v) image->decode_[v] = Decode(float(v) / 255, encoding, gamma);
  const int n = info.channels, g = n >= 3 ? 1 : 0, b = n >= 3 ? 2 : 0;
  for (int y = 0; y < info.height; ++y)
    for (int x = 0; x < info.width; ++x) {
      const uint8_t* p = raw.data() + (size_t(y) * info.width + x) * n;
      const uint32_t alpha = image->channels_ == 4 ? p[3] : 255;
      image->bytes_[image->Column<true>(x) + image->Row<true>(y)] =
          p[0] | uint32_t{p[g]} << 8 | uint32_t{p[b]} << 16 | alpha << 24;
    }
  return image;
}

std::unique_ptr<TexelImage> TexelImage::FromFloats(int width, int height, int channels, std::vector<float> values) {
  LODESTAR_CHECK((channels == 1 || channels == 3 || channels == 4) &&
                 values.size() == size_t(width) * height * channels);
  auto image = std::make_unique<TexelImage>();
  image->width_ = width;
  image->height_ = height;
  image->channels_ = channels;
  image->floats_.assign(values.begin(), values.end());
  return image;
}

// read(place) gives a texel's value.
template <bool kTiled, class Read>
auto TexelImage::Filter(Vec2 st, Wrap wrap, bool nearest, Read read) const {
  using Value = decltype(read(size_t{}));
  // Texel centres are at half integers. Coordinates that overflow an int say nothing anyway.
  const float limit = 1e9f;
  const float fx = std::clamp(st.x * static_cast<float>(width_) - 0.5f, -limit, limit);
  const float fy = std::clamp(st.y * static_cast<float>(height_) - 0.5f, -limit, limit);
  if (nearest) {
    const int x = WrapIndex(static_cast<int>(std::floor(fx + 0.5f)), width_, wrap);
    const int y = WrapIndex(static_cast<int>(std::floor(fy + 0.5f)), height_, wrap);
    return x < 0 || y < 0 ? Value(0.0f) : read(Column<kTiled>(x) + Row<kTiled>(y));
  }
  const float x_floor = std::floor(fx), y_floor = std::floor(fy);
  const float dx = fx - x_floor, dy = fy - y_floor;
  int x0 = static_cast<int>(x_floor), y0 = static_cast<int>(y_floor), x1 = x0 + 1, y1 = y0 + 1;
  float wx0 = 1, wx1 = 1, wy0 = 1, wy1 = 1;
  if (!(x0 >= 0 && y0 >= 0 && x1 < width_ && y1 < height_)) [[unlikely]] {
    // Beyond the border of `black`: any texel, times zero.
    const auto inside = [wrap](int* i, int n) {
      *i = WrapIndex(*i, n, wrap);
      const bool black = *i < 0;
      if (black) *i = 0;
      return black ? 0.0f : 1.0f;
    };
    wx0 = inside(&x0, width_), wx1 = inside(&x1, width_);
    wy0 = inside(&y0, height_), wy1 = inside(&y1, height_);
  }
  const size_t c0 = Column<kTiled>(x0), c1 = Column<kTiled>(x1), r0 = Row<kTiled>(y0), r1 = Row<kTiled>(y1);
  const Value v00 = read(c0 + r0), v10 = read(c1 + r0), v01 = read(c0 + r1), v11 = read(c1 + r1);
  const float a0 = (1 - dx) * wx0, a1 = dx * wx1;
  return (v00 * a0 + v10 * a1) * ((1 - dy) * wy0) + (v01 * a0 + v11 * a1) * (dy * wy1);
}

Rgb TexelImage::LookupRgb(Vec2 st, Wrap wrap, bool nearest) const {
  if (!bytes_.empty()) {
    return Filter<true>(st, wrap, nearest, [this](size_t at) {
      const uint32_t v = bytes_[at];
      return Rgb(decode_[v & 255], decode_[v >> 8 & 255], decode_[v >> 16 & 255]);
    });
  }
  return Filter<false>(st, wrap, nearest, [this](size_t at) {
    const float* p = floats_.data() + at;
    return channels_ == 1 ? Rgb(p[0]) : Rgb(p[0], p[1], p[2]);
  });
}

float TexelImage::LookupFloat(Vec2 st, Wrap wrap, bool nearest) const {
  if (!bytes_.empty()) {
    return Filter<true>(st, wrap, nearest, [this](size_t at) {
      const uint32_t v = bytes_[at];
      if (channels_ == 4) return static_cast<float>(v >> 24) * (1 / 255.0f);
      if (channels_ == 1) return decode_[v & 255];
      return (decode_[v & 255] + decode_[v >> 8 & 255] + decode_[v >> 16 & 255]) * (1 / 3.0f);
    });
  }
  return Filter<false>(st, wrap, nearest, [this](size_t at) {
    const float* p = floats_.data() + at;
    return channels_ == 1 ? p[0] : channels_ == 4 ? p[3] : (p[0] + p[1] + p[2]) * (1 / 3.0f);
  });
}

}  // namespace lodestar
