#include "client/comparison.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>

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
  std::vector<std::string> labels;
  for (const ComparisonRun& run : runs) {
    if (std::find(labels.begin(), labels.end(), run.label) == labels.end()) labels.push_back(run.label);
  }
  Json methods = Json::array();
  double first_error = 0;
  for (const std::string& label : labels) {
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
    json["efficiency"] = error.mean > 0 && seconds.mean > 0 ? Json(1 / (error.mean * seconds.mean)) : Json(nullptr);
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

}  // namespace lodestar
