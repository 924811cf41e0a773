// Runs a program and catches what it says.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lodestar {

struct Ran {
  int code = -1;  // 128 + signal where it was killed
  std::string out, err;
};

// `environment`: "NAME=VALUE" in front of the command.
Ran RunProgram(const std::vector<std::string>& words, const std::vector<std::string>& environment = {});
// The built `lodestar` with these arguments.
Ran RunLodestar(std::vector<std::string> arguments, const std::vector<std::string>& environment = {});

std::string ReadText(const std::filesystem::path& path);

// A scene that renders in milliseconds: a lit square over a floor, 16x12 pixels, 4 spp.
extern const char kTinyScene[];
// A floor in 16x12 pixels, to be lit by what follows; and a spot so strong and so near it that light which comes back
// to where it shines is beyond the range of float.
extern const char kPlainFloor[], kBlindingLight[];

}  // namespace lodestar
