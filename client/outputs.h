// The files of a render: OUT.exr with its picture OUT.png, OUT.csv and OUT.json with error against time, and
// OUT-error.png, their plot.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/film/film.h"
#include "core/image/image.h"

namespace lodestar {

// Of the name, in lower case: ".exr".
std::string Ending(const std::filesystem::path& path);

struct OutputPaths {
  std::filesystem::path image;  // .exr, .png or .pfm as asked for
  std::filesystem::path png, csv, json, plot;
  // Throws Error(kInvalidInput) for another ending or a folder.
  static OutputPaths For(const std::filesystem::path& image);
};

// Fails early, before anything is rendered: makes the folder, and throws Error(kIo) where it cannot be written to.
void PrepareFolder(const std::filesystem::path& file);

// By the ending of the name. An EXR holds R, G, B and variance.Y (the variance of the luminance of each pixel's mean)
// as 32-bit floats, `more` channels of the same size, and the metadata.
void WriteImage(const std::filesystem::path& path, const Image& image,
                const std::map<std::string, std::string>& metadata, const std::vector<ImageChannel>& more = {});

// Linear RGB, no variances. Throws Error(kNotFound / kCorrupt).
Image ReadImageFile(const std::filesystem::path& path);

// Throws Error(kInvalidInput) where the reference has another size than the render will have, or a pixel that is not
// finite.
void CheckReference(const Image& reference, const std::string& path, uint32_t width, uint32_t height);

// Text to a file; beside the name first, then renamed. Throws Error(kIo).
void WriteText(const std::filesystem::path& path, const std::string& text);

}  // namespace lodestar
