#include "core/learning/job.h"

#include <algorithm>
#include <cmath>

#include "core/base/sealed_bytes.h"

namespace lodestar {
namespace {

constexpr uint32_t kJobMagic = DocumentMagic("LDJB"), kJobVersion = 2;
constexpr uint32_t kSurveyMagic = DocumentMagic("LDSV"), kSurveyVersion = 5;

void PutVec(ByteWriter& out, Vec3 v) {
  out.Put(v.x);
  out.Put(v.y);
  out.Put(v.z);
}
Vec3 GetVec(ByteReader& in) {
  const float x = in.Get<float>(), y = in.Get<float>(), z = in.Get<float>();
  return {x, y, z};
}

}  // namespace

void Budget::Check() const {
  const auto refuse = [](const std::string& what) { throw Error(ErrorKind::kInvalidInput, "budget: " + what); };
  if (!(seconds >= 0) || !std::isfinite(seconds))
    refuse("the time must be a number of seconds, 0 or more (0: no time budget)");
  if (!(error >= 0) || !std::isfinite(error)) refuse("the error must be a number, 0 or more (0: no error budget)");
  if (spp > kMaxSpp)
    refuse(std::to_string(spp) + " samples per pixel are more than the " + std::to_string(kMaxSpp) +
           " that can be told apart");
}

Bytes JobSpec::Serialize() const {
  ByteWriter out = OpenDocument(kJobMagic, kJobVersion);
  out.PutString(method);
  out.Put<uint64_t>(options.size());
  for (const auto& [name, value] : options) {
    out.PutString(name);
    out.PutString(value);
  }
  out.Put(budget.spp);
  out.Put(budget.seconds);
  out.Put(budget.error);
  out.Put(seed);
  out.Put(resolution_x);
  out.Put(resolution_y);
  out.PutString(filter);
  out.Put<int32_t>(max_depth);
  out.Put<int32_t>(training_iterations);
  out.Put<uint8_t>(lenient ? 1 : 0);
  return Seal(std::move(out));
}

JobSpec JobSpec::Parse(std::string_view bytes) {
  ByteReader in(OpenSealed(bytes, kJobMagic, kJobVersion, "job"), "job");
  JobSpec job;
  job.method = in.GetString();
  const auto count = in.Get<uint64_t>();
  for (uint64_t i = 0; i < count; ++i) {
    std::string name = in.GetString();
    // Ascending and unique, so that equal jobs have equal bytes.
    if (!job.options.empty() && !(job.options.rbegin()->first < name)) in.Fail("lists its options out of order");
    std::string value = in.GetString();
    job.options.emplace_hint(job.options.end(), std::move(name), std::move(value));
  }
  job.budget.spp = in.Get<uint64_t>();
  job.budget.seconds = in.Get<double>();
  job.budget.error = in.Get<double>();
  job.seed = in.Get<uint64_t>();
  job.resolution_x = in.Get<uint32_t>();
  job.resolution_y = in.Get<uint32_t>();
  job.filter = in.GetString();
  job.max_depth = in.Get<int32_t>();
  job.training_iterations = in.Get<int32_t>();
  job.lenient = in.GetFlag();
  in.ExpectEnd();
  return job;
}

void Survey::SetLeftOut(const std::vector<std::string>& all) {
  left_out.assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(std::min(all.size(), kMaxLeftOut)));
  if (all.size() > kMaxLeftOut) left_out.push_back("and " + std::to_string(all.size() - kMaxLeftOut) + " more");
}

Bytes Survey::Serialize() const {
  ByteWriter out = OpenDocument(kSurveyMagic, kSurveyVersion);
  PutVec(out, bounds.min);
  PutVec(out, bounds.max);
  out.Put(resolution_x);
  out.Put(resolution_y);
  out.Put<int32_t>(max_depth);
  out.Put(scene_spp);
  out.PutString(scene_hash);
  out.PutString(needs);
  out.PutString(not_needed);
  out.Put<uint8_t>(guidable);
  out.PutVector(light_groups);
  out.Put<uint64_t>(left_out.size());
  for (const std::string& line : left_out) out.PutString(line);
  return Seal(std::move(out));
}

Survey Survey::Parse(std::string_view bytes) {
  ByteReader in(OpenSealed(bytes, kSurveyMagic, kSurveyVersion, "survey"), "survey");
  Survey survey;
  survey.bounds.min = GetVec(in);
  survey.bounds.max = GetVec(in);
  survey.resolution_x = in.Get<uint32_t>();
  survey.resolution_y = in.Get<uint32_t>();
  survey.max_depth = in.Get<int32_t>();
  survey.scene_spp = in.Get<uint64_t>();
  survey.scene_hash = in.GetString();
  survey.needs = in.GetString();
  survey.not_needed = in.GetString();
  survey.guidable = in.GetFlag();
  survey.light_groups = in.GetVector<float>();
  if (survey.light_groups.size() > kMaxLightGroups) in.Fail("lists more groups of lights than there may be");
  for (const float share : survey.light_groups) {
    if (!(share > 0 && share <= 1.001f)) in.Fail("has a group of lights with an impossible share");
  }
  const auto left_out = in.Get<uint64_t>();
  if (left_out > kMaxLeftOut + 1) in.Fail("lists more left out than it may");
  for (uint64_t i = 0; i < left_out; ++i) survey.left_out.push_back(in.GetString());
  in.ExpectEnd();
  return survey;
}

}  // namespace lodestar
