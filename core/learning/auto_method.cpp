#include "core/learning/auto_method.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <map>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/sealed_bytes.h"
#include "core/learning/focal_guiding.h"
#include "core/learning/grid_guiding.h"
#include "core/learning/method_maker.h"
#include "core/learning/method_options.h"
#include "core/learning/path_tracing.h"
#include "core/learning/sd_tree_guiding.h"

namespace lodestar {
namespace {

constexpr uint32_t kMagic = DocumentMagic("LAUT"), kVersion = 6;
constexpr const char* kWhat = "state of method 'auto'";

// As much as a learner's film may be better than the one before; and of the first film that tells a variance, after
// which growth is greatest, those that come until its growth is known.
constexpr double kMostGrowth = 1.5, kMostGrowthOfFirst = kMostGrowth * kMostGrowth;

struct Racer {
  const char* name;
  std::unique_ptr<Method> (*make)(const JobSpec&, const Survey&);
  std::map<std::string, std::string> options;  // other than its defaults
  // What shading a vertex costs beside its rays, in rays (docs/decisions/0013-auto.md).
  double vertex_work;
  // Its pilot, in iterations and in paths: as long as learning needs, whatever the size of the picture. Paths are
  // counted in those of the simplest pilot.
  uint32_t pilot_iterations, pilot_paths;
  double worth_above;
};
// What can race, in the order of the pilots; of equals the first wins.
const std::vector<Racer>& Racers() {
  static const std::vector<Racer> kRacers = {
      {"path", Make<PathMethod>, {}, 1.6, 1, 1, 0},
      // Pays where hardly a sample in a thousand meets the light, with the settings for pinholes
      // (docs/decisions/0010-focal-guiding.md). It shows nothing before it has narrowed for some iterations. Where it
      // is tried it may lead by so much that who comes after it need not be.
      {"focal", Make<FocalMethod>, {{"initial-iterations", "5"}, {"narrowing-iterations", "10"}}, 3.4, 10, 3, 1000},
      {"sdtree", Make<SdTreeMethod>, {}, 2.5, 2, 3, 0},
      {"radiance", Make<SdTreeMethod>, {{"target", "radiance"}}, 2.5, 2, 3, 0},
      {"product", Make<SdTreeMethod>, {{"product", "on"}}, 4.4, 2, 3, 0},
      {"grid", Make<GridMethod>, {}, 2.4, 2, 3, 0},
  };
  return kRacers;
}

const AutoState::Parts& PartsOf(const State& state) {
  const auto* cast = dynamic_cast<const AutoState*>(&state);
  LODESTAR_CHECK(cast != nullptr);
  return cast->parts();
}

uint32_t IterationsOf(const AutoState::Parts& parts) {
  uint32_t done = 0;
  for (const AutoState::Entrant& entrant : parts.entrants) done += entrant.iterations;
  return done;
}

const PilotResult* LastOf(const std::vector<PilotResult>& results, uint32_t candidate) {
  const PilotResult* last = nullptr;
  for (const PilotResult& result : results) {
    if (result.candidate == candidate) last = &result;
  }
  return last;
}

}  // namespace

Bytes AutoState::Serialize() const {
  ByteWriter out = OpenDocument(kMagic, kVersion);
  out.Put(parts_.active);
  out.Put<uint8_t>(parts_.settled);
  out.Put(parts_.late_from);
  out.Put(static_cast<uint32_t>(parts_.entrants.size()));
  for (const Entrant& entrant : parts_.entrants) {
    out.Put<uint8_t>(entrant.state != nullptr);
    if (entrant.state) out.PutString(entrant.state->Serialize());
    out.Put(entrant.iterations);
    out.Put(entrant.passes);
    out.Put(entrant.last_passes);
  }
  out.Put(static_cast<uint32_t>(parts_.results.size()));
  for (const PilotResult& result : parts_.results) result.Write(out);
  return Seal(std::move(out));
}

MethodEntry AutoMethod::Entry() {
  return {
      "auto",
      "measures which method renders the image most efficiently, and goes on with it",
      {{"candidates", "path,sdtree,radiance,product,grid,focal or a subset, separated by commas", "path,sdtree,focal",
        "the methods that race; radiance is sdtree with target=radiance, product with product=on; focal is tried only "
        "where path tracing hardly finds the light. Recommended: the default"},
       {"pilot", "an integer from 1000 to 1e9", "580000",
        "paths in the pilot of path tracing; methods that learn have three times as many, and at least what they "
        "cannot show anything without"},
       {"credit", "an integer from -1 to 1000", "-1",
        "iterations of the race within which a method that has shown one film of what it learned is credited with "
        "growth; -1: those that end in the first quarter of the budget (recommended), which the report then names for "
        "a replay"}}};
}

AutoMethod::AutoMethod(const JobSpec& job, const Survey& survey) {
  const MethodEntry entry = Entry();
  const MethodOptions given(entry.name, entry.options, job.options);
  // What a candidate does may not depend on the kind of budget: a run by time is replayed by passes.
  JobSpec own = job;
  own.budget = {};
  const auto paths = static_cast<uint64_t>(given.Integer("pilot", 1000, 1000000000));
  credit_ = given.Integer("credit", -1, 1000);
  std::vector<std::string> names;
  const std::string text = "," + given.Text("candidates") + ",";
  for (size_t begin = 0, end; (end = text.find(',', begin + 1)) != std::string::npos; begin = end)
    names.push_back(text.substr(begin + 1, end - begin - 1));
  const uint64_t pixels = survey.pixels();
  size_t named = 0;
  for (const Racer& racer : Racers()) {
    const auto count = std::count(names.begin(), names.end(), racer.name);
    if (count > 1) given.Refuse("candidates");
    if (count == 0) continue;
    ++named;
    if (!survey.guidable && !candidates_.empty()) {
      not_needed_.emplace_back(racer.name);
      continue;
    }
    own.options = racer.options;
    const uint64_t passes = std::max<uint64_t>(2, (racer.pilot_paths * paths + pixels - 1) / pixels);
    candidates_.push_back(
        {racer.name, racer.make(own, survey), racer.vertex_work, racer.pilot_iterations, passes, racer.worth_above});
  }
  if (named != names.size()) given.Refuse("candidates");
}

// ---- The states of the candidates ----

Method::Active AutoMethod::ActiveUnder(const std::shared_ptr<const State>& state) const {
  const Parts& parts = PartsOf(*state);
  return {candidates_[parts.active].method.get(), parts.entrants[parts.active].state, parts.active};
}

std::shared_ptr<const State> AutoMethod::Initial() const {
  Parts parts;
  for (const Candidate& candidate : candidates_) parts.entrants.push_back({.state = candidate.method->Initial()});
  parts.settled = candidates_.size() == 1;
  return std::make_shared<AutoState>(std::move(parts));
}

std::unique_ptr<Statistics> AutoMethod::NewStatistics(const std::shared_ptr<const State>& state) const {
  const Active active = ActiveUnder(state);
  return active.method->NewStatistics(active.state);
}

// ---- How long, and who ----

uint64_t AutoMethod::OwnPasses(const Parts& parts, uint32_t candidate, uint32_t ahead) const {
  const AutoState::Entrant& entrant = parts.entrants[candidate];
  LODESTAR_CHECK(entrant.state);
  return candidates_[candidate].method->IterationPasses(*entrant.state, entrant.iterations + ahead);
}

uint64_t AutoMethod::PilotPasses(const Parts& parts, uint32_t c) const {
  const Candidate& candidate = candidates_[c];
  const AutoState::Entrant& entrant = parts.entrants[c];
  const uint64_t own = OwnPasses(parts, c);
  if (own == 0) return entrant.iterations > 0 ? 0 : candidate.pilot_passes;
  const auto over = [&](uint32_t iterations, uint64_t passes) {
    return iterations >= candidate.pilot_iterations && passes >= candidate.pilot_passes;
  };
  if (entrant.last_passes >= 2 && over(entrant.iterations, entrant.passes)) return 0;
  // The film that a pilot ends with has to tell a variance.
  return over(entrant.iterations + 1, entrant.passes + own) ? std::max<uint64_t>(2, own) : own;
}

uint64_t AutoMethod::IterationPasses(const State& state, uint32_t iteration) const {
  const Parts& parts = PartsOf(state);
  const uint32_t done = IterationsOf(parts);
  const uint32_t ahead = iteration > done ? iteration - done : 0;
  const uint64_t own = OwnPasses(parts, parts.active, ahead);
  if (parts.settled) return own;
  // Who comes next is not known before this iteration is over; it will not be less than two passes by much.
  if (ahead > 0) return std::max<uint64_t>(2, own);
  const uint64_t pilot = PilotPasses(parts, parts.active);
  return pilot > 0 ? pilot : own;
}

uint32_t AutoMethod::NextInPilot(const Parts& parts, const IterationResult& result, const Results& measured,
                                 bool hopeless) const {
  const auto count = static_cast<uint32_t>(candidates_.size());
  uint32_t c = parts.active;
  if (PilotPasses(parts, c) > 0 && !hopeless) return c;
  // How well the simplest finds the light: by the first film that tells it.
  const auto first = std::ranges::find_if(result.films, [](const IterationFilm& f) { return f.film.passes() >= 2; });
  const double variance = first != result.films.end() ? RelativeVariance(first->film) : 0;
  for (++c; c < count; ++c) {
    if (variance >= candidates_[c].worth_above && !Hopeless(parts, measured, c)) return c;
  }
  return count;
}

std::shared_ptr<const State> AutoMethod::Advance(const std::shared_ptr<const State>& state,
                                                 const IterationResult& result) const {
  Parts parts = PartsOf(*state);
  const Candidate& active = candidates_[parts.active];
  AutoState::Entrant& entrant = parts.entrants[parts.active];
  const bool pilot = !parts.settled && PilotPasses(parts, parts.active) > 0;
  entrant.state = active.method->Advance(entrant.state, result);
  ++entrant.iterations;
  entrant.passes += result.passes;
  entrant.last_passes = result.passes;
  if (const uint32_t done = IterationsOf(parts); parts.late_from == AutoState::kNever) {
    // A replay is told that an iteration is the last where the run had only chosen one that has nothing to learn.
    const bool late = credit_ < 0 ? result.late || result.last : done >= static_cast<uint32_t>(credit_);
    if (late) parts.late_from = done;
  }
  if (!parts.settled) {
    Results measured = Measure(result);
    const auto count = static_cast<uint32_t>(candidates_.size());
    uint32_t next = count;
    if (pilot && !result.last) {
      const bool hopeless = Hopeless(parts, measured, parts.active);
      next = NextInPilot(parts, result, measured, hopeless);
      // States travel with every unit: of who has lost, or is passed over, none is kept.
      if (hopeless) entrant.state = nullptr;
      for (uint32_t c = parts.active + 1; c < next; ++c) parts.entrants[c].state = nullptr;
    }
    if (next < count) {
      parts.active = next;
    } else {
      parts.results = std::move(measured);
      Decide(&parts, result.last);
    }
  }
  return std::make_shared<AutoState>(std::move(parts));
}

// A method that learns nothing, or has learned all that it can, has nothing to train for.
bool AutoMethod::Decided(const State& state) const {
  const Parts& parts = PartsOf(state);
  return parts.settled && OwnPasses(parts, parts.active) == 0;
}

std::map<std::string, std::string> AutoMethod::DecidedOptions(const State& state) const {
  if (candidates_.size() == 1) return {};
  const Parts& parts = PartsOf(state);
  const uint32_t credited = parts.late_from == AutoState::kNever ? IterationsOf(parts) + 1 : parts.late_from;
  return {{"credit", std::to_string(credited)}};
}

// ---- The race ----

AutoMethod::Results AutoMethod::Measure(const IterationResult& result) const {
  const Yardstick yardstick(*result.image);
  std::vector<uint32_t> left(candidates_.size());  // films of the candidate that are still to come
  for (const IterationFilm& film : result.films) {
    LODESTAR_CHECK(film.candidate < candidates_.size());
    ++left[film.candidate];
  }
  Results results;
  for (const IterationFilm& film : result.films) {
    if (left[film.candidate]-- > 2 || film.film.passes() < 2) continue;
    const double work =
        static_cast<double>(film.rays) + candidates_[film.candidate].vertex_work * static_cast<double>(film.vertices);
    results.push_back(MeasurePilot(film.candidate, film.film, work, yardstick));
  }
  return results;
}

double AutoMethod::MostGrowth(const Parts& parts, const Results& measured, uint32_t c) const {
  const Candidate& candidate = candidates_[c];
  // What is for scenes whose light is hardly found gains by orders of magnitude once it has.
  if (candidate.worth_above > 0) return std::numeric_limits<double>::infinity();
  const AutoState::Entrant& entrant = parts.entrants[c];
  uint32_t left = 0;
  double growth = kMostGrowth;  // of one more, of probation
  for (uint64_t passes = entrant.passes;
       passes < candidate.pilot_passes || entrant.iterations + left < candidate.pilot_iterations; ++left) {
    const uint64_t next = OwnPasses(parts, c, left);
    if (next == 0) break;
    passes += next;
    growth *= kMostGrowth;
  }
  const auto films = std::ranges::count(measured, c, &PilotResult::candidate);
  return films == 1 ? std::max(growth, kMostGrowthOfFirst) : growth;
}

bool AutoMethod::Hopeless(const Parts& parts, const Results& measured, uint32_t candidate) const {
  const PilotResult* own = LastOf(measured, candidate);
  // Who has rendered nothing yet begins as the path tracing that its first iteration is.
  const bool begins = own == nullptr && parts.entrants[candidate].iterations == 0 && OwnPasses(parts, 0) == 0;
  if (begins) own = LastOf(measured, 0);
  if (own == nullptr) return false;
  const double growth = MostGrowth(parts, measured, candidate);
  for (uint32_t c = 0; c < candidate; ++c) {
    const PilotResult* other = LastOf(measured, c);
    if (other != nullptr && CompareEfficiency(*own, *other).high * growth < 1) return true;
  }
  return false;
}

double AutoMethod::Promise(const Parts& parts, uint32_t candidate) const {
  // As much as its last was better than the one before, within reason.
  const PilotResult *last = nullptr, *before = nullptr;
  for (const PilotResult& result : parts.results) {
    if (result.candidate != candidate) continue;
    before = last;
    last = &result;
  }
  if (last == nullptr || OwnPasses(parts, candidate) == 0) return 1;
  // One film does not tell how it grows. The next will, and that is worth its cost where much of the job is left.
  if (before == nullptr) return parts.late_from == AutoState::kNever ? kMostGrowthOfFirst : 1;
  return std::clamp(CompareEfficiency(*last, *before).value, 1.0, kMostGrowth);
}

uint32_t AutoMethod::Winner(const Parts& parts) const {
  uint32_t best = 0;
  for (uint32_t c = 0; c < candidates_.size(); ++c) {
    const PilotResult *result = LastOf(parts.results, c), *leader = LastOf(parts.results, best);
    if (result == nullptr || !parts.entrants[c].state) continue;
    if (leader == nullptr) {
      best = c;
      continue;
    }
    // In doubt for one that still learns: wrongly left out it costs what guiding can gain, wrongly kept a fraction.
    const EfficiencyRatio ratio = CompareEfficiency(*result, *leader);
    const double believed = OwnPasses(parts, c) > 0 ? ratio.high : ratio.value;
    if (believed * Promise(parts, c) > Promise(parts, best)) best = c;
  }
  // One that learns may have had the doubt; who has learned all that it can is to lead in fact.
  for (uint32_t c = 0; c < candidates_.size() && OwnPasses(parts, best) == 0; ++c) {
    const PilotResult *result = LastOf(parts.results, c), *leader = LastOf(parts.results, best);
    if (result == nullptr || leader == nullptr || !parts.entrants[c].state) continue;
    if (CompareEfficiency(*result, *leader).value > 1) best = c;
  }
  return best;
}

void AutoMethod::Decide(Parts* parts, bool last) const {
  parts->active = Winner(*parts);
  const PilotResult* own = LastOf(parts->results, parts->active);
  parts->settled = true;
  for (uint32_t c = 0; c < candidates_.size(); ++c) {
    const PilotResult* other = LastOf(parts->results, c);
    const bool waits = c != parts->active && parts->entrants[c].state;
    if (waits && own != nullptr && other != nullptr && CompareEfficiency(*own, *other).value < 1)
      parts->settled = false;
  }
  parts->settled |= last;
  for (uint32_t c = 0; parts->settled && c < candidates_.size(); ++c) {
    if (c != parts->active) parts->entrants[c].state = nullptr;
  }
}

std::string AutoMethod::Explain(const State& state) const {
  const Parts& parts = PartsOf(state);
  const std::string chosen = candidates_[parts.active].name;
  std::string text = chosen;
  for (const std::string& name : not_needed_)
    text += "; " + name + " left out: the scene has no light, or no surface that scatters into more than one direction";
  if (candidates_.size() == 1) return text;
  if (parts.results.empty()) return text + ": the budget ended before anything could be measured";
  const PilotResult* own = LastOf(parts.results, parts.active);
  for (uint32_t c = 0; c < candidates_.size(); ++c) {
    if (c == parts.active) continue;
    const std::string name = candidates_[c].name;
    const PilotResult* other = LastOf(parts.results, c);
    if (own == nullptr || other == nullptr) {
      const bool tried = parts.entrants[c].iterations > 0;
      text += "; " + name + (tried ? " not measured: the budget ended before" : " not tried");
      if (!tried) {
        text += ": ";
        if (candidates_[c].worth_above > 0)
          text += "path tracing finds the light often enough, or ";
        else if (parts.active > 0)
          text += chosen + " led by more than it could have gained, or ";
        text += "the budget is too small";
      }
      continue;
    }
    const EfficiencyRatio ratio = CompareEfficiency(*own, *other);
    // Who leads by promise or by doubt alone is on probation, and the other waits for its chance.
    const bool behind = ratio.value < 1;
    text += "; " + name + (behind && parts.entrants[c].state ? " waits: " : " left out: ") + chosen +
            (behind ? ", which still learns," : "");
    char line[160];
    std::snprintf(line, sizeof line, " was %.3g times as efficient (95 %%: %.3g to %.3g; %llu against %llu passes)",
                  ratio.value, ratio.low, ratio.high, static_cast<unsigned long long>(own->passes),
                  static_cast<unsigned long long>(other->passes));
    text += line;
  }
  return text;
}

std::shared_ptr<const State> AutoMethod::ParseState(std::string_view bytes) const {
  ByteReader in(OpenSealed(bytes, kMagic, kVersion, kWhat), kWhat);
  Parts parts;
  parts.active = in.Get<uint32_t>();
  parts.settled = in.GetFlag();
  parts.late_from = in.Get<uint32_t>();
  const auto count = in.Get<uint32_t>();
  if (count != candidates_.size() || parts.active >= count) in.Fail("has other candidates than its job");
  for (const Candidate& candidate : candidates_) {
    AutoState::Entrant entrant;
    const bool present = in.GetFlag();
    if (present) entrant.state = candidate.method->ParseState(in.GetString());
    entrant.iterations = in.Get<uint32_t>();
    entrant.passes = in.Get<uint64_t>();
    entrant.last_passes = in.Get<uint64_t>();
    parts.entrants.push_back(std::move(entrant));
  }
  if (!parts.entrants[parts.active].state) in.Fail("has no state of the method it goes on with");
  const auto results = in.Get<uint32_t>();
  if (results > 2 * count) in.Fail("has more results than a race can have");
  for (uint32_t i = 0; i < results; ++i) {
    parts.results.push_back(PilotResult::Read(in));
    if (parts.results.back().candidate >= count ||
        parts.results.back().variances.size() != parts.results.front().variances.size())
      in.Fail("has a result of no candidate");
  }
  in.ExpectEnd();
  // The first loses to nobody before the race is over; in the pilots, who comes later has had no turn.
  const bool pilots = !parts.settled && parts.results.empty();
  for (uint32_t c = 0; c < count; ++c) {
    if (!parts.entrants[c].state && !parts.settled && (c == 0 || (pilots && c > parts.active)))
      in.Fail("has lost a candidate during the race");
  }
  return std::make_shared<AutoState>(std::move(parts));
}

}  // namespace lodestar
