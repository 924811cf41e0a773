#include "worker/fingerprint.h"

#include "core/base/sha256_stream.h"
#include "core/guiding/tree_request.h"
#include "core/learning/loop.h"
#include "core/scene/pbrt_parser.h"
#include "core/tracing/local_executor.h"

namespace lodestar {
namespace {

// What could come out otherwise under another Embree, another mathematics library or another rounding mode: which of
// two coplanar triangles is hit, and how often; curved shapes and slanted edges; rough reflection and refraction;
// lights with and without a surface.
constexpr const char* kCanaryScene = R"(
LookAt 0.1 1.2 3.5  0 0.9 0  0 1 0
Camera "perspective" "float fov" 42 "float lensradius" 0.05 "float focaldistance" 3.5
Film "rgb" "integer xresolution" 48 "integer yresolution" 32
Integrator "path" "integer maxdepth" 6
WorldBegin
LightSource "infinite" "rgb L" [ 0.2 0.25 0.3 ]
LightSource "point" "rgb I" [ 1 0.9 0.8 ] "point3 from" [ -0.8 1.7 0.9 ]
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [ 9 8 7 ]
  Translate 0.2 1.9 0
  Rotate 80 1 0 0.1
  Shape "disk" "float radius" 0.4
AttributeEnd
Material "diffuse" "rgb reflectance" [ 0.7 0.6 0.5 ]
Shape "trianglemesh" "point3 P" [ -1 0 -1  1 0 -1  1 0 1.1  -1 0 1 ] "integer indices" [ 0 1 2 0 2 3 ]
Shape "trianglemesh" "point3 P" [ -1 0 -1  1 0 -1  1.1 2 -1  -1 2 -1 ] "integer indices" [ 0 1 2 0 2 3  0 1 2 ]
Material "diffuse" "rgb reflectance" [ 0.1 0.3 0.8 ]
Shape "trianglemesh" "point3 P" [ -1 0 -1  1 0 -1  1.1 2 -1  -1 2 -1 ] "integer indices" [ 0 1 2 0 2 3 ]
Material "coateddiffuse" "rgb reflectance" [ 0.6 0.1 0.1 ] "float roughness" 0.1
Shape "bilinearmesh" "point3 P" [ -1 0 -1  -0.9 0 1  -1 2 -1  -1.1 1.8 1 ]
ObjectBegin "ball"
  Material "conductor" "rgb eta" [ 0.2 0.9 1.1 ] "rgb k" [ 3.9 2.4 2.2 ] "float roughness" 0.2
  Shape "sphere" "float radius" 0.35
ObjectEnd
AttributeBegin
  Translate -0.4 0.35 -0.2
  ObjectInstance "ball"
AttributeEnd
AttributeBegin
  Translate 0.45 0.5 0.3
  Rotate 30 0.3 1 0.2
  Scale 1 1.3 0.8
  ObjectInstance "ball"
AttributeEnd
Material "dielectric" "float roughness" 0.1
AttributeBegin
  Translate 0 0.25 0.7
  Shape "sphere" "float radius" 0.2
AttributeEnd
)";

// The shared libraries are no part of the build id, so the canary goes through them: as a job does, only smaller.
std::string Canary() {
  JobSpec job;
  job.method = "path";
  job.budget.spp = 4;
  const CompiledJob compiled = CompileJob(ParsePbrtText(kCanaryScene, "canary", "."), job);
  Loop loop(job, compiled.survey);
  LocalExecutor executor(compiled.scene, job, loop.method(), 1);
  loop.Run(executor, StopToken(), {});
  // And what no picture shows: whether numbers too small to be normal are kept, or flushed to zero by a library that
  // was built so.
  volatile float tiny = 1e-30f;
  ByteWriter out;
  out.PutString(ImageHash(loop.Develop()).hex);
  for (const float factor : {1e-9f, 3e-12f, 7e-15f}) out.Put(tiny * factor);
  return Sha256(out.bytes()).hex.substr(0, 16);
}

}  // namespace

WorkerInfo DescribeWorker(const std::string& name, int threads) {
  WorkerInfo info;
  info.name = name;
  info.threads = static_cast<uint32_t>(threads);
  info.build_id = Sha256OfFile("/proc/self/exe").hex.substr(0, 16);
  info.canary = Canary();
  info.tree_canary = TreeCanary();
  return info;
}

}  // namespace lodestar
