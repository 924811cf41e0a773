#include "worker/job_cache.h"

#include <algorithm>

#include "core/base/log.h"
#include "core/scene/pbrt_parser.h"

namespace lodestar {
namespace {

std::string WithoutFolder(std::string text, const std::filesystem::path& folder) {
  const std::string prefix = folder.string() + "/";
  for (size_t at = text.find(prefix); at != std::string::npos; at = text.find(prefix, at))
    text.erase(at, prefix.size());
  return text;
}

}  // namespace

LoadedJob::LoadedJob(const JobDescription& description, std::filesystem::path folder, CompiledJob compiled, int threads)
    : folder_(std::move(folder)),
      compiled_(std::move(compiled)),
      method_(MakeMethod(description.spec, compiled_.survey)),
      threads_(description.threads > 0 ? static_cast<int>(std::min(static_cast<uint32_t>(threads), description.threads))
                                       : threads),
      executor_(compiled_.scene, description.spec, *method_, threads_) {}

LoadedJob::~LoadedJob() {
  spdlog::info("fetched and read {} states in {:.2f} s", fetched_, fetching_seconds_);
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

std::shared_ptr<const State> LoadedJob::StateFor(const ContentHash& hash, WorkClient& client) {
  std::lock_guard lock(states_mutex_);
  for (const auto& [known, state] : states_) {
    if (known == hash) return state;
  }
  const auto start = Clock::Steady().Now();
  auto state = method_->ParseState(client.FetchState(hash));
  fetching_seconds_ += Seconds(Clock::Steady().Now() - start);
  ++fetched_;
  states_.emplace_front(hash, state);
  if (states_.size() > 2) states_.pop_back();
  return state;
}

bool LoadedJob::Execute(const RenderUnit& unit, const std::shared_ptr<const State>& state, const StopToken& stop,
                        Contribution* into) {
  if (unit.survey != compiled_.survey.Serialize()) {
    throw Error(ErrorKind::kConflict, "this worker has compiled another scene than the one that was surveyed (hash " +
                                          compiled_.survey.scene_hash + "): are its libraries of another version?");
  }
  return executor_.ExecuteNode(state, unit.round, unit.node, stop, into);
}

std::shared_ptr<LoadedJob> JobCache::Find(const ContentHash& description) {
  std::lock_guard lock(mutex_);
  for (auto it = jobs_.begin(); it != jobs_.end(); ++it) {
    if (it->description != description) continue;
    jobs_.splice(jobs_.begin(), jobs_, it);
    return jobs_.front().job;
  }
  return nullptr;
}

void JobCache::MakeRoom(uint64_t bytes) {
  std::lock_guard lock(mutex_);
  for (const Entry& entry : jobs_) bytes += entry.bytes;
  for (; bytes > trial_.memory_bytes() && !jobs_.empty(); jobs_.pop_back()) bytes -= jobs_.back().bytes;
}

std::shared_ptr<LoadedJob> JobCache::Load(const ContentHash& hash, const StopToken& stop) {
  if (auto job = Find(hash)) return job;
  JobDescription description;
  std::filesystem::path folder;
  try {
    description = JobDescription::Parse(client_.FetchBytes(hash, kMaxSceneFiles * 1200));
    folder = assets_.Materialise(description.scene, [&](const ContentHash& content, const std::filesystem::path& to) {
      client_.FetchAsset(content, to);
    });
  } catch (const Error& error) {
    // Whatever it is: the scene has not been read yet.
    if (error.kind() == ErrorKind::kIo) throw;
    throw Error(ErrorKind::kIo, error.what());
  }
  try {
    const uint64_t bytes = trial_.Run(description, folder, stop);
    MakeRoom(bytes);
    auto scene =
        ParsePbrtFile(folder / description.scene.main, {.lenient = description.spec.lenient, .within = folder});
    // Without this machine's folders, so that every worker's survey has the same bytes.
    for (std::string& line : scene.left_out) line = WithoutFolder(std::move(line), folder);
    auto compiled = CompileJob(scene, description.spec);
    const double seconds = compiled.seconds;
    auto job = std::make_shared<LoadedJob>(description, folder, std::move(compiled), threads_);
    spdlog::info("compiled {} in {:.2f} s within {} MiB, to render on {} of {} threads: {}", description.scene.main,
                 seconds, bytes >> 20, job->threads(), threads_, job->survey().needs);
    std::lock_guard lock(mutex_);
    jobs_.push_front({hash, job, bytes});
    return job;
  } catch (const Error& error) {
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
    throw Error(error.kind(), WithoutFolder(error.what(), folder));
  }
}

}  // namespace lodestar
