#include "core/learning/loop.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/check.h"
#include "core/base/picture_size.h"

namespace lodestar {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();
// The estimate from fewer passes is too unsteady to end a job on: a scene may look black at first.
constexpr uint64_t kMinPassesForErrorStop = 16;
// A picture without any noise has most likely met no light yet.
constexpr uint64_t kMinPassesForNoError = 1024;
// The same for the variances of iterations.
constexpr uint64_t kMinPassesForAutomatic = 8;
// Whether an iteration pays that is begun to see what a method can learn depends on what is left to make use of it.
constexpr double kLate = 0.25;
// Measuring takes time, and neighbouring points tell little: one for every five per cent more passes (two where the
// error ends the job), 200 in all.
constexpr double kPointSpacing = 1.05, kPointSpacingByError = 1.02;
constexpr size_t kMaxPoints = 200;

TileGrid CheckedGrid(const Survey& survey) {
  const uint32_t x = survey.resolution_x, y = survey.resolution_y;
  if (!CanBeRendered(x, y)) {
    throw Error(ErrorKind::kInvalidInput, "a picture of " + std::to_string(x) + "x" + std::to_string(y) +
                                              " pixels cannot be rendered; " + PictureSizeRule());
  }
  return {x, y};
}

// Drops the inner point whose neighbours are closest on a logarithmic scale; the first and the last stay.
void ThinOut(std::vector<ErrorPoint>* points) {
  size_t closest = 1;
  double smallest = kUnknown;
  for (size_t i = 1; i + 1 < points->size(); ++i) {
    const double ratio = static_cast<double>((*points)[i + 1].spp) / static_cast<double>((*points)[i - 1].spp);
    if (ratio < smallest) {
      smallest = ratio;
      closest = i;
    }
  }
  points->erase(points->begin() + static_cast<std::ptrdiff_t>(closest));
}

}  // namespace

uint32_t PassesPerRound(uint32_t width, uint32_t height, bool record) {
  // What a round learned is sent and merged at its end, whatever its length: rounds that record are longer.
  const uint64_t samples = uint64_t{1} << (record ? 21 : 20);
  const uint64_t pixels = std::max<uint64_t>(1, uint64_t{width} * height);
  return static_cast<uint32_t>(std::bit_floor(std::clamp<uint64_t>(samples / pixels, 1, 64)));
}

Loop::Loop(const JobSpec& job, const Survey& survey, const MethodFactory& make_method)
    : job_(job), survey_(survey), grid_(CheckedGrid(survey)) {
  job_.budget.Check();
  method_ = make_method(job_, survey_);
  state_ = method_->Initial();
  final_iteration_ = EndsTraining(0) || method_->Decided(*state_);
  error_ = kUnknown;
  BeginIteration();
}

uint64_t Loop::FilmBytes(const JobSpec& job, const Survey& survey) {
  job.budget.Check();
  const TileGrid grid = CheckedGrid(survey);
  const std::unique_ptr<Method> method = MakeMethod(job, survey);
  const bool trains = method->IterationPasses(*method->Initial(), 0) > 0;
  return Film::Bytes(grid) * (trains ? MostFilms(method->combination()) : 1);
}

void Loop::Run(Executor& executor, const StopToken& stop, const Hooks& hooks, const Clock& clock) {
  const Image* reference = hooks.reference.get();
  if (reference != nullptr) Compare(Develop(), *reference);  // throws where it can never be compared
  if (!finished_) report_.stop_reason.clear();
  while (!finished_) {
    if (!stop.Requested() && iteration_complete_) Advance(executor.shards(), hooks, clock);
    if (stop.Requested()) break;
    const Round round = NextRound();
    if (const std::optional<Round> after = RoundAfter(round)) executor.Announce(state_, *after);
    const Clock::Duration start = clock.Now();
    std::optional<Contribution> contribution = executor.Execute(state_, round, stop);
    if (!contribution) break;
    const Clock::Duration merging = clock.Now();
    AddRound(round, std::move(*contribution));
    const Clock::Duration end = clock.Now();
    const double seconds = Seconds(end - start);
    seconds_ += seconds;
    iteration_seconds_ += seconds;
    films_.back().seconds += seconds;
    seconds_learning_ += Seconds(end - merging);
    DecideStop(round, seconds, reference);
    if (hooks.progress) hooks.progress(Progress(seconds / round.passes));
  }
  if (!finished_) report_.stop_reason = "stopped";
}

// ---- Rounds ----

uint64_t Loop::SppBudget() const {
  const Budget& budget = job_.budget;
  if (budget.spp > 0) return budget.spp;
  if (budget.seconds > 0 || budget.error > 0) return Budget::kMaxSpp;
  return std::clamp<uint64_t>(survey_.scene_spp, 1, Budget::kMaxSpp);
}

Round Loop::RoundAt(uint32_t iteration, uint32_t index, bool final, uint64_t done, uint64_t before) const {
  Round round;
  round.iteration = iteration;
  round.index = index;
  round.first_pass = static_cast<uint32_t>(before);
  round.unit_count = grid_.tile_count();
  round.record = !final;
  // The last iteration's rounds begin with as many passes as there were before, so that the first picture of a job
  // comes soon.
  const uint64_t wanted =
      final ? std::bit_floor(std::max<uint64_t>(1, before)) : method_->IterationPasses(*state_, iteration) - done;
  const uint64_t most = PassesPerRound(grid_.width(), grid_.height(), round.record);
  round.passes = static_cast<uint32_t>(std::min({wanted, most, SppBudget() - before}));
  return round;
}

Round Loop::NextRound() const {
  LODESTAR_CHECK(!finished_);
  if (iteration_complete_) return RoundAt(iteration_ + 1, 0, next_is_final_, 0, passes_);
  return RoundAt(iteration_, round_, final_iteration_, iteration_passes_, passes_);
}

std::optional<Round> Loop::RoundAfter(const Round& round) const {
  const uint64_t done = iteration_passes_ + round.passes, passes = passes_ + round.passes;
  if (passes >= SppBudget() || (!final_iteration_ && done >= method_->IterationPasses(*state_, iteration_)))
    return std::nullopt;
  return RoundAt(iteration_, round_ + 1, final_iteration_, done, passes);
}

void Loop::AddRound(const Round& round, Contribution contribution) {
  LODESTAR_CHECK(contribution.tiles.size() == round.unit_count);
  IterationFilm& current = films_.back();
  for (const FilmTile& tile : contribution.tiles) current.film.Add(grid_, tile);
  current.film.AddPasses(round.passes);
  current.rays += contribution.rays;
  current.vertices += contribution.vertices;
  if (contribution.statistics) {
    LODESTAR_CHECK(round.record);
    contribution.statistics->AddHealth(&report_.health);
    if (learned_) {
      learned_->Merge(*contribution.statistics);
    } else {
      learned_ = std::move(contribution.statistics);
    }
  }
  report_.health.Merge(contribution.health);
  report_.paths += contribution.paths;
  report_.rays += contribution.rays;
  report_.vertices += contribution.vertices;
  passes_ += round.passes;
  iteration_passes_ += round.passes;
  ++round_;
}

void Loop::DecideStop(const Round& round, double round_seconds, const Image* reference) {
  const auto finish = [&](const char* reason) {
    finished_ = true;
    report_.stop_reason = reason;
  };
  iteration_complete_ = !final_iteration_ && iteration_passes_ >= method_->IterationPasses(*state_, iteration_);
  if (passes_ >= SppBudget()) finish("spp");

  const bool first = report_.points.empty();
  const double spacing = job_.budget.error > 0 ? kPointSpacingByError : kPointSpacing;
  const bool due = first || static_cast<double>(passes_) >= spacing * static_cast<double>(report_.points.back().spp);
  const bool measured = due || finished_ || iteration_complete_;
  if (measured) Measure(reference);
  if (finished_) return;

  const uint64_t passes_to_believe = error_ > 0 ? kMinPassesForErrorStop : kMinPassesForNoError;
  if (measured && job_.budget.error > 0 && error_ <= job_.budget.error && iteration_passes_ >= passes_to_believe)
    return finish("error");
  if (iteration_complete_) {
    next_is_final_ = EndsTraining(iteration_ + 1);
    next_is_late_ = SpentAfter(iteration_ + 1) > kLate;
    previous_prediction_ = PredictedVariance();
  }
  const double seconds_per_pass = round_seconds / round.passes;
  if (TimeBudgetOver(seconds_per_pass * NextRound().passes)) {
    finish("time");
    if (!measured) Measure(reference);
  }
}

bool Loop::TimeBudgetOver(double next_round_seconds) const {
  if (job_.budget.seconds <= 0) return false;
  // Another round would overshoot by more than stopping now falls short.
  const double advance = iteration_complete_ ? last_advance_seconds_ : 0;
  return seconds_ + advance + next_round_seconds / 2 > job_.budget.seconds;
}

// ---- Iterations ----

bool Loop::EndsTraining(uint32_t next) const {
  const uint64_t passes = method_->IterationPasses(*state_, next);
  if (passes == 0) return true;
  const int fixed = job_.training_iterations >= 0 ? job_.training_iterations : method_->TrainingIterations();
  if (fixed >= 0) return next >= static_cast<uint32_t>(fixed);

  const uint64_t after = method_->IterationPasses(*state_, next + 1);
  const uint64_t two_doublings = passes + (after > 0 ? after : 2 * passes);
  if (SppBudget() - passes_ < two_doublings) return true;
  // Iterations that grow more slowly could still take more than half. What a race renders is no training.
  if (method_->candidates() == 1 && 2 * (passes_ + passes) > SppBudget()) return true;
  if (next == 0) return false;

  // What others rendered in a race is no training here either.
  if (job_.budget.seconds > 0 && PredictedEnd(passes) - SecondsOfOthers() > job_.budget.seconds / 2) return true;
  if (PassesForError() < static_cast<double>(two_doublings)) return true;
  if (method_->combination() == Method::Combination::kAutomatic && iteration_passes_ >= kMinPassesForAutomatic &&
      previous_prediction_ > 0) {
    return PredictedVariance() >= previous_prediction_;
  }
  return false;
}

double Loop::PredictedEnd(uint64_t passes) const {
  const double seconds_per_pass = iteration_seconds_ / static_cast<double>(iteration_passes_);
  return seconds_ + last_advance_seconds_ + seconds_per_pass * static_cast<double>(passes);
}

double Loop::SecondsOfOthers() const {
  double sum = 0;
  for (const IterationFilm& film : films_) {
    if (film.candidate != films_.back().candidate) sum += film.seconds;
  }
  return sum;
}

double Loop::PassesForError() const {
  if (job_.budget.error <= 0 || !std::isfinite(error_) || error_ <= 0) return kUnknown;
  return static_cast<double>(combined_->passes) * error_ / job_.budget.error;
}

double Loop::SpentAfter(uint32_t next) const {
  const uint64_t passes = method_->IterationPasses(*state_, next);
  const auto end = static_cast<double>(passes_ + passes);
  const double spent = end / std::min(static_cast<double>(SppBudget()), PassesForError());
  return job_.budget.seconds > 0 ? std::max(spent, PredictedEnd(passes) / job_.budget.seconds) : spent;
}

// Variance of the final image if everything from this iteration's start on were rendered with its state; 0: not known.
double Loop::PredictedVariance() const {
  const double variance = films_.back().film.MeanVariance();
  if (!std::isfinite(variance)) return 0;
  const double spp = static_cast<double>(SppBudget());
  double total = static_cast<double>(passes_) / spp, iteration = static_cast<double>(iteration_passes_) / spp;
  if (job_.budget.seconds > 0 && seconds_ / job_.budget.seconds > total) {
    total = seconds_ / job_.budget.seconds;
    iteration = iteration_seconds_ / job_.budget.seconds;
  }
  const double rest = 1 - (total - iteration);
  return rest > 0 ? variance * iteration / rest : 0;
}

void Loop::Advance(ShardRunner* shards, const Hooks& hooks, const Clock& clock) {
  Clock::Duration start = clock.Now();
  if (!combined_) combined_ = Combine(films_, method_->combination());  // restored from a checkpoint
  std::shared_ptr<const State> next = method_->Advance(state_, {.statistics = learned_.get(),
                                                                .iteration = iteration_,
                                                                .passes = iteration_passes_,
                                                                .image = &combined_->image,
                                                                .films = films_,
                                                                .last = next_is_final_,
                                                                .late = next_is_late_,
                                                                .shards = shards});
  if (hooks.advanced) {
    const Clock::Duration called = clock.Now();
    hooks.advanced(state_, learned_.get(), next);
    start += clock.Now() - called;
  }
  state_ = std::move(next);
  MakeRoom(&films_, method_->combination(), combined_->weights);
  ++iteration_;
  final_iteration_ = next_is_final_ || method_->Decided(*state_);
  BeginIteration();
  last_advance_seconds_ = Seconds(clock.Now() - start);
  seconds_ += last_advance_seconds_;
  seconds_learning_ += last_advance_seconds_;
}

void Loop::BeginIteration() {
  films_.push_back({iteration_, Film(grid_), method_->ActiveUnder(state_).candidate});
  learned_.reset();
  combined_.reset();
  round_ = 0;
  iteration_passes_ = 0;
  iteration_seconds_ = 0;
  iteration_complete_ = next_is_final_ = next_is_late_ = false;
}

// ---- Results ----

Image Loop::Develop() const {
  return Combine(films_, method_->combination()).image;
}

void Loop::Measure(const Image* reference) {
  CombinedFilms combined = Combine(films_, method_->combination());
  error_ = combined.passes >= 2 ? EstimateError(combined.image).relmse_trimmed : kUnknown;
  ErrorPoint point;
  point.seconds = seconds_;
  point.spp = passes_;
  point.iteration = iteration_;
  point.relmse_estimated = error_;
  if (reference != nullptr) point.against_reference = Compare(combined.image, *reference);
  report_.points.push_back(std::move(point));
  if (report_.points.size() > kMaxPoints) ThinOut(&report_.points);
  if (iteration_complete_) combined_ = std::move(combined);
}

JobProgress Loop::Progress(double seconds_per_pass) const {
  JobProgress progress;
  progress.iteration = iteration_;
  progress.passes = passes_;
  progress.seconds = seconds_;
  progress.relmse_estimated = error_;
  progress.rays = report_.rays;
  double left = kUnknown;
  const auto consider = [&](double fraction, double seconds) {
    progress.fraction = std::max(progress.fraction, std::clamp(fraction, 0.0, 1.0));
    left = std::min(left, std::max(0.0, seconds));
  };
  const Budget& budget = job_.budget;
  const auto passes = static_cast<double>(passes_), spp = static_cast<double>(SppBudget());
  consider(passes / spp, (spp - passes) * seconds_per_pass);
  if (budget.seconds > 0) consider(seconds_ / budget.seconds, budget.seconds - seconds_);
  // Variance falls with the number of passes.
  if (budget.error > 0 && std::isfinite(error_))
    consider(error_ > 0 ? budget.error / error_ : 1, passes * (error_ / budget.error - 1) * seconds_per_pass);
  if (finished_) progress.fraction = 1, left = 0;
  progress.seconds_left = left;
  return progress;
}

JobReport Loop::Report() const {
  JobReport report = report_;
  report.job = job_;
  for (auto& [name, value] : method_->DecidedOptions(*state_)) report.job.options[name] = value;
  report.survey = survey_;
  report.passes = passes_;
  report.iterations = iteration_ + 1;
  report.training_iterations = static_cast<int>(iteration_) + (final_iteration_ ? 0 : 1);
  report.seconds = seconds_;
  report.seconds_learning = seconds_learning_;
  report.choice = method_->Explain(*state_);
  return report;
}

ContentHash ImageHash(const Image& image) {
  static_assert(sizeof(Rgb) == 3 * sizeof(float));
  Bytes bytes(reinterpret_cast<const char*>(image.pixels.data()), image.pixels.size() * sizeof(Rgb));
  bytes.append(reinterpret_cast<const char*>(image.variance.data()), image.variance.size() * sizeof(float));
  return Sha256(bytes);
}

JobReport FinalReport(const Loop& loop, const Image& image) {
  JobReport report = loop.Report();
  if (loop.state()) report.state_hash = Sha256(loop.state()->Serialize());
  if (report.passes > 0) report.image_hash = ImageHash(image);
  return report;
}

}  // namespace lodestar
