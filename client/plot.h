// The plot of error against time: client/python/lodestar_plot.py under the first Python 3 that has matplotlib.
#pragma once

#include <filesystem>
#include <string>

namespace lodestar {

// Draws `csv` (report_json.h) as `png`. False where that was not possible: then says why, and what to try, on standard
// error; a missing plot never fails a render. LODESTAR_PYTHON names an interpreter to try first, LODESTAR_PLOT another
// script.
bool DrawErrorPlot(const std::filesystem::path& csv, const std::filesystem::path& png, const std::string& title);

}  // namespace lodestar
