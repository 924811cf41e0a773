// A job's report as JSON and its error points as CSV; one schema for renders in a process and on the farm
// (docs/command-line.md).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/learning/loop.h"

namespace lodestar {

// The hashes are left out where the report has none.
nlohmann::json ReportToJson(const JobReport& report);
nlohmann::json MetricsToJson(const ErrorMetrics& metrics);
nlohmann::json PointsToJson(const std::vector<ErrorPoint>& points);
// Members that are missing or of another type count as zero, an estimated error as infinity (unknown); so does one that
// is no error at all: negative or NaN.
std::vector<ErrorPoint> PointsFromJson(const nlohmann::json& points);

// As text, and never an exception: names of files need not be UTF-8, and what is not becomes U+FFFD. `indent` -1: on
// one line.
std::string DumpJson(const nlohmann::json& json, int indent = 2);

// One header line, then one line a point; columns of a reference that was not given stay empty. `label` is quoted (RFC
// 4180) where it must be.
extern const char kCsvHeader[];
std::string PointsToCsv(const std::string& label, uint64_t seed, const std::vector<ErrorPoint>& points);

}  // namespace lodestar
