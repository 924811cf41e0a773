#include "tests/scene/pbrt_testing.h"

namespace lodestar {
namespace {

template <class Kind>
Kind Made(const std::string& text) {
  return Get<Kind>(ParseWorld("Shape " + text).shapes.back().kind);
}

TEST(PbrtShapes, TriangleMesh) {
  const auto mesh = Made<TriangleMesh>(
      "\"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0] \"integer indices\" [0 1 2 0 2 3] \"normal N\" [0 0 1 0 "
      "0 1 0 0 1 0 0 1] \"point2 uv\" [0 0 1 0 1 1 0 1] \"integer faceIndices\" [0 1]");
  ASSERT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.positions[2], (Vec3{1, 1, 0}));
  EXPECT_EQ(mesh.triangles, (std::vector<std::array<uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(mesh.normals.at(3), (Vec3{0, 0, 1}));
  EXPECT_EQ(mesh.uvs.at(2), (Vec2{1, 1}));
  const auto single = Made<TriangleMesh>("\"trianglemesh\" \"point P\" [0 0 0 1 0 0 1 1 0]");
  EXPECT_EQ(single.triangles.size(), 1u);
  EXPECT_EQ(Made<TriangleMesh>("\"trianglemesh\" \"point P\" [0 0 0 1 0 0 1 1 0] \"normal3 N\" [0 0 1 0 1 0 1 0 0]")
                .normals.at(1),
            (Vec3{0, 1, 0}));
  EXPECT_TRUE(single.normals.empty());
  EXPECT_TRUE(single.uvs.empty());
}

TEST(PbrtShapes, PlyMesh) {
  const auto scene = ParseWorld(
      "Shape \"plymesh\" \"string filename\" \"mesh.ply\" \"float edgelength\" 1 \"float displacement.edgelength\" 1");
  EXPECT_EQ(Get<PlyMesh>(scene.shapes.at(0).kind).path, (Folder() / "mesh.ply").string());
  EXPECT_EQ(scene.files, std::vector<std::string>{(Folder() / "mesh.ply").string()});
}

TEST(PbrtShapes, SphereAndDisk) {
  EXPECT_EQ(Made<SphereShape>("\"sphere\"").radius, 1);
  EXPECT_EQ(
      Made<SphereShape>("\"sphere\" \"float radius\" 2 \"float zmin\" -2 \"float zmax\" 2 \"float phimax\" 360").radius,
      2);
  const auto plain = Made<DiskShape>("\"disk\"");
  EXPECT_EQ(plain.radius, 1);
  EXPECT_EQ(plain.inner_radius, 0);
  EXPECT_EQ(plain.height, 0);
  const auto disk =
      Made<DiskShape>("\"disk\" \"float radius\" 3 \"float innerradius\" 2 \"float height\" -1 \"float phimax\" 360");
  EXPECT_EQ(disk.radius, 3);
  EXPECT_EQ(disk.inner_radius, 2);
  EXPECT_EQ(disk.height, -1);
}

TEST(PbrtShapes, BilinearMesh) {
  const auto mesh = Made<BilinearMesh>(
      "\"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0 2 0 0 2 1 0] \"integer indices\" [0 1 2 3 1 4 3 5] "
      "\"point2 uv\" [0 0 1 0 0 1 1 1 2 0 2 1]"
      " \"normal N\" [0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1] \"integer faceIndices\" [0 1]");
  EXPECT_EQ(mesh.patches, (std::vector<std::array<uint32_t, 4>>{{0, 1, 2, 3}, {1, 4, 3, 5}}));
  EXPECT_EQ(mesh.uvs.size(), 6u);
  EXPECT_EQ(mesh.normals.size(), 6u);
  EXPECT_EQ(Made<BilinearMesh>("\"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]").patches.size(), 1u);
}

TEST(PbrtShapes, AlphaIsAConstantOrATexture) {
  EXPECT_EQ(ParseWorld("Shape \"sphere\"").shapes[0].alpha.value, 1);
  EXPECT_EQ(ParseWorld("Shape \"sphere\" \"float alpha\" .5").shapes[0].alpha.value, 0.5f);
  EXPECT_EQ(
      ParseWorld("Texture \"t\" \"float\" \"constant\" Shape \"disk\" \"texture alpha\" \"t\"").shapes[0].alpha.texture,
      0);
}

TEST(PbrtShapes, InstancesKeepTheirTransforms) {
  const auto scene = ParseWorld(
      "Translate 1 0 0 ObjectBegin \"o\" Translate 0 1 0 Material \"dielectric\" Shape \"sphere\" Shape \"disk\" "
      "ObjectEnd Shape \"sphere\""
      " Translate 0 0 1 ObjectInstance \"o\" ObjectInstance \"o\"");
  ASSERT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(scene.objects[0].name, "o");
  ASSERT_EQ(scene.objects[0].shapes.size(), 2u);
  EXPECT_EQ(scene.objects[0].shapes[0].world_from_object.Point({0, 0, 0}), (Vec3{1, 1, 0}));
  ASSERT_EQ(scene.shapes.size(), 1u);
  EXPECT_EQ(scene.shapes[0].world_from_object.Point({0, 0, 0}), (Vec3{1, 0, 0}));  // ObjectEnd restores the state
  EXPECT_NE(scene.shapes[0].material, scene.objects[0].shapes[0].material);
  ASSERT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(scene.instances[1].object, 0);
  EXPECT_EQ(scene.instances[1].world_from_instance.Point({0, 0, 0}), (Vec3{1, 0, 1}));
}

TEST(PbrtShapes, LenientLeavesOutTheShape) {
  const auto scene =
      ParseWorld("Shape \"curve\" \"point3 P\" [0 0 0] \"float width\" 1 Shape \"sphere\" \"float phimax\" 90", true);
  ASSERT_EQ(scene.shapes.size(), 1u);
  EXPECT_EQ(scene.left_out.size(), 2u);
}

TEST(PbrtShapes, RefusesByNameAndPlace) {
  const Refused cases[] = {
      {"Shape \"cube\"", kBad, "2:1", "supported here: trianglemesh"},
      {"Shape \"curve\"", kNo, "2:1", "use trianglemesh"},
      {"Shape \"cylinder\" \"float radius\" 1", kNo, "2:1", "use trianglemesh"},
      {"Shape \"loopsubdiv\"", kNo, "2:1", "use trianglemesh"},
      {"Shape \"cone\"", kNo, "2:1", "use trianglemesh"},
      {"Shape \"heightfield\" \"integer nu\" 2", kNo, "2:1", "\"heightfield\" is not supported; use trianglemesh"},
      {"Shape \"hyperboloid\"", kNo, "2:1", "\"hyperboloid\" is not supported; use trianglemesh"},
      {"Shape \"nurbs\"", kNo, "2:1", "\"nurbs\" is not supported; use trianglemesh"},
      {"Shape \"paraboloid\" \"float zmax\" 1", kNo, "2:1", "\"paraboloid\" is not supported; use trianglemesh"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] \"vector2 uv\" [0 0 0 0 0 0]", kBad, "2:53",
       "expected \"point2 uv\""},
      {"Shape \"trianglemesh\" \"vector P\" [0 0 0 1 0 0 1 1 0]", kBad, "2:22", "\"vector3 P\""},
      {"Shape \"trianglemesh\" \"normal3 P\" [0 0 0 1 0 0 1 1 0]", kBad, "2:22", "\"normal P\""},
      {"Shape \"trianglemesh\"", kBad, "2:1", "needs \"point3 P\""},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0]", kBad, "2:22", "three numbers a value"},
      {"Shape \"trianglemesh\" \"point3 P\" []", kBad, "2:22", "three numbers a value"},
      {"Shape \"trianglemesh\" \"float P\" [0 0 0]", kBad, "2:22", "expected \"point3 P\""},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 1 1]", kBad, "2:1", "needs \"integer indices\""},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] \"integer indices\" [0 1 3]", kBad, "2:53",
       "the index 3, out of range"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] \"integer indices\" [0 1 -1]", kBad, "2:53",
       "the index -1"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] \"integer indices\" [0 1]", kBad, "2:53",
       "three indices a triangle"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] \"integer indices\" []", kBad, "2:53",
       "three indices a triangle"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] \"normal N\" [0 0 1]", kBad, "2:53",
       "1 values for 3 vertices"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] \"point2 uv\" [0 0]", kBad, "2:53",
       "1 values for 3 vertices"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] \"point2 uv\" [0]", kBad, "2:53",
       "two numbers a value"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] \"float uv\" [0 0 0 0 0 0]", kBad, "2:53",
       "expected \"point2 uv\""},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] \"vector3 S\" [0 0 1]", kNo, "2:53", "tangents"},
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 nan 0 1 1 0]", kBad, "2:42", "finite number"},
      {"Shape \"plymesh\"", kBad, "2:1", "needs a \"string filename\""},
      {"Shape \"plymesh\" \"string filename\" \"absent.ply\"", kMissing, "2:17", "absent.ply"},
      {"Shape \"plymesh\" \"string filename\" \"mesh.ply\" \"texture displacement\" \"d\"", kNo, "2:46",
       "as their geometry is"},
      {"Shape \"sphere\" \"float radius\" 0", kBad, "2:16", "greater than 0"},
      {"Shape \"sphere\" \"float zmin\" 0", kNo, "2:16", "whole spheres"},
      {"Shape \"sphere\" \"float zmax\" .5", kNo, "2:16", "whole spheres"},
      {"Shape \"sphere\" \"float phimax\" 180", kNo, "2:16", "whole spheres"},
      {"Shape \"sphere\" \"float height\" 180", kBad, "2:16", "it takes: alpha, phimax, radius, zmax, zmin"},
      {"Shape \"disk\" \"float radius\" -1", kBad, "2:14", "greater than 0"},
      {"Shape \"disk\" \"float innerradius\" 1", kBad, "2:14", "smaller than the radius"},
      {"Shape \"disk\" \"float innerradius\" -1", kBad, "2:14", "negative"},
      {"Shape \"disk\" \"float phimax\" 180", kNo, "2:14", "whole disks"},
      {"Shape \"bilinearmesh\"", kBad, "2:1", "needs \"point3 P\""},
      {"Shape \"bilinearmesh\" \"point3 P\" [0 0 0]", kBad, "2:1", "needs \"integer indices\""},
      {"Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"integer indices\" [0 1 2]", kBad, "2:59",
       "four indices a patch"},
      {"Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"integer indices\" [0 1 2 4]", kBad, "2:59",
       "the index 4"},
      {"Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"normal N\" [0 0 1]", kBad, "2:59",
       "1 values for 4"},
      {"Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"point2 uv\" [0 0]", kBad, "2:59",
       "1 values for 4"},
      {"Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"string emissionfilename\" \"a\"", kNo, "2:59",
       "light from an image"},
      {"Shape \"sphere\" \"float alpha\" 2", kBad, "2:16", "between 0 and 1"},
      {"Shape \"sphere\" \"texture alpha\" \"nowhere\"", kBad, "2:16", "no float texture of that name"},
      {"ObjectBegin \"o\"", kBad, "2:1", "this ObjectBegin is never ended"},
      {"ObjectBegin \"o\" ObjectBegin \"p\"", kBad, "2:17", "do not nest"},
      {"ObjectBegin \"o\" ObjectEnd ObjectBegin \"o\"", kBad, "2:27", "defined already"},
      {"ObjectBegin \"o\" ObjectInstance \"o\"", kBad, "2:17", "do not nest"},
      {"ObjectInstance \"o\"", kBad, "2:1", "no object \"o\""},
      {"ObjectBegin \"o\" AttributeEnd", kBad, "2:17", "the open block is the ObjectBegin"},
      {"AreaLightSource \"diffuse\" ObjectBegin \"o\" Shape \"sphere\" ObjectEnd", kNo, "2:43", "cannot be instanced"},
  };
  for (const Refused& c : cases) ExpectRefused(c, true);
}

}  // namespace
}  // namespace lodestar
