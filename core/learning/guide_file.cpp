#include "core/learning/guide_file.h"

#include <fstream>
#include <sstream>

#include "core/base/sealed_bytes.h"

namespace lodestar {
namespace {

constexpr uint32_t kMagic = DocumentMagic("LGDE"), kVersion = 1;

}  // namespace

Bytes GuideFile::Serialize() const {
  ByteWriter content;
  content.PutString(job.Serialize());
  content.PutString(survey.Serialize());
  content.Put(iterations);
  content.PutString(state);
  content.Put<uint8_t>(training.has_value());
  if (training) {
    content.PutString(training->state);
    content.PutString(training->statistics);
  }
  ByteWriter out = OpenDocument(kMagic, kVersion);
  out.PutString(Compress(content.bytes()));
  return Seal(std::move(out));
}

GuideFile GuideFile::Parse(std::string_view bytes, const std::string& name) {
  ByteReader envelope(OpenSealed(bytes, kMagic, kVersion, name), name);
  const Bytes content = Decompress(envelope.GetString(), name);
  envelope.ExpectEnd();
  ByteReader in(content, name);
  GuideFile file;
  file.job = JobSpec::Parse(in.GetString());
  file.survey = Survey::Parse(in.GetString());
  file.iterations = in.Get<uint32_t>();
  file.state = in.GetString();
  if (in.GetFlag()) {
    file.training.emplace();
    file.training->state = in.GetString();
    file.training->statistics = in.GetString();
  }
  in.ExpectEnd();
  return file;
}

GuideFile GuideFile::Read(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream bytes;
  if (!in || !(bytes << in.rdbuf())) {
    throw Error(ErrorKind::kNotFound,
                path.string() + ": cannot read this guiding state; `lodestar render SCENE --state FILE` writes one");
  }
  return Parse(bytes.str(), "guiding state " + path.string());
}

void GuideFile::CheckScene(const std::string& scene_hash, const std::string& scene_path,
                           const std::string& name) const {
  if (scene_hash == survey.scene_hash) return;
  throw Error(ErrorKind::kConflict,
              name + " was learned in another scene than " + scene_path + " (its hash is " +
                  survey.scene_hash.substr(0, 16) + "..., the scene's " + scene_hash.substr(0, 16) +
                  "...); give the scene it was rendered from, unchanged, or render again with --state");
}

bool Learns(const Method& method) {
  const auto initial = method.Initial();
  return method.ActiveUnder(initial).method != &method || method.IterationPasses(*initial, 0) > 0;
}

}  // namespace lodestar
