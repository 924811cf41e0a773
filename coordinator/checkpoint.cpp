#include "coordinator/checkpoint.h"

namespace lodestar {
namespace {
constexpr uint32_t kMagic = DocumentMagic("LDCJ");
constexpr uint32_t kVersion = 3;
}  // namespace

Bytes JobCheckpoint::Serialize() const {
  ByteWriter out;
  out.Put(kMagic);
  out.Put(kVersion);
  out.PutString(loop);
  out.Put(round.iteration);
  out.Put(round.index);
  out.Put(round.first_pass);
  out.Put(round.passes);
  out.Put(round.unit_count);
  out.Put<uint8_t>(round.record);
  out.PutString(state.hex);
  out.Put<uint64_t>(nodes.size());
  for (const TreeNode node : nodes) {
    out.Put(node.level);
    out.Put(node.index);
  }
  out.PutString(merged);
  return out.Take();
}

JobCheckpoint JobCheckpoint::Parse(std::string_view bytes) {
  ByteReader in(bytes, "job checkpoint");
  if (in.Get<uint32_t>() != kMagic) in.Fail("does not begin like one");
  if (const auto version = in.Get<uint32_t>(); version != kVersion) {
    throw Error(ErrorKind::kConflict, "job checkpoint of version " + std::to_string(version) +
                                          ", this coordinator reads version " + std::to_string(kVersion) +
                                          ": let the release that wrote it finish the job, or submit it again");
  }
  JobCheckpoint checkpoint;
  checkpoint.loop = in.GetString();
  Round& round = checkpoint.round;
  round.iteration = in.Get<uint32_t>();
  round.index = in.Get<uint32_t>();
  round.first_pass = in.Get<uint32_t>();
  round.passes = in.Get<uint32_t>();
  round.unit_count = in.Get<uint32_t>();
  round.record = in.Get<uint8_t>() != 0;
  checkpoint.state.hex = in.GetString();
  const auto count = in.Get<uint64_t>();
  for (uint64_t i = 0; i < count; ++i) {
    TreeNode node;
    node.level = in.Get<uint32_t>();
    node.index = in.Get<uint32_t>();
    checkpoint.nodes.push_back(node);
  }
  checkpoint.merged = in.GetString();
  in.ExpectEnd();
  return checkpoint;
}

}  // namespace lodestar
