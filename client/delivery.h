// What is left of a render, wherever it ran: its files on disk, and its report in words.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "client/outputs.h"

namespace lodestar {

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
