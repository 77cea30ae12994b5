#pragma once

#include <fuse_flow/impl/sensors/depth_map.hpp>
#include <fuse_flow/impl/sensors/multipath_correction.hpp>
#include <fuse_flow/impl/sensors/rig_geometry.hpp>
#include <fuse_flow/sensors/preprocessing.h>

#include <pcl/filters/fast_bilateral.h>
#include <pcl/point_types.h>

#include <cmath>

namespace fuse_flow {
namespace host {

/** \brief Only what was measured fills, so that holes do not close from their rim inwards: until all are looked at, what
 *  was filled in is negative, which filledDepth() takes for a hole. */
inline void fillSmallHoles(const PreprocessingParameters& p, DepthMap& depth) {
  for (int v = 0; v < depth.height(); ++v) {
    const float *above = depth.row(v - 1), *below = depth.row(v + 1);
    float* here = depth.row(v);
    for (int u = 0; u < depth.width(); ++u) {
      if (here[u] > 0) continue;
      here[u] = -filledDepth(p, {above[u - 1], above[u], above[u + 1], here[u - 1], here[u], here[u + 1], below[u - 1],
                                 below[u], below[u + 1]});
    }
  }
  for (int v = 0; v < depth.height(); ++v)
    for (int u = 0; u < depth.width(); ++u) depth.row(v)[u] = std::abs(depth.row(v)[u]);
}

/** \brief Edge-preserving smoothing by PCL's filter, which works on the z of an organised cloud: of more than one row.
 *  The filter allocates the grid that it works on, and a copy, in each call. */
inline void smoothBilaterally(const PreprocessingParameters& p, DepthMap& depth) {
  if (depth.height() < 2) return;
  const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>(static_cast<std::uint32_t>(depth.width()),
                                                                      static_cast<std::uint32_t>(depth.height()));
  bool any = false;
  for (int v = 0; v < depth.height(); ++v)
    for (int u = 0; u < depth.width(); ++u) {
      const float z = depth.row(v)[u];
      pcl::PointXYZ& point = cloud->at(u, v);
      point.x = static_cast<float>(u);
      point.y = static_cast<float>(v);
      point.z = z > 0 ? z : std::numeric_limits<float>::quiet_NaN();
      any = any || z > 0;
    }
  if (!any) return;
  pcl::FastBilateralFilter<pcl::PointXYZ> filter;
  filter.setInputCloud(cloud);
  filter.setSigmaS(p.bilateral_sigma_s);
  filter.setSigmaR(p.bilateral_sigma_r);
  pcl::PointCloud<pcl::PointXYZ> smoothed;
  filter.filter(smoothed);
  for (int v = 0; v < depth.height(); ++v)
    for (int u = 0; u < depth.width(); ++u) {
      float& z = depth.row(v)[u];
      const float s = smoothed.at(u, v).z;
      if (z > 0 && std::isfinite(s) && s > 0) z = s;
    }
}

/** \brief Whether more is to be done to a view than row by row. */
inline bool needsWholeImage(const PreprocessingParameters& p, const ViewModel& view) {
  return p.fill_neighbours > 0 || p.bilateral || MultipathCorrection::wantedBy(view);
}

/** \brief What needs a whole image: multipath interference, filling and smoothing. */
inline void preprocessDepthMap(const PreprocessingParameters& p, const ViewGeometry& view,
                               MultipathCorrection& multipath, DepthMap& depth) {
  if (MultipathCorrection::wantedBy(view)) multipath.correct(view, depth);
  if (p.fill_neighbours > 0) fillSmallHoles(p, depth);
  if (p.bilateral) smoothBilaterally(p, depth);
}

/** \brief D^r of eq. 8 for one view. */
inline void makeDepthMap(const PreprocessingParameters& p, const ViewGeometry& geometry, const DepthView& view,
                         DepthMap& depth) {
  depth.resize(view.width(), view.height());
  for (int v = 0; v < view.height(); ++v)
    convertDepthRow(view, geometry.depth_scale, p.min_range, p.max_range, v, geometry.corrections(v), depth.row(v));
  MultipathCorrection multipath;
  preprocessDepthMap(p, geometry, multipath, depth);
}

}  // namespace host
}  // namespace fuse_flow
