#pragma once

#include <fuse_flow/impl/parameters.hpp>
#include <fuse_flow/impl/quality/local_frame.hpp>
#include <fuse_flow/impl/quality/point_index.hpp>
#include <fuse_flow/impl/sensors/frame_views.hpp>
#include <fuse_flow/quality/reprojection_quality.h>

#include <limits>

namespace fuse_flow {
namespace detail {

/** \brief What all views say about one fused point. */
struct PointAgreement {
  int views{0};
  bool violates{false};
  double mean_error{0};
};

inline PointAgreement pointAgreement(const Vec3& p, const host::FrameViews& views, float visibility) {
  PointAgreement result;
  for (std::size_t j = 0; j < views.depths.size(); ++j) {
    if (views.depths[j].empty()) continue;
    int u = 0, v = 0;
    float z = 0;
    if (!views.rig[j].locate(p, u, v, z)) continue;
    const float D = views.depths[j].row(v)[u];
    if (!(D > 0)) continue;
    if (z < D - visibility) result.violates = true;
    if (std::fabs(z - D) >= visibility) continue;
    result.mean_error += static_cast<double>(std::fabs(z - D));
    ++result.views;
  }
  if (result.views > 0) result.mean_error /= result.views;
  return result;
}

}  // namespace detail

inline void checkParameters(const ReprojectionQualityParameters& p) {
  constexpr const char* owner = "fuse_flow::reprojectionQuality";
  detail::checkLength(owner, "visibility", p.visibility);
  detail::checkLength(owner, "coverage_radius", p.coverage_radius);
  detail::checkRange(owner, "coverage_step", p.coverage_step, 1, 1 << 16);
  detail::checkMeasuringRange(owner, p.min_range, p.max_range);
}

template <typename PointT>
ReprojectionQuality reprojectionQuality(const pcl::PointCloud<PointT>& cloud, const RigFrame& frame,
                                        const ReprojectionQualityParameters& parameters, unsigned int threads) {
  checkRigFrame(frame);
  checkParameters(parameters);
  const int resolved = host::resolveThreads(static_cast<int>(threads));
  PreprocessingParameters raw;
  raw.min_range = parameters.min_range;
  raw.max_range = parameters.max_range;
  const Eigen::Vector3d origin = detail::middleOf(frame);
  host::FrameViews views;
  views.assign(detail::movedTo(origin, frame), raw, resolved);
  const std::vector<Vec3> points = detail::pointsFrom(origin, cloud);

  ReprojectionQuality quality;
  quality.points = cloud.size();
  double sum = 0, multi_view_sum = 0;
  for (const Vec3& point : points) {
    const detail::PointAgreement agreement = detail::pointAgreement(point, views, parameters.visibility);
    quality.violating_points += agreement.violates ? 1 : 0;
    if (agreement.views > 0) {
      ++quality.seen_points;
      sum += agreement.mean_error;
    }
    if (agreement.views > 1) {
      ++quality.multi_view_points;
      multi_view_sum += agreement.mean_error;
    }
  }
  const auto mean = [](double total, std::size_t n) {
    return n > 0 ? total / static_cast<double>(n) : std::numeric_limits<double>::quiet_NaN();
  };
  quality.error = mean(sum, quality.seen_points);
  quality.multi_view_error = mean(multi_view_sum, quality.multi_view_points);

  const detail::PointIndex index(points, parameters.coverage_radius);
  std::vector<ReprojectionQuality> per_view(views.depths.size());
  const int step = parameters.coverage_step;
  host::parallelFor(resolved, views.depths.size(), [&](std::size_t j, int) {
    ReprojectionQuality counts;
    for (int v = 0; v < views.depths[j].height(); v += step)
      for (int u = 0; u < views.depths[j].width(); u += step) {
        const float z = views.depths[j].row(v)[u];
        if (!(z > 0)) continue;
        ++counts.pixels;
        const Vec3 p = views.rig[j].T_world_camera * pointOnRay(views.rig[j].ray(u, v), z);
        counts.covered_pixels += index.anyWithin(p, parameters.coverage_radius) ? 1 : 0;
      }
    per_view[j] = counts;
  });
  for (const ReprojectionQuality& counts : per_view) {
    quality.pixels += counts.pixels;
    quality.covered_pixels += counts.covered_pixels;
  }
  return quality;
}

}  // namespace fuse_flow
