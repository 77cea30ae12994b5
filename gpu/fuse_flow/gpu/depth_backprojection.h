#pragma once

#include <fuse_flow/depth_backprojection.h>
#include <fuse_flow/gpu/device_filter.h>

namespace fuse_flow {
namespace gpu {

/** \brief Eq. 8 for each pixel of the only view, to rows without padding. */
struct BackprojectPixels {
  PixelGrid grid;
  const float* depth;
  float* z;
  Vec3* points;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = grid.addressOf(index);
    const DeviceView& view = grid.views[a.view];
    const int width = view.model.intrinsics.width;
    if (a.u >= width) return;  // padding
    const std::size_t place =
        static_cast<std::size_t>(a.v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(a.u);
    z[place] = depth[index];
    points[place] = view.model.T_world_camera * pointOnRay(view.ray(a.u, a.v), depth[index]);
  }
};

}  // namespace gpu

/** \brief On the GPU, for images and clouds in host memory. \copydetails DepthBackprojection */
template <typename PointT>
class DepthBackprojection<PointT, device::Thrust> : public DepthBackprojection<PointT, device::Host> {
 public:
  ///@{
  /** \brief As in every PCL filter. */
  using Ptr = pcl::shared_ptr<DepthBackprojection>;
  using ConstPtr = pcl::shared_ptr<const DepthBackprojection>;
  ///@}

  /** \copydoc DepthBackprojection<PointT, device::Host>::DepthBackprojection
   *  \throws pcl::PCLException if there is no GPU */
  explicit DepthBackprojection(bool extract_removed_indices = false)
      : DepthBackprojection<PointT, device::Host>(extract_removed_indices), device_("fuse_flow::DepthBackprojection") {}

  /** \brief The CUDA stream that it runs on; default the default stream. */
  void setStream(gpu::Stream stream) { device_.run.stream = stream; }

 protected:
  /** \throws pcl::BadArgumentException also where the bilateral filter is on: it runs on the CPU only */
  void computePoints(const DepthView& view, float* z, Vec3* points) override {
    gpu::checkRunsOnDevice("fuse_flow::DepthBackprojection", this->parameters_);
    RigFrame frame;
    frame.cameras.push_back(this->camera_);
    frame.views.push_back(view);
    gpu::Execution& run = device_.run;
    views_.assign(run, frame, {}, false, host::resolveThreads(this->threads_));
    maps_.make(run, device_.times, views_, gpu::DepthMapParameters::withoutSmoothing(this->parameters_));
    const std::size_t size = static_cast<std::size_t>(view.width()) * static_cast<std::size_t>(view.height());
    z_.resize(size);
    points_.resize(size);
    run.forEach(views_.pixels(), gpu::BackprojectPixels{views_.grid(), maps_.refined(), z_.data(), points_.data()});
    device_.download(z_, size, z);
    device_.download(points_, size, points);
  }

 private:
  gpu::DeviceFilter device_;
  gpu::FrameViews views_;
  gpu::DepthMaps maps_;
  gpu::DeviceBuffer<float> z_;
  gpu::DeviceBuffer<Vec3> points_;
};

}  // namespace fuse_flow
