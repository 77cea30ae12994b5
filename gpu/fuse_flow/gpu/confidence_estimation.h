#pragma once

#include <fuse_flow/confidence_estimation.h>
#include <fuse_flow/gpu/device_filter.h>

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

}  // namespace gpu

/** \brief On the GPU, for clouds in host memory. \copydetails ConfidenceEstimation */
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

 protected:
  void computeConfidence(const host::DepthMap& depth, float* C) override {
    const auto width = static_cast<std::size_t>(depth.width()), height = static_cast<std::size_t>(depth.height());
    if (width * height == 0) return;
    gpu::DeviceView view;
    view.model.intrinsics.width = depth.width();
    view.model.intrinsics.height = depth.height();
    view.pitch = static_cast<std::uint32_t>(width);
    view.slope = slopeScale(this->getParameters(), 1.0f / this->getFocalLength());
    rows_.resize(width * height);
    for (std::size_t v = 0; v < height; ++v)
      std::memcpy(rows_.data() + v * width, depth.row(static_cast<int>(v)), width * sizeof(float));
    device_.upload(&view, 1, view_);
    device_.upload(rows_.data(), width * height, z_);
    C_.resize(width * height);
    device_.run.forEach(width * height,
                        gpu::EstimateConfidence{view_.data(), this->getParameters(), z_.data(), C_.data()});
    device_.download(C_, width * height, C);
  }

 private:
  gpu::DeviceFilter device_;
  std::vector<float> rows_;
  gpu::DeviceBuffer<gpu::DeviceView> view_;
  gpu::DeviceBuffer<float> z_, C_;
};

}  // namespace fuse_flow
