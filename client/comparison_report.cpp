// The report of a comparison, in Markdown and in HTML.
#include <nlohmann/json.hpp>

#include "client/comparison.h"
#include "client/values.h"

namespace lodestar {
namespace {

using Json = nlohmann::json;

constexpr struct {
  const char *key, *title;
} kMetrics[] = {{"rmse", "RMSE"},
                {"mse", "MSE"},
                {"mae", "MAE"},
                {"relmse", "relMSE"},
                {"relmse_trimmed", "trimmed relMSE"},
                {"relmse_estimated", "estimated relMSE"}};

std::string Number(const Json& value) {
  return value.is_number() ? FormatNumber(value.get<double>()) : "-";
}

std::string MeanAndSpread(const Json& spread) {
  if (!spread.is_object()) return "-";
  const std::string mean = Number(spread["mean"]);
  if (spread["deviation"].get<double>() == 0) return mean;
  return mean + " +- " + FormatNumber(spread["deviation"].get<double>());
}

// Header and rows of the table of figures, cell by cell.
std::vector<std::vector<std::string>> Table(const Json& methods) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> head = {"method", "seconds", "spp"};
  const bool measured = !methods.empty() && methods[0].contains("relmse_trimmed");
  for (const auto& metric : kMetrics) {
    if (measured || std::string(metric.key) == "relmse_estimated") head.emplace_back(metric.title);
  }
  for (const char* title : {"median", "efficiency", "ratio to the first"}) head.emplace_back(title);
  rows.push_back(head);
  for (const Json& method : methods) {
    std::vector<std::string> row = {method["method"], MeanAndSpread(method["seconds"]), Number(method["spp"]["mean"])};
    for (const auto& metric : kMetrics) {
      if (measured || std::string(metric.key) == "relmse_estimated")
        row.push_back(MeanAndSpread(method.value(metric.key, Json())));
    }
    row.push_back(Number(method[measured ? "relmse_trimmed" : "relmse_estimated"]["median"]));
    row.push_back(Number(method["efficiency"]));
    row.push_back(Number(method["ratio_to_first"]));
    rows.push_back(std::move(row));
  }
  return rows;
}

// The same of AtEqual.
std::vector<std::vector<std::string>> EqualTable(const Json& document) {
  std::vector<std::vector<std::string>> rows = {
      {"method", "seconds", "spp",
       document["reference"].get<std::string>().empty() ? "estimated relMSE" : "trimmed relMSE", "median", "efficiency",
       "ratio to the first"}};
  const Json& equal = document["equal"];
  for (const Json& method : equal["methods"]) {
    std::vector<std::string> row = {method["method"]};
    for (const char* column : {"seconds", "spp", "error"})
      row.push_back(equal["by"] == column ? Number(equal["at"]) : MeanAndSpread(method[column]));
    const Json& error = method["error"];
    row.push_back(error.is_object() ? Number(error["median"]) : "-");
    row.push_back(Number(method["efficiency"]));
    row.push_back(Number(method["ratio_to_first"]));
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string EqualTitle(const Json& equal) {
  const std::string at = FormatNumber(equal["at"].get<double>());
  return equal["by"] == "spp" ? "Equal samples: " + at + " spp" : "Equal time: " + at + " s";
}

constexpr const char* kEqualExplanation =
    "As much as every run has reached; the values lie between the recorded points of a run, interpolated linearly in "
    "their logarithms.";

std::string Explanation(const Json& document) {
  std::string text =
      "Mean +- sample standard deviation over the seeds. Errors are of linear radiance; trimmed: the worst 0.1 % of "
      "pixels left out; "
      "median, efficiency = 1 / (error x seconds) and ratio = the first method's error over this one's are of the ";
  text += document["reference"].get<std::string>().empty()
              ? "estimated relMSE (no reference was given, so this is each method's own variance)."
              : "trimmed relMSE against " + document["reference"].get<std::string>() + ".";
  return text;
}

std::string Escape(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string MarkdownTable(const std::vector<std::vector<std::string>>& rows) {
  std::string text;
  for (size_t i = 0; i < rows.size(); ++i) {
    for (const std::string& cell : rows[i]) (text += "| ") += cell + " ";
    text += "|\n";
    if (i > 0) continue;
    for (size_t column = 0; column < rows[0].size(); ++column) text += column == 0 ? "| --- " : "| ---: ";
    text += "|\n";
  }
  return text;
}

std::string HtmlTable(const std::vector<std::vector<std::string>>& rows) {
  std::string text = "<table>\n";
  for (size_t i = 0; i < rows.size(); ++i) {
    const std::string tag = i == 0 ? "th" : "td";
    text += "<tr>";
    for (const std::string& cell : rows[i]) (((text += "<") += tag) += ">") += Escape(cell) + "</" + tag + ">";
    text += "</tr>\n";
  }
  return text + "</table>\n";
}

}  // namespace

std::string MarkdownReport(const Json& document) {
  std::string text = "# Comparison: " + document["scene"].get<std::string>() + "\n\n    " +
                     document["command"].get<std::string>() + "\n\n";
  text += MarkdownTable(Table(document["methods"])) + "\n" + Explanation(document) + "\n\n";
  if (const Json& equal = document["equal"]; equal.is_object()) {
    text += "**" + EqualTitle(equal) + ".** " + kEqualExplanation + "\n\n" + MarkdownTable(EqualTable(document)) + "\n";
  }
  if (document["plot"].is_string()) text += "![error against time](" + document["plot"].get<std::string>() + ")\n\n";
  for (const Json& method : document["methods"]) {
    const Json& run = method["runs"][0];
    text += "## " + method["method"].get<std::string>() + "\n\n![picture](" + run["picture"].get<std::string>() + ")";
    if (!run["map"].get<std::string>().empty())
      text += " ![relative luminance error](" + run["map"].get<std::string>() + ")";
    text += "\n\n";
    if (run.contains("choice")) text += "Chose " + run["choice"].get<std::string>() + ".\n\n";
  }
  return text;
}

std::string HtmlReport(const Json& document) {
  std::string text =
      "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>Lodestar comparison</title>\n<style>\n"
      "body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 75rem; padding: 0 1rem; color: #222; "
      "background: #fff }\n"
      "table { border-collapse: collapse } td, th { padding: .3rem .7rem; border-bottom: 1px solid #ccc; text-align: "
      "right }\n"
      "td:first-child, th:first-child { text-align: left } code { background: #eee; padding: .2rem .4rem } img { "
      "max-width: 100% }\n"
      "figure { display: inline-block; margin: .5rem; max-width: 36rem } figcaption { color: #555 }\n</style>\n";
  text += "<h1>" + Escape(document["scene"]) + "</h1>\n<p><code>" + Escape(document["command"]) + "</code></p>\n";
  text += HtmlTable(Table(document["methods"])) + "<p>" + Escape(Explanation(document)) + "</p>\n";
  if (const Json& equal = document["equal"]; equal.is_object()) {
    text += "<p><b>" + EqualTitle(equal) + ".</b> " + kEqualExplanation + "</p>\n" + HtmlTable(EqualTable(document));
  }
  if (document["plot"].is_string())
    text += "<p><img src=\"" + Escape(document["plot"]) + "\" alt=\"error against time\"></p>\n";
  for (const Json& method : document["methods"]) {
    text += "<h2>" + Escape(method["method"]) + "</h2>\n";
    const Json& run = method["runs"][0];
    const std::string seed = "seed " + run["seed"].dump();
    text += "<figure><img src=\"" + Escape(run["picture"]) + "\" alt=\"picture\"><figcaption>" + seed + ", " +
            run["spp"].dump() + " spp</figcaption></figure>\n";
    if (const std::string map = run["map"]; !map.empty()) {
      text +=
          "<figure><img src=\"" + Escape(map) +
          "\" alt=\"error map\"><figcaption>relative luminance error, -1 (blue) to 1 (orange)</figcaption></figure>\n";
    }
    if (run.contains("choice")) text += "<p>Chose " + Escape(run["choice"]) + ".</p>\n";
  }
  return text + "</html>\n";
}

}  // namespace lodestar
