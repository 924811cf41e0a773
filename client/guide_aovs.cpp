#include "client/guide_aovs.h"

#include <limits>
#include <map>
#include <sstream>

#include "client/suggest.h"
#include "core/base/error.h"
#include "core/film/error_metrics.h"

namespace lodestar {

AovChoice AovChoice::Parse(const std::string& text) {
  AovChoice choice;
  const std::map<std::string, bool AovChoice::*> names = {{"albedo", &AovChoice::albedo},
                                                          {"normal", &AovChoice::normal},
                                                          {"depth", &AovChoice::depth},
                                                          {"bsdf-fraction", &AovChoice::bsdf_fraction},
                                                          {"nee", &AovChoice::nee}};
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    const auto found = names.find(word);
    if (found == names.end()) {
      std::vector<std::string> known;
      for (const auto& [name, member] : names) known.push_back(name);
      throw Error(ErrorKind::kInvalidInput,
                  "--aov: unknown '" + word + "'" + Suggestion(word, known) + " (there are: " + Join(known) + ")");
    }
    choice.*found->second = true;
  }
  return choice;
}

std::vector<ImageChannel> AovChannels(const AovChoice& choice, const Features& features) {
  static_assert(sizeof(Rgb) == 3 * sizeof(float) && sizeof(Vec3) == 3 * sizeof(float));
  std::vector<ImageChannel> channels;
  const auto add3 = [&](const std::string& layer, const char* names, const float* values) {
    for (int c = 0; c < 3; ++c) channels.push_back({layer + "." + names[c], values + c, 3});
  };
  if (choice.albedo) add3("albedo", "RGB", &features.albedo.data()->r);
  if (choice.normal) add3("N", "XYZ", &features.normal.data()->x);
  if (choice.depth) channels.push_back({"Z", features.depth.data(), 1});
  if (choice.bsdf_fraction) channels.push_back({"guide.bsdf_fraction", features.bsdf_fraction.data(), 1});
  if (choice.nee) channels.push_back({"guide.nee", features.nee.data(), 1});
  return channels;
}

void WriteFractionPng(const std::filesystem::path& path, const Features& features) {
  std::vector<float> values;
  for (const float fraction : features.bsdf_fraction)
    values.push_back(fraction > 0 ? 2 * fraction - 1 : std::numeric_limits<float>::quiet_NaN());
  WritePng(path.string(), features.width, features.height, FalseColour(values));
}

}  // namespace lodestar
