#pragma once

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/impl/fusion/frame_pipeline.hpp>
#include <fuse_flow/impl/fusion/point_writer.hpp>

#include <new>

namespace fuse_flow {

template <typename PointT>
FuseFlow<PointT, device::Host>::FuseFlow()
    : pipeline_(std::make_unique<host::FramePipeline>()),
      writer_(std::make_unique<host::PointWriter<PointT>>(*pipeline_)) {}

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
void FuseFlow<PointT, device::Host>::setWeightInIntensity(bool weight) {
  writer_->setWeightInIntensity(weight);
}

template <typename PointT>
const FrameStatistics& FuseFlow<PointT, device::Host>::getStatistics() const {
  return pipeline_->statistics;
}

template <typename PointT>
void FuseFlow<PointT, device::Host>::fuse(const RigFrame& frame, PointCloud& output) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::FuseFlow");
  try {
    fuseFrame(frame, output);
  } catch (const std::bad_alloc&) {
    forgetMemory();
    throw;
  }
}

template <typename PointT>
void FuseFlow<PointT, device::Host>::forgetMemory() {
  host::FramePipeline fresh;
  fresh.parameters = pipeline_->parameters;
  fresh.threads = pipeline_->threads;
  *pipeline_ = std::move(fresh);
  writer_->forgetMemory();
}

template <typename PointT>
void FuseFlow<PointT, device::Host>::fuseFrame(const RigFrame& frame, PointCloud& output) {
  using host::FramePipeline;
  const FramePipeline::Clock::time_point start = FramePipeline::Clock::now();
  FramePipeline& pipeline = *pipeline_;
  pipeline.with_color = point::shows_color<PointT>;
  pipeline.generate(frame);

  host::PointWriter<PointT>& writer = *writer_;
  writer.setComputeNormals(compute_normals_);
  FramePipeline::Clock::time_point fused_at;
  if (pipeline.parameters.use_spatial_hash) {
    pipeline.aggregate(writer);
    fused_at = FramePipeline::Clock::now();
    output.resize(pipeline.aggregation().size());
    pipeline.aggregation().forEachBlock(pipeline.resolvedThreads(),
                                        [&](std::size_t position, int thread, std::size_t begin, std::size_t n) {
                                          writer.copy(thread, begin, n, output.points.data() + position);
                                        });
  } else {
    fused_at = FramePipeline::Clock::now();
    output.clear();
    writer.start(1);
    pipeline.fusePointWise([&](const FusedPoint& fused, std::uint64_t cameras) {
      if (!(fused.weight > 0) || fused.weight < pipeline.parameters.aggregation.min_weight) return;
      output.emplace_back();
      writer.write(0, fused, cameras, output.back());
    });
    pipeline.statistics.fuse_ms = FramePipeline::since(fused_at);
  }
  output.header = {};
  output.header.stamp = frame.stamp;
  output.width = static_cast<std::uint32_t>(output.size());
  output.height = 1;
  output.is_dense = !writer.anyUnknownNormal();
  output.sensor_origin_.setZero();
  output.sensor_orientation_.setIdentity();
  pipeline.statistics.fused_points = output.size();
  if (pipeline.parameters.use_spatial_hash) pipeline.statistics.output_ms = FramePipeline::since(fused_at);
  pipeline.statistics.total_ms = FramePipeline::since(start);
}

}  // namespace fuse_flow
