#pragma once

#include "viewer/fusing/frame_fuser.h"
#include "viewer/fusing/latest_slot.h"

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <thread>

namespace fuse_flow::viewing {

/** \brief A FrameFuser on a thread of its own. Requests and answers that come too fast replace each other. */
class FusionWorker {
 public:
  using Answer = std::shared_ptr<const FusedFrame>;

  explicit FusionWorker(std::unique_ptr<FrameSource> source);
  /** \brief Waits for the frame at hand; see stopWithin(). */
  ~FusionWorker();
  FusionWorker(const FusionWorker&) = delete;
  FusionWorker& operator=(const FusionWorker&) = delete;

  void post(FusionRequest request) { state_->requests.put(std::move(request)); }
  /** \brief The latest answer that was not taken yet. */
  std::optional<Answer> take() { return state_->answers.take(); }
  /** \brief Waits for one. Only after post(). */
  std::optional<Answer> wait() { return state_->answers.waitAndTake(); }

  /** \brief Stops between two steps of a frame. False if the step at hand takes longer than that: the thread is then left to
   *  itself, and the program should end. */
  bool stopWithin(std::chrono::milliseconds limit);

 private:
  /** \brief Shared with the thread, which may outlive the worker. */
  struct State {
    explicit State(std::unique_ptr<FrameSource> source) : fuser(std::move(source)) {}
    FrameFuser fuser;
    LatestSlot<FusionRequest> requests;
    LatestSlot<Answer> answers;
    std::atomic<bool> stop{false};
    std::promise<void> ended;
  };

  std::shared_ptr<State> state_;
  std::future<void> ended_;
  std::thread thread_;
};

}  // namespace fuse_flow::viewing
