#include "rpc/work_types.h"

#include <algorithm>

namespace lodestar {
namespace {
constexpr uint32_t kDescriptionVersion = 2;
}

Bytes JobDescription::Serialize() const {
  ByteWriter out;
  out.Put(kDescriptionVersion);
  out.PutString(spec.Serialize());
  out.PutString(scene.Serialize());
  out.Put(threads);
  return out.Take();
}

JobDescription JobDescription::Parse(std::string_view bytes) {
  ByteReader in(bytes, "job description");
  if (in.Get<uint32_t>() != kDescriptionVersion) in.Fail("is of another version");
  JobDescription description;
  description.spec = JobSpec::Parse(in.GetString());
  description.scene = SceneManifest::Parse(in.GetString());
  description.threads = in.Get<uint32_t>();
  in.ExpectEnd();
  return description;
}

bool ContributionHeader::Takes(const LeasedUnit& unit) const {
  if (!unit.render) return false;
  if (nodes.empty()) return true;
  return unit.job == job && unit.render->round == round && unit.render->state == state &&
         std::ranges::none_of(nodes, [&](TreeNode node) { return node.Overlaps(unit.render->node); });
}

void ContributionHeader::Add(const LeasedUnit& unit) {
  if (nodes.empty()) {
    job = unit.job;
    round = unit.render->round;
    state = unit.render->state;
  }
  leases.push_back(unit.id);
  const TreeNode node = unit.render->node;
  nodes.insert(std::ranges::upper_bound(nodes, node.first(), {}, &TreeNode::first), node);
}

}  // namespace lodestar
