#include "client/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "client/values.h"

namespace lodestar {
namespace {

constexpr auto kRedraw = std::chrono::milliseconds(100);
constexpr auto kPlainLine = std::chrono::seconds(5);

int Columns(std::FILE* out) {
  winsize size{};
  return ioctl(fileno(out), TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 100;
}

std::string Bar(double fraction, int width) {
  const int full = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * width + 0.5);
  return "[" + std::string(static_cast<size_t>(full), '#') + std::string(static_cast<size_t>(width - full), '-') + "]";
}

}  // namespace

std::string ProgressText(const JobProgress& progress, int width) {
  char head[32];
  std::snprintf(head, sizeof head, " %3.0f%%", 100 * std::clamp(progress.fraction, 0.0, 1.0));
  std::string text = head;
  text += "  iteration " + std::to_string(progress.iteration) + "  " + std::to_string(progress.passes) + " spp";
  // Below two passes there is no variance yet, hence no estimate.
  text += "  error " + (progress.relmse_estimated > 0 && std::isfinite(progress.relmse_estimated)
                            ? FormatNumber(progress.relmse_estimated)
                            : std::string("-"));
  if (progress.seconds > 0)
    text += "  " + FormatCount(static_cast<double>(progress.rays) / progress.seconds) + "rays/s";
  text += "  " + FormatDuration(progress.seconds);
  text += "  left " + FormatDuration(progress.seconds_left);
  const int room = width - static_cast<int>(text.size()) - 2;
  if (room >= 8) text = Bar(progress.fraction, std::min(room, 30)) + text;
  if (static_cast<int>(text.size()) > width) text.resize(static_cast<size_t>(std::max(width, 0)));
  return text;
}

ProgressLine::ProgressLine(bool quiet, std::FILE* out, const Clock& clock)
    : out_(out), clock_(clock), quiet_(quiet), terminal_(isatty(fileno(out)) != 0) {}

ProgressLine::~ProgressLine() {
  Finish();
}

void ProgressLine::Update(const JobProgress& progress) {
  if (quiet_) return;
  const auto now = clock_.Now();
  const bool last = progress.fraction >= 1;
  if (any_ && !last && now - last_ < (terminal_ ? Clock::Duration(kRedraw) : Clock::Duration(kPlainLine))) return;
  any_ = true;
  last_ = now;
  if (terminal_) {
    // Carriage return, the line, erase to the end of the line.
    std::fprintf(out_, "\r%s\x1b[K", ProgressText(progress, Columns(out_) - 1).c_str());
    open_ = true;
  } else {
    std::fprintf(out_, "%s\n", ProgressText(progress, 120).c_str());
  }
  std::fflush(out_);
}

void ProgressLine::Finish() {
  if (open_) std::fputc('\n', out_);
  open_ = false;
}

}  // namespace lodestar
