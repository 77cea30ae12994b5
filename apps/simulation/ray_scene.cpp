#include "simulation/ray_scene.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <Eigen/Geometry>

#include <cmath>
#include <stdexcept>

namespace fuse_flow::simulation {
namespace {

void check(RTCDevice device, bool ok) {
  if (!ok) throw std::runtime_error("Embree: error " + std::to_string(static_cast<int>(rtcGetDeviceError(device))));
}

RTCRay makeRay(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float near, float far) {
  RTCRay ray{};
  ray.org_x = origin.x();
  ray.org_y = origin.y();
  ray.org_z = origin.z();
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.tnear = near;
  ray.tfar = far;
  ray.mask = 0xffffffffu;
  return ray;
}

/** \brief Barycentric coordinates (of the second and third corner) of the point of a triangle nearest to p. */
Eigen::Vector2f nearestOnTriangle(const Eigen::Vector3f& p, const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                                  const Eigen::Vector3f& c) {
  // The point lies nearest to a corner, an edge or the face, told apart by the signs of six dot products (Ericson,
  // Real-Time Collision Detection, section 5.1.5).
  const Eigen::Vector3f ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const float d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return {0, 0};
  if (d3 >= 0 && d4 <= d3) return {1, 0};
  if (d6 >= 0 && d5 <= d6) return {0, 1};
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {d1 / (d1 - d3), 0};
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {0, d2 / (d2 - d6)};
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const float w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {1 - w, w};
  }
  const float sum = va + vb + vc;
  return {vb / sum, vc / sum};
}

struct Nearest {
  const std::vector<const Object*>* objects;
  std::uint32_t object;
  std::uint32_t triangle;
  Eigen::Vector2f at;
};

bool visitTriangle(RTCPointQueryFunctionArguments* arguments) {
  auto& best = *static_cast<Nearest*>(arguments->userPtr);
  const TriangleMesh& mesh = (*best.objects)[arguments->geomID]->mesh;
  const auto& t = mesh.triangles[arguments->primID];
  const Eigen::Vector3f p(arguments->query->x, arguments->query->y, arguments->query->z);
  const Eigen::Vector3f &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
  const Eigen::Vector2f at = nearestOnTriangle(p, a, b, c);
  const float distance = (a + at.x() * (b - a) + at.y() * (c - a) - p).norm();
  if (!(distance < arguments->query->radius)) return false;
  arguments->query->radius = distance;
  best.object = arguments->geomID;
  best.triangle = arguments->primID;
  best.at = at;
  return true;
}

}  // namespace

struct RayScene::Impl {
  RTCDevice device{nullptr};
  RTCScene scene{nullptr};
  std::vector<Object> fixed;
  std::vector<Object> moving;
  std::vector<const Object*> objects;

  Impl() : device(rtcNewDevice(nullptr)) {
    if (device == nullptr) throw std::runtime_error("Embree cannot be started on this machine");
    build();
  }
  ~Impl() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void add(const Object& object) {
    const TriangleMesh& mesh = object.mesh;
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 3 * sizeof(float), mesh.vertices.size()));
    auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.triangles.size()));
    check(device, vertices != nullptr && indices != nullptr);
    for (const Eigen::Vector3f& v : mesh.vertices) vertices = std::copy(v.data(), v.data() + 3, vertices);
    for (const auto& t : mesh.triangles) indices = std::copy(t.begin(), t.end(), indices);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, static_cast<unsigned int>(objects.size()));
    rtcReleaseGeometry(geometry);
    objects.push_back(&object);
  }

  void build() {
    if (scene != nullptr) rtcReleaseScene(scene);
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);  // no cracks between triangles
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    objects.clear();
    for (const Object& object : fixed) add(object);
    for (const Object& object : moving) add(object);
    rtcCommitScene(scene);
    check(device, rtcGetDeviceError(device) == RTC_ERROR_NONE);
  }

  /** \brief The point of a triangle at barycentric coordinates. */
  SurfacePoint surfacePoint(std::uint32_t object, std::uint32_t triangle, float u, float v) const {
    const TriangleMesh& mesh = objects[object]->mesh;
    const auto& t = mesh.triangles[triangle];
    const auto blend = [&](const std::vector<Eigen::Vector3f>& of) -> Eigen::Vector3f {
      return (1 - u - v) * of[t[0]] + u * of[t[1]] + v * of[t[2]];
    };
    SurfacePoint point;
    point.object = object;
    point.position = blend(mesh.vertices);
    point.rest = mesh.rest.empty() ? point.position : blend(mesh.rest);
    if (mesh.normals.empty()) {
      const Eigen::Vector3f& a = mesh.vertices[t[0]];
      point.normal = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
    } else {
      point.normal = blend(mesh.normals);
    }
    point.normal.normalize();
    return point;
  }
};

RayScene::RayScene() : impl_(std::make_unique<Impl>()) {}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

void RayScene::setFixed(const std::vector<Object>& objects) {
  impl_->fixed = objects;
  impl_->build();
}

void RayScene::setMoving(const std::vector<Object>& objects) {
  impl_->moving = objects;
  impl_->build();
}

RayHit RayScene::intersect(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const {
  RTCRayHit query{};
  query.ray = makeRay(origin, direction, 0.0f, std::numeric_limits<float>::infinity());
  query.hit.geomID = query.hit.primID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(impl_->scene, &query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(impl_->scene, &context, &query);
#endif
  RayHit hit;
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return hit;
  static_cast<SurfacePoint&>(hit) = impl_->surfacePoint(query.hit.geomID, query.hit.primID, query.hit.u, query.hit.v);
  hit.t = query.ray.tfar;
  return hit;
}

bool RayScene::occluded(const Eigen::Vector3f& from, const Eigen::Vector3f& to, float margin) const {
  const Eigen::Vector3f direction = to - from;
  const float length = direction.norm();
  if (!(length > 2 * margin)) return false;
  RTCRay ray = makeRay(from, direction / length, margin, length - margin);
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded1(impl_->scene, &ray);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(impl_->scene, &context, &ray);
#endif
  return ray.tfar < 0;  // Embree's mark of an occluded ray: minus infinity
}

RayHit RayScene::nearest(const Eigen::Vector3f& point, float radius) const {
  RTCPointQuery query{point.x(), point.y(), point.z(), 0.0f, radius};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  Nearest best{&impl_->objects, RTC_INVALID_GEOMETRY_ID, 0, {0, 0}};
  rtcPointQuery(impl_->scene, &query, &context, visitTriangle, &best);
  RayHit hit;
  if (best.object == RTC_INVALID_GEOMETRY_ID) return hit;
  static_cast<SurfacePoint&>(hit) = impl_->surfacePoint(best.object, best.triangle, best.at.x(), best.at.y());
  hit.t = query.radius;
  return hit;
}

const Object& RayScene::object(std::uint32_t number) const { return *impl_->objects[number]; }
bool RayScene::moving(std::uint32_t number) const { return number >= impl_->fixed.size(); }
std::uint32_t RayScene::objectCount() const { return static_cast<std::uint32_t>(impl_->objects.size()); }

}  // namespace fuse_flow::simulation
