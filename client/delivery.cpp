#include "client/delivery.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/plot.h"
#include "client/replay_text.h"
#include "client/values.h"
#include "core/learning/report_json.h"

namespace lodestar {
namespace {

using Json = nlohmann::json;

// A member of an object inside an object, or null: reports of a farm may come from another version.
const Json& At(const Json& json, const char* outer, const char* inner) {
  static const Json kNull;
  const auto a = json.find(outer);
  if (a == json.end() || !a->is_object()) return kNull;
  const auto b = a->find(inner);
  return b == a->end() ? kNull : *b;
}

std::string Text(const Json& value) {
  return value.is_string() ? value.get<std::string>() : value.is_null() ? "" : value.dump();
}
double Value(const Json& value) {
  return value.is_number() ? value.get<double>() : 0;
}

}  // namespace

Json CompleteReport(Json report, const ReportContext& context) {
  report["command"] = context.command_line;
  report["scene"]["path"] = context.scene_path;
  if (const std::string replay = ReplayCommand(report, context.scene_path); !replay.empty())
    report["health"]["replay"] = replay;
  return report;
}

std::map<std::string, std::string> ImageMetadata(const Json& report) {
  std::map<std::string, std::string> metadata;
  metadata["Software"] = "lodestar " LODESTAR_VERSION;
  metadata["lodestar:method"] = Text(At(report, "job", "method"));
  metadata["lodestar:options"] = Text(At(report, "job", "options"));
  metadata["lodestar:seed"] = Text(At(report, "job", "seed"));
  metadata["lodestar:spp"] = Text(At(report, "result", "spp"));
  metadata["lodestar:training_iterations"] = Text(At(report, "result", "training_iterations"));
  metadata["lodestar:seconds"] = Text(At(report, "result", "seconds"));
  metadata["lodestar:scene"] = Text(At(report, "scene", "path"));
  metadata["lodestar:scene_hash"] = Text(At(report, "scene", "hash"));
  metadata["lodestar:command"] = report.value("command", "");
  return metadata;
}

bool Failures::Try(const std::function<void()>& part) {
  try {
    part();
    return true;
  } catch (const std::exception& error) {
    if (first_) {
      std::fprintf(stderr, "lodestar: %s\n", error.what());
    } else {
      first_ = std::current_exception();
    }
    return false;
  }
}

void Failures::Throw() const {
  if (first_) std::rethrow_exception(first_);
}

Json DeliverRender(const OutputPaths& paths, const Image& image, Json report, const std::string& label,
                   Failures& failures, const RenderExtras& extras) {
  Json files = Json::object();
  const auto deliver = [&](const std::string& kind, const std::filesystem::path& path, const auto& write) {
    if (failures.Try(write)) files[kind] = path.string();
  };
  deliver("image", paths.image, [&] { WriteImage(paths.image, image, ImageMetadata(report), extras.aovs); });
  if (paths.png != paths.image) {
    deliver("png", paths.png, [&] { WriteImage(paths.png, image, {}); });
  } else if (files.contains("image")) {
    files["png"] = paths.png.string();
  }
  const auto points = PointsFromJson(report.value("points", Json::array()));
  const Json& seed = At(report, "job", "seed");
  deliver("csv", paths.csv, [&] {
    WriteText(paths.csv, kCsvHeader + PointsToCsv(label, seed.is_number_unsigned() ? seed.get<uint64_t>() : 0, points));
  });
  if (points.empty()) {
    std::fprintf(stderr, "no plot: the render ended before its first error point\n");
  } else if (files.contains("csv") && DrawErrorPlot(paths.csv, paths.plot, paths.image.stem().string())) {
    files["plot"] = paths.plot.string();
  }
  for (const MoreFile& file : extras.files) deliver(file.kind, file.path, file.write);
  report["files"] = files;
  report["files"]["json"] = paths.json.string();
  deliver("json", paths.json, [&] { WriteText(paths.json, DumpJson(report) + "\n"); });
  return files;
}

std::string Summary(const Json& report) {
  const double seconds = Value(At(report, "result", "seconds")), rays = Value(At(report, "result", "rays"));
  std::string text = Text(At(report, "job", "method")) + ": " + Text(At(report, "result", "spp")) + " spp in " +
                     FormatNumber(seconds) + " s";
  if (const double learning = Value(At(report, "result", "seconds_learning")); learning > 0)
    text += " (" + FormatNumber(learning) + " s of it learning)";
  if (seconds > 0 && rays > 0) text += ", " + FormatCount(rays / seconds) + "rays/s";
  if (const std::string reason = Text(At(report, "result", "stop_reason")); !reason.empty())
    text += ", ended by " + reason;
  text += "\n";
  if (const std::string choice = Text(At(report, "result", "choice")); !choice.empty())
    text += "chose " + choice + "\n";
  if (const std::string not_needed = Text(At(report, "scene", "not_needed")); !not_needed.empty())
    text += "not needed by the scene: " + not_needed + "\n";
  if (const auto points = PointsFromJson(report.value("points", Json::array())); !points.empty()) {
    const ErrorPoint& last = points.back();
    text += "estimated relMSE " + (std::isfinite(last.relmse_estimated) ? FormatNumber(last.relmse_estimated)
                                                                        : "unknown (it needs two passes)");
    if (const auto& m = last.against_reference) {
      text += "; against the reference: RMSE " + FormatNumber(m->rmse) + ", MSE " + FormatNumber(m->mse) + ", MAE " +
              FormatNumber(m->mae) + ", relMSE " + FormatNumber(m->relmse) + ", trimmed " +
              FormatNumber(m->relmse_trimmed);
    }
    text += "\n";
  }
  if (const Json& left_out = At(report, "scene", "left_out"); left_out.is_array() && !left_out.empty()) {
    text += "left out of the scene (--lenient):\n";
    for (const Json& line : left_out) text += "  " + Text(line) + "\n";
  }
  if (Value(At(report, "health", "total")) > 0) {
    text += "health: samples refused or changed:";
    for (const auto& [name, count] : At(report, "health", "counts").items()) {
      if (Value(count) > 0) text += " " + name + " " + count.dump();
    }
    text += "\n";
    if (const std::string replay = Text(At(report, "health", "replay")); !replay.empty())
      text += "  the first again: " + replay + "\n";
  }
  if (const auto files = report.find("files"); files != report.end()) {
    for (const char* kind : {"image", "png", "plot", "csv", "json", "state", "fraction"}) {
      if (files->contains(kind))
        text += std::string(kind) + std::string(9 - std::string(kind).size(), ' ') + Text((*files)[kind]) + "\n";
    }
  }
  return text;
}

}  // namespace lodestar
