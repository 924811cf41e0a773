#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <memory>
#include <sstream>

#include "client/command.h"
#include "client/suggest.h"
#include "client/values.h"

namespace lodestar {
namespace {

constexpr char kDescription[] =
    "Lodestar renders pbrt-v4 scenes with path guiding, in this process or on a farm.\n"
    "'lodestar COMMAND --help' lists a command's options with their defaults.";

constexpr char kFooter[] =
    "Examples:\n"
    "  lodestar inspect scenes/door-ajar.pbrt\n"
    "  lodestar render scenes/door-ajar.pbrt --time 60s -o out/door.exr\n"
    "  lodestar submit scenes/door-ajar.pbrt --farm localhost:7420 --spp 256 --watch -o out/door.exr\n"
    "  lodestar compare scenes/door-ajar.pbrt --methods path,sdtree --time 60s --seeds 3 -o out/report\n"
    "\n"
    "Exit codes: 0 done, 1 internal error, 2 wrong option, 3 bad scene, 4 file not readable or writable,\n"
    "            5 farm unreachable, 6 job failed or refused, 130 interrupted.";

void CollectNames(const CLI::App& app, std::vector<std::string>* names) {
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names->push_back("--" + name);
  }
  for (const CLI::App* sub : app.get_subcommands(nullptr)) names->push_back(sub->get_name());
}

// What the command line had that nobody wanted, with what may have been meant.
std::string ExplainExtras(CLI::App& app) {
  const auto chosen = app.get_subcommands();
  const CLI::App& command = chosen.empty() ? app : *chosen.front();
  std::vector<std::string> names;
  CollectNames(command, &names);
  std::string text;
  bool after_option = false;
  for (const std::string& word : app.remaining(true)) {
    const std::string name = word.substr(0, word.find('='));
    const bool option = name.starts_with("-");
    if (!option && after_option) continue;  // the value of an option that nobody knows
    after_option = option;
    if (!text.empty()) text += "\n";
    text += option ? "unknown option " + name
                   : (chosen.empty() ? "unknown command '" : "unexpected argument '") + word + "'";
    if (option || chosen.empty()) text += Suggestion(name, names);
  }
  return text;
}

// Breaks long descriptions, which CLI11 prints on one line.
class WrappingFormatter final : public CLI::Formatter {
 public:
  std::string make_option_desc(const CLI::Option* option) const override {
    constexpr size_t kWidth = 84;
    std::string wrapped;
    size_t column = 0;
    std::istringstream words(CLI::Formatter::make_option_desc(option));
    for (std::string word; words >> word;) {
      if (column > 0 && column + 1 + word.size() > kWidth) {
        wrapped += '\n';
        column = 0;
      } else if (column > 0) {
        wrapped += ' ';
        ++column;
      }
      wrapped += word;
      column += word.size();
    }
    return wrapped;
  }
};

CLI::Validator NumberThat(bool (*fits)(double), const char* must) {
  return {[=](const std::string& text) {
            double value = 0;
            return CLI::detail::lexical_cast(text, value) && fits(value) ? "" : "'" + text + "' " + must;
          },
          ""};
}

int Report(const std::string& message, ExitCode code) {
  std::cout.flush();
  std::cerr << "lodestar: " << message << "\n";
  return static_cast<int>(code);
}

// A command whose words did not come out has not done what it was asked for; one that has failed keeps its reason.
int Delivered(int code) {
  errno = 0;
  std::cout.flush();
  const bool out = std::fflush(stdout) == 0 && !std::ferror(stdout) && std::cout.good();
  if (out || code != static_cast<int>(ExitCode::kOk)) return code;
  return Report("standard output cannot be written" + (errno != 0 ? std::string(": ") + std::strerror(errno) : ""),
                ExitCode::kIo);
}

int UsageError(CLI::App& app, const std::string& message) {
  const auto chosen = app.get_subcommands();
  const std::string command = chosen.empty() ? "" : " " + chosen.front()->get_name();
  return Report(message + "\ntry: lodestar" + command + " --help", ExitCode::kUsage);
}

}  // namespace

CLI::Validator AboveZero() {
  return NumberThat([](double value) { return value > 0; }, "must be a number above 0");
}
CLI::Validator ZeroOrAbove() {
  return NumberThat([](double value) { return value >= 0; }, "must be a number, 0 or above");
}

int RunCli(int argc, const char* const* argv) {
  CLI::App app(kDescription, "lodestar");
  app.footer(kFooter);
  app.set_version_flag("--version", "lodestar " LODESTAR_VERSION);
  app.require_subcommand(0, 1);
  auto formatter = std::make_shared<WrappingFormatter>();
  formatter->column_width(34);
  app.formatter(formatter);  // subcommands inherit it

  Invocation invocation;
  for (int i = 0; i < argc; ++i) invocation.command_line += (i > 0 ? " " : "") + ShellQuote(argv[i]);
  AddRenderCommand(app, invocation);
  AddCompareCommand(app, invocation);
  AddInspectCommand(app, invocation);
  AddDiffCommand(app, invocation);
  AddReplayCommand(app, invocation);
  AddSubmitCommand(app, invocation);
  AddJobsCommand(app, invocation);
  AddWatchCommand(app, invocation);
  AddCancelCommand(app, invocation);
  AddImageCommand(app, invocation);
  AddReportCommand(app, invocation);
  AddWorkersCommand(app, invocation);

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {  // --help, --version
    return Delivered(app.exit(success));
  } catch (const CLI::ParseError& error) {
    const std::string extras = ExplainExtras(app);
    return UsageError(app, extras.empty() ? error.what() : extras);
  }
  if (!invocation.run) {
    std::cerr << app.help();
    return static_cast<int>(ExitCode::kUsage);
  }

  try {
    return Delivered(static_cast<int>(invocation.run()));
  } catch (const CommandError& error) {
    return Report(error.what(), error.code());
  } catch (const Error& error) {
    const ExitCode code = ExitCodeOf(error.kind());
    return code == ExitCode::kUsage ? UsageError(app, error.what()) : Report(error.what(), code);
  } catch (const std::bad_alloc&) {
    return Report("out of memory; try a lower --resolution or a smaller scene", ExitCode::kInternal);
  } catch (const std::exception& error) {
    return Report(std::string("internal error: ") + error.what() +
                      "\nplease report it with the command: " + invocation.command_line,
                  ExitCode::kInternal);
  }
}

}  // namespace lodestar
