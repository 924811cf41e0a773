// Progress of a render on standard error: one line redrawn on a terminal, a plain line now and then elsewhere.
#pragma once

#include <cstdio>
#include <string>

#include "core/base/clock.h"
#include "core/learning/loop.h"

namespace lodestar {

// One line of at most `width` columns: bar, share, iteration, spp, estimated error, rays/s, time left. Pure, for tests.
std::string ProgressText(const JobProgress& progress, int width);

class ProgressLine {
 public:
  // `quiet`: says nothing at all.
  explicit ProgressLine(bool quiet, std::FILE* out = stderr, const Clock& clock = Clock::Steady());
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  void Update(const JobProgress& progress);
  // Ends the redrawn line, so that other output starts on one of its own.
  void Finish();

 private:
  std::FILE* out_;
  const Clock& clock_;
  bool quiet_, terminal_;
  bool open_ = false;  // a redrawn line stands without its newline
  bool any_ = false;
  Clock::Duration last_{};
};

}  // namespace lodestar
