#pragma once

#include <fuse_flow/impl/stereo/host_backend.hpp>
#include <fuse_flow/impl/stereo/stereo_pipeline.hpp>
#include <fuse_flow/stereo/multi_view_stereo.h>

namespace fuse_flow {
FUSE_FLOW_INLINE MultiViewStereo<device::Host>::MultiViewStereo()
    : pipeline_(std::make_unique<detail::StereoPipeline<host::StereoBackend>>()) {}
FUSE_FLOW_INLINE MultiViewStereo<device::Host>::~MultiViewStereo() = default;
FUSE_FLOW_INLINE MultiViewStereo<device::Host>::MultiViewStereo(MultiViewStereo&&) noexcept = default;
FUSE_FLOW_INLINE MultiViewStereo<device::Host>& MultiViewStereo<device::Host>::operator=(MultiViewStereo&&) noexcept =
    default;

FUSE_FLOW_INLINE void MultiViewStereo<device::Host>::setParameters(const StereoParameters& parameters) {
  checkParameters(parameters);
  pipeline_->parameters = parameters;
}

FUSE_FLOW_INLINE const StereoParameters& MultiViewStereo<device::Host>::getParameters() const {
  return pipeline_->parameters;
}

FUSE_FLOW_INLINE void MultiViewStereo<device::Host>::setNumberOfThreads(unsigned int threads) {
  pipeline_->backend.threads = static_cast<int>(threads);
}

FUSE_FLOW_INLINE void MultiViewStereo<device::Host>::setNormals(bool normals) { normals_ = normals; }

FUSE_FLOW_INLINE void MultiViewStereo<device::Host>::estimate(const RigFrame& frame, StereoFrame& result) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::MultiViewStereo");
  const std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  try {
    pipeline_->run(frame);
    detail::writeStereoFrame(*pipeline_, frame, normals_, start, result);
  } catch (const std::bad_alloc&) {
    // A partly allocated buffer would look complete.
    detail::StereoPipeline<host::StereoBackend> fresh;
    fresh.parameters = pipeline_->parameters;
    fresh.backend = pipeline_->backend;
    *pipeline_ = std::move(fresh);
    throw;
  }
}

}  // namespace fuse_flow
