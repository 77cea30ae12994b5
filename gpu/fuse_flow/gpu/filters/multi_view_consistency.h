#pragma once

#include <fuse_flow/filters/multi_view_consistency.h>
#include <fuse_flow/gpu/filters/cloud_selection.h>
#include <fuse_flow/gpu/filters/device_filter.h>
#include <fuse_flow/gpu/fusion/consistency_evaluator.h>

namespace fuse_flow {
namespace gpu {

/** \brief Eq. 4–7 for points of one camera, or of none. */
struct JudgePoints {
  ConsistencyEvaluator evaluator;
  int source_camera;
  const Vec3* points;
  const Vec3* normals;  ///< null: none is known
  float* V;
  int* views;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const { judge(points[k], normals == nullptr ? Vec3{} : normals[k], k); }

  FUSE_FLOW_HD void judge(const Vec3& p, const Vec3& normal, std::uint32_t k) const {
    const Consistency c =
        source_camera < 0 ? evaluator.askAll(p) : evaluator(p, normal, static_cast<std::uint32_t>(source_camera));
    V[k] = consistency(evaluator.parameters, c);
    views[k] = c.views();
  }
};

/** \brief The same for the points of a list of a cloud, and which of them stay. */
template <typename Layout>
struct JudgeListedPoints {
  JudgePoints judge;
  const typename Layout::Words* points;
  PointList list;
  float threshold;
  bool negative;
  std::uint8_t* keep;

  FUSE_FLOW_HD Vec3 normalOf(const typename Layout::Words& point, const Vec3& p) const {
    if (!Layout::has_normal || judge.source_camera < 0 || !asksForNormals(judge.evaluator.parameters)) return {};
    return facingNormal(Layout::normal(point), judge.evaluator.views[judge.source_camera].model.T_world_camera.t - p);
  }

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const std::uint32_t index = list[k];
    const Vec3 p = Layout::position(points[index]);
    if (!isFinite(p)) return;
    judge.judge(p, normalOf(points[index], p), index);
    keep[index] = (judge.V[index] >= threshold) != negative;
  }
};

}  // namespace gpu

/** \brief On the GPU, for clouds in host memory or on the device. \copydetails MultiViewConsistency */
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

  using DeviceCloud = gpu::DeviceCloud<PointT>;
  using MultiViewConsistency<PointT, device::Host>::setInputCloud;
  using MultiViewConsistency<PointT, device::Host>::filter;

  /** \brief The cloud that filter(DeviceCloud&) reads, in the world frame. */
  void setInputCloud(const typename DeviceCloud::ConstPtr& cloud) { device_input_ = cloud; }

  /** \brief As filter() of a cloud in host memory, with setIndices() and all that pcl::FilterIndices offers, and nothing
   *  copied over the bus but the number of points (and the frame's images, where those are in host memory). Each call makes the
   *  depth of all views anew, as their images may have changed: for clouds of N cameras that is N² images, and images on the
   *  device, or the frame pipeline, which makes them once, are what is fast.
   *  getConsistency() and getViewCounts() stay as they were: see deviceConsistency(). \param output its memory is exchanged
   *  for memory of the filter; may be the input
   *  \throws pcl::BadArgumentException if there is no frame, or it contradicts itself */
  void filter(DeviceCloud& output) {
    const detail::OneThread::Inside inside(this->one_thread_, "fuse_flow::MultiViewConsistency");
    const gpu::DeviceFilter::Visit visit(device_);
    const DeviceCloud& input = gpu::DeviceFilter::inputOf("fuse_flow::MultiViewConsistency", device_input_);
    checkRigFrame(this->frame_);
    gpu::Execution& run = device_.run;
    selection_.list(run, input, this->use_indices_ ? this->getIndices() : nullptr);
    const gpu::JudgePoints judge = prepare(input.size());
    if (input.size() > 0) {
      run.fill(V_.data(), input.size(), 0);
      run.fill(views_.data(), input.size(), 0);
    }
    run.forEach(selection_.size(), gpu::JudgeListedPoints<gpu::PointLayout<PointT>>{
                                       judge, input.words(), selection_.points(), this->getThreshold(), this->negative_,
                                       selection_.keep(run, input.size())});
    selection_.apply(run, {this->keep_organized_, this->user_filter_value_, this->extract_removed_indices_},
                     {gpu::ConfidenceField::Change::Scale, V_.data()}, input, result_, *this->removed_indices_);
    std::swap(output, result_);
  }

  /** \brief V of every point of the input of the last filter(DeviceCloud&), and how many views had a say, in device memory. */
  const float* deviceConsistency() const { return V_.data(); }
  /** \copydoc deviceConsistency */
  const int* deviceViewCounts() const { return views_.data(); }

 protected:
  void computeConsistency(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, float* V,
                          int* views) override {
    const gpu::DeviceFilter::Visit visit(device_);
    const std::size_t n = points.size();
    device_.upload(points.data(), n, points_);
    gpu::JudgePoints judge = prepare(n);
    if (!normals.empty()) {
      device_.upload(normals.data(), n, normals_);
      judge.normals = normals_.data();
    }
    device_.run.forEach(n, judge);
    device_.download(V_, n, V);
    device_.download(views_, n, views);
  }

 private:
  /** \brief The frame's depth on the device, and what to ask it about n points. */
  gpu::JudgePoints prepare(std::size_t n) {
    frame_views_.assign(device_.run, this->frame_, nullptr, false, gpu::copyThreads(this->threads_));
    maps_.make(device_.run, device_.times, frame_views_,
               gpu::DepthMapParameters::withoutSmoothing(this->preprocessing_));
    V_.resize(n);
    views_.resize(n);
    const gpu::ConsistencyEvaluator evaluator{frame_views_.grid().views, maps_.measured(), this->parameters_};
    return {evaluator, this->source_camera_, points_.data(), nullptr, V_.data(), views_.data()};
  }

  gpu::DeviceFilter device_;
  gpu::FrameViews frame_views_;
  gpu::DepthMaps maps_;
  gpu::DeviceBuffer<Vec3> points_, normals_;
  gpu::DeviceBuffer<float> V_;
  gpu::DeviceBuffer<int> views_;
  typename DeviceCloud::ConstPtr device_input_;
  gpu::CloudSelection<PointT> selection_;
  DeviceCloud result_;
};

}  // namespace fuse_flow
