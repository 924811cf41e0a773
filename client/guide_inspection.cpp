#include "client/guide_inspection.h"

#include <charconv>
#include <iostream>
#include <type_traits>
#include <utility>

#include "client/guide_pictures.h"
#include "client/guide_table.h"
#include "client/job_options.h"
#include "client/local_render.h"
#include "client/values.h"
#include "core/base/check.h"
#include "core/learning/report_json.h"
#include "core/tracing/visit_guide.h"

namespace lodestar {
namespace {

// "1,2,3" for N = 3.
template <size_t N>
std::array<float, N> ParseNumbers(const std::string& option, const std::string& text, const char* example) {
  std::array<float, N> values{};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (size_t i = 0; i < N; ++i) {
    const auto [next, error] = std::from_chars(at, end, values[i]);
    const bool separated = i + 1 == N ? next == end : next != end && *next == ',';
    if (error != std::errc() || !separated || !std::isfinite(values[i]))
      throw Error(ErrorKind::kInvalidInput, option + " '" + text + "' must be " + std::to_string(N) +
                                                " numbers with commas between them, as in " + example);
    at = next + 1;
  }
  return values;
}
Vec3 ParsePoint(const std::string& option, const std::string& text) {
  const auto v = ParseNumbers<3>(option, text, "0.5,1,-2");
  return {v[0], v[1], v[2]};
}
Vec3 ParseDirection(const std::string& option, const std::string& text) {
  const Vec3 w = ParsePoint(option, text);
  const float length = Length(w);
  if (!(length > 1e-18f) || !std::isfinite(length))
    throw Error(ErrorKind::kInvalidInput, option + " '" + text + "' has no direction");
  return w / length;
}

GuideFile ReadGuide(const std::string& path) {
  try {
    return GuideFile::Read(path);
  } catch (const Error& error) {
    const bool damaged = error.kind() == ErrorKind::kCorrupt;
    throw CommandError(ExitCode::kIo, std::string(error.what()) +
                                          (damaged ? "; `lodestar render SCENE --state FILE` writes one" : ""));
  }
}

// The scene as the file's job had it: its hash covers resolution and filter, too.
std::shared_ptr<const Scene> CompileSceneOf(const GuideFile& file, const GuideArguments& arguments) {
  const SceneDescription description = LoadScene(arguments.scene, {.lenient = arguments.lenient || file.job.lenient});
  const CompiledJob compiled = CompileScene(description, file.job);
  try {
    file.CheckScene(compiled.survey.scene_hash, arguments.scene, arguments.guide);
  } catch (const Error& error) {
    throw CommandError(ExitCode::kIo, error.what());
  }
  return compiled.scene;
}

GuidePoint PointOn(SurfaceHit hit) {
  return {hit.si.p, MakeProductLobes(hit.si, hit.bsdf, hit.wo), hit};
}

GuidePoint PointOfPixel(const Scene& scene, const GuideFile& file, const std::string& text) {
  const Resolution pixel = ParsePixel(text);
  const auto width = static_cast<uint32_t>(scene.resolution_x()), height = static_cast<uint32_t>(scene.resolution_y());
  if (pixel.x >= width || pixel.y >= height) {
    throw Error(ErrorKind::kInvalidInput, "--pixel " + text + " lies outside the image of " + std::to_string(width) +
                                              "x" + std::to_string(height));
  }
  const CameraRay ray =
      scene.camera().Generate({static_cast<float>(pixel.x) + 0.5f, static_cast<float>(pixel.y) + 0.5f}, {0.5f, 0.5f});
  Sampler sampler(file.job.seed, pixel.x, pixel.y, 0);
  auto hit = FirstSmoothSurface(scene, ray, sampler);
  if (!hit)
    throw Error(ErrorKind::kInvalidInput,
                "--pixel " + text + ": no surface but mirrors or glass is seen there; try another");
  return PointOn(std::move(*hit));
}

// The first surface against the normal from the point on, which may lie on it: from a thousandth of the scene above.
GuidePoint PointUnder(const Scene& scene, const GuideArguments& arguments, Vec3 p, Vec3 normal, Vec3 wo) {
  if (arguments.roughness < 1)
    throw Error(ErrorKind::kInvalidInput, "--roughness is for a surface without a scene; this one has its own");
  const float above = 1e-3f * Length(scene.bounds().Diagonal());
  Sampler sampler(0, 0, 0, 0);
  auto hit = FirstSurface(scene, {p + normal * above, -normal}, sampler);
  if (!hit)
    throw Error(ErrorKind::kInvalidInput, "--at " + arguments.at + ": no surface lies there against --normal " +
                                              arguments.normal + "; try another, or --pixel");
  hit->wo = hit->si.shading.ToLocal(wo);
  return PointOn(std::move(*hit));
}

GuidePoint PointOfCoordinates(const GuideArguments& arguments, const Scene* scene) {
  GuidePoint point;
  point.p = ParsePoint("--at", arguments.at);
  if (arguments.normal.empty()) return point;
  const Vec3 normal = ParseDirection("--normal", arguments.normal);
  const Vec3 wo = arguments.wo.empty() ? normal : ParseDirection("--wo", arguments.wo);
  if (scene != nullptr) return PointUnder(*scene, arguments, point.p, normal, wo);
  ProductLobe lobe;
  lobe.kind = arguments.roughness < 1 ? ProductLobe::Kind::kGgxReflection : ProductLobe::Kind::kDiffuseReflection;
  lobe.alpha = arguments.roughness;
  lobe.weight = 1;
  point.lobes.emplace(Frame::FromNormal(normal), wo, std::span(&lobe, 1));
  return point;
}

std::optional<GuidePoint> PointOf(const GuideArguments& arguments, const GuideFile& file, const Scene* scene) {
  if (!arguments.pixel.empty()) {
    if (scene == nullptr)
      throw Error(ErrorKind::kInvalidInput, "--pixel needs the scene: lodestar inspect SCENE --guide FILE");
    return PointOfPixel(*scene, file, arguments.pixel);
  }
  if (!arguments.at.empty()) return PointOfCoordinates(arguments, scene);
  return std::nullopt;
}

// What the guide does at a point, in figures.
nlohmann::json DescribePoint(const GuidePoint& point, const SdTree* tree, const FocalField* field) {
  const auto vec = [](Vec3 v) { return nlohmann::json{v.x, v.y, v.z}; };
  nlohmann::json json = {{"p", vec(point.p)}};
  if (point.surface) json["normal"] = vec(point.surface->si.shading.n);
  if (tree != nullptr) {
    const uint32_t index = tree->LeafAt(point.p);
    const SdTreeLeaf& leaf = tree->leaf(index);
    json["leaf"] = {{"index", index},
                    {"nodes", leaf.node_count},
                    {"depth", leaf.depth},
                    {"learned", leaf.learned != 0},
                    {"records", leaf.records},
                    {"mean_flux", leaf.mean_flux},
                    {"bsdf_fraction", leaf.bsdf_fraction},
                    {"nee_probability", leaf.nee_probability}};
  }
  if (field != nullptr && tree == nullptr) json["bsdf_fraction"] = field->BsdfFraction(point.p);
  if (field != nullptr && tree != nullptr)
    json["focal_share"] = field->HasLearned() ? 1 - field->BsdfFraction(point.p) : 0;
  return json;
}

std::optional<TechniqueSample> SampleBsdf(const SurfaceHit& hit, float u_choice, Vec2 u) {
  const auto sample = hit.bsdf.Sample(hit.wo, u_choice, u);
  if (!sample) return std::nullopt;
  return TechniqueSample{hit.si.shading.ToWorld(sample->wi), sample->weight};
}

// The guide alone where it guides, and the BSDF elsewhere.
template <class Guide>
Technique TechniqueOf(Guide guide) {
  return [guide = std::move(guide)](const SurfaceHit& hit, float u_choice, Vec2 u) -> std::optional<TechniqueSample> {
    if (!hit.bsdf.HasSmoothLobes()) return SampleBsdf(hit, u_choice, u);
    const auto local = guide.At(hit.si, hit.bsdf, hit.wo);
    if (!(local.bsdf_fraction < 1)) return SampleBsdf(hit, u_choice, u);
    const GuidedSample sample = guide.Sample(local, u, u_choice);
    if (!(sample.pdf > 0)) return std::nullopt;
    const Rgb f_cos = hit.bsdf.Evaluate(hit.wo, hit.si.shading.ToLocal(sample.w)).f_cos;
    return TechniqueSample{sample.w, f_cos * (1 / sample.pdf)};
  };
}

// How the two techniques sample at a surface: the BSDF's density, and paths of each.
void DrawTechniques(const Method& method, const std::shared_ptr<const State>& state, const GuideView& view,
                    PictureFolder* out) {
  const SurfaceHit& hit = *view.point->surface;
  out->DrawDensity("bsdf", "BSDF sampling at this surface",
                   [&](Vec3 w) { return hit.bsdf.Evaluate(hit.wo, hit.si.shading.ToLocal(w)).pdf; });
  VisitGuide(*view.scene, method, state, [&]<class Guide>(Guide guide, const PathSettings&) {
    if constexpr (Guide::kGuides) {
      // The other guides' densities are among their own pictures.
      if constexpr (std::is_same_v<Guide, GridGuide>) {
        const auto local = guide.At(hit.si, hit.bsdf, hit.wo);
        if (local.bsdf_fraction < 1)
          out->DrawDensity("guide", "guided directions at this surface", [&](Vec3 w) { return guide.Pdf(local, w); });
      }
      DrawRays("rays-bsdf", "paths by the BSDF", view, SampleBsdf, out);
      DrawRays("rays-guide", "paths by the guide", view, TechniqueOf(std::move(guide)), out);
    }
  });
}

// The point on one line.
std::string PointText(const nlohmann::json& point) {
  std::string text;
  for (const auto& coordinate : point["p"]) text += (text.empty() ? "" : ", ") + FormatNumber(coordinate.get<double>());
  if (!point.contains("leaf") && !point.contains("bsdf_fraction")) return text;
  if (!point.contains("leaf")) return text + ": BSDF fraction " + FormatNumber(point["bsdf_fraction"].get<double>());
  const auto& leaf = point["leaf"];
  const auto number = [&](const char* key) { return FormatNumber(leaf[key].get<double>()); };
  return text + ": leaf " + leaf["index"].dump() + (leaf["learned"].get<bool>() ? "" : " (nothing learned)") + ", " +
         FormatCount(leaf["records"].get<double>()) + " records, D-tree of " + leaf["nodes"].dump() +
         " nodes and depth " + leaf["depth"].dump() + ", mean flux " + number("mean_flux") + ", BSDF fraction " +
         number("bsdf_fraction") + ", light samples " + number("nee_probability") +
         (point.contains("focal_share") ? ", focal share " + FormatNumber(point["focal_share"].get<double>()) : "");
}

void Print(const nlohmann::json& json, const std::string& table) {
  std::cout << "state                 " << json["file"].get<std::string>() << ", "
            << FormatBytes(json["file_bytes"].get<double>()) << "\n"
            << "method                " << json["method"].get<std::string>() << ", " << json["training_iterations"]
            << " training iterations\n"
            << "scene                 " << json["scene_hash"].get<std::string>().substr(0, 16) << "..."
            << (json["scene_checked"].get<bool>() ? ", as given" : ", not checked: no scene was given") << "\n"
            << table;
  if (!json["choice"].is_null()) std::cout << "chose                 " << json["choice"].get<std::string>() << "\n";
  if (json.contains("point")) std::cout << "point                 " << PointText(json["point"]) << "\n";
  if (!json["note"].is_null()) std::cout << "note                  " << json["note"].get<std::string>() << "\n";
  for (const auto& picture : json["pictures"])
    std::cout << "picture               " << picture["file"].get<std::string>() << "\n";
}

}  // namespace

ExitCode InspectGuide(const GuideArguments& arguments) {
  // 1. The file, and the scene where one is given.
  GuideFile file = ReadGuide(arguments.guide);
  GuideView view;
  view.bounds = file.survey.bounds;
  if (!arguments.scene.empty()) view.scene = CompileSceneOf(file, arguments);
  const std::unique_ptr<Method> job_method = MakeMethod(file.job, file.survey);
  const std::shared_ptr<const State> job_state = job_method->ParseState(file.state);
  const Method::Active active = job_method->ActiveUnder(job_state);
  const Method* method = active.method;
  const std::shared_ptr<const State>& state = active.state;
  const std::string choice = job_method->Explain(*job_state);
  view.label = file.job.method;
  if (method != job_method.get()) view.label += " (" + std::string(method->name()) + ")";
  const auto* sd_tree = dynamic_cast<const SdTreeState*>(state.get());
  const auto* focal = dynamic_cast<const FocalState*>(state.get());
  const auto* grid = dynamic_cast<const GridState*>(state.get());
  const auto* mixed = dynamic_cast<const MixedState*>(state.get());
  if (mixed != nullptr) {
    sd_tree = mixed->tree().get();
    focal = mixed->focal().get();
    file.training.reset();  // of both: no record is the tree's alone
  }
  // Of a race that path tracing won there is the choice to tell, and nothing to draw.
  const bool learned = sd_tree != nullptr || focal != nullptr || grid != nullptr;
  const bool looks = !arguments.output.empty() || !arguments.at.empty() || !arguments.pixel.empty();
  if (!learned && (choice.empty() || looks))
    throw Error(ErrorKind::kUnsupported,
                arguments.guide + " holds nothing to show: method '" + view.label +
                    "' learns nothing; render with --method sdtree to see what it would learn" +
                    (choice.empty() ? "" : ". Chose " + choice));

  // 2. What to look at.
  view.point = PointOf(arguments, file, view.scene.get());
  if (!arguments.range.empty()) {
    const auto range = ParseNumbers<2>("--range", arguments.range, "1,8");
    if (!(range[0] > 0) || !(range[1] > range[0]))
      throw Error(ErrorKind::kInvalidInput, "--range " + arguments.range + ": LOW must be above zero and below HIGH");
    if (focal == nullptr)
      throw Error(ErrorKind::kInvalidInput,
                  "--range is for focal densities, and method '" + view.label + "' has none; leave it out");
    view.density_scale = LogScale{range[0], range[1]};
  }
  nlohmann::json json = {{"file", arguments.guide},
                         {"file_bytes", std::filesystem::file_size(arguments.guide)},
                         {"state_bytes", file.state.size()},
                         {"method", view.label},
                         {"options", file.job.options},
                         {"seed", file.job.seed},
                         {"training_iterations", file.iterations},
                         {"scene_hash", file.survey.scene_hash},
                         {"scene_checked", view.scene != nullptr},
                         {"choice", choice.empty() ? nlohmann::json() : nlohmann::json(choice)},
                         {"note", nullptr},
                         {"pictures", nlohmann::json::array()}};
  std::string table;
  const auto describe = [&](const char* part, const nlohmann::json& figures, const std::string& text) {
    (mixed ? json["state"][part] : json["state"]) = figures;
    table += text;
  };
  if (sd_tree) {
    const auto figures = DescribeSdTree(sd_tree->tree());
    describe("tree", figures, SdTreeTable(figures));
  }
  if (focal) {
    const auto figures = DescribeFocal(focal->field());
    describe("field", figures, FocalTable(figures));
  }
  if (grid) {
    const auto figures = DescribeGrid(*grid->grid());
    describe("grid", figures, GridTable(figures));
  }
  if (view.point) {
    json["point"] = DescribePoint(*view.point, sd_tree ? &sd_tree->tree() : nullptr, focal ? &focal->field() : nullptr);
  }

  // 3. The pictures.
  if (!arguments.output.empty()) {
    PictureFolder pictures(arguments.output);
    if (sd_tree) {
      DrawSdTree(*sd_tree, file, view, &pictures);
      if (view.point && RemakeTrees(file, view.point->p).empty())
        json["note"] = "the file has too few records of this place to show its D-tree before reconstruction";
    }
    if (focal) DrawFocal(focal->field(), view, &pictures);
    if (grid) DrawGrid(*grid->grid(), view, &pictures);
    if (view.point && view.point->surface) DrawTechniques(*method, state, view, &pictures);
    json["pictures"] = pictures.pictures();
  }
  if (arguments.json) {
    std::cout << DumpJson(json) << "\n";
  } else {
    Print(json, table);
  }
  return ExitCode::kOk;
}

}  // namespace lodestar
