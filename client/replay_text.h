// The command that renders the health report's first offending pixel sample again.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace lodestar {

// From a report (core/learning/report_json.h); empty where no sample was refused or changed.
std::string ReplayCommand(const nlohmann::json& report, const std::string& scene_path);

}  // namespace lodestar
