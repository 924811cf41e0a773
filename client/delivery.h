// What is left of a render, wherever it ran: its files on disk, and its report in words.
#pragma once

#include <exception>
#include <filesystem>
#include <functional>
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

// What goes wrong with one part of a delivery keeps no other part from its turn.
class Failures {
 public:
  // False where `part` threw. The first failure is kept for Throw(); the others are said on standard error at once.
  bool Try(const std::function<void()>& part);
  void Throw() const;  // the first one; nothing where there was none

 private:
  std::exception_ptr first_;
};

// A file besides those of OutputPaths: its kind in the report, its name, and what writes it.
struct MoreFile {
  std::string kind;
  std::filesystem::path path;
  std::function<void()> write;
};
struct RenderExtras {
  std::vector<ImageChannel> aovs;  // more channels of an EXR
  std::vector<MoreFile> files;
};

// Writes the files of OutputPaths from an image and a report in JSON (report_json.h): the image first, the report last.
// Gives back the names by kind of those that were written, e.g. {"image": "out.exr"}. The plot is left out where there
// are no error points or no matplotlib.
nlohmann::json DeliverRender(const OutputPaths& paths, const Image& image, nlohmann::json report,
                             const std::string& label, Failures& failures, const RenderExtras& extras = {});

// The metadata of the EXR, from the same report.
std::map<std::string, std::string> ImageMetadata(const nlohmann::json& report);

// Result, health and files as a few lines for people.
std::string Summary(const nlohmann::json& report);

}  // namespace lodestar
