#pragma once

#include <fuse_flow/filters/depth_backprojection.h>
#include <fuse_flow/impl/fusion/color_depth_map.hpp>
#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/impl/parameters.hpp>
#include <fuse_flow/impl/sensors/preprocessing.hpp>
#include <fuse_flow/impl/sensors/rig_geometry.hpp>
#include <fuse_flow/point_traits.h>

#include <pcl/impl/pcl_base.hpp>  // PCL compiles its base classes for its own point types only

namespace fuse_flow {
namespace detail {

/** \brief Depth row by row, as the maths of surfaces asks for it. */
struct DepthOfPixels {
  const float* z;
  const host::ViewGeometry& view;

  float depth(int u, int v) const { return z[static_cast<std::ptrdiff_t>(v) * view.intrinsics.width + u]; }
  Ray ray(int u, int v) const { return view.ray(u, v); }
};

}  // namespace detail

template <typename PointT>
void DepthBackprojection<PointT, device::Host>::setCamera(const Camera& camera) {
  checkCamera(camera);
  camera_ = camera;
}

template <typename PointT>
void DepthBackprojection<PointT, device::Host>::setView(const DepthView& view) {
  view_ = view;
  // What pcl::PCLBase wants to see before it filters: without points, but of the size that it checks blocks of indices by.
  const auto size = std::make_shared<PointCloud>();
  size->width = static_cast<std::uint32_t>(view.width());
  size->height = static_cast<std::uint32_t>(view.height());
  input_ = size;
}

template <typename PointT>
void DepthBackprojection<PointT, device::Host>::setInputCloud(const typename PointCloud::ConstPtr& cloud) {
  view_ = {};
  pcl::Filter<PointT>::setInputCloud(cloud);
}

template <typename PointT>
void DepthBackprojection<PointT, device::Host>::setParameters(const PreprocessingParameters& parameters) {
  checkParameters(parameters);
  parameters_ = parameters;
}

template <typename PointT>
void DepthBackprojection<PointT, device::Host>::computePoints(const DepthView& view, float* z, Vec3* points) {
  host::DepthMap depth;
  host::ViewGeometry geometry;
  geometry.assign(camera_);
  host::makeDepthMap(parameters_, geometry, view, depth);
  const int width = depth.width();
  host::parallelFor(host::resolveThreads(threads_), static_cast<std::size_t>(depth.height()),
                    [&](std::size_t row, int) {
                      const int v = static_cast<int>(row);
                      for (int u = 0; u < width; ++u) {
                        const std::size_t index = row * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
                        z[index] = depth.row(v)[u];
                        if (z[index] > 0)
                          points[index] = geometry.T_world_camera * pointOnRay(geometry.ray(u, v), z[index]);
                      }
                    });
}

template <typename PointT>
void DepthBackprojection<PointT, device::Host>::applyFilter(PointCloud& output) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::DepthBackprojection");
  checkCamera(camera_);
  const Intrinsics& K = camera_.intrinsics;
  const int width = K.width;
  const std::size_t size = static_cast<std::size_t>(K.width) * static_cast<std::size_t>(K.height);
  const bool from_cloud = view_.missing();
  std::vector<float> z_of_cloud;
  DepthView depth_view = view_;
  if (from_cloud) {
    if (static_cast<int>(input_->width) != K.width || static_cast<int>(input_->height) != K.height)
      detail::throwBadArgument("fuse_flow::DepthBackprojection: the input cloud is ", input_->width, "x",
                               input_->height, ", camera '", camera_.name, "' is ", K.width, "x", K.height);
    z_of_cloud.reserve(size);
    for (const PointT& point : *input_) z_of_cloud.push_back(point.z);
    depth_view.depth32 = {z_of_cloud.data(), K.width, K.height};
  } else {
    detail::checkView(camera_, view_);
  }
  std::vector<float> depth(size);
  std::vector<Vec3> points(size);
  computePoints(depth_view, depth.data(), points.data());

  // Without setIndices() PCL makes up indices of its own: all pixels then.
  std::vector<std::uint8_t> wanted(size, this->fake_indices_ ? 1 : 0);
  if (!this->fake_indices_)
    for (const pcl::index_t index : *indices_)
      if (index >= 0 && static_cast<std::size_t>(index) < size) wanted[static_cast<std::size_t>(index)] = 1;

  host::ViewGeometry geometry;
  geometry.assign(camera_);
  host::ColorDepthMap color_depth;
  if (point::shows_color<PointT> && !from_cloud && view_.color && geometry.own_color_camera)
    color_depth.assign(geometry, detail::DepthOfPixels{depth.data(), geometry});
  PointCloud result(static_cast<std::uint32_t>(K.width), static_cast<std::uint32_t>(K.height));
  std::vector<std::uint8_t> missing(size, 0);
  host::parallelFor(host::resolveThreads(threads_), static_cast<std::size_t>(K.height), [&](std::size_t row, int) {
    const int v = static_cast<int>(row);
    const float* z = depth.data() + row * static_cast<std::size_t>(width);
    for (int u = 0; u < width; ++u) {
      const std::size_t index = row * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
      PointT& point = result[index];
      if (from_cloud) {
        point = (*input_)[index];
        point::setNormal(point, rotate(geometry.T_world_camera, point::getNormal(point)));
      }
      if (!(z[u] > 0) || !wanted[index]) {
        missing[index] = 1;
        point::setPosition(point, {user_filter_value_, user_filter_value_, user_filter_value_});
        continue;
      }
      point::setPosition(point, points[index]);
      if (from_cloud) continue;
      point::setConfidence(point, view_.confidence ? givenConfidence(view_.confidence.row(v)[u]) : 1.0f);
      if constexpr (point::shows_color<PointT>)
        if (view_.color) {
          const Vec3 rgb = viewColor(geometry, view_.color, color_depth.cells(), u, v, geometry.ray(u, v), z[u]).rgb;
          point::setColor(point, rgb);
          point::setIntensity(point, luminance(rgb));
        }
    }
  });
  removed_indices_->clear();
  bool any_missing = false;
  for (std::size_t index = 0; index < size; ++index) {
    if (!missing[index]) continue;
    any_missing = true;
    if (this->extract_removed_indices_ && wanted[index]) removed_indices_->push_back(static_cast<pcl::index_t>(index));
  }
  result.is_dense = !any_missing || std::isfinite(user_filter_value_);
  result.header = input_->header;
  output = std::move(result);
  output.sensor_origin_ << camera_.T_world_camera.translation().template cast<float>(), 0.0f;
  output.sensor_orientation_ = Eigen::Quaternionf(camera_.T_world_camera.linear().template cast<float>());
}

}  // namespace fuse_flow
