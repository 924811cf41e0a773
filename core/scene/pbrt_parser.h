// pbrt-v4 scene files (pbrt.org/fileformat-v4). Streaming, hand-written; every error carries file:line:column and what
// to try.
#pragma once

#include <filesystem>
#include <string_view>

#include "core/scene/description.h"

namespace lodestar {

struct ParseOptions {
  // Refuse what is not supported (false), or leave it out and list it in SceneDescription::left_out (true).
  bool lenient = false;
  // Not empty: files have relative names and lie in this folder; else Error(kInvalidInput), with nothing read of them.
  // A worker reads what a client sent it, and nothing else of its machine's; "/" asks for relative names alone.
  std::filesystem::path within = {};
};

// Throws Error: kNotFound for missing files, kUnsupported for a directive or parameter that exists in pbrt-v4 and not
// here, kInvalidInput for everything that is not pbrt-v4.
SceneDescription ParsePbrtFile(const std::filesystem::path& path, const ParseOptions& options = {});
// For tests and generators; relative names resolve against `folder`, `name` stands in for the file in messages.
SceneDescription ParsePbrtText(std::string_view text, const std::string& name, const std::filesystem::path& folder,
                               const ParseOptions& options = {});

}  // namespace lodestar
