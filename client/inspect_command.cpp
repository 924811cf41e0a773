// lodestar inspect: what a scene holds, what it needs, and what was left out.
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/command.h"
#include "client/job_options.h"
#include "client/local_render.h"
#include "client/values.h"

namespace lodestar {
namespace {

struct InspectArguments {
  JobArguments job;
  bool json = false;
};

size_t CountAreaLights(const SceneDescription& description) {
  size_t count = 0;
  for (const ShapeDescription& shape : description.shapes) count += shape.light.has_value();
  return count;
}

ExitCode Inspect(const InspectArguments& arguments) {
  const JobSpec job = arguments.job.ToJob();
  const SceneDescription description = LoadScene(arguments.job.scene, arguments.job.lenient);
  const CompiledJob compiled = CompileScene(description, job);
  const Scene& scene = *compiled.scene;
  const Bounds3& bounds = scene.bounds();
  const auto corner = [](Vec3 v) { return nlohmann::json{v.x, v.y, v.z}; };

  if (arguments.json) {
    nlohmann::json json = {
        {"scene", arguments.job.scene},
        {"hash", scene.hash().hex},
        {"needs", scene.needs().ToString()},
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
  CLI::App* sub = app.add_subcommand("inspect", "Say what a scene holds and needs, and what is left out");
  AddJobOptions(*sub, arguments->job, {.method = false, .budget = false});
  sub->add_flag("--json", arguments->json, "One JSON document on standard out");
  sub->footer("Example:\n  lodestar inspect scenes/door-ajar.pbrt --json");
  sub->callback([arguments, &invocation] { invocation.run = [arguments] { return Inspect(*arguments); }; });
}

}  // namespace lodestar
