#pragma once

#include "methods/method.h"

#include <fuse_flow/recordings/recording.h>

#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief A frame that was fused, with what it was fused from. */
struct FusedFrame {
  std::size_t number{0};  ///< of the recording
  LoadedFrame input;
  Method::Cloud cloud;
  bool has_normals{false};                         ///< see MethodOptions::normals
  pcl::PointCloud<PointFusedNormal> with_normals;  ///< then the same points with them
  FrameStatistics statistics;
};

/** \brief An output for fused frames: files, figures, or anything else that takes one frame after the other. One loop can feed several
 *  sinks. */
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  /** \brief One frame; they come in the order in which they were chosen. What a sink keeps stays as it is: the frame's memory is used again
   *  only when nobody holds it. \throws what ends the run */
  virtual void take(const std::shared_ptr<const FusedFrame>& frame) = 0;
  /** \brief After the last frame: what was noticed, a line each. */
  virtual std::vector<std::string> finish() { return {}; }
};

/** \brief Memory for frames, used again once nobody holds it. Frames may be let go of on any thread, also after the pool is gone. */
class FramePool {
 public:
  /** \brief A frame to be filled in, with the memory of an earlier one where there is one. For one thread. */
  std::shared_ptr<FusedFrame> next() {
    std::unique_ptr<FusedFrame> frame;
    {
      const std::lock_guard<std::mutex> lock(free_->mutex);
      if (!free_->frames.empty()) {
        frame = std::move(free_->frames.back());
        free_->frames.pop_back();
      }
    }
    if (!frame) {
      frame = std::make_unique<FusedFrame>();
      ++size_;
    }
    const auto give_back = [free = free_](FusedFrame* used) {
      std::unique_ptr<FusedFrame> owner(used);
      const std::lock_guard<std::mutex> lock(free->mutex);
      free->frames.push_back(std::move(owner));
    };
    return std::shared_ptr<FusedFrame>(frame.release(), give_back);
  }
  /** \brief Frames in memory. */
  std::size_t size() const { return size_; }

 private:
  struct Free {
    std::mutex mutex;
    std::vector<std::unique_ptr<FusedFrame>> frames;
  };
  std::shared_ptr<Free> free_{std::make_shared<Free>()};
  std::size_t size_{0};
};

}  // namespace fuse_flow::io
