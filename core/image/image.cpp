#include "core/image/image.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/image/image_file.h"
#include "core/math/elementary.h"
#include "core/math/srgb.h"

namespace lodestar {

std::unique_ptr<OIIO::ImageInput> OpenImage(const std::string& path, RawImage* info) {
  if (!std::filesystem::is_regular_file(path))
    throw Error(ErrorKind::kNotFound,
                "image file '" + path + "' does not exist; names are relative to the scene file's folder");
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  auto input = OIIO::ImageInput::open(path, &config);
  if (!input) throw Error(ErrorKind::kCorrupt, "cannot read image '" + path + "': " + OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.width <= 0 || spec.height <= 0 || spec.depth > 1 || spec.nchannels < 1 ||
      int64_t{spec.width} * spec.height > (int64_t{1} << 30))
    throw Error(ErrorKind::kCorrupt, "image '" + path + "' has an unusable size or no channels");
  info->width = spec.width;
  info->height = spec.height;
  info->channels = spec.nchannels;
  info->stored = spec.format;
  info->integer = !spec.format.is_floating_point();
  info->has_alpha = spec.nchannels == 4 || spec.nchannels == 2;
  Chromaticities named;
  // Written with few digits as often as not.
  const auto same = [](float a, float b) { return std::abs(a - b) < 1e-3f; };
  if (!info->integer && spec.nchannels >= 3 &&
      spec.getattribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), named.data()) &&
      !std::ranges::equal(named, kRec709, same))
    info->chromaticities = named;
  return input;
}

std::optional<PrimariesMatrix> Conversion(const RawImage& info, WhitePoint white, const std::string& path) {
  if (!info.chromaticities) return std::nullopt;
  const auto conversion = ToRec709(*info.chromaticities, white);
  if (!conversion) throw Error(ErrorKind::kCorrupt, "image '" + path + "' has chromaticities of no colour space");
  return conversion;
}

template <class T>
std::vector<T> ReadPixels(OIIO::ImageInput& input, const RawImage& info, const std::string& path) {
  std::vector<T> pixels(size_t(info.width) * info.height * info.channels);
  if (!input.read_image(0, 0, 0, info.channels, OIIO::BaseTypeFromC<T>::value, pixels.data()))
    throw Error(ErrorKind::kCorrupt, "image '" + path + "' is truncated or damaged: " + input.geterror());
  return pixels;
}
template std::vector<uint8_t> ReadPixels<uint8_t>(OIIO::ImageInput&, const RawImage&, const std::string&);
template std::vector<uint16_t> ReadPixels<uint16_t>(OIIO::ImageInput&, const RawImage&, const std::string&);
template std::vector<float> ReadPixels<float>(OIIO::ImageInput&, const RawImage&, const std::string&);

FloatImage ReadImage(const std::string& path) {
  RawImage info;
  const auto input = OpenImage(path, &info);
  const auto raw = ReadPixels<float>(*input, info, path);
  FloatImage image{info.width, info.height, std::vector<Rgb>(size_t(info.width) * info.height)};
  const auto to_rec709 = Conversion(info, WhitePoint::kKept, path);
  const int g = info.channels >= 3 ? 1 : 0, b = info.channels >= 3 ? 2 : 0;
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    const float* p = raw.data() + i * info.channels;
    Rgb c(p[0], p[g], p[b]);
    if (info.integer) c = {SrgbToLinear(c.r), SrgbToLinear(c.g), SrgbToLinear(c.b)};
    if (to_rec709) c = (*to_rec709)(c);
    image.pixels[i] = c;
  }
  return image;
}

namespace {

// Runs `write` on a temporary name, then renames.
template <class Write>
void WriteThenRename(const std::string& path, const OIIO::ImageSpec& spec, Write&& write) {
  const std::filesystem::path target(path);
  const std::string partial = (target.parent_path() / (".partial-" + target.filename().string())).string();
  const auto fail = [&](const std::string& why) {
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    throw Error(ErrorKind::kIo, "cannot write image '" + path + "': " + why +
                                    "; is the folder there and writable, and the disk not full?");
  };
  auto output = OIIO::ImageOutput::create(partial);
  if (!output) fail(OIIO::geterror());
  if (!output->open(partial, spec)) fail(output->geterror());
  if (!write(*output)) fail(output->geterror());
  if (!output->close()) fail(output->geterror());
  std::error_code error;
  std::filesystem::rename(partial, target, error);
  if (error) fail(error.message());
}

}  // namespace

void WriteExr(const std::string& path, int width, int height, const std::vector<ImageChannel>& channels,
              const ExrOptions& options) {
  const int n = static_cast<int>(channels.size());
  OIIO::ImageSpec spec(width, height, n, options.half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
  spec.channelnames.clear();
  for (const auto& c : channels) spec.channelnames.push_back(c.name);
  spec.alpha_channel = -1;
  spec.attribute("compression", "zip");
  for (const auto& [key, value] : options.metadata) spec.attribute(key, value);
  std::vector<float> pixels(size_t(width) * height * n);
  for (int c = 0; c < n; ++c)
    for (size_t i = 0; i < size_t(width) * height; ++i) pixels[i * n + c] = channels[c].values[i * channels[c].stride];
  WriteThenRename(path, spec,
                  [&](OIIO::ImageOutput& out) { return out.write_image(OIIO::TypeDesc::FLOAT, pixels.data()); });
}

void WriteExr(const std::string& path, const FloatImage& image, const ExrOptions& options) {
  const float* p = image.pixels.empty() ? nullptr : &image.pixels[0].r;
  WriteExr(path, image.width, image.height, {{"R", p, 3}, {"G", p + 1, 3}, {"B", p + 2, 3}}, options);
}

std::vector<uint8_t> ToSrgb8(const FloatImage& image, float exposure) {
  const float scale = Pow(2, exposure);
  std::vector<uint8_t> bytes;
  bytes.reserve(image.pixels.size() * 3);
  for (const Rgb& p : image.pixels)
    for (int c = 0; c < 3; ++c) bytes.push_back(LinearToSrgb8(p[c] * scale));
  return bytes;
}

void WritePng(const std::string& path, int width, int height, const std::vector<uint8_t>& bytes) {
  LODESTAR_CHECK(bytes.size() == size_t(width) * height * 3);
  OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  WriteThenRename(path, spec,
                  [&](OIIO::ImageOutput& out) { return out.write_image(OIIO::TypeDesc::UINT8, bytes.data()); });
}

void WritePng(const std::string& path, const FloatImage& image, float exposure) {
  WritePng(path, image.width, image.height, ToSrgb8(image, exposure));
}

}  // namespace lodestar
