#pragma once

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/impl/host/frame_pipeline.hpp>
#include <fuse_flow/point_traits.h>

#include <array>

namespace fuse_flow {

inline FuseFlowParameters FuseFlowParameters::published() {
  FuseFlowParameters p;
  p.smoothing.passes = 0;
  p.adapt_noise = false;
  p.half_weight_noise = 0;
  p.max_noise = 0;
  p.confidence.form = ConfidenceForm::Published;
  p.confidence.threshold = 0.4f;
  p.consistency.occlusion = OcclusionForm::Published;
  p.consistency.distance = DistanceForm::Euclidean;
  p.consistency.sigma_per_noise = 0;
  p.aggregation.representatives = Representatives::HighestConfidence;
  p.aggregation.consistency_at = ConsistencyAt::Representatives;
  p.aggregation.min_weight = 0;
  p.aggregation.weak_weight = 0;
  p.aggregation.confirmation_reach = 0;
  return p;
}

inline void checkParameters(const FuseFlowParameters& p) {
  checkParameters(p.preprocessing);
  checkParameters(p.smoothing);
  checkParameters(p.confidence);
  checkParameters(p.consistency);
  checkParameters(p.aggregation);
  detail::checkNonNegative("fuse_flow::FuseFlow", "half_weight_noise", p.half_weight_noise);
  detail::checkNonNegative("fuse_flow::FuseFlow", "max_noise", p.max_noise);
  if (p.crop_box && (p.crop_box->isEmpty() || !p.crop_box->min().allFinite() || !p.crop_box->max().allFinite()))
    detail::throwBadArgument("fuse_flow::FuseFlow: crop_box is empty or not finite");
}

template <typename PointT>
FuseFlow<PointT, device::Host>::FuseFlow() : pipeline_(std::make_unique<host::FramePipeline>()) {}

template <typename PointT>
FuseFlow<PointT, device::Host>::~FuseFlow() = default;

template <typename PointT>
void FuseFlow<PointT, device::Host>::setParameters(const FuseFlowParameters& parameters) {
  checkParameters(parameters);
  pipeline_->parameters = parameters;
}

template <typename PointT>
const FuseFlowParameters& FuseFlow<PointT, device::Host>::getParameters() const {
  return pipeline_->parameters;
}

template <typename PointT>
void FuseFlow<PointT, device::Host>::setNumberOfThreads(unsigned int threads) {
  pipeline_->threads = static_cast<int>(threads);
}

template <typename PointT>
void FuseFlow<PointT, device::Host>::setComputeNormals(bool compute) {
  compute_normals_ = compute;
}

template <typename PointT>
const FrameStatistics& FuseFlow<PointT, device::Host>::getStatistics() const {
  return pipeline_->statistics;
}

template <typename PointT>
void FuseFlow<PointT, device::Host>::fuse(const RigFrame& frame, PointCloud& output) {
  using host::FramePipeline;
  const FramePipeline::Clock::time_point start = FramePipeline::Clock::now();
  FramePipeline& pipeline = *pipeline_;
  pipeline.generate(frame);

  using Sources = std::array<host::FramePoints::Pixel, kRepresentatives>;
  const auto locate = [&](const FusedPoint& fused, Sources& sources) {
    if constexpr (point::has_color<PointT> || point::has_normal<PointT>)
      for (std::size_t k = 0; k < fused.count; ++k) {
        sources[k] = pipeline.locate(fused.source[k]);
        if constexpr (point::has_color<PointT>) pipeline.prefetchColor(sources[k]);
      }
  };
  const auto write = [&](const FusedPoint& fused, const Sources& sources, PointT& point) {
    point = PointT();
    point::setPosition(point, fused.p);
    point::setWeight(point, fused.weight);
    point::setViewCount(point, fused.views);
    ColorMean color;
    NormalMean normal;
    for (std::size_t k = 0; k < fused.count; ++k) {
      if constexpr (point::has_color<PointT>) color.add(fused.share[k], pipeline.color(sources[k]));
      if constexpr (point::has_normal<PointT>)
        if (compute_normals_) normal.add(fused.share[k], pipeline.normal(sources[k]));
    }
    point::setColor(point, color.mean());
    point::setNormal(point, normal.mean());
  };

  FramePipeline::Clock::time_point fused_at;
  if (pipeline.parameters.use_spatial_hash) {
    pipeline.aggregate();
    fused_at = FramePipeline::Clock::now();
    output.resize(pipeline.aggregation().size());
    pipeline.aggregation().forEach(
        pipeline.resolvedThreads(), [&](std::size_t position, const FusedPoint* fused, std::size_t n) {
          constexpr std::size_t batch = 16;  // whose colours are on their way from memory at a time
          std::array<Sources, batch> sources;
          for (std::size_t begin = 0; begin < n; begin += batch) {
            const std::size_t end = std::min(n, begin + batch);
            for (std::size_t k = begin; k < end; ++k) locate(fused[k], sources[k - begin]);
            for (std::size_t k = begin; k < end; ++k) write(fused[k], sources[k - begin], output[position + k]);
          }
        });
  } else {
    fused_at = FramePipeline::Clock::now();
    output.clear();
    pipeline.fusePointWise([&](const FusedPoint& fused) {
      if (!(fused.weight > 0) || fused.weight < pipeline.parameters.aggregation.min_weight) return;
      Sources sources;
      locate(fused, sources);
      output.emplace_back();
      write(fused, sources, output.back());
    });
    pipeline.statistics.fuse_ms = FramePipeline::since(fused_at);
  }
  output.header = {};
  output.header.stamp = frame.stamp;
  output.width = static_cast<std::uint32_t>(output.size());
  output.height = 1;
  output.is_dense = true;
  output.sensor_origin_.setZero();
  output.sensor_orientation_.setIdentity();
  pipeline.statistics.fused_points = output.size();
  if (pipeline.parameters.use_spatial_hash) pipeline.statistics.output_ms = FramePipeline::since(fused_at);
  pipeline.statistics.total_ms = FramePipeline::since(start);
}

}  // namespace fuse_flow
