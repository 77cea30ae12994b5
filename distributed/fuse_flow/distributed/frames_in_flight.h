#pragma once

#include <fuse_flow/distributed/frame_lanes.h>
#include <fuse_flow/distributed/fuse_flow.h>

#include <memory>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief Several frames at a time over the same ranks: while the images of one are on their way between ranks, the next is measured and the
 *  one before is fused. Each frame is that of FuseFlow, the same bytes; frames a second rise, and no frame is ready sooner.
 *
 *  \code
 *  MPI_Init_thread(…, MPI_THREAD_MULTIPLE, …);
 *  fuse_flow::distributed::MpiCommunicator first, second;
 *  fuse_flow::distributed::FramesInFlight<fuse_flow::PointFused> fusion({&first, &second});
 *  fusion.forEachLane([&](auto& lane) { lane.setParameters(parameters); });
 *  fusion.submit(frame);  // its images must stay alive until next() has returned it
 *  fusion.submit(later);
 *  fusion.next(cloud);    // of frame
 *  \endcode
 *
 *  Every frame has a communicator of its own while it is in flight, as messages of two would get mixed up: so there are as many lanes as
 *  communicators, and MPI must allow several threads at once. All ranks have equally many lanes, and call submit() and next() equally often.
 *  The destructor waits for the frames in flight. After a rank was silent (RankError) that frame's communicator is of no more use, nor is this object.
 *  Only one thread at a time may use an object. */
template <typename PointT, typename Device = device::Host>
class FramesInFlight;

/** \brief On the CPU. \copydetails FramesInFlight */
template <typename PointT>
class FramesInFlight<PointT, device::Host> {
 public:
  using PointCloud = pcl::PointCloud<PointT>;
  using Fusion = FuseFlow<PointT, device::Host>;

  /** \param lanes of this rank, one for each frame that may be in flight, each another one; must outlive this object
   *  \throws pcl::BadArgumentException for none, for a null pointer, for the same twice, and for those of different ranks */
  explicit FramesInFlight(const std::vector<Communicator*>& lanes)
      : lanes_(lanes, [](Communicator& communicator) { return std::make_unique<Lane>(communicator); }) {}

  /** \brief For settings: setup(Fusion&), of each lane. All lanes need the same. Threads are of each lane: of the default, 0,
   *  each takes all cores. Only while no frame is in flight. */
  template <typename Setup>
  void forEachLane(const Setup& setup) {
    lanes_.forEach([&](Lane& lane) { setup(lane.fusion); });
  }

  /** \brief The rank at which next() gives the whole cloud, and at others an empty one; −1, the default: each rank keeps the points of its
   *  cells. The same on all ranks. \throws pcl::BadArgumentException if there is no such rank */
  void setGatherAt(int rank) {
    lanes_.checkRank(rank);
    lanes_.forEach([&](Lane& lane) { lane.gather_at = rank; });
  }

  /** \brief Starts a frame and returns. \param frame as for FuseFlow::fuse()  \throws pcl::PCLException if as many are in flight as there are
   *  lanes */
  void submit(const RigFrame& frame) {
    lanes_.submit([&](Lane& lane) { lane.frame = frame; });
  }

  /** \brief Waits for the oldest frame. The memory of \p output goes to a later one. Throws what FuseFlow::fuse() would have thrown for it;
   *  that frame is then gone. \throws pcl::PCLException if none is in flight */
  void next(PointCloud& output) {
    Lane& lane = lanes_.next();
    output.swap(lane.gather_at < 0 ? lane.part : lane.whole);
  }

  std::size_t inFlight() const { return lanes_.inFlight(); }

  ///@{
  /** \brief Of the frame that was taken last. */
  const FrameStatistics& getStatistics() const { return lanes_.statistics(); }
  const PartStatistics& getPartStatistics() const { return lanes_.partStatistics(); }
  ///@}

 private:
  struct Lane {
    explicit Lane(Communicator& communicator) : fusion(communicator) {}
    void begin() const noexcept {}
    void run() {
      fusion.fuse(frame, part);
      if (gather_at >= 0) fusion.gather(part, whole, gather_at);
    }

    Fusion fusion;
    RigFrame frame;
    int gather_at{-1};
    PointCloud part, whole;
  };

  FrameLanes<Lane> lanes_;
};

}  // namespace distributed
}  // namespace fuse_flow
