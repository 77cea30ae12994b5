#include "methods/fusion_method.h"
#include "methods/fusion_with_normals.h"
#include "methods/gpu_method.h"

#include <fuse_flow/gpu/filters/adaptive_hash_fusion.h>
#include <fuse_flow/gpu/filters/confidence_estimation.h>
#include <fuse_flow/gpu/filters/depth_backprojection.h>
#include <fuse_flow/gpu/filters/multi_view_consistency.h>
#include <fuse_flow/gpu/fuse_flow.h>
#include <fuse_flow/gpu/runtime/system.h>
#include <fuse_flow/recordings/error.h>
#ifdef FUSE_FLOW_WITH_STREAM
#include "stream/gpu/gpu_frame_encoder.h"
#endif

#include <pcl/point_types.h>

// No tool needs these: a build where there is nvcc shows that they compile, and so do the host's classes in a CUDA source.
template class fuse_flow::ConfidenceEstimation<fuse_flow::PointFused, fuse_flow::device::Thrust>;
template class fuse_flow::DepthBackprojection<fuse_flow::PointFused, fuse_flow::device::Thrust>;
template class fuse_flow::MultiViewConsistency<fuse_flow::PointFused, fuse_flow::device::Thrust>;
template class fuse_flow::AdaptiveHashFusion<fuse_flow::PointFused, fuse_flow::device::Thrust>;
template class fuse_flow::FuseFlow<pcl::PointXYZ>;

namespace fuse_flow::io {
bool runsOnGpu(const std::string& device) {
  if (device == "cpu") return false;
  const std::string missing = gpu::missingDevice();
  if (device == "gpu" && !missing.empty()) throw OptionError("--device gpu: " + missing + "; use --device cpu");
  return missing.empty();
}

namespace {

/** \brief Comes before what runs on the stream, which it must outlive. */
struct FusionStream {
  gpu::OwnStream fusing{gpu::StreamPriority::First};
};

/** \brief A method on a stream of its own, before whatever else the device does: fusing is short, estimating the depth of the next frame is not. Its
 *  clouds can become bytes where they are. */
template <typename Fusion>
class OnGpu : private FusionStream, public Fusion {
 public:
  explicit OnGpu(const MethodOptions& options) : Fusion(options) {
    this->fusion_.setStream(fusing.get());
#ifdef FUSE_FLOW_WITH_STREAM
    if (options.encoding) encoder_ = std::make_unique<stream::GpuFrameEncoder>(*options.encoding);
#endif
  }
#ifdef FUSE_FLOW_WITH_STREAM
  std::shared_ptr<const stream::EncodedFrame> fuseEncoded(const RigFrame& frame,
                                                          const stream::FrameTimes& times) override {
    if (!encoder_) return nullptr;
    const auto points = this->fusion_.fuseOnDevice(frame);
    this->statistics_ = this->fusion_.getStatistics();
    return encoder_->encode(stream::viewOf(points.points, points.size), times, fusing.get());
  }

 private:
  std::unique_ptr<stream::GpuFrameEncoder> encoder_;
#endif
};

}  // namespace

std::unique_ptr<Method> makeGpuFusion(const MethodOptions& options) {
  if (options.morePerPoint())
    return std::make_unique<OnGpu<FusionWithNormals<FuseFlow<PointFusedNormal, device::Thrust>>>>(options);
  return std::make_unique<OnGpu<FusionMethod<FuseFlow<PointFused, device::Thrust>>>>(options);
}

}  // namespace fuse_flow::io
