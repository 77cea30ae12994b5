#include "viewer/fusing/fusion_worker.h"

#ifdef __linux__
#include <sys/resource.h>
#endif

namespace fuse_flow::viewing {
namespace {

/** \brief Where cores are few, the window comes first. The threads that fusion starts inherit it. Not by more: a thread needs the CPU to
 *  end, too, and with 10 the program was gone three seconds after its window on a machine that others kept busy. */
void yieldToTheWindow() {
#ifdef __linux__
  constexpr int kNicer = 4;
  setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + kNicer);  // on Linux 0 is the calling thread
#endif
}

}  // namespace

FusionWorker::FusionWorker(std::unique_ptr<FrameSource> source)
    : state_(std::make_shared<State>(std::move(source))), ended_(state_->ended.get_future()) {
  thread_ = std::thread([state = state_] {
    yieldToTheWindow();
    while (const std::optional<FusionRequest> request = state->requests.waitAndTake())
      if (Answer answer = state->fuser.fuse(*request, state->stop)) state->answers.put(std::move(answer));
    state->ended.set_value();
  });
}

bool FusionWorker::stopWithin(std::chrono::milliseconds limit) {
  state_->stop = true;
  state_->requests.close();
  state_->answers.close();
  if (!thread_.joinable()) return true;
  if (ended_.wait_for(limit) != std::future_status::ready) {
    thread_.detach();
    return false;
  }
  thread_.join();
  return true;
}

FusionWorker::~FusionWorker() { stopWithin(std::chrono::hours(1)); }

}  // namespace fuse_flow::viewing
