// lodestar inspect: what a scene holds, what it needs, and what was left out; with --guide what was learned in it.
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/command.h"
#include "client/guide_inspection.h"
#include "client/job_options.h"
#include "client/local_render.h"
#include "client/values.h"
#include "core/learning/report_json.h"

namespace lodestar {
namespace {

struct InspectArguments {
  JobArguments job;
  GuideArguments guide;
  bool json = false;
};

void AddGuideOptions(CLI::App* sub, GuideArguments& guide) {
  const char* group = "What was learned";
  CLI::Option* file =
      sub->add_option(
             "--guide", guide.guide,
             "A guiding state, as `lodestar render --state FILE` writes it: a table of what it holds instead of "
             "the scene's. The scene is optional; where it is given, it must be the one of the state")
          ->type_name("FILE")
          ->group(group);
  const auto add = [&](const char* name, std::string& value, const char* help, const char* type) {
    return sub->add_option(name, value, help)->type_name(type)->group(group)->needs(file);
  };
  CLI::Option* output =
      add("-o,--output", guide.output, "Pictures (.png) of the state in this folder [the table alone]", "DIR");
  CLI::Option* at = add("--at", guide.at, "Look at this point, in the scene's coordinates", "X,Y,Z");
  CLI::Option* pixel =
      add("--pixel", guide.pixel,
          "Look at what this pixel shows: its first surface that is no mirror or glass; needs the scene", "X,Y");
  pixel->excludes(at);
  CLI::Option* normal =
      add("--normal", guide.normal,
          "With --at: a surface with this normal there, for the product of tree and BSDF; with the scene, its first "
          "surface from there against the normal",
          "X,Y,Z")
          ->needs(at);
  add("--wo", guide.wo, "With --normal: the direction that it is seen from [the normal]", "X,Y,Z")->needs(normal);
  sub->add_option("--roughness", guide.roughness,
                  "With --normal and no scene: GGX alpha of its lobe; 1 is a diffuse one")
      ->check(Unnamed(CLI::Range(0.001, 1.0)))
      ->capture_default_str()
      ->group(group)
      ->needs(normal);
  add("--range", guide.range,
      "Ends of the colour scale of focal densities, in units of their mean [the densities' own, five powers of ten at "
      "most]",
      "LOW,HIGH")
      ->needs(output);
  // The state says how its scene was compiled.
  for (const char* name : {"--resolution", "--filter", "--max-depth", "--seed"}) file->excludes(sub->get_option(name));
}

size_t CountAreaLights(const SceneDescription& description) {
  size_t count = 0;
  for (const ShapeDescription& shape : description.shapes) count += shape.light.has_value();
  return count;
}

ExitCode Inspect(const InspectArguments& arguments) {
  if (!arguments.guide.guide.empty()) {
    GuideArguments guide = arguments.guide;
    guide.scene = arguments.job.scene;
    guide.lenient = arguments.job.lenient;
    guide.json = arguments.json;
    return InspectGuide(guide);
  }
  if (arguments.job.scene.empty())
    throw Error(ErrorKind::kInvalidInput, "give a scene, or a guiding state with --guide");
  const JobSpec job = arguments.job.ToJob();
  const SceneDescription description = LoadScene(arguments.job.scene, {.lenient = arguments.job.lenient});
  const CompiledJob compiled = CompileScene(description, job);
  const Scene& scene = *compiled.scene;
  const Bounds3& bounds = scene.bounds();
  const auto corner = [](Vec3 v) { return nlohmann::json{v.x, v.y, v.z}; };

  if (arguments.json) {
    nlohmann::json json = {
        {"scene", arguments.job.scene},
        {"hash", scene.hash().hex},
        {"needs", scene.needs().ToString()},
        {"not_needed", scene.needs().NotNeeded()},
        {"resolution", {scene.resolution_x(), scene.resolution_y()}},
        {"max_depth", scene.max_depth()},
        {"samples_per_pixel", description.samples_per_pixel},
        {"triangles", scene.triangle_count()},
        {"shapes", description.shapes.size()},
        {"objects", description.objects.size()},
        {"instances", description.instances.size()},
        {"materials", description.materials.size()},
        {"textures", description.textures.size()},
        {"lights", {{"area", CountAreaLights(description)}, {"other", description.lights.size()}}},
        {"bounds", bounds.empty() ? nlohmann::json(nullptr) : nlohmann::json{corner(bounds.min), corner(bounds.max)}},
        {"memory_bytes", scene.memory_bytes()},
        {"files", description.files},
        {"left_out", description.left_out}};
    std::cout << DumpJson(json) << "\n";
    return ExitCode::kOk;
  }
  const auto vec = [](Vec3 v) {
    return "(" + FormatNumber(v.x) + ", " + FormatNumber(v.y) + ", " + FormatNumber(v.z) + ")";
  };
  std::cout << "scene       " << arguments.job.scene << "\n"
            << "image       " << scene.resolution_x() << "x" << scene.resolution_y() << ", depth " << scene.max_depth()
            << ", " << description.samples_per_pixel << " spp\n"
            << "needs       " << scene.needs().ToString() << "\n"
            << "not needed  " << scene.needs().NotNeeded() << "\n"
            << "triangles   " << scene.triangle_count() << "\n"
            << "shapes      " << description.shapes.size() << ", " << description.objects.size() << " objects, "
            << description.instances.size() << " instances\n"
            << "materials   " << description.materials.size() << ", " << description.textures.size() << " textures\n"
            << "lights      " << CountAreaLights(description) << " area, " << description.lights.size() << " other\n"
            << "bounds      " << (bounds.empty() ? "empty" : vec(bounds.min) + " to " + vec(bounds.max)) << "\n"
            << "memory      " << FormatBytes(static_cast<double>(scene.memory_bytes())) << "\n"
            << "files       " << description.files.size() << "\n"
            << "left out    "
            << (description.left_out.empty() ? "nothing"
                                             : std::to_string(description.left_out.size()) + " (listed above)")
            << "\n"
            << "hash        " << scene.hash().hex << "\n";
  return ExitCode::kOk;
}

}  // namespace

void AddInspectCommand(CLI::App& app, Invocation& invocation) {
  auto arguments = std::make_shared<InspectArguments>();
  CLI::App* sub = app.add_subcommand("inspect", "Say what a scene holds and needs, or what was learned in it");
  AddJobOptions(*sub, arguments->job, {.method = false, .budget = false});
  sub->get_option("scene")->required(false);
  AddGuideOptions(sub, arguments->guide);
  sub->add_flag("--json", arguments->json, "One JSON document on standard out");
  sub->footer(
      "Examples:\n"
      "  lodestar inspect scenes/door-ajar.pbrt --json\n"
      "  lodestar render scenes/door-ajar.pbrt --spp 127 -o out/door.exr --state out/door.lguide\n"
      "  lodestar inspect --guide out/door.lguide\n"
      "  lodestar inspect scenes/door-ajar.pbrt --guide out/door.lguide --pixel 200,150 -o out/door-guide\n"
      "  lodestar inspect --guide out/door.lguide --at 0,1,0 --normal 0,1,0 --wo 1,1,0 --roughness 0.2 -o out/at");
  sub->callback([arguments, &invocation] { invocation.run = [arguments] { return Inspect(*arguments); }; });
}

}  // namespace lodestar
