#include "client/guide_canvas.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "client/guide_font.h"
#include "client/values.h"
#include "core/film/oklab.h"
#include "core/image/image.h"

namespace lodestar {
namespace {

constexpr Colour kPaper{250, 250, 250}, kInk{20, 20, 20}, kBlack{0, 0, 0}, kWhite{255, 255, 255};
constexpr uint32_t kMargin = 12, kLeastSide = 384, kBarHeight = 14, kLineHeight = 20, kTick = 4;
constexpr float kShade = 0.35f;  // how much of a picture is the scene that is blended in

Colour Mix(Colour a, Colour b, float t) {
  Colour mixed;
  for (size_t c = 0; c < 3; ++c) mixed[c] = static_cast<uint8_t>(std::lround(Lerp(t, a[c], b[c])));
  return mixed;
}

std::string PowerOfTen(int exponent) {
  if (exponent >= -2 && exponent <= 3) return FormatNumber(std::pow(10.0, exponent));
  char text[16];
  std::snprintf(text, sizeof text, "1e%d", exponent);
  return text;
}

void DrawLegend(Canvas* canvas, uint32_t y, uint32_t width, const LogScale& scale) {
  for (uint32_t x = 0; x < width; ++x)
    canvas->Fill(kMargin + x, y, 1, kBarHeight,
                 SequentialColour(static_cast<float>(x) / static_cast<float>(width - 1)));
  const uint32_t below = y + kBarHeight;
  const auto label = [&](float position, const std::string& text, uint32_t* free_from) {
    const uint32_t x = kMargin + static_cast<uint32_t>(position * static_cast<float>(width - 1));
    const uint32_t half = Canvas::TextWidth(text, 1) / 2;
    const uint32_t from = std::min(std::max(x, kMargin + half) - half, kMargin + width - std::min(width, 2 * half));
    canvas->Fill(x, below, 1, kTick, kInk);
    if (from < *free_from) return;
    canvas->Text(from, below + kTick + 2, text, 1, kInk);
    *free_from = from + 2 * half + 6;
  };
  uint32_t free_from = 0;
  const int first = static_cast<int>(std::ceil(std::log10(scale.low) - 1e-6)),
            last = static_cast<int>(std::floor(std::log10(scale.high) + 1e-6));
  if (last <= first) {  // less than two powers of ten
    label(0, FormatNumber(scale.low), &free_from);
    label(1, FormatNumber(scale.high), &free_from);
    return;
  }
  for (int exponent = first; exponent <= last; ++exponent)
    label(scale.Position(std::pow(10.0f, static_cast<float>(exponent))), PowerOfTen(exponent), &free_from);
}

}  // namespace

Canvas::Canvas(uint32_t width, uint32_t height, Colour background)
    : width_(width), height_(height), bytes_(size_t{width} * height * 3) {
  Fill(0, 0, width, height, background);
}

void Canvas::Set(uint32_t x, uint32_t y, Colour colour) {
  if (x >= width_ || y >= height_) return;
  std::copy(colour.begin(), colour.end(), bytes_.begin() + static_cast<std::ptrdiff_t>((size_t{y} * width_ + x) * 3));
}

void Canvas::Fill(uint32_t x, uint32_t y, uint32_t width, uint32_t height, Colour colour) {
  for (uint32_t j = y; j < y + height; ++j) {
    for (uint32_t i = x; i < x + width; ++i) Set(i, j, colour);
  }
}

void Canvas::Text(uint32_t x, uint32_t y, std::string_view text, uint32_t scale, Colour colour) {
  for (const char c : text) {
    const auto rows = Glyph(c);
    for (uint32_t j = 0; j < 7; ++j) {
      for (uint32_t i = 0; i < 5; ++i) {
        if (rows[j] & (0x10u >> i)) Fill(x + i * scale, y + j * scale, scale, scale, colour);
      }
    }
    x += 6 * scale;
  }
}

void Canvas::WritePng(const std::filesystem::path& path) const {
  lodestar::WritePng(path.string(), width_, height_, bytes_);
}

LogScale LogScale::Of(const FloatGrid& grid) {
  float least = kInfinity, greatest = 0;
  for (const float value : grid.values) {
    if (!(value > 0) || !std::isfinite(value)) continue;
    least = std::min(least, value);
    greatest = std::max(greatest, value);
  }
  if (!(greatest > 0)) return {};
  least = std::max(least, 1e-5f * greatest);
  return least < 0.999f * greatest ? LogScale{least, greatest} : LogScale{0.5f * greatest, 2 * greatest};
}

float LogScale::Position(float value) const {
  if (!(value > low)) return 0;
  return std::min(1.0f, Log(value / low) / Log(high / low));
}

Canvas DrawPicture(const FloatGrid& grid, const PictureStyle& style) {
  const LogScale scale = style.scale.value_or(LogScale::Of(grid));
  const uint32_t longest = std::max(grid.width, grid.height), zoom = std::max(1u, (kLeastSide + longest - 1) / longest);
  const uint32_t width = std::max(kLeastSide, grid.width * zoom),
                 height = grid.height * zoom;  // of what is inside the margins
  const uint32_t top = kMargin + kLineHeight;
  Canvas canvas(width + 2 * kMargin, top + height + kMargin + kBarHeight + kTick + 2 * kLineHeight, kPaper);
  // 1. What it shows; small where it would not fit.
  canvas.Text(kMargin, kMargin - 2, style.title, Canvas::TextWidth(style.title, 2) <= width ? 2 : 1, kInk);
  // 2. The values.
  for (uint32_t y = 0; y < grid.height; ++y) {
    for (uint32_t x = 0; x < grid.width; ++x) {
      const size_t i = size_t{y} * grid.width + x;
      const float value = grid.values[i];
      Colour colour = value > 0 ? SequentialColour(scale.Position(value)) : kBlack;
      if (!style.shade.empty()) {
        const auto grey = static_cast<uint8_t>(std::clamp(style.shade[i], 0.0f, 1.0f) * 255);
        colour = Mix(colour, {grey, grey, grey}, kShade);
      }
      if (!style.borders.empty() && style.borders[i]) colour = Mix(colour, kBlack, 0.55f);
      canvas.Fill(kMargin + x * zoom, top + y * zoom, zoom, zoom, colour);
    }
  }
  if (style.marker) {
    const auto at = [&](float v, uint32_t side) {
      return static_cast<uint32_t>(std::clamp(v, 0.0f, static_cast<float>(side - 1)) * static_cast<float>(zoom));
    };
    const uint32_t x = kMargin + at((*style.marker)[0], grid.width), y = top + at((*style.marker)[1], grid.height);
    for (uint32_t arm = 3; arm < 10; ++arm) {
      for (const int side : {-1, 1}) {
        const uint32_t dx = static_cast<uint32_t>(side) * arm;
        canvas.Fill(x + dx - 1, y - 1, 3, 3, kBlack);
        canvas.Fill(x - 1, y + dx - 1, 3, 3, kBlack);
      }
    }
    for (uint32_t arm = 3; arm < 10; ++arm) {
      for (const int side : {-1, 1}) {
        const uint32_t dx = static_cast<uint32_t>(side) * arm;
        canvas.Set(x + dx, y, kWhite);
        canvas.Set(x, y + dx, kWhite);
      }
    }
  }
  // 3. What the colours mean.
  const uint32_t bar = top + height + kMargin;
  DrawLegend(&canvas, bar, width, scale);
  canvas.Text(kMargin, bar + kBarHeight + kTick + kLineHeight - 4, style.caption, 1, kInk);
  return canvas;
}

}  // namespace lodestar
