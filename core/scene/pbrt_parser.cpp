#include "core/scene/pbrt_parser.h"

#include "core/scene/pbrt_builder.h"
#include "core/scene/pbrt_file.h"

namespace lodestar {
namespace {

SceneDescription Parse(PbrtBuilder& builder, std::string text, const std::string& name,
                       const std::filesystem::path& folder) {
  Tokenizer in(std::move(text), name);
  builder.Read(in, folder);
  return builder.Finish(in.Here());
}

}  // namespace

SceneDescription ParsePbrtFile(const std::filesystem::path& path, const ParseOptions& options) {
  PbrtBuilder builder(options, path.parent_path());
  std::string text = ReadFileMaybeGzip(path);
  builder.AddFile(path);
  return Parse(builder, std::move(text), path.string(), path.parent_path());
}

SceneDescription ParsePbrtText(std::string_view text, const std::string& name, const std::filesystem::path& folder,
                               const ParseOptions& options) {
  PbrtBuilder builder(options, folder);
  return Parse(builder, std::string(text), name, folder);
}

}  // namespace lodestar
