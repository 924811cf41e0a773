// Methods side by side over several seeds: figures, and the report of them. The JSON of Summarize is the one source of
// both reports.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/film/error_metrics.h"
#include "core/learning/loop.h"

namespace lodestar {

// One render of a comparison.
struct ComparisonRun {
  std::string label;  // the method as the user wrote it
  uint64_t seed = 0;
  JobReport report;
  std::optional<ErrorMetrics> metrics;  // of the final image; none without a reference
  std::string picture, map;             // file names within the report's folder; map empty without a reference
};

struct Spread {
  double mean = 0, median = 0, deviation = 0, low = 0, high = 0;  // deviation: of the sample, 0 for one value
};
Spread SpreadOf(std::vector<double> values);

// "path,sdtree:nee=always,combine=discard" -> two methods: a piece NAME=VALUE without a method of its own belongs to
// the one before it. Throws Error(kInvalidInput) where a method follows the single value of an option that takes a
// list.
std::vector<std::string> SplitMethods(const std::string& text);

// A label as part of a file name.
std::string FileLabel(const std::string& label);

// By method, in the order of first appearance: spp, seconds, every metric with its spread over the seeds, efficiency =
// 1 / (error * seconds) and the error of the first method over this one's (above 1: better than the first). The error
// is the trimmed relMSE, estimated where there is no reference.
nlohmann::json Summarize(const std::vector<ComparisonRun>& runs);

// The runs again where all have the same samples per pixel or the same seconds: as much as the shortest has reached.
// Between the recorded points of a run the values are interpolated, linearly in their logarithms. Gives {"by": "spp" or
// "seconds", "at", "methods": [{"method", "seconds", "spp", "error" (the ranked one; spreads, null where a run has no
// error that early), "efficiency", "ratio_to_first"}]}, or null where a run has no error at all.
enum class EqualBy { kSamples, kTime };
nlohmann::json AtEqual(const std::vector<ComparisonRun>& runs, EqualBy by);

// `document`: {"scene", "command", "methods": Summarize(), "equal": AtEqual(), "plot": file or null, "reference": file
// or ""}.
std::string MarkdownReport(const nlohmann::json& document);
std::string HtmlReport(const nlohmann::json& document);

}  // namespace lodestar
