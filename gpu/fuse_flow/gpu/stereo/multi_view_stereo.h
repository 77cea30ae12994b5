#pragma once

#include <fuse_flow/gpu/runtime/copy_threads.h>
#include <fuse_flow/gpu/runtime/execution.h>
#include <fuse_flow/gpu/runtime/on_error.h>
#include <fuse_flow/gpu/stereo/stereo_images.h>
#include <fuse_flow/impl/stereo/stereo_pipeline.hpp>
#include <fuse_flow/stereo/multi_view_stereo.h>

#include <cstring>
#include <utility>

namespace fuse_flow {
namespace gpu {

#if FUSE_FLOW_CUDA
/** \brief Threads of a block. */
constexpr int kStereoThreads = 128;
/** \brief Blocks in flight on a multiprocessor. With fewer, nothing hides that windows wait for their samples; with more, a thread has too few
 *  registers for its window. */
constexpr int kStereoBlocks = 3;

template <typename Step>
__global__ void __launch_bounds__(kStereoThreads, kStereoBlocks) runStereoStep(std::uint32_t n, Step step) {
  const std::uint32_t k = blockIdx.x * kStereoThreads + threadIdx.x;
  if (k < n) step(k);
}
#endif

/** \brief Runs the steps of stereo on the device. */
class StereoBackend {
 public:
  template <typename Value>
  using Buffer = DeviceBuffer<Value>;

  Execution run;
  int threads{0};

  template <typename Step>
  void forEach(std::size_t n, const Step& step) {
#if FUSE_FLOW_CUDA
    if (n == 0) return;
    const auto blocks = static_cast<unsigned int>((n + kStereoThreads - 1) / kStereoThreads);
    run.launch("a step of stereo", runStereoStep<Step>, dim3(blocks), kStereoThreads, static_cast<std::uint32_t>(n),
               step);
#else
    run.forEach(n, step);
#endif
  }
  template <typename Value>
  void upload(const std::vector<Value>& values, Buffer<Value>& to) {
    to.resize(values.size());
    run.copy(to.data(), values.data(), values.size());
    run.wait();  // before the values are gone
  }
  template <typename Value>
  void download(const Value* from, std::size_t n, Value* to) {
    asked_for_.push_back(
        {reinterpret_cast<const char*>(from), reinterpret_cast<char*>(to), n * sizeof(Value), fetched_bytes_});
    fetched_bytes_ += n * sizeof(Value);
  }
  ImageView<Rgb8> reachable(std::size_t view, const ImageView<Rgb8>& image) {
    return images_.onDevice(run, view, image, copyThreads(threads));
  }
  /** \brief What download() was asked for is there then. It goes through pinned memory: pageable memory is reached at a tenth of the bus. */
  void wait() {
    const std::vector<Fetched> fetched = forget();
    if (!fetched.empty()) pinned_.resize(fetched.back().at + fetched.back().bytes);
    for (const Fetched& piece : fetched) run.copy(pinned_.data() + piece.at, piece.from, piece.bytes);
    run.wait();
    host::parallelFor(copyThreads(threads), fetched.size(), [&](std::size_t k, int) {
      if (fetched[k].bytes > 0) std::memcpy(fetched[k].to, pinned_.data() + fetched[k].at, fetched[k].bytes);
    });
  }
  /** \brief After an error: the memory that was to be written may be gone. */
  void settle() noexcept {
    asked_for_.clear();
    fetched_bytes_ = 0;
    run.settle();
  }

 private:
  struct Fetched {
    const char* from;
    char* to;
    std::size_t bytes, at;
  };
  std::vector<Fetched> forget() {
    fetched_bytes_ = 0;
    return std::exchange(asked_for_, {});
  }

  StereoImages images_;
  std::vector<Fetched> asked_for_;
  std::size_t fetched_bytes_{0};
  PinnedBuffer<char> pinned_;
};

}  // namespace gpu

/** \brief On the GPU, all views of a frame at once; the same bytes as on the CPU. \copydetails MultiViewStereo
 *
 *  Images may be in pageable, pinned or device memory; each is found out by its pointer. Compile with nvcc's -fmad=false (the CMake
 *  target does): else the bytes are others. */
template <>
class MultiViewStereo<device::Thrust> {
 public:
  /** \brief Throws pcl::PCLException if there is no device. It runs on the device that is current where it is made. */
  MultiViewStereo()
      : home_("fuse_flow::MultiViewStereo"),
        pipeline_(std::make_unique<detail::StereoPipeline<gpu::StereoBackend>>()) {}

  /** \copydoc MultiViewStereo<device::Host>::setParameters */
  void setParameters(const StereoParameters& parameters) {
    checkParameters(parameters);
    pipeline_->parameters = parameters;
  }
  const StereoParameters& getParameters() const { return pipeline_->parameters; }

  /** \brief Host threads that copy pageable images; 0, the default: one per core, at most 16. */
  void setNumberOfThreads(unsigned int threads) { pipeline_->backend.threads = static_cast<int>(threads); }

  /** \copydoc MultiViewStereo<device::Host>::setNormals */
  void setNormals(bool normals) { normals_ = normals; }

  /** \brief The CUDA stream that it runs on; default the default stream. */
  void setStream(gpu::Stream stream) { pipeline_->backend.run.stream = stream; }

  /** \copydoc MultiViewStereo<device::Host>::estimate */
  void estimate(const RigFrame& frame, StereoFrame& result) {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::MultiViewStereo");
    const gpu::HomeDevice::Visit visit(home_);
    const gpu::OnError settle([this] { pipeline_->backend.settle(); });
    const std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    pipeline_->run(frame);
    detail::writeStereoFrame(*pipeline_, frame, normals_, start, result);
  }

  /** \brief The same, but depth, confidence and colour stay on the device, until the next call: for FuseFlow on the same stream. Returns
   *  before they are computed. \param result its cameras are those of the colour images, see stereoCamera(); views that no other view overlaps
   *  are missing */
  void estimateOnDevice(const RigFrame& frame, RigFrame& result) {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::MultiViewStereo");
    const gpu::HomeDevice::Visit visit(home_);
    const gpu::OnError settle([this] { pipeline_->backend.settle(); });
    pipeline_->run(frame);
    result.cameras = pipeline_->rig().resultCameras();
    result.stamp = frame.stamp;
    result.views.assign(frame.cameras.size(), {});
    for (std::size_t k = 0; k < result.views.size(); ++k) {
      if (pipeline_->rig().geometry(k).sources.empty()) continue;
      const Intrinsics& K = result.cameras[k].intrinsics;
      const std::uint32_t first = pipeline_->firstPixels()[k];
      result.views[k].depth32 = {pipeline_->depth() + first, K.width, K.height};
      result.views[k].confidence = {pipeline_->confidence() + first, K.width, K.height};
      result.views[k].color = pipeline_->images()[k];
    }
  }

  /** \brief Waits until the device has computed what estimateOnDevice() began. */
  void wait() {
    const gpu::HomeDevice::Visit visit(home_);
    pipeline_->backend.wait();
  }

 private:
  detail::OneThread one_thread_;
  gpu::HomeDevice home_;
  std::unique_ptr<detail::StereoPipeline<gpu::StereoBackend>> pipeline_;
  bool normals_{true};
};

}  // namespace fuse_flow
