#pragma once

#include <fuse_flow/filters/confidence_estimation.h>
#include <fuse_flow/gpu/filters/cloud_selection.h>
#include <fuse_flow/gpu/filters/device_filter.h>

#include <cstring>

namespace fuse_flow {
namespace gpu {

/** \brief Eq. 3 for each pixel of one depth map. */
struct EstimateConfidence {
  const DeviceView* view;
  ConfidenceParameters parameters;
  const float* z;
  float* C;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const std::uint32_t v = index / view->pitch;
    const std::uint32_t u = index - v * view->pitch;
    DepthPatch patch;
    readPatch({view, z}, static_cast<int>(u), static_cast<int>(v), index, 1, patch.z);
    const float c = parameters.form == ConfidenceForm::Published
                        ? confidencePublished(parameters, patch)
                        : confidenceSlopeCompensated(parameters, patch, view->slope);
    C[index] = patch.z[4] > 0 ? c : 0.0f;
  }
};

/** \brief The depth of each point of an organised cloud, along the camera's axis; 0 where there is none. */
template <typename Layout>
struct DepthOfPoints {
  const typename Layout::Words* points;
  Vec3 origin, axis;
  float* z;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const Vec3 p = Layout::position(points[index]);
    const float along = isFinite(p) ? dot(axis, p - origin) : 0.0f;
    z[index] = along > 0 ? along : 0.0f;
  }
};

/** \brief C > τ, or not. */
struct KeepConfident {
  PointList list;
  const float* C;
  float threshold;
  bool negative;
  std::uint8_t* keep;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const std::uint32_t index = list[k];
    keep[index] = C[index] > 0 && (C[index] > threshold) != negative;
  }
};

}  // namespace gpu

/** \brief On the GPU, for clouds in host memory or on the device. \copydetails ConfidenceEstimation */
template <typename PointT>
class ConfidenceEstimation<PointT, device::Thrust> : public ConfidenceEstimation<PointT, device::Host> {
 public:
  ///@{
  /** \brief As in every PCL filter. */
  using Ptr = pcl::shared_ptr<ConfidenceEstimation>;
  using ConstPtr = pcl::shared_ptr<const ConfidenceEstimation>;
  ///@}

  /** \copydoc ConfidenceEstimation<PointT, device::Host>::ConfidenceEstimation
   *  \throws pcl::PCLException if there is no GPU */
  explicit ConfidenceEstimation(bool extract_removed_indices = false)
      : ConfidenceEstimation<PointT, device::Host>(extract_removed_indices),
        device_("fuse_flow::ConfidenceEstimation") {}

  /** \brief The CUDA stream that it runs on; default the default stream. */
  void setStream(gpu::Stream stream) { device_.run.stream = stream; }

  using DeviceCloud = gpu::DeviceCloud<PointT>;
  using ConfidenceEstimation<PointT, device::Host>::setInputCloud;
  using ConfidenceEstimation<PointT, device::Host>::filter;

  /** \brief The cloud that filter(DeviceCloud&) reads; organised. */
  void setInputCloud(const typename DeviceCloud::ConstPtr& cloud) { device_input_ = cloud; }

  /** \brief As filter() of a cloud in host memory, with setIndices() and all that pcl::FilterIndices offers, and nothing
   *  copied over the bus but the number of points. getConfidence() stays as it was: see deviceConfidence(). \param output
   *  its memory is exchanged for memory of the filter; may be the input
   *  \throws pcl::UnorganizedPointCloudException for a cloud that is not organised */
  void filter(DeviceCloud& output) {
    const detail::OneThread::Inside inside(this->one_thread_, "fuse_flow::ConfidenceEstimation");
    const gpu::DeviceFilter::Visit visit(device_);
    const DeviceCloud& input = gpu::DeviceFilter::inputOf("fuse_flow::ConfidenceEstimation", device_input_);
    this->checkOrganized(input);
    gpu::Execution& run = device_.run;
    selection_.list(run, input, this->use_indices_ ? this->getIndices() : nullptr);
    const Vec3 origin{input.sensor_origin_.x(), input.sensor_origin_.y(), input.sensor_origin_.z()};
    const Eigen::Vector3f axis = input.sensor_orientation_ * Eigen::Vector3f::UnitZ();
    z_.resize(input.size());
    run.forEach(input.size(), gpu::DepthOfPoints<gpu::PointLayout<PointT>>{
                                  input.words(), origin, {axis.x(), axis.y(), axis.z()}, z_.data()});
    estimate(static_cast<int>(input.width), static_cast<int>(input.height));
    run.forEach(selection_.size(), gpu::KeepConfident{selection_.points(), C_.data(), this->getParameters().threshold,
                                                      this->negative_, selection_.keep(run, input.size())});
    selection_.apply(run, {this->keep_organized_, this->user_filter_value_, this->extract_removed_indices_},
                     {gpu::ConfidenceField::Change::Set, C_.data()}, input, result_, *this->removed_indices_);
    std::swap(output, result_);
  }

  /** \brief C of every pixel of the input of the last filter(DeviceCloud&), row by row, in device memory. */
  const float* deviceConfidence() const { return C_.data(); }

 protected:
  void computeConfidence(const host::DepthMap& depth, float* C) override {
    const gpu::DeviceFilter::Visit visit(device_);
    const auto width = static_cast<std::size_t>(depth.width()), height = static_cast<std::size_t>(depth.height());
    rows_.resize(width * height);
    for (std::size_t v = 0; v < height; ++v)
      std::memcpy(rows_.data() + v * width, depth.row(static_cast<int>(v)), width * sizeof(float));
    device_.upload(rows_.data(), width * height, z_);
    estimate(depth.width(), depth.height());
    device_.download(C_, width * height, C);
  }

 private:
  /** \brief C_ from z_. */
  void estimate(int width, int height) {
    const std::size_t size = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    C_.resize(size);
    if (size == 0) return;
    gpu::DeviceView view;
    view.model.intrinsics.width = width;
    view.model.intrinsics.height = height;
    view.pitch = static_cast<std::uint32_t>(width);
    view.slope =
        slopeScale(this->getParameters(), 1.0f / this->getFocalLength(), viewNoise(this->getParameters(), nullptr));
    device_.upload(&view, 1, view_);
    device_.run.forEach(size, gpu::EstimateConfidence{view_.data(), this->getParameters(), z_.data(), C_.data()});
  }

  gpu::DeviceFilter device_;
  std::vector<float> rows_;
  gpu::DeviceBuffer<gpu::DeviceView> view_;
  gpu::DeviceBuffer<float> z_, C_;
  typename DeviceCloud::ConstPtr device_input_;
  gpu::CloudSelection<PointT> selection_;
  DeviceCloud result_;
};

}  // namespace fuse_flow
