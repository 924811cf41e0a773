#include "rpc/work_types.h"

namespace lodestar {
namespace {
constexpr uint32_t kDescriptionVersion = 1;
}

Bytes JobDescription::Serialize() const {
  ByteWriter out;
  out.Put(kDescriptionVersion);
  out.PutString(spec.Serialize());
  out.PutString(scene.Serialize());
  return out.Take();
}

JobDescription JobDescription::Parse(std::string_view bytes) {
  ByteReader in(bytes, "job description");
  if (in.Get<uint32_t>() != kDescriptionVersion) in.Fail("is of another version");
  JobDescription description;
  description.spec = JobSpec::Parse(in.GetString());
  description.scene = SceneManifest::Parse(in.GetString());
  in.ExpectEnd();
  return description;
}

}  // namespace lodestar
