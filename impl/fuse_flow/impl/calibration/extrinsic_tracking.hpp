#pragma once

#include <fuse_flow/calibration/extrinsic_tracking.h>
#include <fuse_flow/impl/host/parallel.hpp>

#include <algorithm>
#include <chrono>
#include <cstring>

#if defined(__linux__)
#include <sys/resource.h>
#endif

namespace fuse_flow {
namespace detail {

/** \brief The rows of an image, one after the other. */
template <typename Pixel>
ImageView<Pixel> copyImage(const ImageView<Pixel>& image, std::vector<Pixel>& pixels) {
  if (!image) return {};
  const auto width = static_cast<std::size_t>(image.width);
  pixels.resize(width * static_cast<std::size_t>(image.height));
  for (int v = 0; v < image.height; ++v)
    std::memcpy(pixels.data() + static_cast<std::size_t>(v) * width, image.row(v), width * sizeof(Pixel));
  return {pixels.data(), image.width, image.height};
}

/** \brief The calling thread gives way to others: a frame that is late is worse than poses that are a few frames older. */
inline void giveWay() {
#if defined(__linux__)  // where threads have priorities of their own
  constexpr int behind = 5;
  (void)setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + behind);
#endif
}

/** \brief What runs beside others must not wait for them: on the CPU it does not. */
template <typename PointT>
void runBesideOthers(ExtrinsicEstimation<PointT, device::Host>&) {}

}  // namespace detail

template <typename PointT, typename Device>
ExtrinsicParameters ExtrinsicTracking<PointT, Device>::defaultParameters() {
  ExtrinsicParameters p;
  p.samples = 3000;
  p.max_iterations = 20;
  return p;
}

template <typename PointT, typename Device>
ExtrinsicTracking<PointT, Device>::ExtrinsicTracking(const std::vector<Camera>& cameras, double deviation,
                                                     const ExtrinsicParameters& parameters,
                                                     const PoseFilterParameters& filter)
    : parameters_(parameters), cameras_(cameras.size()) {
  std::vector<Eigen::Isometry3d> initial;
  for (const Camera& camera : cameras) {
    checkCamera(camera);
    initial.push_back(camera.T_world_camera);
  }
  estimation_.setParameters(parameters);
  estimation_.setNumberOfThreads(1);
  using detail::runBesideOthers;  // that of the GPU is found by its argument
  runBesideOthers(estimation_);
  filter_.setParameters(filter);
  filter_.reset(initial, deviation);
  TrackedPoses poses;
  poses.T_world_camera = initial;
  poses_ = std::make_shared<const TrackedPoses>(poses);
  thread_ = std::thread([this] { work(); });
}

template <typename PointT, typename Device>
ExtrinsicTracking<PointT, Device>::~ExtrinsicTracking() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

template <typename PointT, typename Device>
void ExtrinsicTracking<PointT, Device>::setNumberOfThreads(unsigned int threads) {
  finish();
  estimation_.setNumberOfThreads(threads);
}

template <typename PointT, typename Device>
void ExtrinsicTracking<PointT, Device>::setMinInterval(std::uint64_t microseconds) {
  const std::lock_guard<std::mutex> lock(mutex_);
  min_interval_ = microseconds;
}

template <typename PointT, typename Device>
std::uint64_t ExtrinsicTracking<PointT, Device>::getMinInterval() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return min_interval_;
}

template <typename PointT, typename Device>
bool ExtrinsicTracking<PointT, Device>::push(const RigFrame& frame) {
  checkRigFrame(frame);
  if (frame.cameras.size() != cameras_)
    detail::throwBadArgument("fuse_flow::ExtrinsicTracking: a frame of ", frame.cameras.size(), " cameras, must be ",
                             cameras_);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
    if (copying_ || taken_ || cameras_ < 2) return false;  // one camera has nobody to agree with
    // A recording that begins anew goes back in time.
    if (last_stamp_ && frame.stamp > *last_stamp_ && frame.stamp - *last_stamp_ < min_interval_) return false;
    copying_ = true;
  }
  const auto end_copying = [this](bool taken) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      copying_ = false;
      taken_ = taken;
      if (taken) last_stamp_ = copy_.frame.stamp;
    }
    changed_.notify_all();
  };
  try {
    copy_.assign(frame, parameters_.use_color);  // the thread looks at it only once it is taken
  } catch (...) {
    end_copying(false);
    throw;
  }
  end_copying(true);
  return true;
}

template <typename PointT, typename Device>
void ExtrinsicTracking<PointT, Device>::finish() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return !copying_ && !taken_; });
}

template <typename PointT, typename Device>
std::shared_ptr<const TrackedPoses> ExtrinsicTracking<PointT, Device>::poses() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return poses_;
}

template <typename PointT, typename Device>
void ExtrinsicTracking<PointT, Device>::apply(RigFrame& frame) const {
  const std::shared_ptr<const TrackedPoses> newest = poses();
  for (std::size_t i = 0; i < std::min(cameras_, frame.cameras.size()); ++i)
    frame.cameras[i].T_world_camera = newest->T_world_camera[i];
}

template <typename PointT, typename Device>
void ExtrinsicTracking<PointT, Device>::Copy::assign(const RigFrame& from, bool with_color) {
  frame.cameras = from.cameras;
  frame.stamp = from.stamp;
  frame.views.assign(from.views.size(), {});
  depth16.resize(from.views.size());
  depth32.resize(from.views.size());
  color.resize(from.views.size());
  // Two threads, because the caller of push() waits for the copy; not more, because the fusion of frames in flight needs the cores.
  const int threads = std::min({2, host::resolveThreads(0), static_cast<int>(from.views.size())});
  host::parallelFor(threads, from.views.size(), [&](std::size_t i, int) {
    frame.views[i].depth16 = detail::copyImage(from.views[i].depth16, depth16[i]);
    frame.views[i].depth32 = detail::copyImage(from.views[i].depth32, depth32[i]);
    if (with_color) frame.views[i].color = detail::copyImage(from.views[i].color, color[i]);
  });
}

template <typename PointT, typename Device>
void ExtrinsicTracking<PointT, Device>::work() {
  detail::giveWay();
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return taken_ || stop_; });
    if (stop_) return;
    lock.unlock();
    std::exception_ptr error;
    try {
      estimate();
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    error_ = error;
    taken_ = false;
    changed_.notify_all();
  }
}

template <typename PointT, typename Device>
void ExtrinsicTracking<PointT, Device>::estimate() {
  const auto start = std::chrono::steady_clock::now();
  estimation_.clear();
  estimation_.addFrame(copy_.frame);
  TrackedPoses poses;
  poses.moved = filter_.update(estimation_.estimate(filter_.poses()));
  poses.T_world_camera = filter_.poses();
  poses.stamp = copy_.frame.stamp;
  poses.updates = poses_->updates + 1;
  poses.milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  const std::lock_guard<std::mutex> lock(mutex_);
  poses_ = std::make_shared<const TrackedPoses>(std::move(poses));
}

}  // namespace fuse_flow
