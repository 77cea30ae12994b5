#include "viewer/fusing/point_attributes.h"

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/impl/sensors/frame_views.hpp>

#include <pcl/features/impl/integral_image_normal.hpp>
#include <pcl/features/integral_image_normal.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace fuse_flow::viewing {
namespace {

constexpr float kSameSurface = 0.05f;   // metres; as eq. 12 decides that a camera sees a point
constexpr std::size_t kSample = 10000;  // points that tell a mean well enough to look at

host::FrameViews viewsOf(const RigFrame& frame, int threads) {
  host::FrameViews views;
  views.assign(frame, PreprocessingParameters(), threads);
  return views;
}

/** \brief Normals in the camera's frame, or its negative: PCL turns them to the viewpoint, the camera. */
pcl::PointCloud<pcl::Normal> imageNormals(const host::FrameViews& views, std::size_t camera) {
  const auto surface = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  const auto& depth = views.depths[camera];
  surface->resize(static_cast<std::size_t>(depth.width()) * static_cast<std::size_t>(depth.height()));
  surface->width = static_cast<std::uint32_t>(depth.width());
  surface->height = static_cast<std::uint32_t>(depth.height());
  surface->is_dense = false;
  for (int v = 0; v < depth.height(); ++v)
    for (int u = 0; u < depth.width(); ++u) {
      const float z = depth.row(v)[u];
      const Vec3 p = pointOnRay(views.rig[camera].ray(u, v), z > 0 ? z : std::numeric_limits<float>::quiet_NaN());
      surface->at(u, v) = pcl::PointXYZ(p.x, p.y, p.z);
    }
  pcl::IntegralImageNormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setNormalEstimationMethod(estimation.AVERAGE_3D_GRADIENT);
  estimation.setMaxDepthChangeFactor(0.03f);
  estimation.setNormalSmoothingSize(10.0f);
  estimation.setInputCloud(surface);
  pcl::PointCloud<pcl::Normal> normals;
  estimation.compute(normals);
  return normals;
}

}  // namespace

std::vector<Origin> originsOf(const Cloud& cloud, const RigFrame& frame, int threads) {
  const host::FrameViews views = viewsOf(frame, threads);
  std::vector<Origin> origins(cloud.size());
  host::parallelForEach(threads, cloud.size(), [&](std::size_t k) {
    const Vec3 p{cloud[k].x, cloud[k].y, cloud[k].z};
    float nearest = kSameSurface;
    for (std::size_t j = 0; j < views.depths.size(); ++j) {
      int u = 0, v = 0;
      float z = 0;
      if (views.depths[j].empty() || !views.rig[j].locate(p, u, v, z)) continue;
      const float D = views.depths[j].row(v)[u];
      if (!(D > 0) || !(std::fabs(z - D) < nearest)) continue;
      nearest = std::fabs(z - D);
      origins[k] = {static_cast<std::uint32_t>(j), u, v};
    }
  });
  return origins;
}

std::vector<Eigen::Vector3f> normalsOf(const std::vector<Origin>& origins, const RigFrame& frame, int threads) {
  const host::FrameViews views = viewsOf(frame, threads);
  std::vector<pcl::PointCloud<pcl::Normal>> images(views.depths.size());
  host::parallelFor(threads, images.size(), [&](std::size_t j, int) {
    if (!views.depths[j].empty()) images[j] = imageNormals(views, j);
  });
  std::vector<Eigen::Vector3f> normals(origins.size(), Eigen::Vector3f::Zero());
  host::parallelForEach(threads, origins.size(), [&](std::size_t k) {
    const Origin& origin = origins[k];
    if (origin.camera == Origin::kNone) return;
    const pcl::Normal& n = images[origin.camera].at(origin.u, origin.v);
    if (!std::isfinite(n.normal_x)) return;
    const Vec3 turned = rotate(views.rig[origin.camera].T_world_camera, Vec3{n.normal_x, n.normal_y, n.normal_z});
    normals[k] = Eigen::Vector3f(turned.x, turned.y, turned.z);
  });
  return normals;
}

std::vector<float> truthDistances(const Cloud& cloud, const simulation::RayScene& scene, int threads) {
  std::vector<float> distances(cloud.size());
  host::parallelForEach(threads, cloud.size(),
                        [&](std::size_t k) { distances[k] = scene.nearest(cloud[k].getVector3fMap(), 1.0f).t; });
  return distances;
}

double meanTruthDistance(const Cloud& cloud, const simulation::RayScene& scene, int threads) {
  const std::size_t step = (cloud.size() + kSample - 1) / kSample;
  Cloud sample;
  for (std::size_t k = 0; k < cloud.size(); k += step) sample.push_back(cloud[k]);
  double sum = 0, count = 0;
  for (const float distance : truthDistances(sample, scene, threads)) {
    if (!std::isfinite(distance)) continue;
    sum += static_cast<double>(distance);
    ++count;
  }
  return sum / count;
}

}  // namespace fuse_flow::viewing
