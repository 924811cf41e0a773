#include "core/image/image.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/base/error.h"
#include "core/image/texel_image.h"
#include "core/math/primaries.h"
#include "core/math/srgb.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {
namespace {

std::string Temp(const std::string& name) {
  static const TemporaryFolder folder;
  return folder / name;
}

FloatImage Gradient(int width, int height) {
  FloatImage image{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.pixels.push_back({float(x) / width, float(y) / height, 0.25f});
  return image;
}

TEST(Image, FloatExrRoundTripsEveryBit) {
  FloatImage image = Gradient(13, 7);
  image.At(3, 2) = {1e-30f, 3.1e30f, -7};
  WriteExr(Temp("float.exr"), image, {.half = false, .metadata = {{"lodestar:job", "abc"}}});
  const FloatImage back = ReadImage(Temp("float.exr"));
  ASSERT_EQ(back.width, 13);
  ASSERT_EQ(back.height, 7);
  EXPECT_EQ(back.pixels, image.pixels);
}

TEST(Image, HalfExrRoundTripsToHalfPrecision) {
  const FloatImage image = Gradient(9, 9);
  WriteExr(Temp("half.exr"), image, {.half = true, .metadata = {}});
  const FloatImage back = ReadImage(Temp("half.exr"));
  for (size_t i = 0; i < image.pixels.size(); ++i) EXPECT_NEAR(back.pixels[i].r, image.pixels[i].r, 5e-4);
  EXPECT_LT(std::filesystem::file_size(Temp("half.exr")), 4000u);
}

TEST(Image, ExrKeepsNamedChannels) {
  const std::vector<float> values{1, 2, 3, 4, 5, 6};
  WriteExr(Temp("aov.exr"), 3, 2,
           {{"R", values.data()}, {"G", values.data()}, {"B", values.data()}, {"variance.R", values.data()}});
  EXPECT_EQ(ReadImage(Temp("aov.exr")).At(2, 1), Rgb(6));
}

// An EXR in ACES2065-1, as pbrt's imgtool writes skies: as light it keeps its white, as a surface its white is ours.
TEST(Image, ChromaticitiesAreConverted) {
  const Chromaticities aces{0.7347f, 0.2653f, 0, 1, 0.0001f, -0.077f, 0.32168f, 0.33767f};
  const auto write = [](const char* name, const Chromaticities& primaries) {
    OIIO::ImageSpec spec(1, 1, 3, OIIO::TypeDesc::FLOAT);
    spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), primaries.data());
    const auto out = OIIO::ImageOutput::create(Temp(name));
    const float pixel[3] = {0.3f, 0.36f, 0.5f};
    ASSERT_TRUE(out && out->open(Temp(name), spec) && out->write_image(OIIO::TypeDesc::FLOAT, pixel) && out->close());
  };
  const Rgb written(0.3f, 0.36f, 0.5f);
  const auto expect = [&](const char* name, Rgb light, Rgb surface) {
    const Rgb read = ReadImage(Temp(name)).At(0, 0);
    const Rgb texel = TexelImage::Load(Temp(name), TexelImage::Encoding::kLinear, 1)
                          ->LookupRgb({0.5f, 0.5f}, TexelImage::Wrap::kClamp, true);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(read[c], light[c], 2e-3f) << name << ", component " << c;
      EXPECT_NEAR(texel[c], surface[c], 2e-3f) << name << ", component " << c;
    }
  };
  write("aces.exr", aces);
  expect("aces.exr", (*ToRec709(aces, WhitePoint::kKept))(written), (*ToRec709(aces, WhitePoint::kAdapted))(written));
  EXPECT_LT(ReadImage(Temp("aces.exr")).At(0, 0).r, 0.18f);
  write("rec709.exr", kRec709);
  EXPECT_EQ(ReadImage(Temp("rec709.exr")).At(0, 0), written);
  write("none.exr", {});
  EXPECT_THROW(ReadImage(Temp("none.exr")), Error);
}

TEST(Image, PngIsSrgbWithExposure) {
  FloatImage image{3, 1, {Rgb(0.5f), Rgb(0.25f), Rgb(7, -1, NAN)}};
  EXPECT_EQ(ToSrgb8(image), (std::vector<uint8_t>{188, 188, 188, 137, 137, 137, 255, 0, 0}));
  WritePng(Temp("a.png"), image, 1);
  const FloatImage back = ReadImage(Temp("a.png"));
  EXPECT_NEAR(back.At(0, 0).r, 1, 1e-6);
  EXPECT_NEAR(back.At(1, 0).r, 0.5, 0.005);
}

TEST(Image, PngOfBytesKeepsEveryByte) {
  std::vector<uint8_t> bytes(256 * 3);
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<uint8_t>(i / 3);
  WritePng(Temp("ramp.png"), 256, 1, bytes);
  EXPECT_EQ(ToSrgb8(ReadImage(Temp("ramp.png"))), bytes);
}

TEST(Image, SrgbInverts) {
  for (int i = 0; i <= 255; ++i) EXPECT_NEAR(LinearToSrgb(SrgbToLinear(i / 255.0f)), i / 255.0f, 1e-6);
  EXPECT_NEAR(SrgbToLinear(0.5f), 0.21404114, 1e-6);
}

TEST(Image, ErrorsNameTheFile) {
  const auto expect = [](const std::string& path, ErrorKind kind) {
    try {
      ReadImage(path);
      ADD_FAILURE() << "no error for " << path;
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), kind);
      EXPECT_NE(std::string(e.what()).find(path), std::string::npos) << e.what();
    }
  };
  expect(Temp("absent.png"), ErrorKind::kNotFound);
  std::ofstream(Temp("garbage.png")) << "this is no image";
  expect(Temp("garbage.png"), ErrorKind::kCorrupt);
  WriteExr(Temp("whole.exr"), Gradient(64, 64));
  std::filesystem::copy_file(Temp("whole.exr"), Temp("cut.exr"), std::filesystem::copy_options::overwrite_existing);
  std::filesystem::resize_file(Temp("cut.exr"), std::filesystem::file_size(Temp("cut.exr")) / 2);
  expect(Temp("cut.exr"), ErrorKind::kCorrupt);
  EXPECT_THROW(WriteExr("/nonexistent-folder/a.exr", Gradient(2, 2)), Error);
  EXPECT_THROW(WritePng("/nonexistent-folder/a.png", Gradient(2, 2)), Error);
}

TEST(Image, PfmRowsRunFromTheBottom) {
  std::ofstream out(Temp("rows.pfm"), std::ios::binary);
  out << "PF\n1 2\n-1.0\n";
  const float values[6] = {1, 1, 1, 2, 2, 2};  // the file's first row is the lowest
  out.write(reinterpret_cast<const char*>(values), sizeof(values));
  out.close();
  const FloatImage image = ReadImage(Temp("rows.pfm"));
  EXPECT_EQ(image.At(0, 0), Rgb(2));
  EXPECT_EQ(image.At(0, 1), Rgb(1));
}

using Wrap = TexelImage::Wrap;

TEST(TexelImage, BilinearWrapsAndNearest) {
  const auto image = TexelImage::FromFloats(2, 2, 1, {0, 1, 2, 3});
  EXPECT_EQ(image->LookupFloat({0.25f, 0.25f}, Wrap::kClamp, false), 0);  // a texel's centre
  EXPECT_EQ(image->LookupFloat({0.75f, 0.75f}, Wrap::kClamp, false), 3);
  EXPECT_EQ(image->LookupFloat({0.5f, 0.5f}, Wrap::kClamp, false), 1.5f);
  EXPECT_EQ(image->LookupFloat({0, 0.25f}, Wrap::kClamp, false), 0);
  EXPECT_EQ(image->LookupFloat({0, 0.25f}, Wrap::kRepeat, false), 0.5f);
  EXPECT_EQ(image->LookupFloat({5, 0.25f}, Wrap::kRepeat, false), 0.5f);
  EXPECT_EQ(image->LookupFloat({-3.75f, 0.25f}, Wrap::kRepeat, false), 0);
  EXPECT_EQ(image->LookupFloat({1, 0.75f}, Wrap::kBlack, false), 1.5f);
  EXPECT_EQ(image->LookupFloat({1.5f, 0.75f}, Wrap::kBlack, false), 0);
  EXPECT_EQ(image->LookupFloat({0.45f, 0.1f}, Wrap::kClamp, true), 0);
  EXPECT_EQ(image->LookupFloat({0.55f, 0.9f}, Wrap::kClamp, true), 3);
  EXPECT_TRUE(std::isfinite(image->LookupFloat({1e30f, -1e30f}, Wrap::kRepeat, false)));
}

// 8-bit files go through tiles and the table: every texel of an odd-sized image comes back.
TEST(TexelImage, EightBitTexelsAreLinearised) {
  const FloatImage image = Gradient(11, 6);
  WritePng(Temp("tiles.png"), image);
  const FloatImage decoded = ReadImage(Temp("tiles.png"));
  const auto texels = TexelImage::Load(Temp("tiles.png"), TexelImage::Encoding::kSrgb, 1);
  EXPECT_EQ(texels->channels(), 3);
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 11; ++x) {
      const Vec2 st{(x + 0.5f) / 11, (y + 0.5f) / 6};
      const Rgb a = texels->LookupRgb(st, Wrap::kRepeat, true), b = decoded.At(x, y),
                c = texels->LookupRgb(st, Wrap::kRepeat, false);
      EXPECT_NEAR(a.r, b.r, 1e-6);
      EXPECT_NEAR(a.g, b.g, 1e-6);
      EXPECT_NEAR(a.b, b.b, 1e-6);
      EXPECT_NEAR(c.g, b.g, 1e-5);
      EXPECT_NEAR(texels->LookupFloat(st, Wrap::kRepeat, true), (b.r + b.g + b.b) / 3, 1e-6);
    }
  const auto linear = TexelImage::Load(Temp("tiles.png"), TexelImage::Encoding::kLinear, 1);
  EXPECT_NEAR(linear->LookupRgb({0.01f, 0.01f}, Wrap::kClamp, true).b, 137 / 255.0, 1e-6);
  const auto gamma = TexelImage::Load(Temp("tiles.png"), TexelImage::Encoding::kGamma, 2);
  EXPECT_NEAR(gamma->LookupRgb({0.01f, 0.01f}, Wrap::kClamp, true).b, (137 / 255.0) * (137 / 255.0), 1e-6);
}

TEST(TexelImage, AlphaIsWhatAFloatTextureReads) {
  const auto image = TexelImage::FromFloats(1, 1, 4, {0.1f, 0.2f, 0.3f, 0.75f});
  EXPECT_EQ(image->LookupFloat({0.5f, 0.5f}, Wrap::kRepeat, false), 0.75f);
  EXPECT_EQ(image->LookupRgb({0.5f, 0.5f}, Wrap::kRepeat, false), Rgb(0.1f, 0.2f, 0.3f));
}

}  // namespace
}  // namespace lodestar
