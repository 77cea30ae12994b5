#pragma once

#include <fuse_flow/distributed/communicator.h>
#include <fuse_flow/distributed/part_statistics.h>
#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/impl/host/lane_ring.hpp>
#include <fuse_flow/one_thread.h>

#include <memory>
#include <string>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief What FramesInFlight is on any device: lanes, each with a FuseFlow of its own, and what is refused.
 *  \tparam Lane has fusion, and run() for a frame */
template <typename Lane>
class FrameLanes {
 public:
  /** \param make makes the lane of a communicator: a std::unique_ptr<Lane> */
  template <typename Make>
  FrameLanes(const std::vector<Communicator*>& communicators, const Make& make)
      : ranks_(ranksOf(communicators)),
        ring_(communicators.size(), [&](std::size_t k) { return make(*communicators[k]); }) {}

  /** \brief \throws pcl::BadArgumentException if there is no such rank, and it is not −1 */
  void checkRank(int rank) const {
    if (rank < -1 || rank >= ranks_)
      detail::throwBadArgument(kName, ": the rank to gather at is ", rank, ", must be in [-1, ", ranks_ - 1, "]");
  }

  std::size_t inFlight() const { return ring_.inFlight(); }
  const FrameStatistics& statistics() const { return statistics_; }
  const PartStatistics& partStatistics() const { return part_statistics_; }

  /** \brief For settings: visit(lane) of each. */
  template <typename Visit>
  void forEach(const Visit& visit) {
    const detail::OneThread::Inside inside(one_thread_, kName);
    if (inFlight() > 0)
      throw pcl::PCLException(std::string(kName) +
                              ": frames are in flight: take them by next() before settings change");
    for (std::size_t k = 0; k < ring_.lanes(); ++k) visit(ring_.lane(k));
  }

  /** \brief Starts a frame. \param enter enter(lane) gives it to the lane */
  template <typename Enter>
  void submit(const Enter& enter) {
    const detail::OneThread::Inside inside(one_thread_, kName);
    if (inFlight() == ring_.lanes())
      throw pcl::PCLException(std::string(kName) + ": " + std::to_string(ring_.lanes()) +
                              " frames are in flight; call next() first");
    enter(ring_.upcoming());
    ring_.start();
  }

  /** \brief Waits for the oldest frame; throws what its run() threw, and then has no statistics. */
  Lane& next() {
    const detail::OneThread::Inside inside(one_thread_, kName);
    if (inFlight() == 0) throw pcl::PCLException(std::string(kName) + ": no frame is in flight");
    statistics_ = {};
    part_statistics_ = {};
    Lane& lane = ring_.finishOldest();
    statistics_ = lane.fusion.getStatistics();
    part_statistics_ = lane.fusion.getPartStatistics();
    return lane;
  }

 private:
  static constexpr const char* kName = "fuse_flow::distributed::FramesInFlight";

  /** \brief How many ranks they join. */
  static int ranksOf(const std::vector<Communicator*>& communicators) {
    if (communicators.empty())
      detail::throwBadArgument(kName, ": there is no communicator, must be one for each frame that may be in flight");
    for (std::size_t k = 0; k < communicators.size(); ++k) {
      if (communicators[k] == nullptr) detail::throwBadArgument(kName, ": communicator ", k, " is null");
      for (std::size_t before = 0; before < k; ++before)
        if (communicators[before] == communicators[k])
          detail::throwBadArgument(kName, ": communicators ", before, " and ", k,
                                   " are the same, must be different: messages of two frames would get mixed up");
      if (communicators[k]->size() != communicators[0]->size() || communicators[k]->rank() != communicators[0]->rank())
        detail::throwBadArgument(kName, ": communicator ", k, " is of other ranks than the first");
    }
    return communicators[0]->size();
  }

  detail::OneThread one_thread_;
  FrameStatistics statistics_;
  PartStatistics part_statistics_;
  int ranks_;
  host::LaneRing<Lane> ring_;
};

}  // namespace distributed
}  // namespace fuse_flow
