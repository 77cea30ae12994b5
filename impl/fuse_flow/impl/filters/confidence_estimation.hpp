#pragma once

#include <fuse_flow/filters/confidence_estimation.h>
#include <fuse_flow/impl/filters/index_filter.hpp>
#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/impl/parameters.hpp>
#include <fuse_flow/impl/sensors/depth_map.hpp>
#include <fuse_flow/point_traits.h>

namespace fuse_flow {

template <typename PointT>
void ConfidenceEstimation<PointT, device::Host>::setParameters(const ConfidenceParameters& parameters) {
  checkParameters(parameters);
  if (parameters.form == ConfidenceForm::Given)
    detail::throwBadArgument(
        "fuse_flow::ConfidenceEstimation: form is Given, which is FuseFlow's: a cloud has no DepthView::confidence");
  parameters_ = parameters;
}

template <typename PointT>
void ConfidenceEstimation<PointT, device::Host>::setFocalLength(float pixels) {
  detail::checkPositive("fuse_flow::ConfidenceEstimation", "focal length", pixels);
  focal_length_ = pixels;
}

template <typename PointT>
void ConfidenceEstimation<PointT, device::Host>::computeConfidence(const host::DepthMap& depth, float* C) {
  const auto width = static_cast<std::size_t>(depth.width());
  host::parallelFor(host::resolveThreads(threads_), static_cast<std::size_t>(depth.height()), [&](std::size_t v, int) {
    host::confidenceRow(parameters_, depth, 1.0f / focal_length_, viewNoise(parameters_, nullptr), static_cast<int>(v),
                        C + v * width);
  });
}

template <typename PointT>
template <typename Cloud>
void ConfidenceEstimation<PointT, device::Host>::checkOrganized(const Cloud& cloud) {
  if (!cloud.isOrganized() && !cloud.empty())
    throw pcl::UnorganizedPointCloudException("fuse_flow::ConfidenceEstimation: the input cloud is " +
                                              std::to_string(cloud.width) + "x" + std::to_string(cloud.height) +
                                              ", must be organised");
}

template <typename PointT>
void ConfidenceEstimation<PointT, device::Host>::applyFilter(pcl::Indices& indices) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::ConfidenceEstimation");
  checkOrganized(*input_);
  const int width = static_cast<int>(input_->width);
  const int height = input_->empty() ? 0 : static_cast<int>(input_->height);
  const Vec3 origin{input_->sensor_origin_.x(), input_->sensor_origin_.y(), input_->sensor_origin_.z()};
  const Eigen::Vector3f z_axis = input_->sensor_orientation_ * Eigen::Vector3f::UnitZ();
  const Vec3 axis{z_axis.x(), z_axis.y(), z_axis.z()};
  const int threads = host::resolveThreads(threads_);
  const std::size_t rows = static_cast<std::size_t>(height);

  host::DepthMap depth;
  depth.resize(width, height);
  confidence_.resize(input_->size());
  host::parallelFor(threads, rows, [&](std::size_t v, int) {
    float* z = depth.row(static_cast<int>(v));
    const PointT* points = input_->points.data() + v * input_->width;
    for (int u = 0; u < width; ++u) {
      const Vec3 p{points[u].x, points[u].y, points[u].z};
      const float along = isFinite(p) ? dot(axis, p - origin) : 0.0f;
      z[u] = along > 0 ? along : 0.0f;
    }
  });
  computeConfidence(depth, confidence_.data());
  const auto C = [this](pcl::index_t index) { return confidence_[static_cast<std::size_t>(index)]; };
  detail::splitIndices(
      *indices_, this->negative_, this->extract_removed_indices_, indices, *removed_indices_,
      [&](pcl::index_t index) { return C(index) > 0; },
      [&](pcl::index_t index) { return C(index) > parameters_.threshold; });
}

template <typename PointT>
void ConfidenceEstimation<PointT, device::Host>::applyFilter(PointCloud& output) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::ConfidenceEstimation");
  if constexpr (!point::has_confidence<PointT>) {
    pcl::FilterIndices<PointT>::applyFilter(output);
  } else {
    const bool keep_organized = this->keep_organized_;
    if (keep_organized) {
      pcl::FilterIndices<PointT>::applyFilter(output);
      for (std::size_t i = 0; i < output.size(); ++i) point::setConfidence(output[i], confidence_[i]);
    } else {
      pcl::Indices indices;
      applyFilter(indices);
      output.is_dense = true;
      pcl::copyPointCloud(*input_, indices, output);
      for (std::size_t i = 0; i < output.size(); ++i)
        point::setConfidence(output[i], confidence_[detail::copiedFrom(indices, input_->size(), i)]);
    }
  }
}

}  // namespace fuse_flow
