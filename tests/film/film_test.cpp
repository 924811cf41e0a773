#include "core/film/film.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

namespace lodestar {
namespace {

FilmTile TileOf(const TileGrid& grid, uint32_t tile, const std::vector<Rgb>& samples) {
  FilmTile result{tile, std::vector<PixelSum>(grid.Rect(tile).pixels())};
  for (PixelSum& pixel : result.pixels) {
    for (const Rgb sample : samples) pixel.Add(sample);
  }
  return result;
}

Film FilmOf(const TileGrid& grid, const std::vector<Rgb>& samples) {
  Film film(grid);
  for (uint32_t tile = 0; tile < grid.tile_count(); ++tile) film.Add(grid, TileOf(grid, tile, samples));
  film.AddPasses(static_cast<uint32_t>(samples.size()));
  return film;
}

Bytes BytesOf(const Film& film) {
  ByteWriter out;
  film.Write(out);
  return out.Take();
}

TEST(TileGrid, CoversEveryPixelOnce) {
  const TileGrid grid(33, 17);
  ASSERT_EQ(grid.tile_count(), 6u);
  std::vector<int> seen(33 * 17);
  for (uint32_t tile = 0; tile < grid.tile_count(); ++tile) {
    const TileRect rect = grid.Rect(tile);
    EXPECT_EQ(rect.pixels(), rect.width() * rect.height());
    for (uint32_t y = rect.y0; y < rect.y1; ++y) {
      for (uint32_t x = rect.x0; x < rect.x1; ++x) {
        ++seen[y * 33 + x];
        EXPECT_EQ(grid.TileAt(x, y), tile);
      }
    }
  }
  for (const int count : seen) EXPECT_EQ(count, 1);
  EXPECT_EQ(grid.Rect(5).width(), 1u);
  EXPECT_EQ(grid.Rect(5).height(), 1u);
}

TEST(Film, MeanAndVarianceOfTheMean) {
  // Luminances 1 and 3: mean 2, sample variance 2, variance of the mean 1.
  const Image image = FilmOf(TileGrid(5, 3), {Rgb(1), Rgb(3)}).Develop();
  ASSERT_EQ(image.size(), 15u);
  for (size_t i = 0; i < image.size(); ++i) {
    EXPECT_EQ(image.pixels[i], Rgb(2));
    EXPECT_NEAR(image.variance[i], 1, 1e-6);
  }
}

TEST(Film, OnePassTellsNoVariance) {
  const Film film = FilmOf(TileGrid(1, 1), {Rgb(7)});
  EXPECT_EQ(film.Develop().variance[0], 0);
  EXPECT_EQ(film.MeanVariance(), std::numeric_limits<double>::infinity());
  EXPECT_EQ(Film(TileGrid(1, 1)).MeanVariance(), std::numeric_limits<double>::infinity());
  EXPECT_EQ(Film(TileGrid(1, 1)).Develop().pixels[0], Rgb(0));
}

TEST(Film, EqualSamplesHaveNoVarianceAtAnyScale) {
  for (const float scale : {1e-12f, 1e-3f, 1.0f, 1e12f}) {
    const Film film = FilmOf(TileGrid(2, 2), std::vector<Rgb>(10, Rgb(scale)));
    const Image image = film.Develop();
    EXPECT_NEAR(image.pixels[3].g / scale, 1, 1e-6) << scale;
    EXPECT_LE(image.variance[3], 1e-6f * scale * scale) << scale;
    EXPECT_GE(image.variance[3], 0) << scale;
  }
  EXPECT_EQ(FilmOf(TileGrid(2, 2), std::vector<Rgb>(10, Rgb(0))).MeanVariance(), 0);
}

TEST(Film, OverflowingSumsStayFinite) {
  PixelSum sum;
  sum.Add(Rgb(3e38f, -3e38f, 1));
  sum.Add(Rgb(3e38f, -3e38f, 1));
  EXPECT_EQ(sum.r, std::numeric_limits<float>::max());
  EXPECT_EQ(sum.g, -std::numeric_limits<float>::max());
  EXPECT_EQ(sum.b, 2);
  EXPECT_EQ(sum.luminance_squared, std::numeric_limits<float>::max());
}

TEST(Film, OfAnImageDevelopsIntoIt) {
  const Image image = {2, 1, {Rgb(0.3f, 2, 0.01f), Rgb(0)}, {1e-4f, 7}};
  const Film film(image, 12);
  EXPECT_EQ(film.passes(), 12u);
  const Image again = film.Develop();
  for (size_t p = 0; p < 2; ++p) {
    for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(again.pixels[p][c], image.pixels[p][c]);
    EXPECT_FLOAT_EQ(again.variance[p], image.variance[p]);
  }
}

TEST(Film, FireflyDoesNotOwnTheMeanVariance) {
  const TileGrid grid(16, 16);
  Film film(grid);
  FilmTile tile = TileOf(grid, 0, {Rgb(1), Rgb(3)});
  tile.pixels[5] = {};
  tile.pixels[5].Add(Rgb(0));
  tile.pixels[5].Add(Rgb(1e6f));
  film.Add(grid, tile);
  film.AddPasses(2);
  EXPECT_NEAR(film.MeanVariance(10), (255 * 1.0 + 10) / 256, 1e-5);
  EXPECT_GT(film.MeanVariance(1e30), 1e8);
}

TEST(Film, MostlyBlackPictureKeepsItsVariance) {
  const TileGrid grid(16, 16);
  Film film(grid);
  FilmTile tile{0, std::vector<PixelSum>(256)};
  for (const float v : {1.0f, 3.0f}) tile.pixels[7].Add(Rgb(v));
  film.Add(grid, tile);
  film.AddPasses(2);
  EXPECT_NEAR(film.MeanVariance(), 1.0 / 256, 1e-8);
}

TEST(Film, AMillionPassesDoNotDrift) {
  const TileGrid grid(1, 1);
  const FilmTile tile = TileOf(grid, 0, {Rgb(0.1f)});
  Film film(grid);
  float in_floats = 0;
  for (int i = 0; i < 1000000; ++i) {
    film.Add(grid, tile);
    film.AddPasses(1);
    in_floats += 0.1f;
  }
  EXPECT_EQ(film.passes(), 1000000u);
  EXPECT_EQ(film.Develop().pixels[0].r, 0.1f);
  EXPECT_GT(std::fabs(in_floats / 1e6f - 0.1f), 1e-4f);  // what doubles are for
  EXPECT_LT(film.Develop().variance[0], 1e-15f);
}

TEST(Film, TilesOfARoundAddInAnyOrder) {
  const TileGrid grid(40, 40);
  Film forward(grid), backward(grid);
  for (uint32_t round = 0; round < 3; ++round) {
    const auto tile = [&](uint32_t i) {
      return TileOf(grid, i, {Rgb(0.1f * static_cast<float>(i + 1)), Rgb(1.0f / static_cast<float>(round + 3))});
    };
    for (uint32_t i = 0; i < grid.tile_count(); ++i) {
      forward.Add(grid, tile(i));
      backward.Add(grid, tile(grid.tile_count() - 1 - i));
    }
    forward.AddPasses(2);
    backward.AddPasses(2);
  }
  EXPECT_EQ(BytesOf(forward), BytesOf(backward));
}

TEST(Film, BytesKeepEveryBit) {
  const Film film = FilmOf(TileGrid(17, 3), {Rgb(1e-12f, 0.1f, 3e5f), Rgb(0.3f)});
  const Bytes bytes = BytesOf(film);
  ByteReader in(bytes, "film");
  const Film back = Film::Read(in);
  in.ExpectEnd();
  EXPECT_EQ(BytesOf(back), bytes);
  EXPECT_EQ(back.passes(), 2u);
}

TEST(Film, DamagedBytesAreRefused) {
  const Bytes bytes = BytesOf(FilmOf(TileGrid(4, 4), {Rgb(1)}));
  for (size_t size = 0; size < bytes.size(); ++size) {
    ByteReader in(std::string_view(bytes).substr(0, size), "film");
    EXPECT_THROW(Film::Read(in), Error) << size;
  }
  Bytes other_size = bytes;
  other_size[0] = 5;
  ByteReader resized(other_size, "film");
  EXPECT_THROW(Film::Read(resized), Error);
  Bytes nan = bytes;
  const double value = std::numeric_limits<double>::quiet_NaN();
  std::memcpy(nan.data() + nan.size() - 16, &value, 8);
  ByteReader poisoned(nan, "film");
  EXPECT_THROW(Film::Read(poisoned), Error);
}

}  // namespace
}  // namespace lodestar
