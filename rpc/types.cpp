#include "rpc/types.h"

#include "core/base/error.h"

namespace lodestar {
namespace {

constexpr uint32_t kManifestVersion = 1;

[[noreturn]] void Refuse(const std::string& what) {
  throw Error(ErrorKind::kInvalidInput, "scene manifest: " + what);
}

// A name that stays inside the folder it is put in, on any file system we write to.
void CheckName(const std::string& name) {
  if (name.empty() || name.size() > 1024) Refuse("a file name must have 1 to 1024 bytes");
  if (name.front() == '/' || name.back() == '/') Refuse("'" + name + "' is not a relative file name");
  for (const char c : name) {
    if (static_cast<unsigned char>(c) < 32 || c == '\\' || c == 127)
      Refuse("a file name holds a control character or a backslash");
  }
  size_t at = 0;
  while (at <= name.size()) {
    const size_t end = std::min(name.find('/', at), name.size());
    const std::string part = name.substr(at, end - at);
    if (part.empty() || part == "." || part == "..") Refuse("'" + name + "' has an empty, '.' or '..' part");
    at = end + 1;
  }
}

}  // namespace

void SceneManifest::Validate() const {
  if (files.empty()) Refuse("no files");
  if (files.size() > kMaxSceneFiles)
    Refuse(std::to_string(files.size()) + " files, at most " + std::to_string(kMaxSceneFiles) + " are taken");
  if (!files.contains(main)) Refuse("the main file '" + main + "' is not among the files");
  uint64_t total = 0;
  for (const auto& [name, file] : files) {
    CheckName(name);
    if (!IsContentHash(file.hash.hex)) Refuse("'" + name + "' has no valid SHA-256");
    if (file.size > kMaxAssetBytes)
      Refuse("'" + name + "' has " + std::to_string(file.size) + " bytes, at most " + std::to_string(kMaxAssetBytes) +
             " are taken");
    total += file.size;
  }
  if (total > kMaxSceneBytes)
    Refuse(std::to_string(total) + " bytes in all, at most " + std::to_string(kMaxSceneBytes) + " are taken");
}

Bytes SceneManifest::Serialize() const {
  ByteWriter out;
  out.Put(kManifestVersion);
  out.PutString(main);
  out.Put<uint64_t>(files.size());
  for (const auto& [name, file] : files) {
    out.PutString(name);
    out.PutString(file.hash.hex);
    out.Put(file.size);
  }
  return out.Take();
}

SceneManifest SceneManifest::Parse(std::string_view bytes) {
  ByteReader in(bytes, "scene manifest");
  if (in.Get<uint32_t>() != kManifestVersion) in.Fail("is of another version");
  SceneManifest manifest;
  manifest.main = in.GetString();
  const auto count = in.Get<uint64_t>();
  for (uint64_t i = 0; i < count; ++i) {
    std::string name = in.GetString();
    SceneFile file;
    file.hash.hex = in.GetString();
    file.size = in.Get<uint64_t>();
    manifest.files.emplace(std::move(name), std::move(file));
  }
  in.ExpectEnd();
  return manifest;
}

const char* JobPhaseName(JobPhase phase) {
  switch (phase) {
    case JobPhase::kQueued:
      return "queued";
    case JobPhase::kRunning:
      return "running";
    case JobPhase::kDone:
      return "done";
    case JobPhase::kFailed:
      return "failed";
    case JobPhase::kCancelled:
      return "cancelled";
  }
  return "unknown";
}

}  // namespace lodestar
