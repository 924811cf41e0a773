// What focal guiding finds in whole renders: a pinhole, a small light, the place that lights all others, the focus of a
// lens, and what a mirror shows behind itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include "core/learning/focal_guiding.h"
#include "tests/support/render.h"

namespace lodestar {
namespace {

// A leaf voxel of what was learned, in the scene's space.
struct Voxel {
  Bounds3 bounds;
  float density;  // relative to the mean
  double mass;    // as a share
};

std::vector<Voxel> Learned(const CompiledJob& compiled, const JobSpec& job) {
  const auto field = FocalField::Parse(test::Render(compiled, job).state);
  EXPECT_TRUE(field->HasLearned());
  EXPECT_EQ(field->iteration(), field->options().iterations());
  const FocalOctree& octree = field->octrees()[0];
  std::vector<Voxel> voxels;
  for (uint32_t index = 0; index < octree.node_count(); ++index) {
    const FocalOctree::Node& node = octree.node(index);
    for (int octant = 0; octant < 8; ++octant) {
      if ((node.inner >> octant) & 1) continue;
      const Vec3 lower{node.corner[0] + static_cast<float>(octant & 1) * node.half,
                       node.corner[1] + static_cast<float>(octant >> 1 & 1) * node.half,
                       node.corner[2] + static_cast<float>(octant >> 2) * node.half};
      voxels.push_back({{field->corner() + lower * field->sides(),
                         field->corner() + (lower + Vec3{node.half, node.half, node.half}) * field->sides()},
                        field->RelativeDensity(node.density[octant]),
                        octree.mass(index * 8 + static_cast<uint32_t>(octant)) / octree.mass()});
    }
  }
  return voxels;
}

const Voxel& Densest(const std::vector<Voxel>& voxels) {
  return *std::ranges::max_element(voxels, {}, &Voxel::density);
}

double DistanceFrom(Vec3 p, const Bounds3& bounds) {
  return Length(p - (bounds.min + bounds.max) * 0.5f);
}

// The share of the mass in voxels whose middles fulfil a condition.
template <class Condition>
double MassWhere(const std::vector<Voxel>& voxels, Condition&& condition) {
  double mass = 0;
  for (const Voxel& voxel : voxels)
    if (condition((voxel.bounds.min + voxel.bounds.max) * 0.5f)) mass += voxel.mass;
  return mass;
}

CompiledJob CompileFile(const char* name, const JobSpec& job) {
  return CompileJob(ParsePbrtFile(std::filesystem::path(LODESTAR_SOURCE_DIR) / "scenes" / name), job);
}

// In pictures of so many pixels; 0: the scene's.
JobSpec FocalJob(std::map<std::string, std::string> options, uint64_t spp, int training_iterations, uint32_t width = 0,
                 uint32_t height = 0) {
  JobSpec job;
  job.method = "focal";
  job.options = std::move(options);
  job.budget.spp = spp;
  job.training_iterations = training_iterations;
  job.resolution_x = width;
  job.resolution_y = height;
  job.seed = 1;
  return job;
}

TEST(FocalRenderTest, ThePinholeIsTheDensestPlace) {
  constexpr float kRadius = 0.01f;  // as scenes/generate/camera_obscura.py has it
  const Vec3 hole{0, 0.9f, 0};
  // All iterations, though little is left for the picture.
  const JobSpec job =
      FocalJob({{"initial-iterations", "5"}, {"narrowing-iterations", "10"}, {"passes", "64"}}, 1088, 15, 32, 24);
  const std::vector<Voxel> voxels = Learned(CompileFile("camera-obscura.pbrt", job), job);
  EXPECT_LT(DistanceFrom(hole, Densest(voxels).bounds), 2 * kRadius);
  EXPECT_GT(MassWhere(voxels, [&](Vec3 p) { return Length(p - hole) < 5 * kRadius; }), 0.5);
}

// Without next event estimation, which would leave little of its light to be found.
TEST(FocalRenderTest, ASmallLightIsTheDensestPlace) {
  const Vec3 panel{0, 1.96f, 0};  // 0.15 x 0.15, as scenes/generate/emissive_panel.py has it
  const JobSpec job = FocalJob({{"nee", "never"}, {"passes", "32"}}, 416, 12, 24, 24);
  const std::vector<Voxel> voxels = Learned(CompileFile("emissive-panel.pbrt", job), job);
  EXPECT_LT(DistanceFrom(panel, Densest(voxels).bounds), 0.15);
  EXPECT_GT(MassWhere(voxels, [&](Vec3 p) { return Length(p - panel) < 0.2f; }), 0.25);
}

// The flashlight's spot on the ceiling, of a radius of about a metre, is no light, but lights all else.
TEST(FocalRenderTest, AnIndirectSpotIsFound) {
  const Vec3 spot{-0.35f, 2.1f, -0.1f};  // above the flashlight, as scenes/generate/flashlight.py has it
  const JobSpec job = FocalJob({{"passes", "16"}}, 208, 12, 32, 24);
  const std::vector<Voxel> voxels = Learned(CompileFile("flashlight.pbrt", job), job);
  // A hundredth of the room, around the spot's middle.
  const double found = MassWhere(voxels, [&](Vec3 p) {
    return std::fabs(p.x - spot.x) < 0.6f && std::fabs(p.z - spot.z) < 0.6f && p.y > spot.y - 0.2f;
  });
  EXPECT_GT(found, 0.05);
  // As much of the ceiling's other end, which the flashlight does not reach.
  const double elsewhere = MassWhere(voxels, [&](Vec3 p) {
    return std::fabs(p.x - spot.x) < 0.6f && std::fabs(p.z - 2.5f) < 0.6f && p.y > spot.y - 0.2f;
  });
  EXPECT_GT(found, 4 * elsewhere);
}

// A lamp above a ball of glass in the hole of a black plate, through which alone its light reaches the floor.
constexpr const char* kBallLens = R"(Integrator "path" "integer maxdepth" [6]
PixelFilter "box"
Film "rgb" "integer xresolution" [24] "integer yresolution" [24]
LookAt 0.5 0.6 0.6  0 0 0  0 1 0
Camera "perspective" "float fov" [60]
WorldBegin
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "point3 P" [-1 0 -1  1 0 -1  1 0 1  -1 0 1] "integer indices" [0 1 2 0 2 3]
Material "diffuse" "rgb reflectance" [0 0 0]
Shape "trianglemesh" "point3 P" [-1 1 -1  -0.14 1 -1  -0.14 1 1  -1 1 1] "integer indices" [0 1 2 0 2 3]
Shape "trianglemesh" "point3 P" [0.14 1 -1  1 1 -1  1 1 1  0.14 1 1] "integer indices" [0 1 2 0 2 3]
Shape "trianglemesh" "point3 P" [-0.14 1 -1  0.14 1 -1  0.14 1 -0.14  -0.14 1 -0.14] "integer indices" [0 1 2 0 2 3]
Shape "trianglemesh" "point3 P" [-0.14 1 0.14  0.14 1 0.14  0.14 1 1  -0.14 1 1] "integer indices" [0 1 2 0 2 3]
AttributeBegin
Material "dielectric" "float eta" [1.5] "float roughness" [0]
Translate 0 1 0
Shape "sphere" "float radius" [0.2]
AttributeEnd
AreaLightSource "diffuse" "rgb L" [20 20 20]
Translate 0 2.5 0
Shape "sphere" "float radius" [0.1]
)";

// The ball's focal length is 0.3 from its middle: the lamp's image lies 0.375 below it, at the rim of the hole 0.3.
TEST(FocalRenderTest, TheFocusOfALensIsTheDensestPlace) {
  const Vec3 focus{0, 0.66f, 0};
  const JobSpec job = FocalJob({{"narrowing-iterations", "8"}, {"passes", "64"}}, 960, 14);
  const std::vector<Voxel> voxels = Learned(CompileJob(ParsePbrtText(kBallLens, "lens.pbrt", "."), job), job);
  EXPECT_LT(DistanceFrom(focus, Densest(voxels).bounds), 0.1);
  EXPECT_GT(MassWhere(voxels, [&](Vec3 p) { return Length(p - focus) < 0.2f; }), 0.3);
}

// A lamp at x = -0.5 before a mirror that divides the scene at x = 0. Behind it are its image and a dark wall.
constexpr const char* kMirror = R"(Integrator "path" "integer maxdepth" [6]
PixelFilter "box"
Film "rgb" "integer xresolution" [32] "integer yresolution" [32]
LookAt -0.6 0 0.8  -0.6 0 -1  0 1 0
Camera "perspective" "float fov" [70]
WorldBegin
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "point3 P" [-1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1] "integer indices" [0 1 2 0 2 3]
Shape "trianglemesh" "point3 P" [-1 -1 -1  -1 -1 1  -1 1 1  -1 1 -1] "integer indices" [0 1 2 0 2 3]
Shape "trianglemesh" "point3 P" [1 -1 -1  1 -1 1  1 1 1  1 1 -1] "integer indices" [0 1 2 0 2 3]
Material "conductor" "float roughness" [0]
Shape "trianglemesh" "point3 P" [0 -1 -1  0 -1 1  0 1 1  0 1 -1] "integer indices" [0 1 2 0 2 3]
AreaLightSource "diffuse" "rgb L" [20 20 20]
Translate -0.5 0.1 0.1
Shape "sphere" "float radius" [0.1]
)";

TEST(FocalRenderTest, ImagesLieBehindMirrors) {
  const Vec3 image{0.5f, 0.1f, 0.1f};
  JobSpec job = FocalJob({{"passes", "4"}}, 64, 12);
  const CompiledJob compiled = CompileJob(ParsePbrtText(kMirror, "mirror.pbrt", "."), job);
  for (const char* images : {"on", "off"}) {
    job.options["images"] = images;
    std::vector<Voxel> behind = Learned(compiled, job);
    constexpr float kRounding = 1e-4f;
    std::erase_if(behind, [](const Voxel& voxel) { return voxel.bounds.min.x < -kRounding; });
    ASSERT_FALSE(behind.empty());
    const double mass = MassWhere(behind, [](Vec3) { return true; });
    if (images == std::string("on")) {
      EXPECT_GT(mass, 0.5);
      EXPECT_LT(DistanceFrom(image, Densest(behind).bounds), 0.2);
    } else {
      EXPECT_LT(mass, 1e-6);  // what rounding lets through the mirror
    }
  }
}

}  // namespace
}  // namespace lodestar
