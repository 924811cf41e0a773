#include "core/learning/auto_method.h"

#include <algorithm>
#include <cstdio>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/learning/method_options.h"
#include "core/learning/path_tracing.h"
#include "core/learning/sd_tree_guiding.h"
#include "core/learning/sealed_bytes.h"

namespace lodestar {
namespace {

constexpr uint32_t kMagic = DocumentMagic("LAUT"), kVersion = 1;
constexpr const char* kWhat = "state of method 'auto'";

// What shading a vertex costs beside its rays, in rays: from docs/performance.md, "What a vertex costs".
constexpr double kPathVertexWork = 1.6, kSdTreeVertexWork = 3.2;

const AutoState::Parts& PartsOf(const State& state) {
  const auto* cast = dynamic_cast<const AutoState*>(&state);
  LODESTAR_CHECK(cast != nullptr);
  return cast->parts();
}

}  // namespace

Bytes AutoState::Serialize() const {
  ByteWriter out = OpenDocument(kMagic, kVersion);
  out.Put(parts_.active);
  out.Put<uint8_t>(parts_.settled);
  out.Put<uint8_t>(parts_.decided);
  out.Put(static_cast<uint32_t>(parts_.states.size()));
  for (const auto& state : parts_.states) {
    out.Put<uint8_t>(state != nullptr);
    if (state) out.PutString(state->Serialize());
  }
  out.PutVector(parts_.work);
  out.Put(static_cast<uint32_t>(parts_.results.size()));
  for (const PilotResult& result : parts_.results) result.Write(out);
  return Seal(std::move(out));
}

MethodEntry AutoMethod::Entry() {
  return {"auto",
          "measures which method renders the image most efficiently, and goes on with it",
          {{"candidates", "path,sdtree or a subset, separated by commas", "path,sdtree",
            "the methods that race. Recommended: the default"}}};
}

AutoMethod::AutoMethod(const JobSpec& job, const Survey& survey) {
  const MethodEntry entry = Entry();
  const MethodOptions given(entry.name, entry.options, job.options);
  JobSpec own = job;
  own.options.clear();
  const std::string text = "," + given.Text("candidates") + ",";
  for (size_t begin = 0, end; (end = text.find(',', begin + 1)) != std::string::npos; begin = end) {
    const std::string name = text.substr(begin + 1, end - begin - 1);
    const bool repeated = std::any_of(candidates_.begin(), candidates_.end(),
                                      [&](const Candidate& c) { return c.method->name() == name; });
    if (repeated) given.Refuse("candidates");
    // Both pilots end in sixteen passes, so that they are measured alike; a tree needs the fifteen before to be one.
    if (name == "path") {
      candidates_.push_back({std::make_unique<PathMethod>(own), kPathVertexWork, {16}});
    } else if (name == "sdtree") {
      candidates_.push_back({std::make_unique<SdTreeMethod>(own, survey), kSdTreeVertexWork, {1, 2, 4, 8, 16}});
    } else {
      given.Refuse("candidates");
    }
  }
}

uint32_t AutoMethod::PilotIterations() const {
  size_t count = 0;
  for (const Candidate& candidate : candidates_) count += candidate.pilot.size();
  return static_cast<uint32_t>(count);
}

AutoMethod::Turn AutoMethod::TurnOf(uint32_t iteration) const {
  for (uint32_t c = 0; c < candidates_.size(); ++c) {
    const auto length = static_cast<uint32_t>(candidates_[c].pilot.size());
    if (iteration < length) return {c, iteration, iteration + 2 >= length};
    iteration -= length;
  }
  LODESTAR_CHECK(false);
}

// After the pilot the winner's iterations go on doubling.
uint64_t AutoMethod::IterationPasses(uint32_t iteration) const {
  const uint32_t pilot = PilotIterations();
  if (iteration >= pilot) return uint64_t{32} << std::min(iteration - pilot, 27u);
  const Turn turn = TurnOf(iteration);
  return candidates_[turn.candidate].pilot[turn.iteration];
}

const Method& AutoMethod::ActiveMethod(const State& state) const {
  return *candidates_[PartsOf(state).active].method;
}

std::shared_ptr<const State> AutoMethod::ActiveState(const State& state) const {
  const AutoState::Parts& parts = PartsOf(state);
  return parts.states[parts.active];
}

std::shared_ptr<const State> AutoMethod::Initial() const {
  AutoState::Parts parts;
  for (const Candidate& candidate : candidates_) parts.states.push_back(candidate.method->Initial());
  parts.decided = candidates_.size() == 1 && candidates_[0].method->IterationPasses(0) == 0;
  return std::make_shared<AutoState>(std::move(parts));
}

std::unique_ptr<Statistics> AutoMethod::NewStatistics(const std::shared_ptr<const State>& state) const {
  return ActiveMethod(*state).NewStatistics(ActiveState(*state));
}

std::unique_ptr<Statistics> AutoMethod::ParseStatistics(const std::shared_ptr<const State>& state,
                                                        std::string_view bytes) const {
  return ActiveMethod(*state).ParseStatistics(ActiveState(*state), bytes);
}

namespace {

// How much better a candidate's next film may be than its last: as much as that was than the one before, within reason.
constexpr double kMostGrowth = 1.5;

double Promise(const std::vector<PilotResult>& results, uint32_t candidate) {
  const PilotResult *last = nullptr, *before = nullptr;
  for (const PilotResult& result : results) {
    if (result.candidate != candidate) continue;
    before = last;
    last = &result;
  }
  return before == nullptr ? 1 : std::clamp(CompareEfficiency(*last, *before).value, 1.0, kMostGrowth);
}

const PilotResult* LastOf(const std::vector<PilotResult>& results, uint32_t candidate) {
  const PilotResult* last = nullptr;
  for (const PilotResult& result : results) {
    if (result.candidate == candidate) last = &result;
  }
  return last;
}

}  // namespace

uint32_t AutoMethod::Winner(const std::vector<PilotResult>& results) const {
  uint32_t best = 0;
  for (uint32_t c = 0; c < candidates_.size(); ++c) {
    const PilotResult *result = LastOf(results, c), *leader = LastOf(results, best);
    if (result == nullptr) continue;
    // Of equals the first, which is the simplest.
    if (leader == nullptr || CompareEfficiency(*result, *leader).value * Promise(results, c) > Promise(results, best))
      best = c;
  }
  return best;
}

void AutoMethod::Decide(AutoState::Parts* parts) const {
  parts->active = Winner(parts->results);
  const PilotResult* own = LastOf(parts->results, parts->active);
  parts->settled = true;
  for (uint32_t c = 0; c < candidates_.size(); ++c) {
    const PilotResult* other = LastOf(parts->results, c);
    if (c != parts->active && own != nullptr && other != nullptr && CompareEfficiency(*own, *other).value < 1)
      parts->settled = false;
  }
  for (uint32_t c = 0; parts->settled && c < candidates_.size(); ++c) {
    if (c != parts->active) parts->states[c] = nullptr;
  }
}

std::vector<PilotResult> AutoMethod::Measure(const IterationResult& result, const AutoState::Parts& parts) const {
  const PixelEstimate pixels = EstimatePixels(*result.image);
  std::vector<PilotResult> results;
  for (const IterationFilm& film : result.films) {
    const Turn turn = film.iteration < PilotIterations() ? TurnOf(film.iteration) : Turn{parts.active, 0, true};
    if (turn.measured && film.film.passes() >= 2)
      results.push_back(MeasurePilot(turn.candidate, film.film, parts.work[film.iteration], pixels));
  }
  return results;
}

std::shared_ptr<const State> AutoMethod::Advance(const std::shared_ptr<const State>& state,
                                                 const IterationResult& result) const {
  AutoState::Parts parts = PartsOf(*state);
  const uint32_t pilot = PilotIterations(), next = result.iteration + 1;
  const Candidate& active = candidates_[parts.active];
  parts.states[parts.active] = active.method->Advance(parts.states[parts.active], result);
  if (!parts.settled) {
    parts.work.push_back(static_cast<double>(result.rays) + active.vertex_work * static_cast<double>(result.vertices));
    if (next < pilot && !result.last) {
      parts.active = TurnOf(next).candidate;
    } else {
      parts.results = Measure(result, parts);
      Decide(&parts);
      if (result.last) parts.settled = true;
    }
  }
  // A method that learns nothing has nothing to train for.
  parts.decided = next >= pilot && candidates_[parts.active].method->IterationPasses(next) == 0;
  if (parts.decided) parts.settled = true;
  return std::make_shared<AutoState>(std::move(parts));
}

bool AutoMethod::Decided(const State& state) const {
  return PartsOf(state).decided;
}

std::string AutoMethod::Explain(const State& state) const {
  const AutoState::Parts& parts = PartsOf(state);
  const std::string chosen(candidates_[parts.active].method->name());
  if (parts.results.empty()) return chosen + ": the budget ended before anything could be measured";
  std::string text = chosen;
  const PilotResult* own = LastOf(parts.results, parts.active);
  for (uint32_t c = 0; c < candidates_.size(); ++c) {
    const PilotResult* other = LastOf(parts.results, c);
    if (c == parts.active || own == nullptr || other == nullptr) continue;
    const EfficiencyRatio ratio = CompareEfficiency(*own, *other);
    char line[200];
    std::snprintf(line, sizeof line,
                  "; %s left out: %s was %.2f times as efficient (95 %%: %.2f to %.2f; %llu against %llu passes)",
                  std::string(candidates_[c].method->name()).c_str(), chosen.c_str(), ratio.value, ratio.low,
                  ratio.high, static_cast<unsigned long long>(own->passes),
                  static_cast<unsigned long long>(other->passes));
    text += line;
  }
  return text;
}

std::shared_ptr<const State> AutoMethod::ParseState(std::string_view bytes) const {
  ByteReader in(OpenSealed(bytes, kMagic, kVersion, kWhat), kWhat);
  AutoState::Parts parts;
  parts.active = in.Get<uint32_t>();
  const auto settled = in.Get<uint8_t>(), decided = in.Get<uint8_t>();
  const auto count = in.Get<uint32_t>();
  if (count != candidates_.size() || parts.active >= count || settled > 1 || decided > 1)
    in.Fail("has other candidates than its job");
  parts.settled = settled != 0;
  parts.decided = decided != 0;
  for (const Candidate& candidate : candidates_) {
    const auto present = in.Get<uint8_t>();
    if (present > 1) in.Fail("has a malformed flag");
    parts.states.push_back(present ? candidate.method->ParseState(in.GetString()) : nullptr);
  }
  if (!parts.states[parts.active]) in.Fail("has no state of the method it goes on with");
  parts.work = in.GetVector<double>();
  for (const double work : parts.work) {
    if (!(work >= 0)) in.Fail("has work that is no number");
  }
  const auto results = in.Get<uint32_t>();
  if (results > 64) in.Fail("has more results than a race can have");
  for (uint32_t i = 0; i < results; ++i) {
    parts.results.push_back(PilotResult::Read(in));
    if (parts.results.back().candidate >= count ||
        parts.results.back().variances.size() != parts.results.front().variances.size())
      in.Fail("has a result of no candidate");
  }
  in.ExpectEnd();
  return std::make_shared<AutoState>(std::move(parts));
}

}  // namespace lodestar
