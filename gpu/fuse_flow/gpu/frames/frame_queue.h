#pragma once

#include <fuse_flow/gpu/frames/frame_lane.h>
#include <fuse_flow/gpu/runtime/stream_copy.h>
#include <fuse_flow/impl/host/lane_ring.hpp>

#include <memory>

namespace fuse_flow {
namespace gpu {

/** \brief How far the thread that drives a frame brings its points. */
enum class Delivery { Device, Pinned, Cloud };

/** \brief Several lanes process the frames in cyclic order. Each lane has its own thread and stream: while one frame is computed, the next
 *  frame is uploaded and the previous frame is downloaded. */
template <typename PointT>
class FrameQueue {
 public:
  explicit FrameQueue(std::size_t lanes) : ring_(lanes, [](std::size_t) { return std::make_unique<Seat>(); }) {}

  std::size_t lanes() const { return ring_.lanes(); }
  std::size_t inFlight() const { return ring_.inFlight(); }

  /** \brief prepare(lane) sets the lane's parameters, its share of the host threads among them; the images must stay alive until the frame has been taken. The lane must
   *  be free: fewer frames in flight than lanes. \param after a stream whose work, as it is by now, comes first */
  template <typename Prepare>
  void submit(const RigFrame& frame, Delivery delivery, Stream after, const Prepare& prepare) {
    Seat& seat = ring_.upcoming();
    prepare(seat.lane);
    seat.delivery = delivery;
    seat.order.put(after, seat.stream.get());
    seat.frame = frame;
    ring_.start();
  }

  /** \brief Waits for the oldest frame; take(lane, points, stamp, cloud) must be done with the points when it returns. They are in
   *  pinned memory, null if they were left on the device: the lane has them. The cloud, else null, has been filled if that was to
   *  be; it may be swapped for another. Rethrows what its computation threw. */
  template <typename Take>
  void next(const Take& take) {
    Seat& seat = ring_.finishOldest();
    take(seat.lane, seat.points, seat.frame.stamp, seat.delivery == Delivery::Cloud ? &seat.cloud : nullptr);
  }

 private:
  /** \brief A lane, the frame that it is at, and what comes of it. */
  struct Seat {
    HomeDevice home{"fuse_flow::FuseFlow"};   // first: nothing else is made without a device
    OwnStream stream{StreamPriority::First};  // before the search for poses; outlives what runs on it
    StreamOrder order;
    FrameLane<PointT> lane;
    RigFrame frame;
    PointSpan<PointT> points;
    Delivery delivery{Delivery::Pinned};
    pcl::PointCloud<PointT> cloud;

    Seat() { lane.pipeline.run.stream = stream.get(); }

    void begin() const noexcept { home.stay(); }
    void run() {
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
  };

  host::LaneRing<Seat> ring_;
};

}  // namespace gpu
}  // namespace fuse_flow
