#pragma once

#include <fuse_flow/filters/adaptive_hash_fusion.h>
#include <fuse_flow/impl/fusion/consistency_evaluator.hpp>
#include <fuse_flow/impl/fusion/hash_aggregation.hpp>
#include <fuse_flow/impl/parameters.hpp>
#include <fuse_flow/impl/sensors/frame_views.hpp>
#include <fuse_flow/point_traits.h>

#include <pcl/impl/pcl_base.hpp>  // PCL compiles its base classes for its own point types only

#include <atomic>
#include <numeric>

namespace fuse_flow {

template <typename PointT>
void AdaptiveHashFusion<PointT, device::Host>::setParameters(const AggregationParameters& parameters) {
  checkParameters(parameters);
  parameters_ = parameters;
}

template <typename PointT>
void AdaptiveHashFusion<PointT, device::Host>::setFrame(const RigFrame& frame,
                                                        const ConsistencyParameters& parameters) {
  checkParameters(parameters);
  if (frame.cameras.empty()) {
    frame_.reset();
  } else {
    checkRigFrame(frame);
    frame_ = frame;
  }
  consistency_ = parameters;
}

template <typename PointT>
void AdaptiveHashFusion<PointT, device::Host>::setPreprocessing(const PreprocessingParameters& parameters) {
  checkParameters(parameters);
  preprocessing_ = parameters;
}

template <typename PointT>
std::vector<FusedPoint> AdaptiveHashFusion<PointT, device::Host>::fusePoints(const std::vector<WeightedPoint>& points,
                                                                             const std::vector<std::uint32_t>& cameras,
                                                                             std::vector<std::uint64_t>& agreeing) {
  const int threads = host::resolveThreads(threads_);
  host::HashAggregation aggregation;
  // A stretch ends where the camera changes, so that a run of points is of one camera.
  std::vector<std::size_t> stretch_ends;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const std::size_t begin = stretch_ends.empty() ? 0 : stretch_ends.back();
    const bool last = k + 1 == points.size() || cameras[k] != cameras[k + 1];
    if (last || k + 1 - begin == 32768) stretch_ends.push_back(k + 1);
  }
  std::vector<host::RunBuilder>& builders = aggregation.grid.start(stretch_ends.size());
  host::parallelFor(threads, stretch_ends.size(), [&](std::size_t s, int) {
    builders[s].start(parameters_.cell_size);
    for (std::size_t k = s == 0 ? 0 : stretch_ends[s - 1]; k < stretch_ends[s]; ++k)
      builders[s].add(static_cast<std::uint32_t>(k), points[k].p);
    builders[s].finish();
  });
  aggregation.grid.merge();

  const host::PointArray array(points, cameras);
  host::FusedPointLists lists;
  if (frame_) {
    host::FrameViews views;
    views.assign(*frame_, preprocessing_, threads);
    host::ConsistencyEvaluator evaluator(consistency_, views.rig, views.depths);
    const std::vector<ViewNoise> noise = host::givenNoise(views.rig);
    evaluator.setNoise(noise);
    evaluator.setConfidence(&frame_->views);
    aggregation.fuse(parameters_, threads, array, &evaluator, {}, lists);
  } else {
    aggregation.fuse(parameters_, threads, array, nullptr, {}, lists);
  }
  std::vector<FusedPoint> fused(aggregation.size());
  agreeing.resize(fused.size());
  aggregation.forEachBlock(threads, [&](std::size_t position, int thread, std::size_t begin, std::size_t n) {
    std::copy_n(lists[thread].points.data() + begin, n, fused.data() + position);
    std::copy_n(lists[thread].cameras.data() + begin, n, agreeing.data() + position);
  });
  return fused;
}

template <typename PointT>
void AdaptiveHashFusion<PointT, device::Host>::applyFilter(PointCloud& output) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::AdaptiveHashFusion");
  constexpr const char* owner = "fuse_flow::AdaptiveHashFusion";
  if (!cameras_.empty() && cameras_.size() != input_->size())
    detail::throwBadArgument(owner, ": ", cameras_.size(), " camera indices for ", input_->size(), " points");
  const auto camera_of_input = [this](pcl::index_t i) {
    return cameras_.empty() ? 0u : cameras_[static_cast<std::size_t>(i)];
  };

  // Camera after camera, as the cells want them; within a camera in the order of the input.
  std::vector<pcl::index_t> order;
  for (const pcl::index_t index : *indices_) {
    const PointT& p = (*input_)[static_cast<std::size_t>(index)];
    if (isFinite({p.x, p.y, p.z}) && givenConfidence(point::getConfidence(p)) > 0) order.push_back(index);
    if (frame_ && camera_of_input(index) >= frame_->cameras.size())
      detail::throwBadArgument(owner, ": point ", index, " is of camera ", camera_of_input(index), ", the frame has ",
                               frame_->cameras.size());
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](pcl::index_t a, pcl::index_t b) { return camera_of_input(a) < camera_of_input(b); });
  std::vector<WeightedPoint> points(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const PointT& p = (*input_)[static_cast<std::size_t>(order[k])];
    points[k] = {{p.x, p.y, p.z}, givenConfidence(point::getConfidence(p))};
  }

  std::vector<std::uint32_t> cameras(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) cameras[k] = camera_of_input(order[k]);
  std::vector<std::uint64_t> agreeing;
  const std::vector<FusedPoint> all_fused = fusePoints(points, cameras, agreeing);
  agreeing.resize(all_fused.size(), 0);

  PointCloud result;
  result.resize(all_fused.size());
  std::atomic<bool> all_finite{true};
  const auto write = [&](const FusedPoint& fused, std::uint64_t mask, PointT& point) {
    const auto source = [&](std::size_t k) -> const PointT& {
      return (*input_)[static_cast<std::size_t>(order[fused.source[k]])];
    };
    std::size_t main = 0;
    Vec3 color{};
    IntensityMean intensity;
    NormalMean normal;
    for (std::size_t k = 0; k < fused.count; ++k) {
      if (fused.share[k] > fused.share[main]) main = k;
      color = color + fused.share[k] * point::getColor(source(k));
      intensity.add(fused.share[k], point::getIntensity(source(k)));
      normal.add(fused.share[k], point::getNormal(source(k)));
      mask |= cameraBit(cameras[fused.source[k]]);
    }
    point = source(main);
    point::setPosition(point, fused.p);
    point::setColor(point, color);
    if (normal.known()) point::setNormal(point, normal.mean());
    point::setIntensity(point, weight_in_intensity_ ? fused.weight : intensity.mean());
    point::setConfidence(point, fused.weight);
    point::setViewCount(point, fused.views);
    point::setCameraMask(point, mask);
    if (!isFinite(point::getNormal(point))) all_finite = false;
  };
  host::parallelForEach(host::resolveThreads(threads_), all_fused.size(),
                        [&](std::size_t k) { write(all_fused[k], agreeing[k], result[k]); });

  removed_indices_->clear();
  if (this->extract_removed_indices_) {
    std::vector<std::uint8_t> represents(input_->size(), 0);
    for (const FusedPoint& fused : all_fused)
      for (std::size_t k = 0; k < fused.count; ++k) represents[static_cast<std::size_t>(order[fused.source[k]])] = 1;
    for (const pcl::index_t index : *indices_)
      if (!represents[static_cast<std::size_t>(index)]) removed_indices_->push_back(index);
  }
  result.header = input_->header;
  result.sensor_origin_ = input_->sensor_origin_;
  result.sensor_orientation_ = input_->sensor_orientation_;
  result.is_dense = all_finite;
  output = std::move(result);
}

}  // namespace fuse_flow
