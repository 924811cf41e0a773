#include "client/values.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>

#include "core/base/error.h"
#include "core/base/picture_size.h"

namespace lodestar {
namespace {

// A non-negative decimal number at the front of `text`, which is shortened by it.
std::optional<double> TakeNumber(std::string_view* text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value, std::chars_format::fixed);
  if (error != std::errc() || !(value >= 0)) return std::nullopt;
  text->remove_prefix(static_cast<size_t>(end - text->data()));
  return value;
}

std::optional<double> TakeUnit(std::string_view* text) {
  struct Unit {
    std::string_view name;
    double seconds;
  };
  // Longest first: "min" and "ms" begin with "m".
  static constexpr Unit kUnits[] = {{"min", 60}, {"ms", 1e-3}, {"s", 1}, {"m", 60}, {"h", 3600}, {"d", 86400}};
  for (const Unit& unit : kUnits) {
    if (!text->starts_with(unit.name)) continue;
    text->remove_prefix(unit.name.size());
    return unit.seconds;
  }
  return std::nullopt;
}

std::optional<PixelPair> ParsePair(std::string_view text, char separator) {
  PixelPair pair;
  const size_t at = text.find(separator);
  if (at == std::string_view::npos) return std::nullopt;
  const auto parse = [](std::string_view part, uint32_t* value) {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), *value);
    return error == std::errc() && end == part.data() + part.size() && !part.empty();
  };
  if (!parse(text.substr(0, at), &pair.x) || !parse(text.substr(at + 1), &pair.y)) return std::nullopt;
  return pair;
}

std::string Printf(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

}  // namespace

double ParseDuration(std::string_view text) {
  std::string_view rest = text;
  double seconds = 0;
  const auto refuse = [&]() -> double {
    throw Error(
        ErrorKind::kInvalidInput,
        "'" + std::string(text) + "' is not a duration; write seconds or a unit, e.g. 90, 60s, 5m, 1h30m, 250ms");
  };
  for (int parts = 0; !rest.empty(); ++parts) {
    const auto number = TakeNumber(&rest);
    if (!number) return refuse();
    if (rest.empty() && parts == 0) {  // a plain number is seconds
      seconds = *number;
      break;
    }
    const auto unit = TakeUnit(&rest);
    if (!unit) return refuse();
    seconds += *number * *unit;
  }
  if (!(seconds > 0) || !std::isfinite(seconds)) return refuse();
  return seconds;
}

std::string FormatDuration(double seconds) {
  if (!(seconds >= 0)) return "-:--";
  const auto whole = static_cast<long long>(std::min(seconds + 0.5, 3.6e8));
  char text[64];
  if (whole >= 3600) {
    std::snprintf(text, sizeof text, "%lld:%02lld:%02lld", whole / 3600, whole / 60 % 60, whole % 60);
  } else {
    std::snprintf(text, sizeof text, "%lld:%02lld", whole / 60, whole % 60);
  }
  return text;
}

Resolution ParseResolution(std::string_view text) {
  const auto pair = ParsePair(text, 'x');
  if (!pair || pair->x == 0 || pair->y == 0 || pair->x > kMaxSide || pair->y > kMaxSide) {
    throw Error(ErrorKind::kInvalidInput, "'" + std::string(text) +
                                              "' is not a resolution; write WIDTHxHEIGHT with 1 to " +
                                              std::to_string(kMaxSide) + " pixels each, e.g. 640x360");
  }
  return *pair;
}

Pixel ParsePixel(std::string_view text) {
  const auto pair = ParsePair(text, ',');
  if (!pair)
    throw Error(ErrorKind::kInvalidInput,
                "'" + std::string(text) + "' is not a pixel; write X,Y with (0,0) the upper left one, e.g. 12,34");
  return *pair;
}

std::string FormatCount(double value) {
  if (value >= 1e9) return Printf("%.2f G", value / 1e9);
  if (value >= 1e6) return Printf("%.2f M", value / 1e6);
  if (value >= 1e4) return Printf("%.0f k", value / 1e3);
  return Printf("%.0f", value);
}

std::string FormatBytes(double bytes) {
  if (bytes >= 1e9) return Printf("%.2f GB", bytes / 1e9);
  if (bytes >= 1e6) return Printf("%.1f MB", bytes / 1e6);
  if (bytes >= 1e3) return Printf("%.1f kB", bytes / 1e3);
  return Printf("%.0f B", bytes);
}

std::string FormatNumber(double value) {
  return Printf("%.4g", value);
}

std::string ShellQuote(std::string_view word) {
  const auto plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) ||
           std::string_view("-_./=,:+@%").find(c) != std::string_view::npos;
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), plain)) return std::string(word);
  std::string quoted = "'";
  for (const char c : word) {
    if (c == '\'') {
      quoted += "'\\''";
    } else {
      quoted += c;
    }
  }
  return quoted + "'";
}

}  // namespace lodestar
