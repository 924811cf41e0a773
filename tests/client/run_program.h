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

// A folder of its own for the current test, emptied first and removed with the object.
class TestFolder {
 public:
  TestFolder();
  ~TestFolder();
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  std::filesystem::path Write(const std::string& name, const std::string& text) const;

 private:
  std::filesystem::path path_;
};

std::string ReadText(const std::filesystem::path& path);

// A scene that renders in milliseconds: a lit square over a floor, 16x12 pixels, 4 spp.
extern const char kTinyScene[];

}  // namespace lodestar
