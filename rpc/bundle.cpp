#include <algorithm>
#include <set>

#include "core/base/error.h"
#include "rpc/farm_client.h"

namespace lodestar {
namespace fs = std::filesystem;

SceneBundle BundleScene(const std::vector<std::string>& files) {
  if (files.empty()) throw Error(ErrorKind::kInvalidInput, "a scene without files cannot be uploaded");
  // Step 1: absolute names without "." and "..", links kept as they are (their names are what the scene uses).
  std::vector<fs::path> paths;
  for (const auto& file : files) {
    auto path = fs::absolute(file).lexically_normal();
    if (!fs::is_regular_file(path))
      throw Error(ErrorKind::kNotFound, path.string() + ", which the scene names, is not a file");
    paths.push_back(std::move(path));
  }
  // Step 2: the deepest folder that holds all of them.
  fs::path root = paths.front().parent_path();
  for (const auto& path : paths) {
    while (std::mismatch(root.begin(), root.end(), path.begin(), path.end()).first != root.end())
      root = root.parent_path();
  }
  // Step 3: names relative to it.
  SceneBundle bundle;
  bundle.main = paths.front().lexically_relative(root).generic_string();
  std::set<std::string> seen;
  for (const auto& path : paths) {
    auto name = path.lexically_relative(root).generic_string();
    if (seen.insert(name).second) bundle.files.push_back({name, path});
  }
  return bundle;
}

}  // namespace lodestar
