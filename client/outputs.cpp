#include "client/outputs.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "core/base/error.h"

namespace lodestar {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void FailWrite(const fs::path& path, const std::string& why) {
  throw Error(ErrorKind::kIo,
              path.string() + ": cannot write: " + why + "; check the folder, its permissions and the free space");
}

template <class Write>
void WriteBeside(const fs::path& path, const Write& write) {
  const fs::path beside = path.string() + ".part" + std::to_string(getpid());
  {
    std::ofstream out(beside, std::ios::binary);
    if (out) write(out);
    out.flush();
    if (!out) {
      const std::string why = std::strerror(errno);
      std::error_code ignored;
      fs::remove(beside, ignored);
      FailWrite(path, why);
    }
  }
  std::error_code error;
  fs::rename(beside, path, error);
  if (error) FailWrite(path, error.message());
}

// Portable float map: rows from the bottom up, little-endian (the negative scale says so).
void WritePfm(const fs::path& path, const Image& image) {
  static_assert(sizeof(Rgb) == 3 * sizeof(float));
  WriteBeside(path, [&](std::ofstream& out) {
    out << "PF\n" << image.width << " " << image.height << "\n-1.0\n";
    for (uint32_t y = image.height; y-- > 0;) {
      out.write(reinterpret_cast<const char*>(image.pixels.data() + size_t(y) * image.width),
                std::streamsize(size_t(image.width) * sizeof(Rgb)));
    }
  });
}

FloatImage ToFloatImage(const Image& image) {
  FloatImage floats;
  floats.width = static_cast<int>(image.width);
  floats.height = static_cast<int>(image.height);
  floats.pixels = image.pixels;
  return floats;
}

}  // namespace

std::string Ending(const fs::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

OutputPaths OutputPaths::For(const fs::path& image) {
  const std::string ending = Ending(image);
  if (ending != ".exr" && ending != ".png" && ending != ".pfm") {
    throw Error(ErrorKind::kInvalidInput,
                "-o '" + image.string() + "' must end in .exr (with variance and metadata), .png or .pfm");
  }
  const fs::path stem = fs::path(image).replace_extension();
  OutputPaths paths;
  paths.image = image;
  paths.png = ending == ".png" ? image : fs::path(stem.string() + ".png");
  paths.csv = stem.string() + ".csv";
  paths.json = stem.string() + ".json";
  paths.plot = stem.string() + "-error.png";
  return paths;
}

void PrepareFolder(const fs::path& file) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw Error(ErrorKind::kIo, folder.string() + ": cannot make this folder: " + error.message() + "; choose another");
  if (access(folder.c_str(), W_OK) != 0)
    throw Error(ErrorKind::kIo,
                folder.string() + ": cannot write into this folder: " + std::strerror(errno) + "; choose another");
  if (fs::is_directory(file)) throw Error(ErrorKind::kInvalidInput, file.string() + " is a folder; name a file in it");
}

void WriteImage(const fs::path& path, const Image& image, const std::map<std::string, std::string>& metadata,
                const std::vector<ImageChannel>& more) {
  const std::string ending = Ending(path);
  if (ending == ".png") return WritePng(path.string(), ToFloatImage(image));
  if (ending == ".pfm") return WritePfm(path, image);
  const float* rgb = &image.pixels.data()->r;
  std::vector<ImageChannel> channels = {{"R", rgb, 3}, {"G", rgb + 1, 3}, {"B", rgb + 2, 3}};
  if (image.variance.size() == image.pixels.size()) channels.push_back({"variance.Y", image.variance.data(), 1});
  channels.insert(channels.end(), more.begin(), more.end());
  ExrOptions options;
  options.metadata = metadata;
  WriteExr(path.string(), static_cast<int>(image.width), static_cast<int>(image.height), channels, options);
}

Image ReadImageFile(const fs::path& path) {
  if (!fs::exists(path)) throw Error(ErrorKind::kNotFound, path.string() + ": no such file");
  if (fs::is_directory(path)) throw Error(ErrorKind::kNotFound, path.string() + " is a folder; name an image in it");
  FloatImage floats = ReadImage(path.string());
  Image image;
  image.width = static_cast<uint32_t>(floats.width);
  image.height = static_cast<uint32_t>(floats.height);
  image.pixels = std::move(floats.pixels);
  return image;
}

void CheckReference(const Image& reference, const std::string& path, uint32_t width, uint32_t height) {
  for (size_t i = 0; i < reference.size(); ++i) {
    if (IsFinite(reference.pixels[i])) continue;
    throw Error(ErrorKind::kInvalidInput, "the reference " + path + " is not finite at pixel " +
                                              std::to_string(i % reference.width) + "," +
                                              std::to_string(i / reference.width));
  }
  if (reference.width == width && reference.height == height) return;
  const std::string size = std::to_string(reference.width) + "x" + std::to_string(reference.height);
  throw Error(ErrorKind::kInvalidInput, "the reference " + path + " has " + size +
                                            " pixels and the render would have " + std::to_string(width) + "x" +
                                            std::to_string(height) + "; try --resolution " + size);
}

void WriteText(const fs::path& path, const std::string& text) {
  WriteBeside(path, [&](std::ofstream& out) { out << text; });
}

}  // namespace lodestar
