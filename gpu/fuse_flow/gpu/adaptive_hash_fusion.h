#pragma once

#include <fuse_flow/adaptive_hash_fusion.h>
#include <fuse_flow/gpu/cloud_aggregation.h>

namespace fuse_flow {

/** \brief On the GPU, for clouds in host memory. The points of a coarse cell come in the order of their places in it.
 *  \copydetails AdaptiveHashFusion */
template <typename PointT>
class AdaptiveHashFusion<PointT, device::Thrust> : public AdaptiveHashFusion<PointT, device::Host> {
 public:
  ///@{
  /** \brief As in every PCL filter. */
  using Ptr = pcl::shared_ptr<AdaptiveHashFusion>;
  using ConstPtr = pcl::shared_ptr<const AdaptiveHashFusion>;
  ///@}

  /** \copydoc AdaptiveHashFusion<PointT, device::Host>::AdaptiveHashFusion
   *  \throws pcl::PCLException if there is no GPU */
  explicit AdaptiveHashFusion(bool extract_removed_indices = false)
      : AdaptiveHashFusion<PointT, device::Host>(extract_removed_indices), device_("fuse_flow::AdaptiveHashFusion") {}

  /** \brief The CUDA stream that it runs on; default the default stream. */
  void setStream(gpu::Stream stream) { device_.run.stream = stream; }

 protected:
  std::vector<FusedPoint> fusePoints(const std::vector<WeightedPoint>& points,
                                     const std::vector<std::uint32_t>& cameras) override {
    if (!this->frame_) return aggregation_.fuse(this->parameters_, points, cameras, nullptr);
    views_.assign(device_.run, *this->frame_, {}, false, host::resolveThreads(this->threads_));
    maps_.make(device_.run, device_.times, views_,
               gpu::DepthMapParameters::withoutSmoothing(PreprocessingParameters()));
    const gpu::ConsistencyEvaluator evaluator{views_.grid().views, maps_.measured(), this->consistency_};
    return aggregation_.fuse(this->parameters_, points, cameras, &evaluator);
  }

 private:
  gpu::DeviceFilter device_;
  gpu::CloudAggregation aggregation_{device_};
  gpu::FrameViews views_;
  gpu::DepthMaps maps_;
};

}  // namespace fuse_flow
