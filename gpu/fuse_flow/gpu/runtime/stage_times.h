#pragma once

#include <fuse_flow/gpu/runtime/system.h>

#include <chrono>
#include <string>
#include <vector>

namespace fuse_flow {
namespace gpu {

/** \brief Device time of each stage of a frame, for the benchmark; costs nothing unless enabled. */
class StageTimes {
 public:
  struct Stage {
    const char* name;
    /** \brief Each input read once, each output written once: what the stage would move if it were a single pass. An image that it
     *  looks into counts whole; where it takes samples, only those do. */
    double bytes;
    /** \brief What the passes of its algorithm read and write, with what they hand from one to the next; at least bytes. */
    double moved_bytes;
    double ms;
  };

  bool enabled{false};

  ~StageTimes() {
#if FUSE_FLOW_CUDA
    for (const cudaEvent_t event : events_) (void)cudaEventDestroy(event);
#endif
  }
  StageTimes() = default;
  StageTimes(const StageTimes&) = delete;

  void start(Stream stream) {
    if (!enabled) return;
    stream_ = stream;
    stages_.clear();
    record();
  }

  /** \brief Ends a stage of a single pass. */
  void mark(const char* name, double bytes = 0) { mark(name, bytes, bytes); }
  /** \brief Ends a stage of several. */
  void mark(const char* name, double bytes, double moved_bytes) {
    if (!enabled) return;
    stages_.push_back({name, bytes, moved_bytes, 0});
    record();
  }

  ///@{
  /** \brief Of a stage that has been marked, once it is known how much there was. */
  void setBytes(const char* name, double bytes) { setBytes(name, bytes, bytes); }
  void setBytes(const char* name, double bytes, double moved_bytes) {
    if (!enabled) return;
    for (Stage& stage : stages_)
      if (std::string(stage.name) == name) {
        stage.bytes = bytes;
        stage.moved_bytes = moved_bytes;
      }
  }
  ///@}

  /** \brief Of the last frame, after its stream has been waited for. */
  const std::vector<Stage>& stages() {
    for (std::size_t k = 0; k < stages_.size(); ++k) {
#if FUSE_FLOW_CUDA
      float ms = 0;
      check(cudaEventElapsedTime(&ms, events_[k], events_[k + 1]), "cudaEventElapsedTime");
      stages_[k].ms = static_cast<double>(ms);
#else
      stages_[k].ms = std::chrono::duration<double, std::milli>(moments_[k + 1] - moments_[k]).count();
#endif
    }
    return stages_;
  }

 private:
  void record() {
    const std::size_t k = stages_.size();
#if FUSE_FLOW_CUDA
    while (events_.size() <= k) {
      events_.emplace_back();
      check(cudaEventCreate(&events_.back()), "cudaEventCreate");
    }
    check(cudaEventRecord(events_[k], stream_), "cudaEventRecord");
#else
    moments_.resize(k + 1);
    moments_[k] = std::chrono::steady_clock::now();
#endif
  }

  Stream stream_{};
  std::vector<Stage> stages_;
#if FUSE_FLOW_CUDA
  std::vector<cudaEvent_t> events_;
#else
  std::vector<std::chrono::steady_clock::time_point> moments_;
#endif
};

}  // namespace gpu
}  // namespace fuse_flow
