// Logging through spdlog, to standard error, so that --json output on standard out stays clean.
#pragma once

#include <spdlog/spdlog.h>

#include <string>

namespace lodestar {

// Called once from main: name goes into every line; LODESTAR_LOG=debug|info|warn|error sets the level (default info).
void InitLog(const std::string& name);

}  // namespace lodestar
