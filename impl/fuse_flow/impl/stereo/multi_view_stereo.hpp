#pragma once

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/impl/host/wide_vectors.hpp>
#include <fuse_flow/impl/stereo/stereo_pipeline.hpp>
#include <fuse_flow/stereo/multi_view_stereo.h>

namespace fuse_flow {
namespace host {

/** \brief Runs the steps of stereo on the threads of the CPU. */
class StereoBackend {
 public:
  template <typename Value>
  using Buffer = std::vector<Value>;

  int threads{0};

  template <typename Step>
  void forEach(std::size_t n, const Step& step) {
    constexpr std::size_t of_task = 512;
    parallelFor(resolveThreads(threads), (n + of_task - 1) / of_task, [&](std::size_t task, int) {
      const std::size_t end = std::min(n, (task + 1) * of_task);
      inWideVectors([&] {
        for (std::size_t k = task * of_task; k < end; ++k) step(static_cast<std::uint32_t>(k));
      });
    });
  }
  template <typename Value>
  void upload(const std::vector<Value>& values, Buffer<Value>& to) {
    to = values;
  }
  template <typename Value>
  void download(const Value* from, std::size_t n, Value* to) {
    std::copy(from, from + n, to);
  }
  ImageView<Rgb8> reachable(std::size_t, const ImageView<Rgb8>& image) { return image; }
  void wait() {}
};

}  // namespace host

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

FUSE_FLOW_INLINE void MultiViewStereo<device::Host>::estimate(const RigFrame& frame, StereoFrame& result) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::MultiViewStereo");
  const std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  try {
    pipeline_->run(frame);
    detail::writeStereoFrame(*pipeline_, frame, start, result);
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
