// One subcommand a file: each registers its options and, when chosen, leaves the function that main runs.
#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>
#include <functional>
#include <string>

#include "client/exit_code.h"

namespace lodestar {

struct Invocation {
  std::string command_line;       // as typed, quoted for a shell: goes into what the command writes
  std::function<ExitCode()> run;  // set by the chosen subcommand
};

// A check that leaves the option's type in --help alone; its message still says what is accepted.
inline CLI::Validator Unnamed(const CLI::Validator& check) {
  return check.description("");
}

// Numbers without an upper end. (CLI11's own checks for them name one, in 309 digits.)
CLI::Validator AboveZero();
CLI::Validator ZeroOrAbove();

void AddRenderCommand(CLI::App& app, Invocation& invocation);
void AddCompareCommand(CLI::App& app, Invocation& invocation);
void AddInspectCommand(CLI::App& app, Invocation& invocation);
void AddReplayCommand(CLI::App& app, Invocation& invocation);
void AddDiffCommand(CLI::App& app, Invocation& invocation);
void AddSubmitCommand(CLI::App& app, Invocation& invocation);
void AddJobsCommand(CLI::App& app, Invocation& invocation);
void AddWatchCommand(CLI::App& app, Invocation& invocation);
void AddCancelCommand(CLI::App& app, Invocation& invocation);
void AddImageCommand(CLI::App& app, Invocation& invocation);
void AddReportCommand(CLI::App& app, Invocation& invocation);
void AddWorkersCommand(CLI::App& app, Invocation& invocation);

// Parses, runs, and turns whatever was thrown into a message on standard error and an exit code.
int RunCli(int argc, const char* const* argv);

}  // namespace lodestar
