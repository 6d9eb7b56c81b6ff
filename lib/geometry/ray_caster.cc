#include "lib/geometry/ray_caster.h"

#include <limits>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <tbb/task_arena.h>

#include "lib/common/error.h"

namespace secondlook::geometry {

struct RayCaster::Scene {
  RTCDevice device{rtcNewDevice("set_affinity=0")};
  RTCScene scene{rtcNewScene(device)};

  Scene() = default;
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  ~Scene() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
};

namespace {

/// Embree 3 (Debian 12) and 4 (Ubuntu 24.04) differ in how a ray is asked.
void IntersectAll(RTCScene scene, std::vector<RTCRayHit>* stream) {
#if RTC_VERSION_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  for (RTCRayHit& ray : *stream) rtcIntersect1(scene, &ray, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect1M(scene, &context, stream->data(), static_cast<unsigned>(stream->size()),
                 sizeof(RTCRayHit));
#endif
}

}  // namespace

RayCaster::RayCaster(const Mesh& mesh) : scene_(std::make_unique<Scene>()) {
  if (mesh.empty()) Throw<InvalidArgument>("ray caster: the mesh has no triangle");
  RTCGeometry geometry = rtcNewGeometry(scene_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices.size()));
  auto* triangles = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), mesh.triangles.size()));
  if (vertices == nullptr || triangles == nullptr) {
    Throw<InvalidArgument>("ray caster: no memory for {} vertices and {} triangles",
                           mesh.vertices.size(), mesh.triangles.size());
  }
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    for (int i = 0; i < 3; ++i) *vertices++ = vertex[i];
  }
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) *triangles++ = static_cast<unsigned>(triangle[i]);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcSetSceneFlags(scene_->scene, RTC_SCENE_FLAG_ROBUST);  // no ray slips between two triangles
  // One thread builds the tree, so that it is the same every time. The device's own setting
  // "threads=1" would hold the whole process to one thread.
  tbb::task_arena(1).execute([this] { rtcCommitScene(scene_->scene); });
}

RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

std::vector<RayHit> RayCaster::Cast(std::span<const Ray> rays_M) const {
  std::vector<RTCRayHit> stream(rays_M.size());
  for (std::size_t i = 0; i < rays_M.size(); ++i) {
    RTCRay& ray = stream[i].ray;
    ray.org_x = rays_M[i].p_MO.x();
    ray.org_y = rays_M[i].p_MO.y();
    ray.org_z = rays_M[i].p_MO.z();
    ray.dir_x = rays_M[i].direction_M.x();
    ray.dir_y = rays_M[i].direction_M.y();
    ray.dir_z = rays_M[i].direction_M.z();
    ray.tnear = 0.0F;
    ray.tfar = std::numeric_limits<float>::infinity();
    ray.time = 0.0F;
    ray.mask = ~0U;
    ray.id = 0;
    ray.flags = 0;
    stream[i].hit.geomID = RTC_INVALID_GEOMETRY_ID;
  }
  IntersectAll(scene_->scene, &stream);
  std::vector<RayHit> hits(rays_M.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const RTCHit& hit = stream[i].hit;
    if (hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
    hits[i] = {static_cast<int>(hit.primID), stream[i].ray.tfar,
               Eigen::Vector3f(1.0F - hit.u - hit.v, hit.u, hit.v),
               Eigen::Vector3f(hit.Ng_x, hit.Ng_y, hit.Ng_z).normalized()};
  }
  return hits;
}

}  // namespace secondlook::geometry
