#include "core/scene/accelerator.h"

#include <embree3/rtcore.h>
#include <immintrin.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cmath>
#include <string>

#include "core/base/check.h"
#include "core/base/error.h"

namespace lodestar {
namespace {

// The high one splits triangles in space: measured no faster on the shared scenes, in rays, at a longer build.
constexpr RTCBuildQuality kBuildQuality = RTC_BUILD_QUALITY_MEDIUM;

// What a callback of one geometry needs.
struct Callback {
  const GeometryGroup* group;
  const TextureTable* textures;
  const MaterialTable* materials;
  uint32_t slot;
  const std::vector<Quadric>* quadrics = nullptr;
};

Vec3 Origin(const RTCRay& r) {
  return {r.org_x, r.org_y, r.org_z};
}
Vec3 Direction(const RTCRay& r) {
  return {r.dir_x, r.dir_y, r.dir_z};
}

// In whole vectors: the traversal reads them so, and what was stored in parts would reach it only through the cache.
void SetRay(const Ray& ray, RTCRay* r) {
  const Vec3 o = ray.origin, d = ray.direction;
  _mm_store_ps(&r->org_x, _mm_setr_ps(o.x, o.y, o.z, 0));  // and tnear
  _mm_store_ps(&r->dir_x, _mm_setr_ps(d.x, d.y, d.z, 0));  // and time
  r->tfar = ray.t_max;
  r->mask = ~0u;
  r->id = 0;
  r->flags = 0;
}

// The filter of triangles with alpha; N is always 1 here.
void FilterTriangle(const RTCFilterFunctionNArguments* args) {
  const auto& callback = *static_cast<const Callback*>(args->geometryUserPtr);
  const auto& ray = *reinterpret_cast<const RTCRay*>(args->ray);
  const auto& hit = *reinterpret_cast<const RTCHit*>(args->hit);
  const MeshRecord& record = callback.group->meshes[callback.group->triangles[callback.slot][hit.primID].mesh];
  if (!AlphaAccepts(*callback.group, *callback.textures, *callback.materials, record, Origin(ray), Direction(ray),
                    args->context->instID[0], callback.slot, hit.primID, hit.u, hit.v, {}))
    args->valid[0] = 0;
}

struct QuadricHit {
  double t;
  float u, v;
  Vec3 ng;
};

// Nearest sphere hit in (t_min, t_max) that `accept` takes. The discriminant comes from the point of closest approach
// (Haines et al. 2019, "Precision Improvements for Ray/Sphere Intersection"), in double: a ray from 1e7 radii away
// still meets it.
template <class Accept>
bool IntersectSphere(const Quadric& q, const RTCRay& ray, double t_max, QuadricHit* out, Accept accept) {
  const auto o = q.object_from_group.Point(ray.org_x, ray.org_y, ray.org_z);
  const auto d = q.object_from_group.Vector(ray.dir_x, ray.dir_y, ray.dir_z);
  const double dd = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  const double od = o[0] * d[0] + o[1] * d[1] + o[2] * d[2];
  const double closest = -od / dd;
  const double fx = o[0] + closest * d[0], fy = o[1] + closest * d[1], fz = o[2] + closest * d[2];
  const double f = std::sqrt(fx * fx + fy * fy + fz * fz);
  const double discriminant = (q.radius - f) * (q.radius + f);
  if (!(discriminant >= 0)) return false;
  const double half = std::sqrt(discriminant / dd);
  const double oo = std::sqrt(o[0] * o[0] + o[1] * o[1] + o[2] * o[2]);
  const double c = (oo - q.radius) * (oo + q.radius) / dd;
  // The root of larger magnitude directly, the other from the product of both.
  const double far_root = closest + std::copysign(half, closest);
  const double near_root = far_root != 0 ? c / far_root : 0;
  const double roots[2] = {std::min(far_root, near_root), std::max(far_root, near_root)};
  for (const double t : roots) {
    if (!(t > double(ray.tnear) && t <= t_max)) continue;
    double x = fx + (t - closest) * d[0], y = fy + (t - closest) * d[1], z = fz + (t - closest) * d[2];
    const double inverse = 1 / std::sqrt(x * x + y * y + z * z);
    *out = {t, 0, 0, {float(x * inverse), float(y * inverse), float(z * inverse)}};
    if (accept(*out)) return true;
  }
  return false;
}

template <class Accept>
bool IntersectDisk(const Quadric& q, const RTCRay& ray, double t_max, QuadricHit* out, Accept accept) {
  const auto o = q.object_from_group.Point(ray.org_x, ray.org_y, ray.org_z);
  const auto d = q.object_from_group.Vector(ray.dir_x, ray.dir_y, ray.dir_z);
  if (d[2] == 0) return false;
  const double t = (q.height - o[2]) / d[2];
  if (!(t > double(ray.tnear) && t <= t_max)) return false;
  const double x = o[0] + t * d[0], y = o[1] + t * d[1];
  const double rr = x * x + y * y;
  if (rr > q.radius * q.radius || rr < q.inner_radius * q.inner_radius) return false;
  *out = {t, float(x / q.radius), float(y / q.radius), {}};
  return accept(*out);
}

bool IntersectQuadric(const Callback& callback, unsigned instance, unsigned primitive, const RTCRay& ray,
                      QuadricHit* hit) {
  const Quadric& q = (*callback.quadrics)[primitive];
  const auto accept = [&](const QuadricHit& h) {
    return !(q.record.flags & MeshRecord::kHasAlpha) ||
           AlphaAccepts(*callback.group, *callback.textures, *callback.materials, q.record, Origin(ray), Direction(ray),
                        instance, callback.slot, primitive, h.u, h.v, h.ng);
  };
  return callback.slot == kSpheres ? IntersectSphere(q, ray, ray.tfar, hit, accept)
                                   : IntersectDisk(q, ray, ray.tfar, hit, accept);
}

void QuadricIntersect(const RTCIntersectFunctionNArguments* args) {
  if (!args->valid[0]) return;
  const auto& callback = *static_cast<const Callback*>(args->geometryUserPtr);
  auto& rayhit = *reinterpret_cast<RTCRayHit*>(args->rayhit);
  QuadricHit hit;
  if (!IntersectQuadric(callback, args->context->instID[0], args->primID, rayhit.ray, &hit)) return;
  rayhit.ray.tfar = static_cast<float>(hit.t);
  rayhit.hit.u = hit.u;
  rayhit.hit.v = hit.v;
  rayhit.hit.Ng_x = hit.ng.x;
  rayhit.hit.Ng_y = hit.ng.y;
  rayhit.hit.Ng_z = hit.ng.z;
  rayhit.hit.primID = args->primID;
  rayhit.hit.geomID = args->geomID;
  rayhit.hit.instID[0] = args->context->instID[0];
}

void QuadricOccluded(const RTCOccludedFunctionNArguments* args) {
  if (!args->valid[0]) return;
  const auto& callback = *static_cast<const Callback*>(args->geometryUserPtr);
  auto& ray = *reinterpret_cast<RTCRay*>(args->ray);
  QuadricHit hit;
  if (IntersectQuadric(callback, args->context->instID[0], args->primID, ray, &hit)) ray.tfar = -kInfinity;
}

// Boxes of the ellipsoid or ellipse, rounded outwards.
void QuadricBounds(const RTCBoundsFunctionArguments* args) {
  const auto& callback = *static_cast<const Callback*>(args->geometryUserPtr);
  const Quadric& q = (*callback.quadrics)[args->primID];
  const bool sphere = callback.slot == kSpheres;
  const auto center = q.group_from_object.Point(0, 0, sphere ? 0 : q.height);
  float* lower = &args->bounds_o->lower_x;
  float* upper = &args->bounds_o->upper_x;
  for (int axis = 0; axis < 3; ++axis) {
    const double half = q.HalfExtent(axis, sphere);
    const double pad = (std::fabs(center[axis]) + half) * 4 * kRound;
    lower[axis] = std::nextafter(float(center[axis] - half - pad), -kInfinity);
    upper[axis] = std::nextafter(float(center[axis] + half + pad), kInfinity);
  }
}

// Called from inside the library, where nothing may be thrown: keeps the first message.
void OnError(void* user, RTCError, const char* message) {
  auto& first = *static_cast<std::string*>(user);
  if (first.empty()) first = message ? message : "unknown error";
}

bool OnMemory(void* user, ssize_t bytes, bool) {
  static_cast<std::atomic<int64_t>*>(user)->fetch_add(bytes, std::memory_order_relaxed);
  return true;
}

}  // namespace

struct Accelerator::Impl {
  Impl(const TextureTable& textures, const MaterialTable& materials) : textures(textures), materials(materials) {}

  const TextureTable& textures;
  const MaterialTable& materials;
  std::atomic<int64_t> memory{0};
  std::string error;
  RTCDevice device = nullptr;
  std::vector<RTCScene> scenes;
  std::vector<std::unique_ptr<Callback>> callbacks;

  ~Impl() {
    for (RTCScene scene : scenes) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }

  void Attach(RTCScene scene, RTCGeometry geometry, uint32_t slot) {
    rtcSetGeometryBuildQuality(geometry, kBuildQuality);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, slot);
    rtcReleaseGeometry(geometry);
  }

  RTCScene Build(const GeometryGroup& group, const std::vector<Instance>* instances) {
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, kBuildQuality);
    for (const uint32_t slot : {kOpaqueTriangles, kFilteredTriangles}) {
      const auto& triangles = group.triangles[slot];
      if (triangles.empty()) continue;
      RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, group.vertices.data(), 0,
                                 sizeof(Vertex), group.vertices.size());
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.data(), 0,
                                 sizeof(Triangle), triangles.size());
      if (slot == kFilteredTriangles) {
        rtcSetGeometryUserData(geometry, NewCallback(group, slot, nullptr));
        rtcSetGeometryIntersectFilterFunction(geometry, FilterTriangle);
        rtcSetGeometryOccludedFilterFunction(geometry, FilterTriangle);
      }
      Attach(scene, geometry, slot);
    }
    for (const uint32_t slot : {kSpheres, kDisks}) {
      const auto& quadrics = slot == kSpheres ? group.spheres : group.disks;
      if (quadrics.empty()) continue;
      RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
      rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(quadrics.size()));
      rtcSetGeometryUserData(geometry, NewCallback(group, slot, &quadrics));
      rtcSetGeometryBoundsFunction(geometry, QuadricBounds, nullptr);
      rtcSetGeometryIntersectFunction(geometry, QuadricIntersect);
      rtcSetGeometryOccludedFunction(geometry, QuadricOccluded);
      Attach(scene, geometry, slot);
    }
    if (instances) {
      for (size_t i = 0; i < instances->size(); ++i) {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, scenes[(*instances)[i].group]);
        rtcSetGeometryTimeStepCount(geometry, 1);
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, (*instances)[i].embree_transform.data());
        Attach(scene, geometry, kFirstInstance + static_cast<uint32_t>(i));
      }
    }
    // Embree builds in an arena of its own. While all of TBB is held to one thread the build has one order on every
    // machine, so ties between coplanar primitives fall the same way; renders of this process go on with the threads
    // that they have.
    const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    rtcJoinCommitScene(scene);
    return scene;
  }

  Callback* NewCallback(const GeometryGroup& group, uint32_t slot, const std::vector<Quadric>* quadrics) {
    callbacks.push_back(std::make_unique<Callback>(Callback{&group, &textures, &materials, slot, quadrics}));
    return callbacks.back().get();
  }
};

Accelerator::Accelerator(const std::vector<GeometryGroup>& groups, const std::vector<Instance>& instances,
                         const TextureTable& textures, const MaterialTable& materials)
    : impl_(std::make_unique<Impl>(textures, materials)) {
  LODESTAR_CHECK(!groups.empty());
  impl_->device = rtcNewDevice("isa=avx2,start_threads=0,set_affinity=0");
  if (!impl_->device)
    throw Error(ErrorKind::kUnsupported, "the ray tracing library cannot start; this machine needs a CPU with AVX2");
  rtcSetDeviceErrorFunction(impl_->device, OnError, &impl_->error);
  rtcSetDeviceMemoryMonitorFunction(impl_->device, OnMemory, &impl_->memory);
  impl_->scenes.resize(groups.size(), nullptr);
  // The world last: its instances refer to the committed others.
  for (size_t i = 1; i < groups.size(); ++i) impl_->scenes[i] = impl_->Build(groups[i], nullptr);
  impl_->scenes[0] = impl_->Build(groups[0], &instances);
  if (!impl_->error.empty())
    throw Error(ErrorKind::kIo, "building the ray tracing structure failed: " + impl_->error +
                                    "; is there enough memory for this scene?");
  scene_ = impl_->scenes[0];
}

Accelerator::~Accelerator() = default;

bool Accelerator::Intersect(const Ray& ray, Hit* hit) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit r;
  SetRay(ray, &r.ray);
  r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(static_cast<RTCScene>(scene_), &context, &r);
  if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit->t = r.ray.tfar;
  hit->u = r.hit.u;
  hit->v = r.hit.v;
  hit->ng = {r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z};
  hit->geometry = r.hit.geomID;
  hit->primitive = r.hit.primID;
  hit->instance = r.hit.instID[0] == RTC_INVALID_GEOMETRY_ID ? Hit::kNoInstance : r.hit.instID[0] - kFirstInstance;
  return true;
}

bool Accelerator::Unoccluded(const Ray& ray) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay r;
  SetRay(ray, &r);
  rtcOccluded1(static_cast<RTCScene>(scene_), &context, &r);
  return r.tfar >= 0;
}

size_t Accelerator::memory_bytes() const {
  return static_cast<size_t>(impl_->memory.load());
}

}  // namespace lodestar
