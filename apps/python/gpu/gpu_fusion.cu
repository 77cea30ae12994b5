#include "../fusion/fusion_of.h"
#include "gpu_fusion.h"

#include <fuse_flow/gpu/fuse_flow.h>

namespace fuse_flow::python {
namespace {

int currentDevice() {
  int device = 0;
  gpu::check(cudaGetDevice(&device), "cudaGetDevice");
  return device;
}

template <typename PointT>
class GpuFusionOf : public GpuFusion {
 public:
  explicit GpuFusionOf(const PointExtras& extras) : extras_(extras), device_(currentDevice()) {
    fusion_.setComputeNormals(extras.normals);
    fusion_.setStream(stream_.get());
  }
  void setParameters(const FuseFlowParameters& parameters) override { fusion_.setParameters(parameters); }
  void setNumberOfThreads(unsigned int threads) override { fusion_.setNumberOfThreads(threads); }
  FrameStatistics statistics() const override { return fusion_.getStatistics(); }
  std::uintptr_t stream() const override { return reinterpret_cast<std::uintptr_t>(stream_.get()); }
  int device() const override { return device_; }
  void waitFor(std::uintptr_t other) override {
    const gpu::HomeDevice::Visit visit(home_);
    order_.put(reinterpret_cast<gpu::Stream>(other), stream_.get());
  }

  Cloud fuse(const RigFrame& frame) override {
    const std::shared_ptr<pcl::PointCloud<PointT>> points = pool_->take();
    fusion_.fuse(frame, *points);
    return {points, reinterpret_cast<std::byte*>(points->data()), points->size(), layoutOf<PointT>(extras_),
            frame.stamp};
  }

  GpuCloud fuseOnDevice(const RigFrame& frame) override {
    const gpu::HomeDevice::Visit visit(home_);
    const std::shared_ptr<gpu::DeviceCloud<PointT>> points = device_pool_->take();
    // Whoever had this memory before has let it go, but work that reads it may still be on a stream of theirs.
    if (points->bytes() > 0) gpu::check(cudaDeviceSynchronize(), "cudaDeviceSynchronize");
    fusion_.fuse(frame, *points);
    return {points,         reinterpret_cast<std::byte*>(points->words()),
            points->size(), layoutOf<PointT>(extras_),
            frame.stamp,    device_};
  }

 private:
  PointExtras extras_;
  gpu::HomeDevice home_{"fuse_flow::FuseFlow"};
  int device_;
  gpu::OwnStream stream_;
  gpu::StreamOrder order_;
  FuseFlow<PointT, device::Thrust> fusion_;
  std::shared_ptr<Pool<pcl::PointCloud<PointT>>> pool_ = std::make_shared<Pool<pcl::PointCloud<PointT>>>();
  std::shared_ptr<Pool<gpu::DeviceCloud<PointT>>> device_pool_ = std::make_shared<Pool<gpu::DeviceCloud<PointT>>>();
};

}  // namespace

std::unique_ptr<GpuFusion> makeGpuFusion(const PointExtras& extras) {
  const std::string missing = gpu::missingDevice();
  if (!missing.empty()) throw pcl::PCLException("fuse_flow::FuseFlow: device='gpu': " + missing);
  if (extras.normals || extras.camera_mask) return std::make_unique<GpuFusionOf<io::PointFusedNormal>>(extras);
  return std::make_unique<GpuFusionOf<PointFused>>(extras);
}

}  // namespace fuse_flow::python
