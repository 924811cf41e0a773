#include "client/comparison.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "client/job_options.h"
#include "core/base/check.h"
#include "core/learning/report_json.h"

namespace lodestar {
namespace {

using Json = nlohmann::json;

Json ToJson(const Spread& spread) {
  return {{"mean", spread.mean},
          {"median", spread.median},
          {"deviation", spread.deviation},
          {"low", spread.low},
          {"high", spread.high}};
}

std::vector<std::string> LabelsOf(const std::vector<ComparisonRun>& runs) {
  std::vector<std::string> labels;
  for (const ComparisonRun& run : runs) {
    if (std::find(labels.begin(), labels.end(), run.label) == labels.end()) labels.push_back(run.label);
  }
  return labels;
}

// The figure that methods are ranked by.
double RankedError(const ComparisonRun& run) {
  if (run.metrics) return run.metrics->relmse_trimmed;
  return run.report.points.empty() ? 0 : run.report.points.back().relmse_estimated;
}

template <class Value>
Spread Over(const std::vector<const ComparisonRun*>& runs, const Value& value) {
  std::vector<double> values;
  for (const ComparisonRun* run : runs) values.push_back(value(*run));
  return SpreadOf(std::move(values));
}

// A run at some moment.
struct Moment {
  double seconds, spp, error;
};

// Of the recorded points those whose logarithms can be taken.
std::vector<Moment> MomentsOf(const ComparisonRun& run) {
  std::vector<Moment> moments;
  for (const ErrorPoint& point : run.report.points) {
    const double error = point.against_reference ? point.against_reference->relmse_trimmed : point.relmse_estimated;
    if (point.seconds > 0 && point.spp > 0 && error > 0 && std::isfinite(error))
      moments.push_back({point.seconds, static_cast<double>(point.spp), error});
  }
  return moments;
}

// Nothing before the first moment.
std::optional<Moment> MomentAt(const std::vector<Moment>& moments, double Moment::*by, double at) {
  const auto after =
      std::find_if(moments.begin(), moments.end(), [&](const Moment& moment) { return moment.*by >= at; });
  LODESTAR_CHECK(after != moments.end());
  if (*after.*by == at) return *after;
  if (after == moments.begin()) return std::nullopt;
  const Moment& a = *(after - 1);
  const Moment& b = *after;
  const double share = std::log(at / a.*by) / std::log(b.*by / a.*by);
  const auto between = [&](double Moment::*member) { return a.*member * std::pow(b.*member / a.*member, share); };
  Moment moment = {between(&Moment::seconds), between(&Moment::spp), between(&Moment::error)};
  moment.*by = at;  // to the bit
  return moment;
}

Json EfficiencyJson(double error, double seconds) {
  return error > 0 && seconds > 0 ? Json(1 / (error * seconds)) : Json(nullptr);
}

// "auto:candidates=path" and then "sdtree": a second method, or a second candidate?
void RefuseACutList(const std::string& choice, const std::string& next) {
  const size_t equals = choice.rfind('=');
  if (equals == std::string::npos || choice.find('/', equals) != std::string::npos) return;
  const size_t name = choice.find_last_of(":,", equals) + 1;
  const std::string option = choice.substr(name, equals - name);
  if (!TakesList(FindMethod(choice.substr(0, choice.find(':'))), option)) return;
  throw Error(ErrorKind::kInvalidInput,
              "--methods: '" + choice + "," + next + "' does not say whether the comma ends the list of '" + option +
                  "'; write " + option + "=A/B for a list, or name the other methods in front of this one");
}

}  // namespace

Spread SpreadOf(std::vector<double> values) {
  Spread spread;
  if (values.empty()) return spread;
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  spread.low = values.front();
  spread.high = values.back();
  spread.median = n % 2 == 1 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
  for (const double value : values) spread.mean += value / static_cast<double>(n);
  if (n > 1) {
    double sum = 0;
    for (const double value : values) sum += (value - spread.mean) * (value - spread.mean);
    spread.deviation = std::sqrt(sum / static_cast<double>(n - 1));
  }
  return spread;
}

std::vector<std::string> SplitMethods(const std::string& text) {
  std::vector<std::string> methods;
  for (size_t at = 0; at <= text.size();) {
    const size_t end = std::min(text.find(',', at), text.size());
    const std::string piece = text.substr(at, end - at);
    at = end + 1;
    if (piece.empty()) continue;
    const bool option = piece.find('=') != std::string::npos && piece.find(':') == std::string::npos;
    if (option && !methods.empty()) {
      // "sdtree,nee=always" means the same as "sdtree:nee=always".
      methods.back() += (methods.back().find(':') == std::string::npos ? ":" : ",") + piece;
    } else {
      if (!methods.empty()) RefuseACutList(methods.back(), piece);
      methods.push_back(piece);
    }
  }
  return methods;
}

std::string FileLabel(const std::string& label) {
  std::string name;
  for (const char c : label) {
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' || c == '.') {
      name += c;
    } else if (!name.empty() && name.back() != '_') {
      name += '_';
    }
  }
  return name;
}

Json Summarize(const std::vector<ComparisonRun>& runs) {
  Json methods = Json::array();
  double first_error = 0;
  for (const std::string& label : LabelsOf(runs)) {
    std::vector<const ComparisonRun*> mine;
    for (const ComparisonRun& run : runs) {
      if (run.label == label) mine.push_back(&run);
    }
    const Spread error = Over(mine, RankedError);
    const Spread seconds = Over(mine, [](const ComparisonRun& run) { return run.report.seconds; });
    if (methods.empty()) first_error = error.mean;
    Json json;
    json["method"] = label;
    json["seconds"] = ToJson(seconds);
    json["seconds_learning"] = ToJson(Over(mine, [](const ComparisonRun& run) { return run.report.seconds_learning; }));
    json["spp"] = ToJson(Over(mine, [](const ComparisonRun& run) { return static_cast<double>(run.report.passes); }));
    json["rays_per_second"] = ToJson(Over(mine, [](const ComparisonRun& run) {
      return run.report.seconds > 0 ? static_cast<double>(run.report.rays) / run.report.seconds : 0;
    }));
    json["relmse_estimated"] = ToJson(Over(mine, [](const ComparisonRun& run) {
      return run.report.points.empty() ? 0 : run.report.points.back().relmse_estimated;
    }));
    if (std::all_of(mine.begin(), mine.end(), [](const ComparisonRun* run) { return run->metrics.has_value(); })) {
      json["rmse"] = ToJson(Over(mine, [](const ComparisonRun& run) { return run.metrics->rmse; }));
      json["mse"] = ToJson(Over(mine, [](const ComparisonRun& run) { return run.metrics->mse; }));
      json["mae"] = ToJson(Over(mine, [](const ComparisonRun& run) { return run.metrics->mae; }));
      json["relmse"] = ToJson(Over(mine, [](const ComparisonRun& run) { return run.metrics->relmse; }));
      json["relmse_trimmed"] = ToJson(error);
    }
    json["efficiency"] = EfficiencyJson(error.mean, seconds.mean);
    json["ratio_to_first"] = error.mean > 0 ? Json(first_error / error.mean) : Json(nullptr);
    for (const ComparisonRun* run : mine) {
      Json one = {{"seed", run->seed},
                  {"seconds", run->report.seconds},
                  {"spp", run->report.passes},
                  {"health_events", run->report.health.total()},
                  {"picture", run->picture},
                  {"map", run->map},
                  {"points", PointsToJson(run->report.points)}};
      if (run->metrics) one["reference"] = MetricsToJson(*run->metrics);
      if (!run->report.choice.empty()) one["choice"] = run->report.choice;
      json["runs"].push_back(std::move(one));
    }
    methods.push_back(std::move(json));
  }
  return methods;
}

Json AtEqual(const std::vector<ComparisonRun>& runs, EqualBy equal) {
  double Moment::*const by = equal == EqualBy::kSamples ? &Moment::spp : &Moment::seconds;
  std::vector<std::vector<Moment>> moments;
  double at = std::numeric_limits<double>::infinity();
  for (const ComparisonRun& run : runs) {
    moments.push_back(MomentsOf(run));
    if (moments.back().empty()) return nullptr;
    at = std::min(at, moments.back().back().*by);
  }
  Json methods = Json::array();
  std::optional<double> first_error;
  for (const std::string& label : LabelsOf(runs)) {
    std::vector<double> seconds, spp, error;
    bool early = false;  // a run has no error at that moment yet
    for (size_t i = 0; i < runs.size(); ++i) {
      if (runs[i].label != label) continue;
      const auto moment = MomentAt(moments[i], by, at);
      if (!moment) {
        early = true;
        continue;
      }
      seconds.push_back(moment->seconds);
      spp.push_back(moment->spp);
      error.push_back(moment->error);
    }
    Json json = {{"method", label}};
    for (const auto& [name, values] : {std::pair{"seconds", &seconds}, {"spp", &spp}, {"error", &error}})
      json[name] = early ? Json(nullptr) : ToJson(SpreadOf(*values));
    const double mean = early ? 0 : SpreadOf(error).mean;
    if (!first_error) first_error = mean;
    json["efficiency"] = early ? Json(nullptr) : EfficiencyJson(mean, SpreadOf(seconds).mean);
    json["ratio_to_first"] = mean > 0 && *first_error > 0 ? Json(*first_error / mean) : Json(nullptr);
    methods.push_back(std::move(json));
  }
  return {{"by", equal == EqualBy::kSamples ? "spp" : "seconds"}, {"at", at}, {"methods", std::move(methods)}};
}

}  // namespace lodestar
