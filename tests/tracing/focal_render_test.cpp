// What focal guiding finds in whole renders: a pinhole, and what a mirror shows behind itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

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

TEST(FocalRenderTest, ThePinholeIsTheDensestPlace) {
  constexpr float kRadius = 0.01f;  // as scenes/generate/camera_obscura.py has it
  const Vec3 hole{0, 0.9f, 0};
  JobSpec job;
  job.method = "focal";
  job.options = {{"initial-iterations", "5"}, {"narrowing-iterations", "10"}, {"passes", "64"}};
  job.budget.spp = 1088;
  job.training_iterations = 15;  // all of them, though little is left for the picture
  job.resolution_x = 32;
  job.resolution_y = 24;
  job.seed = 1;
  const std::filesystem::path scenes = std::filesystem::path(LODESTAR_SOURCE_DIR) / "scenes";
  const std::vector<Voxel> voxels = Learned(CompileJob(ParsePbrtFile(scenes / "camera-obscura.pbrt"), job), job);
  EXPECT_LT(DistanceFrom(hole, Densest(voxels).bounds), 2 * kRadius);
  double around = 0;
  for (const Voxel& voxel : voxels)
    if (DistanceFrom(hole, voxel.bounds) < 5 * kRadius) around += voxel.mass;
  EXPECT_GT(around, 0.5);
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
  JobSpec job;
  job.method = "focal";
  job.options["passes"] = "4";
  job.budget.spp = 64;
  job.training_iterations = 12;
  job.seed = 1;
  const CompiledJob compiled = CompileJob(ParsePbrtText(kMirror, "mirror.pbrt", "."), job);
  for (const char* images : {"on", "off"}) {
    job.options["images"] = images;
    std::vector<Voxel> behind = Learned(compiled, job);
    constexpr float kRounding = 1e-4f;
    std::erase_if(behind, [](const Voxel& voxel) { return voxel.bounds.min.x < -kRounding; });
    ASSERT_FALSE(behind.empty());
    double mass = 0;
    for (const Voxel& voxel : behind) mass += voxel.mass;
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
