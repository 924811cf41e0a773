#include "core/learning/report_json.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace lodestar {
namespace {

using Json = nlohmann::json;

// JSON knows no infinities: they are null.
Json Number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json HealthToJson(const HealthReport& health) {
  Json counts = Json::object();
  for (int i = 0; i < kHealthEvents; ++i)
    counts[HealthEventName(static_cast<HealthEvent>(i))] = health.counts[static_cast<size_t>(i)];
  Json json = {{"total", health.total()}, {"counts", counts}};
  if (health.first.exists()) {
    json["first"] = {{"event", HealthEventName(health.first.event)},
                     {"pixel", {health.first.pixel_x, health.first.pixel_y}},
                     {"pass", health.first.pass},
                     {"iteration", health.first.iteration}};
  }
  return json;
}

std::string CsvNumber(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g", value);
  return std::isfinite(value) ? text : "";
}

// A label with options in it has commas.
std::string CsvText(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace

const char kCsvHeader[] = "method,seed,seconds,spp,iteration,relmse_estimated,rmse,mse,mae,relmse,relmse_trimmed\n";

Json MetricsToJson(const ErrorMetrics& metrics) {
  return {{"rmse", Number(metrics.rmse)},
          {"mse", Number(metrics.mse)},
          {"mae", Number(metrics.mae)},
          {"relmse", Number(metrics.relmse)},
          {"relmse_trimmed", Number(metrics.relmse_trimmed)}};
}

Json PointsToJson(const std::vector<ErrorPoint>& points) {
  Json list = Json::array();
  for (const ErrorPoint& point : points) {
    Json json = {{"seconds", Number(point.seconds)},
                 {"spp", point.spp},
                 {"iteration", point.iteration},
                 {"relmse_estimated", Number(point.relmse_estimated)}};
    if (point.against_reference) json["reference"] = MetricsToJson(*point.against_reference);
    list.push_back(std::move(json));
  }
  return list;
}

std::vector<ErrorPoint> PointsFromJson(const Json& list) {
  std::vector<ErrorPoint> points;
  if (!list.is_array()) return points;
  const auto number = [](const Json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_number() ? found->get<double>() : 0.0;
  };
  for (const Json& json : list) {
    ErrorPoint point;
    point.seconds = number(json, "seconds");
    point.spp = static_cast<uint64_t>(number(json, "spp"));
    point.iteration = static_cast<uint32_t>(number(json, "iteration"));
    // Null stands for "not known yet", which is an infinity.
    const auto estimated = json.find("relmse_estimated");
    point.relmse_estimated = estimated != json.end() && estimated->is_number() ? estimated->get<double>() : INFINITY;
    if (!(point.relmse_estimated >= 0)) point.relmse_estimated = INFINITY;
    if (const auto reference = json.find("reference"); reference != json.end() && reference->is_object()) {
      point.against_reference =
          ErrorMetrics{number(*reference, "rmse"), number(*reference, "mse"), number(*reference, "mae"),
                       number(*reference, "relmse"), number(*reference, "relmse_trimmed")};
    }
    points.push_back(point);
  }
  return points;
}

Json ReportToJson(const JobReport& report) {
  const JobSpec& job = report.job;
  const Survey& survey = report.survey;
  const auto corner = [](Vec3 v) { return Json{v.x, v.y, v.z}; };
  Json json;
  json["scene"] = {{"hash", survey.scene_hash},
                   {"needs", survey.needs},
                   {"not_needed", survey.not_needed},
                   {"resolution", {survey.resolution_x, survey.resolution_y}},
                   {"max_depth", survey.max_depth},
                   {"left_out", survey.left_out},
                   {"bounds", {corner(survey.bounds.min), corner(survey.bounds.max)}}};
  json["job"] = {{"method", job.method},
                 {"options", job.options},
                 {"seed", job.seed},
                 {"filter", job.filter},
                 {"lenient", job.lenient},
                 {"budget", {{"spp", job.budget.spp}, {"seconds", job.budget.seconds}, {"error", job.budget.error}}}};
  json["result"] = {{"stop_reason", report.stop_reason},
                    {"spp", report.passes},
                    {"iterations", report.iterations},
                    {"training_iterations", report.training_iterations},
                    {"seconds", report.seconds},
                    {"seconds_learning", report.seconds_learning},
                    {"rays", report.rays},
                    {"paths", report.paths},
                    {"vertices", report.vertices},
                    {"rays_per_second", report.seconds > 0 ? static_cast<double>(report.rays) / report.seconds : 0.0}};
  if (!report.choice.empty()) json["result"]["choice"] = report.choice;
  if (!report.state_hash.empty()) json["result"]["state_sha256"] = report.state_hash.hex;
  if (!report.image_hash.empty()) json["result"]["image_sha256"] = report.image_hash.hex;
  json["health"] = HealthToJson(report.health);
  json["points"] = PointsToJson(report.points);
  return json;
}

std::string DumpJson(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

std::string PointsToCsv(const std::string& label, uint64_t seed, const std::vector<ErrorPoint>& points) {
  std::string csv;
  const std::string name = CsvText(label);
  for (const ErrorPoint& point : points) {
    csv += name + "," + std::to_string(seed) + "," + CsvNumber(point.seconds) + "," + std::to_string(point.spp) + "," +
           std::to_string(point.iteration) + "," + CsvNumber(point.relmse_estimated);
    if (const auto& m = point.against_reference) {
      for (const double value : {m->rmse, m->mse, m->mae, m->relmse, m->relmse_trimmed})
        (csv += ",") += CsvNumber(value);
    } else {
      csv += ",,,,,";
    }
    csv += "\n";
  }
  return csv;
}

}  // namespace lodestar
