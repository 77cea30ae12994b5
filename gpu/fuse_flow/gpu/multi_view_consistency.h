#pragma once

#include <fuse_flow/gpu/consistency_evaluator.h>
#include <fuse_flow/gpu/device_filter.h>
#include <fuse_flow/multi_view_consistency.h>

namespace fuse_flow {
namespace gpu {

/** \brief Eq. 4–7 for points of one camera, or of none. */
struct JudgePoints {
  ConsistencyEvaluator evaluator;
  int source_camera;
  const Vec3* points;
  float* V;
  int* views;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const Consistency c = source_camera < 0 ? evaluator.askAll(points[k])
                                            : evaluator(points[k], static_cast<std::uint32_t>(source_camera));
    V[k] = consistency(evaluator.parameters, c);
    views[k] = c.views();
  }
};

}  // namespace gpu

/** \brief On the GPU, for clouds in host memory. \copydetails MultiViewConsistency */
template <typename PointT>
class MultiViewConsistency<PointT, device::Thrust> : public MultiViewConsistency<PointT, device::Host> {
 public:
  ///@{
  /** \brief As in every PCL filter. */
  using Ptr = pcl::shared_ptr<MultiViewConsistency>;
  using ConstPtr = pcl::shared_ptr<const MultiViewConsistency>;
  ///@}

  /** \copydoc MultiViewConsistency<PointT, device::Host>::MultiViewConsistency
   *  \throws pcl::PCLException if there is no GPU */
  explicit MultiViewConsistency(bool extract_removed_indices = false)
      : MultiViewConsistency<PointT, device::Host>(extract_removed_indices),
        device_("fuse_flow::MultiViewConsistency") {}

  /** \brief The CUDA stream that it runs on; default the default stream. */
  void setStream(gpu::Stream stream) { device_.run.stream = stream; }

 protected:
  /** \throws pcl::BadArgumentException also where the bilateral filter is on: it runs on the CPU only */
  void computeConsistency(const std::vector<Vec3>& points, float* V, int* views) override {
    gpu::checkRunsOnDevice("fuse_flow::MultiViewConsistency", this->preprocessing_);
    gpu::Execution& run = device_.run;
    frame_views_.assign(run, this->frame_, {}, false, host::resolveThreads(this->threads_));
    maps_.make(run, device_.times, frame_views_, gpu::DepthMapParameters::withoutSmoothing(this->preprocessing_));
    const std::size_t n = points.size();
    device_.upload(points.data(), n, points_);
    V_.resize(n);
    views_.resize(n);
    const gpu::ConsistencyEvaluator evaluator{frame_views_.grid().views, maps_.measured(), this->parameters_};
    run.forEach(n, gpu::JudgePoints{evaluator, this->source_camera_, points_.data(), V_.data(), views_.data()});
    device_.download(V_, n, V);
    device_.download(views_, n, views);
  }

 private:
  gpu::DeviceFilter device_;
  gpu::FrameViews frame_views_;
  gpu::DepthMaps maps_;
  gpu::DeviceBuffer<Vec3> points_;
  gpu::DeviceBuffer<float> V_;
  gpu::DeviceBuffer<int> views_;
};

}  // namespace fuse_flow
