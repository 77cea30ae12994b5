#pragma once

#include <fuse_flow/distributed/gpu/device_exchange.h>

#include <pcl/exceptions.h>

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace fuse_flow {
namespace distributed {

/** \brief One DeviceExchange for several frames at a time: they take turns, in the order of the frames, the same at all ranks. So the k-th
 *  exchange of one rank meets the k-th of every other. Where memory is given back, a device waits for all that was launched on it: if ranks
 *  launched their exchanges in different orders, each could wait for one that the other has not launched. */
class ExchangeTurns {
 public:
  /** \param exchange must outlive this object; one thread at a time calls it */
  explicit ExchangeTurns(DeviceExchange& exchange) : exchange_(&exchange) {}

  /** \brief The exchange of one lane, for one frame after the other. */
  class Lane : public DeviceExchange {
   public:
    explicit Lane(ExchangeTurns& turns) : turns_(&turns) {}

    /** \brief Before a frame. \param turn its number, counted from 0 over all lanes */
    void enter(std::uint64_t turn) {
      turn_ = turn;
      over_ = false;
    }
    /** \brief At most once a frame. */
    void exchange(gpu::Execution& run, const std::vector<DeviceMessage>& sends,
                  const std::vector<DeviceMessage>& receives) override {
      if (over_) throw pcl::PCLException("fuse_flow::distributed: a frame exchanges a second time out of its turn");
      turns_->await(turn_);
      const End end{*this};
      turns_->exchange_->exchange(run, sends, receives);
    }
    /** \brief After a frame, which may have exchanged nothing: those after it must not wait for it. */
    void leave() {
      if (over_) return;
      turns_->await(turn_);
      endTurn();
    }

   private:
    struct End {
      Lane& lane;
      ~End() { lane.endTurn(); }
    };
    void endTurn() {
      over_ = true;
      turns_->pass();
    }

    ExchangeTurns* turns_;
    std::uint64_t turn_{0};
    bool over_{true};
  };

 private:
  void await(std::uint64_t turn) {
    std::unique_lock<std::mutex> lock(mutex_);
    passed_.wait(lock, [&] { return turn_ == turn; });
  }
  void pass() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ++turn_;
    }
    passed_.notify_all();
  }

  DeviceExchange* exchange_;
  std::mutex mutex_;
  std::condition_variable passed_;
  std::uint64_t turn_{0};
};

}  // namespace distributed
}  // namespace fuse_flow
