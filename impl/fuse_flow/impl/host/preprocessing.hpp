#pragma once

#include <fuse_flow/impl/host/depth_map.hpp>
#include <fuse_flow/preprocessing.h>

#include <pcl/filters/fast_bilateral.h>
#include <pcl/point_types.h>

namespace fuse_flow {
namespace host {

/** \brief Reads the raw depth only, so that holes do not close from their rim inwards. \param raw scratch of the caller */
inline void fillSmallHoles(const PreprocessingParameters& p, DepthMap& depth, DepthMap& raw) {
  raw = depth;
  for (int v = 0; v < depth.height(); ++v)
    for (int u = 0; u < depth.width(); ++u) {
      if (raw.row(v)[u] > 0) continue;
      const float *above = raw.row(v - 1) + u, *here = raw.row(v) + u, *below = raw.row(v + 1) + u;
      depth.row(v)[u] =
          filledDepth(p, {above[-1], above[0], above[1], here[-1], here[0], here[1], below[-1], below[0], below[1]});
    }
}

/** \brief Edge-preserving smoothing by PCL's filter, which works on the z of an organised cloud: of more than one row. */
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

/** \brief What needs a whole image: filling and smoothing. */
inline void preprocessDepthMap(const PreprocessingParameters& p, DepthMap& depth) {
  DepthMap raw;
  if (p.fill_neighbours > 0) fillSmallHoles(p, depth, raw);
  if (p.bilateral) smoothBilaterally(p, depth);
}

/** \brief D^r of eq. 8 for one view. */
inline void makeDepthMap(const PreprocessingParameters& p, const DepthView& view, DepthMap& depth) {
  depth.resize(view.width(), view.height());
  for (int v = 0; v < view.height(); ++v) convertDepthRow(view, p.min_range, p.max_range, v, depth.row(v));
  preprocessDepthMap(p, depth);
}

}  // namespace host
}  // namespace fuse_flow
