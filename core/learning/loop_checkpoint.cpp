// A loop's whole position as bytes.
#include <cmath>

#include "core/base/sealed_bytes.h"
#include "core/learning/loop.h"

namespace lodestar {
namespace {

constexpr uint32_t kMagic = DocumentMagic("LDCP"), kVersion = 5;
constexpr const char* kWhat = "checkpoint";

void WritePoint(ByteWriter& out, const ErrorPoint& point) {
  out.Put(point.seconds);
  out.Put(point.spp);
  out.Put(point.iteration);
  out.Put(point.relmse_estimated);
  out.Put<uint8_t>(point.against_reference ? 1 : 0);
  if (!point.against_reference) return;
  const ErrorMetrics& m = *point.against_reference;
  for (const double value : {m.rmse, m.mse, m.mae, m.relmse, m.relmse_trimmed}) out.Put(value);
}

double ReadSeconds(ByteReader& in) {
  const auto value = in.Get<double>();
  if (!(value >= 0) || !std::isfinite(value)) in.Fail("has a time that is not a number");
  return value;
}

ErrorPoint ReadPoint(ByteReader& in) {
  ErrorPoint point;
  point.seconds = ReadSeconds(in);
  point.spp = in.Get<uint64_t>();
  point.iteration = in.Get<uint32_t>();
  point.relmse_estimated = in.Get<double>();
  if (in.GetFlag()) {
    ErrorMetrics m;
    for (double* value : {&m.rmse, &m.mse, &m.mae, &m.relmse, &m.relmse_trimmed}) *value = in.Get<double>();
    point.against_reference = m;
  }
  return point;
}

}  // namespace

class LoopCheckpoint {
 public:
  static Bytes Write(const Loop& loop) {
    ByteWriter out = OpenDocument(kMagic, kVersion);
    out.PutString(loop.job_.Serialize());
    out.PutString(loop.survey_.Serialize());
    out.PutString(loop.state_->Serialize());
    WritePosition(out, loop);
    out.Put<uint64_t>(loop.films_.size());
    for (const IterationFilm& film : loop.films_) {
      out.Put(film.iteration);
      out.Put(film.candidate);
      out.Put(film.rays);
      out.Put(film.vertices);
      out.Put(film.seconds);
      film.film.Write(out);
    }
    out.Put<uint8_t>(loop.learned_ ? 1 : 0);
    if (loop.learned_) out.PutString(loop.learned_->Serialize());
    WriteReport(out, loop.report_);
    return Seal(std::move(out));
  }

  static std::unique_ptr<Loop> Read(std::string_view bytes) {
    ByteReader in(OpenSealed(bytes, kMagic, kVersion, kWhat), kWhat);
    const JobSpec job = JobSpec::Parse(in.GetString());
    const Survey survey = Survey::Parse(in.GetString());
    auto loop = std::make_unique<Loop>(job, survey);
    loop->state_ = loop->method_->ParseState(in.GetString());
    ReadPosition(in, loop.get());
    ReadFilms(in, loop.get());
    loop->learned_.reset();
    if (in.GetFlag()) AddStatistics(*loop->method_, loop->state_, in.GetView(), &loop->learned_);
    ReadReport(in, &loop->report_);
    in.ExpectEnd();
    return loop;
  }

 private:
  static void WritePosition(ByteWriter& out, const Loop& loop) {
    out.Put(loop.iteration_);
    out.Put(loop.round_);
    out.Put(loop.iteration_passes_);
    out.Put(loop.passes_);
    for (const bool flag :
         {loop.final_iteration_, loop.iteration_complete_, loop.next_is_final_, loop.next_is_late_, loop.finished_})
      out.Put<uint8_t>(flag ? 1 : 0);
    for (const double value : {loop.seconds_, loop.seconds_learning_, loop.iteration_seconds_,
                               loop.last_advance_seconds_, loop.previous_prediction_, loop.error_}) {
      out.Put(value);
    }
  }

  static void ReadPosition(ByteReader& in, Loop* loop) {
    loop->iteration_ = in.Get<uint32_t>();
    loop->round_ = in.Get<uint32_t>();
    loop->iteration_passes_ = in.Get<uint64_t>();
    loop->passes_ = in.Get<uint64_t>();
    for (bool* flag : {&loop->final_iteration_, &loop->iteration_complete_, &loop->next_is_final_, &loop->next_is_late_,
                       &loop->finished_})
      *flag = in.GetFlag();
    for (double* value : {&loop->seconds_, &loop->seconds_learning_, &loop->iteration_seconds_,
                          &loop->last_advance_seconds_, &loop->previous_prediction_}) {
      *value = ReadSeconds(in);
    }
    loop->error_ = in.Get<double>();
    // Whatever else the position says, the next round must be computable from it.
    const uint64_t bound = loop->method_->IterationPasses(*loop->state_, loop->iteration_);
    const bool training = !loop->final_iteration_;
    const bool fits = loop->iteration_passes_ <= loop->passes_ && loop->passes_ <= loop->SppBudget() &&
                      (loop->finished_ || loop->passes_ < loop->SppBudget()) &&
                      (!training || (bound > 0 && loop->iteration_passes_ <= bound)) &&
                      (!loop->iteration_complete_ || (training && loop->iteration_passes_ == bound)) &&
                      (!training || loop->finished_ || loop->iteration_complete_ || loop->iteration_passes_ < bound);
    if (!fits) in.Fail("has a position that its job cannot be in");
  }

  static void ReadFilms(ByteReader& in, Loop* loop) {
    loop->films_.clear();
    const auto count = in.Get<uint64_t>();
    if (count == 0 || count > uint64_t{loop->iteration_} + 1) in.Fail("has a number of films that its job cannot have");
    for (uint64_t i = 0; i < count; ++i) {
      IterationFilm film;
      film.iteration = in.Get<uint32_t>();
      film.candidate = in.Get<uint32_t>();
      film.rays = in.Get<uint64_t>();
      film.vertices = in.Get<uint64_t>();
      film.seconds = ReadSeconds(in);
      film.film = Film::Read(in);
      if (film.film.width() != loop->grid_.width() || film.film.height() != loop->grid_.height())
        in.Fail("has a film of another size than its job's");
      if (film.candidate >= loop->method_->candidates()) in.Fail("has a film of no candidate");
      loop->films_.push_back(std::move(film));
    }
    if (loop->films_.back().iteration != loop->iteration_ ||
        loop->films_.back().candidate != loop->method_->ActiveUnder(loop->state_).candidate ||
        loop->films_.back().film.passes() != loop->iteration_passes_) {
      in.Fail("has a last film that is not the current iteration's");
    }
  }

  static void WriteReport(ByteWriter& out, const JobReport& report) {
    out.Put<uint64_t>(report.points.size());
    for (const ErrorPoint& point : report.points) WritePoint(out, point);
    report.health.Write(out);
    out.Put(report.rays);
    out.Put(report.paths);
    out.Put(report.vertices);
    out.PutString(report.stop_reason);
  }

  static void ReadReport(ByteReader& in, JobReport* report) {
    report->points.clear();
    const auto count = in.Get<uint64_t>();
    for (uint64_t i = 0; i < count; ++i) report->points.push_back(ReadPoint(in));
    report->health = HealthReport::Read(in);
    report->rays = in.Get<uint64_t>();
    report->paths = in.Get<uint64_t>();
    report->vertices = in.Get<uint64_t>();
    report->stop_reason = in.GetString();
  }
};

Bytes Loop::Checkpoint() const {
  return LoopCheckpoint::Write(*this);
}

std::unique_ptr<Loop> Loop::Restore(std::string_view checkpoint) {
  return LoopCheckpoint::Read(checkpoint);
}

}  // namespace lodestar
