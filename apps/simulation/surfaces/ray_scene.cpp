#include "simulation/surfaces/ray_scene.h"

#include "simulation/surfaces/ray_triangle.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>
#include <utility>

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/** \brief Throws Embree's first error since the last call. */
void check(RTCDevice device) {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (error != RTC_ERROR_NONE) throw std::runtime_error("Embree: error " + std::to_string(static_cast<int>(error)));
}

/** \brief A moment as Embree takes it. */
float clamped(float moment) { return moment > 0 ? std::min(moment, 1.0f) : 0.0f; }

/** \brief A little more: bounds that Embree compares with must not cut off what ties with the best. */
float beyond(double value) { return static_cast<float>(value * (1 + 1e-6)); }

#if RTC_VERSION_MAJOR >= 4
using QueryContext = RTCRayQueryContext;
#else
using QueryContext = RTCIntersectContext;
#endif

/** \brief A ray on its way through Embree: what it met first up to now. */
struct RayQuery : QueryContext {
  RayQuery(const Vector3f& origin, const Vector3f& direction, const BetweenSteps& when, double near, double far)
      : ray(origin, direction), moment(when), nearest(near), t(far) {
#if RTC_VERSION_MAJOR >= 4
    rtcInitRayQueryContext(this);
#else
    rtcInitIntersectContext(this);
#endif
  }

  /** \brief Whether the ray meets a triangle in its interval. It does only inside the triangle's box, half as much enlarged as for
   *  Embree: rounding can put what is met of a triangle that is seen nearly edge-on outside of it, where Embree would not always
   *  look for it. */
  bool meets(const Triangles& triangles, std::uint32_t number, double& where, Barycentric& on) const {
    const Triangle corners = triangles.at(number, moment);
    if (!ray.meets(corners, where, on) || !(where >= nearest && where <= t)) return false;
    const float half = 0.5f * triangles.margin;
    for (int axis = 0; axis < 3; ++axis) {
      const auto [low, high] = std::minmax({corners[0][axis], corners[1][axis], corners[2][axis]});
      const double p = ray.along(axis, where);
      if (!(p >= static_cast<double>(low - half) && p <= static_cast<double>(high + half))) return false;
    }
    return true;
  }

  WatertightRay ray;
  BetweenSteps moment;
  double nearest;
  double t;
  std::uint32_t triangle{RTC_INVALID_GEOMETRY_ID};
  Barycentric at;
};

void boundTriangle(const RTCBoundsFunctionArguments* arguments) {
  const auto& part = *static_cast<const TriangleRange*>(arguments->geometryUserPtr);
  const Triangles& triangles = *part.triangles;
  const Triangle& t = triangles.at(part.first + arguments->primID, std::size_t{arguments->timeStep});
  const Vector3f low = t[0].cwiseMin(t[1]).cwiseMin(t[2]).array() - triangles.margin;
  const Vector3f high = t[0].cwiseMax(t[1]).cwiseMax(t[2]).array() + triangles.margin;
  RTCBounds& bounds = *arguments->bounds_o;
  bounds.lower_x = low.x();
  bounds.lower_y = low.y();
  bounds.lower_z = low.z();
  bounds.upper_x = high.x();
  bounds.upper_y = high.y();
  bounds.upper_z = high.z();
}

void intersectTriangle(const RTCIntersectFunctionNArguments* arguments) {
  auto& query = *static_cast<RayQuery*>(arguments->context);
  const auto& part = *static_cast<const TriangleRange*>(arguments->geometryUserPtr);
  const std::uint32_t number = part.first + arguments->primID;
  double t;
  Barycentric at;
  if (arguments->valid[0] == 0 || !query.meets(*part.triangles, number, t, at)) return;
  if (t >= query.t && number >= query.triangle) return;
  query.t = t;
  query.triangle = number;
  query.at = at;
  RTCRayN_tfar(RTCRayHitN_RayN(arguments->rayhit, 1), 1, 0) = beyond(t);
}

void occludeByTriangle(const RTCOccludedFunctionNArguments* arguments) {
  const auto& query = *static_cast<const RayQuery*>(arguments->context);
  const auto& part = *static_cast<const TriangleRange*>(arguments->geometryUserPtr);
  double t;
  Barycentric at;
  if (arguments->valid[0] != 0 && query.meets(*part.triangles, part.first + arguments->primID, t, at))
    RTCRayN_tfar(arguments->ray, 1, 0) = -std::numeric_limits<float>::infinity();  // Embree's mark of an occluded ray
}

RTCRay makeRay(const Vector3f& origin, const Vector3f& direction, float moment, float near, float far) {
  RTCRay ray{};
  ray.org_x = origin.x();
  ray.org_y = origin.y();
  ray.org_z = origin.z();
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.time = moment;
  ray.tnear = near;
  ray.tfar = far;
  ray.mask = 0xffffffffu;
  return ray;
}

/** \brief A triangle beside a place, and its point that is nearest to it. */
struct Candidate {
  double distance;
  std::uint32_t triangle;
  Barycentric at;
  Vector3d foot;
};

/** \brief Points within this of the nearest are one with it, metres for each metre of the largest coordinate. */
constexpr float kTouching = 1e-6f;

struct NearestQuery {
  const Triangles* triangles;
  const std::vector<TriangleRange>* parts;
  Vector3d point;
  double touching;
  double best;
  std::vector<Candidate> candidates;
};

bool visitTriangle(RTCPointQueryFunctionArguments* arguments) {
  auto& query = *static_cast<NearestQuery*>(arguments->userPtr);
  const std::uint32_t number = (*query.parts)[arguments->geomID].first + arguments->primID;
  const Triangle& triangle = query.triangles->all[number];
  Candidate candidate{0, number, nearestOnTriangle(query.point, triangle), {}};
  candidate.foot = placeOn(triangle, candidate.at);
  candidate.distance = (candidate.foot - query.point).norm();
  if (!(candidate.distance <= query.best + query.touching)) return false;
  query.candidates.push_back(candidate);
  if (!(candidate.distance < query.best)) return false;
  query.best = candidate.distance;
  const float radius = beyond(query.best + query.touching);
  if (!(radius < arguments->query->radius)) return false;
  arguments->query->radius = radius;
  return true;
}

}  // namespace

struct RayScene::Impl {
  RTCDevice device{nullptr};
  RTCScene scene{nullptr};
  std::vector<Object> fixed;
  /** \brief What moves, at each step of its motion; at least one. */
  std::vector<std::vector<Object>> steps{1};
  /** \brief At the first step. */
  std::vector<const Object*> objects;
  /** \brief The number of each object's first triangle. */
  std::vector<std::uint32_t> first;
  Triangles triangles;
  /** \brief What stands still, and what moves; by the number of its geometry, without those that are empty. */
  std::vector<TriangleRange> parts;
  float largest{1};  ///< coordinate, at least 1 m

  explicit Impl(const std::string& embree) : device(rtcNewDevice(embree.empty() ? nullptr : embree.c_str())) {
    if (device == nullptr) throw std::runtime_error("Embree cannot be started on this machine");
    build();
  }
  ~Impl() {
    if (scene != nullptr) rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void add(const Object& object) {
    objects.push_back(&object);
    first.push_back(static_cast<std::uint32_t>(triangles.all.size()));
    add(object.mesh, triangles.all);
  }

  void add(const TriangleMesh& mesh, std::vector<Triangle>& to) {
    const auto& v = mesh.vertices;
    for (const auto& t : mesh.triangles) to.push_back({v[t[0]], v[t[1]], v[t[2]]});
    for (const Vector3f& p : v) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  }

  void collect() {
    objects.clear();
    first.clear();
    triangles.all.clear();
    triangles.later.clear();
    largest = 1;
    for (const Object& object : fixed) add(object);
    triangles.first_moving = static_cast<std::uint32_t>(triangles.all.size());
    for (const Object& object : steps[0]) add(object);
    for (std::size_t step = 1; step < steps.size(); ++step) {
      triangles.later.emplace_back();
      for (const Object& object : steps[step]) add(object.mesh, triangles.later.back());
    }
    triangles.margin = 1e-5f * largest;
  }

  void attach(const TriangleRange& part, std::size_t count, std::size_t time_steps) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned int>(count));
    rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned int>(time_steps));
    rtcSetGeometryUserData(geometry, const_cast<TriangleRange*>(&part));
    rtcSetGeometryBoundsFunction(geometry, boundTriangle, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersectTriangle);
    rtcSetGeometryOccludedFunction(geometry, occludeByTriangle);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
  }

  void build() {
    if (scene != nullptr) rtcReleaseScene(scene);
    scene = nullptr;  // what follows may run out of memory
    collect();
    scene = rtcNewScene(device);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    const std::size_t still = triangles.first_moving, moving = triangles.all.size() - still;
    parts.clear();
    if (still > 0) parts.push_back({&triangles, 0});
    if (moving > 0) parts.push_back({&triangles, triangles.first_moving});
    if (still > 0) attach(parts.front(), still, 1);
    if (moving > 0) attach(parts.back(), moving, steps.size());
    rtcCommitScene(scene);
    check(device);
  }

  /** \param moment in [0, 1] */
  BetweenSteps between(float moment) const {
    const float at = moment * static_cast<float>(steps.size() - 1);
    const float step = std::floor(at);
    return {static_cast<std::size_t>(step), at - step};
  }

  /** \brief An object's mesh at a step; the first one's if it stands still. */
  const TriangleMesh& mesh(std::uint32_t object, std::size_t step) const {
    return object < fixed.size() ? fixed[object].mesh : steps[step][object - fixed.size()].mesh;
  }

  std::uint32_t objectOf(std::uint32_t triangle) const {
    return static_cast<std::uint32_t>(std::upper_bound(first.begin(), first.end(), triangle) - first.begin() - 1);
  }

  /** \brief A place on a triangle. */
  SurfacePoint surfacePoint(std::uint32_t number, const Barycentric& at, const BetweenSteps& moment = {}) const {
    SurfacePoint point;
    point.object = objectOf(number);
    const TriangleMesh& here = mesh(point.object, moment.step);
    const auto& t = here.triangles[number - first[point.object]];
    const auto u = static_cast<float>(at.u), v = static_cast<float>(at.v);
    const auto on = [&](const std::vector<Vector3f>& of) -> Vector3f {
      return (1 - u - v) * of[t[0]] + u * of[t[1]] + v * of[t[2]];
    };
    const auto blend = [&](std::vector<Vector3f> TriangleMesh::*of) -> Vector3f {
      if (!(moment.share > 0) || point.object < fixed.size()) return on(here.*of);
      return (1 - moment.share) * on(here.*of) + moment.share * on(mesh(point.object, moment.step + 1).*of);
    };
    point.position = blend(&TriangleMesh::vertices);
    point.rest = here.rest.empty() ? point.position : on(here.rest);
    point.normal =
        here.normals.empty() ? areaVector(triangles.at(number, moment)).cast<float>() : blend(&TriangleMesh::normals);
    point.normal.normalize();
    if (!here.velocities.empty()) point.velocity = on(here.velocities);
    return point;
  }

  static Vector3d areaVector(const Triangle& t) {
    const Vector3d a = t[0].cast<double>();
    return (t[1].cast<double>() - a).cross(t[2].cast<double>() - a);
  }
};

RayScene::RayScene(const std::string& embree) : impl_(std::make_unique<Impl>(embree)) {}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

void RayScene::setFixed(const std::vector<Object>& objects) {
  impl_->fixed = objects;
  impl_->build();
}

void RayScene::setMoving(const std::vector<Object>& objects) { setMotion({objects}); }

void RayScene::setMotion(std::vector<std::vector<Object>> steps) {
  if (steps.empty()) steps.emplace_back();  // nothing moves
  for (const std::vector<Object>& step : steps) {
    bool same = step.size() == steps[0].size();
    for (std::size_t k = 0; same && k < step.size(); ++k)
      same = step[k].mesh.triangles == steps[0][k].mesh.triangles &&
             step[k].mesh.vertices.size() == steps[0][k].mesh.vertices.size() &&
             step[k].mesh.normals.size() == steps[0][k].mesh.normals.size();
    if (!same || steps.size() > RTC_MAX_TIME_STEP_COUNT)
      throw std::invalid_argument("a motion must have the same objects with the same triangles at at most " +
                                  std::to_string(RTC_MAX_TIME_STEP_COUNT) + " times");
  }
  impl_->steps = std::move(steps);
  impl_->build();
}

RayHit RayScene::intersect(const Vector3f& origin, const Vector3f& direction, float moment) const {
  RayHit hit;
  if (!(direction.cwiseAbs().maxCoeff() > 0)) return hit;
  constexpr float far = std::numeric_limits<float>::infinity();
  const float time = clamped(moment);
  const BetweenSteps when = impl_->between(time);
  RayQuery query(origin, direction, when, 0, static_cast<double>(far));
  RTCRayHit ray{};
  ray.ray = makeRay(origin, direction, time, 0, far);
  ray.hit.geomID = ray.hit.primID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &query;
  rtcIntersect1(impl_->scene, &ray, &arguments);
#else
  rtcIntersect1(impl_->scene, &query, &ray);
#endif
  if (query.triangle == RTC_INVALID_GEOMETRY_ID) return hit;
  static_cast<SurfacePoint&>(hit) = impl_->surfacePoint(query.triangle, query.at, when);
  hit.t = static_cast<float>(query.t);
  return hit;
}

bool RayScene::occluded(const Vector3f& from, const Vector3f& to, float margin, float moment) const {
  const Vector3f direction = to - from;
  const float length = direction.norm();
  if (!(length > 2 * margin)) return false;
  const Vector3f unit = direction / length;
  const float near = margin, far = length - margin;
  const float time = clamped(moment);
  RayQuery query(from, unit, impl_->between(time), static_cast<double>(near), static_cast<double>(far));
  RTCRay ray = makeRay(from, unit, time, near * (1 - 1e-6f), beyond(static_cast<double>(far)));
#if RTC_VERSION_MAJOR >= 4
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &query;
  rtcOccluded1(impl_->scene, &ray, &arguments);
#else
  rtcOccluded1(impl_->scene, &query, &ray);
#endif
  return ray.tfar < 0;
}

NearestHit RayScene::nearest(const Vector3f& point, float radius) const {
  NearestHit hit;
  NearestQuery search{&impl_->triangles,           &impl_->parts,
                      point.cast<double>(),        static_cast<double>(kTouching * impl_->largest),
                      static_cast<double>(radius), {}};
  RTCPointQuery query{point.x(), point.y(), point.z(), 0.0f, beyond(static_cast<double>(radius) + search.touching)};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(impl_->scene, &query, &context, visitTriangle, &search);
  auto& all = search.candidates;
  const auto before = [](const Candidate& a, const Candidate& b) {
    return a.distance < b.distance || (a.distance == b.distance && a.triangle < b.triangle);
  };
  const auto best = std::min_element(all.begin(), all.end(), before);
  if (best == all.end() || !(best->distance <= static_cast<double>(radius))) return hit;
  const Candidate nearest = *best;
  static_cast<SurfacePoint&>(hit) = impl_->surfacePoint(nearest.triangle, nearest.at);
  hit.t = static_cast<float>(nearest.distance);
  // All triangles that touch there, in the order of their numbers: sums depend on it.
  const auto apart = [&](const Candidate& c) { return !((c.foot - nearest.foot).norm() <= search.touching); };
  all.erase(std::remove_if(all.begin(), all.end(), apart), all.end());
  std::sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) { return a.triangle < b.triangle; });
  Vector3d flat = Vector3d::Zero(), smooth = Vector3d::Zero();
  for (const Candidate& c : all) {
    const double angle = angleAround(nearest.foot, impl_->triangles.all[c.triangle], search.touching);
    flat += angle * Impl::areaVector(impl_->triangles.all[c.triangle]).normalized();
    smooth += angle * impl_->surfacePoint(c.triangle, c.at).normal.cast<double>();
  }
  hit.signed_distance = flat.dot(search.point - nearest.foot) > 0 ? hit.t : -hit.t;
  // Where two closed meshes lie face to face the mean vanishes.
  if (all.size() > 1 && smooth.norm() > 1e-6) hit.normal = smooth.normalized().cast<float>();
  return hit;
}

const Object& RayScene::object(std::uint32_t number) const { return *impl_->objects[number]; }
bool RayScene::moving(std::uint32_t number) const { return number >= impl_->fixed.size(); }
std::uint32_t RayScene::objectCount() const { return static_cast<std::uint32_t>(impl_->objects.size()); }

}  // namespace fuse_flow::simulation
