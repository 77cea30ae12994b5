#include "evaluation/truth_quality.h"

#include "simulation/portable_math.h"
#include "simulation/random.h"
#include "simulation/sensor.h"

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/impl/quality/point_index.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector3f;

constexpr float kGhost = 0.03f;

/** \brief Points spread evenly over a mesh, about one for every spacing². */
void sampleMesh(const TriangleMesh& mesh, std::uint32_t number, float spacing, std::vector<SurfacePoint>& samples) {
  double due = 0.5;  // what is left of a sample is carried over to the next triangle
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    const auto& t = mesh.triangles[k];
    const Vector3f &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vector3f normal = (b - a).cross(c - a);
    due += 0.5 * static_cast<double>(normal.norm()) / (static_cast<double>(spacing) * static_cast<double>(spacing));
    Random random(1, number, k, 0);
    for (; due >= 1; due -= 1) {
      float u = static_cast<float>(random.uniform()), v = static_cast<float>(random.uniform());
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      SurfacePoint point;
      point.position = a + u * (b - a) + v * (c - a);
      point.normal = normal.normalized();
      if (!mesh.velocities.empty()) {
        const Vector3f &va = mesh.velocities[t[0]], &vb = mesh.velocities[t[1]], &vc = mesh.velocities[t[2]];
        point.velocity = va + u * (vb - va) + v * (vc - va);
      }
      point.object = number;
      samples.push_back(point);
    }
  }
}

/** \brief The nearest of points, where one is near enough. */
class NearestPoint {
 public:
  explicit NearestPoint(const std::vector<Vector3f>& points) : index_(toVec3(points), 0.01f) {}

  /** \brief Distance to the nearest point, metres; infinite if none is within reach. */
  float operator()(const Vector3f& p, float reach, std::size_t* number = nullptr) const {
    const auto found = index_.nearest({p.x(), p.y(), p.z()}, reach);
    if (!found) return std::numeric_limits<float>::infinity();
    if (number != nullptr) *number = found->number;
    return std::sqrt(found->squared_distance);
  }

 private:
  static std::vector<Vec3> toVec3(const std::vector<Vector3f>& points) {
    std::vector<Vec3> result;
    result.reserve(points.size());
    for (const Vector3f& p : points) result.push_back({p.x(), p.y(), p.z()});
    return result;
  }

  detail::PointIndex index_;
};

double meanOf(const std::vector<float>& values, const std::vector<float>& distances) {
  double sum = 0;
  std::size_t n = 0;
  for (std::size_t k = 0; k < values.size(); ++k)
    if (distances[k] <= kGhost) sum += static_cast<double>(values[k]), ++n;
  return n > 0 ? sum / static_cast<double>(n) : TruthQuality::kUnknown;
}

double shareUnder(const std::vector<float>& distances, float limit) {
  const auto n = std::count_if(distances.begin(), distances.end(), [limit](float d) { return d <= limit; });
  return distances.empty() ? TruthQuality::kUnknown : static_cast<double>(n) / static_cast<double>(distances.size());
}

double harmonicMean(double a, double b) { return a + b > 0 ? 2 * a * b / (a + b) : 0; }

void summarise(std::vector<float> distances, TruthQuality& quality) {
  if (distances.empty()) return;
  std::sort(distances.begin(), distances.end());
  double sum = 0;
  for (const float d : distances) sum += static_cast<double>(d);
  const auto at = [&](double share) {
    return 1e3 *
           static_cast<double>(distances[static_cast<std::size_t>(share * static_cast<double>(distances.size() - 1))]);
  };
  quality.accuracy_mean = 1e3 * sum / static_cast<double>(distances.size());
  quality.accuracy_median = at(0.5);
  quality.accuracy_p95 = at(0.95);
  quality.precision_5 = shareUnder(distances, 0.005f);
  quality.precision_10 = shareUnder(distances, 0.010f);
  quality.ghosting = 1 - shareUnder(distances, kGhost);
}

/** \brief Where a field of a cloud's points lies; none: -1. */
int offsetOf(const pcl::PCLPointCloud2& cloud, const std::string& name) {
  for (const pcl::PCLPointField& field : cloud.fields)
    if (field.name == name) return static_cast<int>(field.offset);
  return -1;
}

}  // namespace

PlainCloud plainCloud(const pcl::PCLPointCloud2& cloud) {
  PlainCloud plain;
  const auto number = [&](std::size_t point, int offset) {
    float value;
    std::memcpy(&value, &cloud.data[point * cloud.point_step + static_cast<std::size_t>(offset)], sizeof(value));
    return value;
  };
  const int x = offsetOf(cloud, "x"), y = offsetOf(cloud, "y"), z = offsetOf(cloud, "z");
  const int nx = offsetOf(cloud, "normal_x"), ny = offsetOf(cloud, "normal_y"), nz = offsetOf(cloud, "normal_z");
  const int color = std::max(offsetOf(cloud, "rgb"), offsetOf(cloud, "rgba"));
  const std::size_t count = x < 0 || y < 0 || z < 0 ? 0 : static_cast<std::size_t>(cloud.width) * cloud.height;
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3f p(number(k, x), number(k, y), number(k, z));
    if (!p.allFinite()) continue;
    plain.positions.push_back(p);
    if (nx >= 0 && ny >= 0 && nz >= 0) plain.normals.emplace_back(number(k, nx), number(k, ny), number(k, nz));
    if (color < 0) continue;
    const std::uint8_t* bgr = &cloud.data[k * cloud.point_step + static_cast<std::size_t>(color)];
    plain.colors.emplace_back(bgr[2], bgr[1], bgr[0]);
  }
  return plain;
}

std::vector<SurfacePoint> visibleSurface(const RayScene& scene, const std::vector<Camera>& cameras,
                                         const std::vector<bool>& present, const Visibility& visibility, int threads) {
  std::vector<SurfacePoint> samples;
  for (std::uint32_t k = 0; k < scene.objectCount(); ++k)
    sampleMesh(scene.object(k).mesh, k, visibility.spacing, samples);
  const TrueCameras views(cameras, present, visibility);
  std::vector<std::uint8_t> visible(samples.size());
  host::parallelForEach(threads, samples.size(),
                        [&](std::size_t k) { visible[k] = views.anySees(scene, samples[k]) ? 1 : 0; });
  std::size_t kept = 0;
  for (std::size_t k = 0; k < samples.size(); ++k)
    if (visible[k]) samples[kept++] = samples[k];
  samples.resize(kept);
  return samples;
}

TruthQuality compareWithTruth(const PlainCloud& cloud, const RayScene& scene, const std::vector<SurfacePoint>& visible,
                              int threads, TruthMatches* matches) {
  TruthQuality quality;
  const std::size_t n = cloud.positions.size();
  quality.points = n;
  quality.surface_samples = visible.size();
  std::vector<float> distances(n), angles(cloud.normals.size()), colors(cloud.colors.size());
  TruthMatches found;
  found.surface.resize(n);
  found.gaps.resize(visible.size());
  host::parallelForEach(threads, n, [&](std::size_t k) {
    const NearestHit& hit = found.surface[k] = scene.nearest(cloud.positions[k]);
    distances[k] = hit.t;
    if (!hit) return;
    if (!angles.empty()) {
      const float cosine = std::clamp(cloud.normals[k].dot(hit.normal), -1.0f, 1.0f);
      angles[k] = portable::acos(cosine) * 57.29578f;
    }
    if (!colors.empty()) {
      const Vector3f truth = litColor(scene.object(hit.object).material, hit.normal, hit.rest);
      colors[k] = (cloud.colors[k] - truth).cwiseAbs().mean();
    }
  });
  summarise(distances, quality);
  quality.normal_error = meanOf(angles, distances);
  quality.color_error = meanOf(colors, distances);
  const NearestPoint nearest(cloud.positions);
  host::parallelForEach(threads, visible.size(),
                        [&](std::size_t k) { found.gaps[k] = nearest(visible[k].position, 0.010f); });
  quality.completeness_5 = shareUnder(found.gaps, 0.005f);
  quality.completeness_10 = shareUnder(found.gaps, 0.010f);
  quality.f_score_5 = harmonicMean(quality.precision_5, quality.completeness_5);
  quality.f_score_10 = harmonicMean(quality.precision_10, quality.completeness_10);
  if (matches != nullptr) *matches = std::move(found);
  return quality;
}

namespace {

/** \brief The points of a cloud beside fixed surfaces: where on the surface each stands, and how far in front of it. */
struct Heights {
  std::vector<Vector3f> feet;
  std::vector<float> heights;
};

Heights heightsOver(const RayScene& scene, const PlainCloud& cloud, int threads) {
  std::vector<RayHit> hits(cloud.positions.size());
  host::parallelForEach(threads, hits.size(),
                        [&](std::size_t k) { hits[k] = scene.nearest(cloud.positions[k], kGhost); });
  Heights result;
  for (std::size_t k = 0; k < hits.size(); ++k) {
    if (!hits[k] || scene.moving(hits[k].object)) continue;
    result.feet.push_back(hits[k].position);
    result.heights.push_back(hits[k].normal.dot(cloud.positions[k] - hits[k].position));
  }
  return result;
}

}  // namespace

double flicker(const PlainCloud& before, const PlainCloud& after, const RayScene& scene, int threads) {
  double sum = 0;
  std::size_t n = 0;
  const auto oneWay = [&](const Heights& from, const Heights& to) {
    // Beside each other on the surface: the nearest point in space would be one of much the same height.
    const NearestPoint nearest(to.feet);
    std::vector<float> change(from.feet.size());
    host::parallelForEach(threads, change.size(), [&](std::size_t k) {
      std::size_t other = 0;
      const bool there = nearest(from.feet[k], kGhost, &other) <= kGhost;
      change[k] = there ? std::min(std::fabs(from.heights[k] - to.heights[other]), kGhost) : kGhost;
    });
    for (const float d : change) sum += static_cast<double>(d);
    n += change.size();
  };
  const Heights heights_before = heightsOver(scene, before, threads),
                heights_after = heightsOver(scene, after, threads);
  oneWay(heights_before, heights_after);
  oneWay(heights_after, heights_before);
  return n > 0 ? 1e3 * sum / static_cast<double>(n) : TruthQuality::kUnknown;
}

}  // namespace fuse_flow::simulation
