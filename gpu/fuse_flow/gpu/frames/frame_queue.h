#pragma once

#include <fuse_flow/gpu/frames/frame_lane.h>
#include <fuse_flow/gpu/runtime/stream_copy.h>

#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>

namespace fuse_flow {
namespace gpu {

/** \brief How far the thread that drives a frame brings its points. */
enum class Delivery { Device, Pinned, Cloud };

/** \brief Several lanes process the frames in cyclic order. Each lane has its own thread and stream: while one frame is computed, the next
 *  frame is uploaded and the previous frame is downloaded. */
template <typename PointT>
class FrameQueue {
 public:
  explicit FrameQueue(std::size_t lanes) {
    for (std::size_t k = 0; k < lanes; ++k) workers_.push_back(std::make_unique<Worker>());
  }

  std::size_t lanes() const { return workers_.size(); }
  std::size_t inFlight() const { return submitted_ - taken_; }

  /** \brief prepare(lane) sets the lane's parameters, its share of the host threads among them; the images must stay alive until the frame has been taken. The lane must
   *  be free: fewer frames in flight than lanes. \param after a stream whose work, as it is by now, comes first */
  template <typename Prepare>
  void submit(const RigFrame& frame, Delivery delivery, Stream after, const Prepare& prepare) {
    Worker& worker = *workers_[submitted_ % lanes()];
    prepare(worker.lane);
    worker.delivery = delivery;
    worker.order.put(after, worker.stream.get());
    worker.start(frame);
    ++submitted_;
  }

  /** \brief Waits for the oldest frame; take(lane, points, stamp, cloud) must be done with the points when it returns. They are in
   *  pinned memory, null if they were left on the device: the lane has them. The cloud, else null, has been filled if that was to
   *  be; it may be swapped for another. Rethrows what its computation threw. */
  template <typename Take>
  void next(const Take& take) {
    Worker& worker = *workers_[taken_ % lanes()];
    ++taken_;
    worker.finish();
    take(worker.lane, worker.points, worker.frame.stamp, worker.delivery == Delivery::Cloud ? &worker.cloud : nullptr);
  }

 private:
  struct Worker {
    OwnStream stream{StreamPriority::First};  // before the search for poses; outlives what runs on it
    StreamOrder order;
    FrameLane<PointT> lane;
    RigFrame frame;
    PointSpan<PointT> points;
    Delivery delivery{Delivery::Pinned};
    pcl::PointCloud<PointT> cloud;

    Worker() {
#if FUSE_FLOW_CUDA
      check(cudaGetDevice(&device_), "cudaGetDevice");
#endif
      lane.pipeline.run.stream = stream.get();
      thread_ = std::thread([this] { work(); });
    }

    ~Worker() {
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        state_ = State::Stop;
      }
      changed_.notify_all();
      thread_.join();
    }

    void start(const RigFrame& next) {
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        frame = next;
        state_ = State::Working;
      }
      changed_.notify_all();
    }

    void finish() {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [this] { return state_ == State::Idle; });
      if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
    }

   private:
    enum class State { Idle, Working, Stop };

    void work() {
#if FUSE_FLOW_CUDA
      (void)cudaSetDevice(device_);
#endif
      std::unique_lock<std::mutex> lock(mutex_);
      for (;;) {
        changed_.wait(lock, [this] { return state_ != State::Idle; });
        if (state_ == State::Stop) return;
        lock.unlock();
        std::exception_ptr error;
        try {
          deliver();
        } catch (...) {
          error = std::current_exception();
        }
        lock.lock();
        error_ = error;
        if (state_ == State::Working) state_ = State::Idle;
        changed_.notify_all();
      }
    }

    void deliver() {
      if (delivery == Delivery::Device) {
        lane.fuseOnDevice(frame);
        lane.pipeline.run.wait();
        lane.pipeline.finish();
        points = {nullptr, 0};
        return;
      }
      points = lane.fusePinned(frame);
      if (delivery == Delivery::Cloud) toCloud(points, frame.stamp, lane.pipeline.threads, streamCopy, cloud);
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    State state_{State::Idle};
    std::exception_ptr error_;
    int device_{0};
    std::thread thread_;
  };

  std::vector<std::unique_ptr<Worker>> workers_;
  std::size_t submitted_{0};
  std::size_t taken_{0};
};

}  // namespace gpu
}  // namespace fuse_flow
