#include <cmath>

#include "core/base/error.h"
#include "rpc/convert.h"

namespace lodestar {
namespace {

constexpr size_t kMaxText = 64 << 10;

[[noreturn]] void Refuse(const std::string& what) {
  throw Error(ErrorKind::kInvalidInput, what);
}
ContentHash Hash(const std::string& hex, const char* what) {
  if (!IsContentHash(hex)) Refuse(std::string(what) + " is not a SHA-256 of 64 lower-case hex digits");
  return {hex};
}

// Who, under which lease, for which job: what a survey and a failure begin with.
template <class Message, class Value>
void PutSender(const Value& value, Message* m) {
  m->set_worker_id(value.worker.value);
  m->set_lease_id(value.lease.value);
  m->set_job_id(value.job.value);
}
template <class Value, class Message>
Value TakeSender(const Message& m) {
  Value value;
  value.worker.value = m.worker_id();
  value.lease.value = m.lease_id();
  value.job.value = m.job_id();
  return value;
}

std::string Limited(const std::string& text) {
  return text.size() <= kMaxText ? text : text.substr(0, kMaxText) + " [cut]";
}

}  // namespace

v1::Round ToProto(const Round& round) {
  v1::Round m;
  m.set_iteration(round.iteration);
  m.set_index(round.index);
  m.set_first_pass(round.first_pass);
  m.set_passes(round.passes);
  m.set_unit_count(round.unit_count);
  m.set_record(round.record);
  return m;
}
Round FromProto(const v1::Round& m) {
  return {m.iteration(), m.index(), m.first_pass(), m.passes(), m.unit_count(), m.record()};
}

v1::TreeNode ToProto(TreeNode node) {
  v1::TreeNode m;
  m.set_level(node.level);
  m.set_index(node.index);
  return m;
}
TreeNode FromProto(const v1::TreeNode& m) {
  // Shifts stay defined and blocks inside 32 bits whatever a peer sends.
  if (m.level() > 31 || (uint64_t{m.index()} << m.level()) > 0xffffffffu)
    Refuse("a tree node outside the range of units");
  return {m.level(), m.index()};
}

v1::Lease ToProto(const LeasedUnit& lease) {
  v1::Lease m;
  m.set_id(lease.id.value);
  m.set_job_id(lease.job.value);
  m.set_description_sha256(lease.description.hex);
  m.set_duration_ms(static_cast<uint32_t>(lease.duration / std::chrono::milliseconds(1)));
  if (lease.render) {
    auto* r = m.mutable_render();
    *r->mutable_round() = ToProto(lease.render->round);
    *r->mutable_node() = ToProto(lease.render->node);
    r->set_state_sha256(lease.render->state.hex);
    r->set_survey(lease.render->survey);
  } else if (lease.shard) {
    m.mutable_shard()->set_request(lease.shard->request);
  } else {
    m.mutable_survey();
  }
  return m;
}
LeasedUnit FromProto(const v1::Lease& m) {
  LeasedUnit lease;
  lease.id.value = m.id();
  lease.job.value = m.job_id();
  lease.description = Hash(m.description_sha256(), "a lease's job description");
  lease.duration = std::chrono::milliseconds(m.duration_ms());
  switch (m.unit_case()) {
    case v1::Lease::kRender:
      lease.render = RenderUnit{FromProto(m.render().round()), FromProto(m.render().node()),
                                Hash(m.render().state_sha256(), "a lease's state"), m.render().survey()};
      break;
    case v1::Lease::kShard:
      lease.shard = ShardUnit{m.shard().request()};
      break;
    case v1::Lease::kSurvey:
      break;
    default:
      Refuse("a lease without a unit this worker knows: install the coordinator's release");
  }
  return lease;
}

v1::ContributionHeader ToProto(const ContributionHeader& h) {
  v1::ContributionHeader m;
  m.set_worker_id(h.worker.value);
  for (const LeaseId lease : h.leases) m.add_lease_ids(lease.value);
  m.set_job_id(h.job.value);
  *m.mutable_round() = ToProto(h.round);
  for (const TreeNode node : h.nodes) *m.add_nodes() = ToProto(node);
  m.set_state_sha256(h.state.hex);
  m.set_size(h.size);
  m.set_seconds(h.seconds);
  return m;
}
ContributionHeader FromProto(const v1::ContributionHeader& m) {
  ContributionHeader h;
  h.worker.value = m.worker_id();
  for (const uint64_t lease : m.lease_ids()) h.leases.push_back({lease});
  h.job.value = m.job_id();
  h.round = FromProto(m.round());
  if (m.nodes().empty()) Refuse("a contribution of no tree nodes");
  for (const auto& node : m.nodes()) h.nodes.push_back(FromProto(node));
  h.state = Hash(m.state_sha256(), "a contribution's state");
  h.size = m.size();
  h.seconds = std::isfinite(m.seconds()) && m.seconds() > 0 ? m.seconds() : 0;
  if (h.size > kMaxContributionBytes)
    Refuse("a contribution of " + std::to_string(h.size) + " bytes; at most " + std::to_string(kMaxContributionBytes) +
           " are taken");
  return h;
}

v1::RegisterRequest ToProto(const WorkerInfo& info) {
  v1::RegisterRequest m;
  m.set_protocol_version(info.protocol_version);
  m.set_build_id(info.build_id);
  m.set_canary(info.canary);
  m.set_name(info.name);
  m.set_threads(info.threads);
  m.set_tree_canary(info.tree_canary);
  return m;
}
WorkerInfo FromProto(const v1::RegisterRequest& m) {
  if (m.build_id().size() > 256 || m.canary().size() > 256 || m.name().size() > 256 || m.tree_canary().size() > 256)
    Refuse("a worker's name, build id and canaries have at most 256 bytes each");
  return {m.protocol_version(), m.build_id(), m.canary(), m.name(), m.threads(), m.tree_canary()};
}

v1::SubmitSurveyRequest ToProto(const SurveyResult& r) {
  v1::SubmitSurveyRequest m;
  PutSender(r, &m);
  if (r.scene_error.empty()) {
    m.set_survey(r.survey);
  } else {
    m.set_scene_error(r.scene_error);
  }
  for (const auto& line : r.log) m.add_log(line);
  return m;
}
SurveyResult FromProto(const v1::SubmitSurveyRequest& m) {
  auto r = TakeSender<SurveyResult>(m);
  r.survey = m.survey();
  r.scene_error = Limited(m.scene_error());
  if (m.result_case() == v1::SubmitSurveyRequest::RESULT_NOT_SET) Refuse("a survey without a result");
  for (const auto& line : m.log()) {
    if (r.log.size() == 100) break;
    r.log.push_back(Limited(line));
  }
  return r;
}

v1::SubmitShardRequest ToProto(const ShardAnswer& a) {
  v1::SubmitShardRequest m;
  PutSender(a, &m);
  m.set_trees(a.trees);
  return m;
}
ShardAnswer FromProto(const v1::SubmitShardRequest& m) {
  auto a = TakeSender<ShardAnswer>(m);
  if (m.trees().size() > kMaxShardBytes)
    Refuse("a shard of " + std::to_string(m.trees().size()) + " bytes; at most " + std::to_string(kMaxShardBytes) +
           " are taken");
  a.trees = m.trees();
  return a;
}

v1::ReportFailureRequest ToProto(const UnitFailure& f) {
  v1::ReportFailureRequest m;
  PutSender(f, &m);
  m.set_kind(static_cast<v1::ReportFailureRequest::Kind>(f.kind));
  m.set_message(f.message);
  return m;
}
UnitFailure FromProto(const v1::ReportFailureRequest& m) {
  if (m.kind() < v1::ReportFailureRequest::KIND_RETURNED || m.kind() > v1::ReportFailureRequest::KIND_WORKER)
    Refuse("a failure of an unknown kind");
  auto f = TakeSender<UnitFailure>(m);
  f.kind = static_cast<UnitFailure::Kind>(m.kind());
  f.message = Limited(m.message());
  return f;
}

void RefuseUnknownFields(const google::protobuf::Message& message) {
  const auto* reflection = message.GetReflection();
  const auto& unknown = reflection->GetUnknownFields(message);
  if (unknown.field_count() > 0) {
    Refuse("field " + std::to_string(unknown.field(0).number()) + " of " + message.GetDescriptor()->full_name() +
           " is not known here: the sender is newer, install the same release on both ends");
  }
  std::vector<const google::protobuf::FieldDescriptor*> fields;
  reflection->ListFields(message, &fields);
  for (const auto* field : fields) {
    if (field->cpp_type() != google::protobuf::FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (field->is_map() &&
        field->message_type()->map_value()->cpp_type() != google::protobuf::FieldDescriptor::CPPTYPE_MESSAGE)
      continue;
    if (field->is_repeated()) {
      for (int i = 0; i < reflection->FieldSize(message, field); ++i)
        RefuseUnknownFields(reflection->GetRepeatedMessage(message, field, i));
    } else {
      RefuseUnknownFields(reflection->GetMessage(message, field));
    }
  }
}

}  // namespace lodestar
