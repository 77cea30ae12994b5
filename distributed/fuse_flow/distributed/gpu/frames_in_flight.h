#pragma once

#include <fuse_flow/distributed/frames_in_flight.h>
#include <fuse_flow/distributed/gpu/exchange_turns.h>
#include <fuse_flow/distributed/gpu/fuse_flow.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief On GPUs, one for each rank: while the pixels of one frame are on their way between GPUs, the next is uploaded and measured, and the one
 *  before is fused and downloaded. Each lane has a CUDA stream and memory of its own.
 *
 *  \code
 *  fuse_flow::distributed::MpiCommunicator first, second, third;
 *  fuse_flow::distributed::NcclExchange exchange(first);
 *  fuse_flow::distributed::FramesInFlight<fuse_flow::PointFused, fuse_flow::device::Thrust> fusion({&first, &second, &third}, exchange);
 *  \endcode
 *
 *  \copydetails FramesInFlight */
template <typename PointT>
class FramesInFlight<PointT, device::Thrust> {
 public:
  using PointCloud = pcl::PointCloud<PointT>;
  using Fusion = FuseFlow<PointT, device::Thrust>;

  /** \brief Pixels go through host memory, over the communicators. \param lanes as on the CPU */
  explicit FramesInFlight(const std::vector<Communicator*>& lanes)
      : lanes_(lanes, [](Communicator& communicator) { return std::make_unique<Lane>(communicator); }) {}

  /** \param exchange of the same ranks; the frames take turns. Must outlive this object, and use none of \p lanes while it exchanges */
  FramesInFlight(const std::vector<Communicator*>& lanes, DeviceExchange& exchange)
      : turns_(std::make_unique<ExchangeTurns>(exchange)),
        lanes_(lanes, [this](Communicator& communicator) { return std::make_unique<Lane>(communicator, *turns_); }) {}

  /** \copydoc FramesInFlight<PointT,device::Host>::forEachLane */
  template <typename Setup>
  void forEachLane(const Setup& setup) {
    lanes_.forEach([&](Lane& lane) { setup(lane.fusion); });
  }

  /** \brief Whether each frame is copied into a cloud by the thread that drives it, for next(); default on. Off for nextPinned(). Only while no
   *  frame is in flight. */
  void setCopyAhead(bool copy_ahead) {
    lanes_.forEach([&](Lane& lane) { lane.copy_ahead = copy_ahead; });
    copy_ahead_ = copy_ahead;
  }

  /** \copydoc FramesInFlight<PointT,device::Host>::submit */
  void submit(const RigFrame& frame) {
    lanes_.submit([&](Lane& lane) { lane.enter(frame, submitted_); });
    ++submitted_;
  }

  /** \brief Waits for the oldest frame: the points of this rank's cells. The memory of \p output goes to a later frame. Throws what
   *  FuseFlow::fuse() would have thrown for it; that frame is then gone. \throws pcl::PCLException if none is in flight, or if frames are not
   *  copied ahead */
  void next(PointCloud& output) { output.swap(take(true).cloud); }

  /** \brief The same without a copy: visit(points in pinned memory), which must be done with them when it returns. \throws pcl::PCLException also
   *  if frames are copied ahead */
  template <typename Visit>
  void nextPinned(const Visit& visit) {
    visit(take(false).points);
  }

  std::size_t inFlight() const { return lanes_.inFlight(); }

  ///@{
  /** \brief Of the frame that was taken last. */
  const FrameStatistics& getStatistics() const { return lanes_.statistics(); }
  const PartStatistics& getPartStatistics() const { return lanes_.partStatistics(); }
  ///@}

 private:
  struct Lane {
    explicit Lane(Communicator& communicator) : fusion(communicator) { fusion.setStream(stream.get()); }
    Lane(Communicator& communicator, ExchangeTurns& turns)
        : turn(std::make_unique<ExchangeTurns::Lane>(turns)), fusion(communicator, *turn) {
      fusion.setStream(stream.get());
    }

    void enter(const RigFrame& next, std::uint64_t number) {
      frame = next;
      if (turn) turn->enter(number);
    }

    void begin() const noexcept { home.stay(); }
    void run() {
      const Leave leave{turn.get()};
      if (copy_ahead) {
        fusion.fuse(frame, cloud);
      } else {
        points = fusion.fusePinned(frame);
      }
    }

    struct Leave {
      ExchangeTurns::Lane* turn;
      ~Leave() {
        if (turn != nullptr) turn->leave();
      }
    };

    gpu::HomeDevice home{"fuse_flow::distributed::FramesInFlight"};  // first: nothing else is made without a device
    gpu::OwnStream stream;                                           // outlives what runs on it
    std::unique_ptr<ExchangeTurns::Lane> turn;
    Fusion fusion;
    RigFrame frame;
    bool copy_ahead{true};
    PointCloud cloud;
    gpu::PointSpan<PointT> points;
  };

  Lane& take(bool copied) {
    if (copy_ahead_ != copied)
      throw pcl::PCLException(copied
                                  ? "fuse_flow::distributed::FramesInFlight: next() needs setCopyAhead(true)"
                                  : "fuse_flow::distributed::FramesInFlight: nextPinned() needs setCopyAhead(false)");
    return lanes_.next();
  }

  bool copy_ahead_{true};
  std::uint64_t submitted_{0};
  std::unique_ptr<ExchangeTurns> turns_;
  FrameLanes<Lane> lanes_;
};

}  // namespace distributed
}  // namespace fuse_flow
