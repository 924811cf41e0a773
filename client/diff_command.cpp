// lodestar diff: the error of an image against a reference, and where it is.
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/command.h"
#include "client/outputs.h"
#include "client/values.h"
#include "core/film/error_metrics.h"
#include "core/learning/report_json.h"

namespace lodestar {
namespace {

struct DiffArguments {
  std::string image, reference, output;
  float limit = 1;
  bool json = false;
};

ExitCode Diff(const DiffArguments& arguments) {
  const Image image = ReadImageFile(arguments.image), reference = ReadImageFile(arguments.reference);
  if (image.width != reference.width || image.height != reference.height) {
    const auto size = [](const Image& of) { return std::to_string(of.width) + "x" + std::to_string(of.height); };
    throw Error(ErrorKind::kInvalidInput, arguments.image + " has " + size(image) + " pixels and " +
                                              arguments.reference + " has " + size(reference) +
                                              "; render both at one --resolution");
  }
  const ErrorMetrics metrics = Compare(image, reference);
  if (!arguments.output.empty()) {
    PrepareFolder(arguments.output);
    WritePng(arguments.output, image.width, image.height,
             FalseColour(RelativeLuminanceError(image, reference), arguments.limit));
  }
  if (arguments.json) {
    nlohmann::json json = MetricsToJson(metrics);
    json["image"] = arguments.image;
    json["reference"] = arguments.reference;
    if (!arguments.output.empty()) json["map"] = arguments.output;
    std::cout << DumpJson(json) << "\n";
  } else {
    std::cout << "RMSE             " << FormatNumber(metrics.rmse) << "\nMSE              " << FormatNumber(metrics.mse)
              << "\nMAE              " << FormatNumber(metrics.mae) << "\nrelMSE           "
              << FormatNumber(metrics.relmse) << "\nrelMSE, trimmed  " << FormatNumber(metrics.relmse_trimmed)
              << "   (worst 0.1 % of pixels left out)\n";
    if (!arguments.output.empty()) std::cout << "error map        " << arguments.output << "\n";
  }
  return ExitCode::kOk;
}

}  // namespace

void AddDiffCommand(CLI::App& app, Invocation& invocation) {
  auto arguments = std::make_shared<DiffArguments>();
  CLI::App* sub = app.add_subcommand("diff", "Measure the error of an image against a reference");
  sub->add_option("image", arguments->image, "Image: .exr, .pfm, or an 8-bit file, taken for sRGB")
      ->required()
      ->type_name("IMAGE");
  sub->add_option("reference", arguments->reference, "What it should be, of the same size")
      ->required()
      ->type_name("REFERENCE");
  sub->add_option("-o,--output", arguments->output,
                  "Write the relative luminance error in false colours: blue too dark, orange too bright")
      ->type_name("FILE.png")
      ->check([](const std::string& name) { return name.ends_with(".png") ? "" : "the error map must end in .png"; });
  sub->add_option("--limit", arguments->limit, "Relative error at the ends of the colour scale")
      ->capture_default_str()
      ->check(AboveZero());
  sub->add_flag("--json", arguments->json, "One JSON document on standard out");
  sub->footer("Example:\n  lodestar diff out/door.exr out/reference.exr -o out/door-map.png");
  sub->callback([arguments, &invocation] { invocation.run = [arguments] { return Diff(*arguments); }; });
}

}  // namespace lodestar
