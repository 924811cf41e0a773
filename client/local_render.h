// A render in this process, and what is left of it on disk.
#pragma once

#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "client/outputs.h"
#include "client/progress.h"
#include "core/base/stop.h"
#include "core/learning/guide_file.h"
#include "core/learning/report_json.h"
#include "core/tracing/tracer.h"

namespace lodestar {

struct RenderResult {
  Image image;
  JobReport report;
  std::shared_ptr<const State> state;  // at the end
};

// Throws Error(kInvalidInput) for a job in which nothing is learned that --state could save.
void CheckLearns(const CompiledJob& compiled, const JobSpec& job);
// Runs the job to its budget or to a stop request. `guide`, where given, is filled with what was learned. Throws Error.
RenderResult RenderLocally(const CompiledJob& compiled, const JobSpec& job, int threads,
                           const std::shared_ptr<const Image>& reference, const StopToken& stop, ProgressLine& progress,
                           GuideFile* guide = nullptr);

// CompileJob, with its errors turned into CommandError(kBadScene).
CompiledJob CompileScene(const SceneDescription& description, const JobSpec& job);

// The report of a render with what only the command line knows: the scene's path, the command, the replay command.
struct ReportContext {
  std::string scene_path;
  std::string command_line;
};
nlohmann::json CompleteReport(nlohmann::json report, const ReportContext& context);

// Writes the files of OutputPaths from an image and a report in JSON (report_json.h); gives back their names by kind,
// e.g. {"image": "out.exr"}. The plot is left out where there are no error points or no matplotlib.
// `aovs`: more channels of an EXR.
nlohmann::json DeliverRender(const OutputPaths& paths, const Image& image, nlohmann::json report,
                             const std::string& label, const std::vector<ImageChannel>& aovs = {});

// The metadata of the EXR, from the same report.
std::map<std::string, std::string> ImageMetadata(const nlohmann::json& report);

// Result, health and files as a few lines for people.
std::string Summary(const nlohmann::json& report);

}  // namespace lodestar
