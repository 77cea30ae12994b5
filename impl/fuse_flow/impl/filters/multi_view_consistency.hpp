#pragma once

#include <fuse_flow/filters/multi_view_consistency.h>
#include <fuse_flow/impl/filters/index_filter.hpp>
#include <fuse_flow/impl/fusion/consistency_evaluator.hpp>
#include <fuse_flow/impl/parameters.hpp>
#include <fuse_flow/impl/sensors/frame_views.hpp>
#include <fuse_flow/point_traits.h>

namespace fuse_flow {

template <typename PointT>
void MultiViewConsistency<PointT, device::Host>::setFrame(const RigFrame& frame, int source_camera) {
  checkRigFrame(frame);
  detail::checkRange("fuse_flow::MultiViewConsistency", "source_camera", source_camera, -1,
                     static_cast<int>(frame.cameras.size()) - 1);
  frame_ = frame;
  source_camera_ = source_camera;
}

template <typename PointT>
void MultiViewConsistency<PointT, device::Host>::setParameters(const ConsistencyParameters& parameters) {
  checkParameters(parameters);
  parameters_ = parameters;
}

template <typename PointT>
void MultiViewConsistency<PointT, device::Host>::setPreprocessing(const PreprocessingParameters& parameters) {
  checkParameters(parameters);
  preprocessing_ = parameters;
}

template <typename PointT>
void MultiViewConsistency<PointT, device::Host>::setThreshold(float threshold) {
  detail::checkRange("fuse_flow::MultiViewConsistency", "threshold", threshold, 0.0f, 1.0f);
  threshold_ = threshold;
}

template <typename PointT>
void MultiViewConsistency<PointT, device::Host>::computeConsistency(const std::vector<Vec3>& points,
                                                                    const std::vector<Vec3>& normals, float* V,
                                                                    int* views) {
  const int threads = host::resolveThreads(threads_);
  host::FrameViews frame_views;
  frame_views.assign(frame_, preprocessing_, threads);
  host::ConsistencyEvaluator evaluator(parameters_, frame_views.rig, frame_views.depths);
  const std::vector<ViewNoise> noise = host::givenNoise(frame_views.rig);
  evaluator.setNoise(noise);
  evaluator.setConfidence(&frame_.views);
  host::parallelForEach(threads, points.size(), [&](std::size_t k) {
    const Vec3 normal = normals.empty() ? Vec3{} : normals[k];
    const Consistency c = source_camera_ < 0 ? evaluator.askAll(points[k])
                                             : evaluator(points[k], normal, static_cast<std::size_t>(source_camera_));
    V[k] = consistency(parameters_, c);
    views[k] = c.views();
  });
}

template <typename PointT>
void MultiViewConsistency<PointT, device::Host>::applyFilter(pcl::Indices& indices) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::MultiViewConsistency");
  checkRigFrame(frame_);
  consistency_.assign(input_->size(), 0.0f);
  view_counts_.assign(input_->size(), 0);
  const auto finite = [this](pcl::index_t index) {
    const PointT& p = (*input_)[static_cast<std::size_t>(index)];
    return isFinite({p.x, p.y, p.z});
  };
  std::vector<std::size_t> asked;
  std::vector<Vec3> points, normals;
  const bool with_normals = point::has_normal<PointT> && source_camera_ >= 0 && asksForNormals(parameters_);
  for (const pcl::index_t index : *indices_) {
    if (!finite(index)) continue;
    const PointT& p = (*input_)[static_cast<std::size_t>(index)];
    asked.push_back(static_cast<std::size_t>(index));
    points.push_back({p.x, p.y, p.z});
    if (with_normals) normals.push_back(facingNormal(point::getNormal(p), toSource(points.back())));
  }
  std::vector<float> V(points.size());
  std::vector<int> views(points.size());
  computeConsistency(points, normals, V.data(), views.data());
  for (std::size_t k = 0; k < asked.size(); ++k) {
    consistency_[asked[k]] = V[k];
    view_counts_[asked[k]] = views[k];
  }
  detail::splitIndices(*indices_, this->negative_, this->extract_removed_indices_, indices, *removed_indices_, finite,
                       [&](pcl::index_t index) { return consistency_[static_cast<std::size_t>(index)] >= threshold_; });
}

template <typename PointT>
void MultiViewConsistency<PointT, device::Host>::applyFilter(PointCloud& output) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::MultiViewConsistency");
  if constexpr (!point::has_confidence<PointT>) {
    pcl::FilterIndices<PointT>::applyFilter(output);
  } else {
    const auto weigh = [this](PointT& point, std::size_t index) {
      point::setConfidence(point, point::getConfidence((*input_)[index]) * consistency_[index]);
    };
    if (this->keep_organized_) {
      pcl::FilterIndices<PointT>::applyFilter(output);
      for (const pcl::index_t index : *indices_)  // nobody was asked about the others
        weigh(output[static_cast<std::size_t>(index)], static_cast<std::size_t>(index));
    } else {
      pcl::Indices indices;
      applyFilter(indices);
      output.is_dense = true;
      pcl::copyPointCloud(*input_, indices, output);
      for (std::size_t i = 0; i < output.size(); ++i) weigh(output[i], detail::copiedFrom(indices, input_->size(), i));
    }
  }
}

}  // namespace fuse_flow
