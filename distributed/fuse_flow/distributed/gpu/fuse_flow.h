#pragma once

#include <fuse_flow/distributed/fuse_flow.h>
#include <fuse_flow/distributed/gpu/part_pipeline.h>
#include <fuse_flow/distributed/gpu/staged_exchange.h>
#include <fuse_flow/gpu/frames/frame_lane.h>

#include <memory>
#include <utility>

namespace fuse_flow {
namespace distributed {

/** \brief On GPUs, one for each rank: together they give the points that fuse_flow::FuseFlow for device::Thrust gives of all views on one, the
 *  same bytes; each rank has those of its cells, in its GPU's memory.
 *
 *  \code
 *  cudaSetDevice(rank);
 *  fuse_flow::distributed::MpiCommunicator ranks;
 *  fuse_flow::distributed::NcclExchange exchange(ranks);  // without: through host memory
 *  fuse_flow::distributed::FuseFlow<fuse_flow::PointFused, fuse_flow::device::Thrust> fusion(ranks, exchange);
 *  fusion.fuse(frame, cloud);  // with the views of this rank's cameras; cloud: the points of its cells
 *  \endcode
 *
 *  Small messages, of which blocks of cells hold points and which windows of pixels are sent, go over the Communicator; pixels go over
 *  the DeviceExchange. Once a rank has begun to send pixels, an error of one leaves the others waiting, as long as the exchange waits.
 *
 *  \copydetails FuseFlow */
template <typename PointT>
class FuseFlow<PointT, device::Thrust> {
 public:
  using PointCloud = pcl::PointCloud<PointT>;

  /** \brief Pixels go through host memory: StagedExchange. It runs on the device that is current where it is made.
   *  \param communicator of this rank; must outlive this object */
  explicit FuseFlow(Communicator& communicator)
      : staged_(std::make_unique<StagedExchange>(communicator)), lane_(std::make_unique<Lane>()) {
    lane_->pipeline.communicator = &communicator;
    lane_->pipeline.exchange = staged_.get();
  }

  /** \param communicator of this rank  \param exchange of the same ranks; both must outlive this object */
  FuseFlow(Communicator& communicator, DeviceExchange& exchange) : lane_(std::make_unique<Lane>()) {
    lane_->pipeline.communicator = &communicator;
    lane_->pipeline.exchange = &exchange;
  }

  /** \brief Throws pcl::BadArgumentException for a value out of range, for use_spatial_hash off (without cells there is nothing to share out),
   *  and for agreement.min_views > 0, which ranks with GPUs do not yet ask each other; device::Host does. */
  void setParameters(const FuseFlowParameters& parameters) {
    checkParameters(parameters);
    if (!parameters.use_spatial_hash)
      detail::throwBadArgument(
          "fuse_flow::distributed::FuseFlow: use_spatial_hash is off, must be on: ranks share out cells");
    if (parameters.agreement.min_views > 0)
      detail::throwBadArgument("fuse_flow::distributed::FuseFlow: agreement.min_views is ",
                               parameters.agreement.min_views,
                               ", must be 0: ranks with GPUs do not ask each other whether views agree; those of "
                               "device::Host do");
    lane_->pipeline.parameters = parameters;
  }
  const FuseFlowParameters& getParameters() const { return lane_->pipeline.parameters; }

  /** \brief As in fuse_flow::FuseFlow for device::Thrust. */
  void setNumberOfThreads(unsigned int threads) { threads_ = static_cast<int>(threads); }
  /** \brief As in fuse_flow::FuseFlow; the same on all ranks. Default off. */
  void setComputeNormals(bool compute) { lane_->compute_normals = compute; }
  /** \brief As in fuse_flow::FuseFlow; the same on all ranks. Default off. */
  void setWeightInIntensity(bool weight) { lane_->weight_in_intensity = weight; }
  /** \brief Who fuses which cells; the same on all ranks. Default Ownership::Curve. */
  void setOwnership(Ownership ownership) { lane_->pipeline.ownership = ownership; }
  /** \brief Whether this rank takes a share of the cells; off for one that only has cameras. At least one must. Default on. */
  void setFusing(bool fusing) { lane_->pipeline.fusing = fusing; }
  /** \brief The CUDA stream that it runs on; default the default stream. On another, a frame's first half is launched as a graph. */
  void setStream(gpu::Stream stream) { lane_->pipeline.run.stream = stream; }

  /** \brief Fuses one frame. \param frame with all cameras of the rig, and the views of those that this rank has; other ranks have the
   *  others. A camera of which no rank has a view is missing  \param output the points of this rank's cells; of its header only the stamp
   *  is set, to the latest of the ranks'
   *  \throws RankError where another rank cannot do its part, or has another rig, other parameters or a camera of this one's; what
   *  fuse_flow::FuseFlow throws where this rank cannot. Before pixels are exchanged, nothing is then fused by any rank, and the next
   *  frame may be tried */
  void fuse(const RigFrame& frame, PointCloud& output) {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::distributed::FuseFlow");
    const gpu::HomeDevice::Visit visit(home_);
    prepare();
    const gpu::PointSpan<PointT> points = lane_->fusePinned(frame);
    gpu::toCloud(points, lane_->pipeline.stamp(), lane_->pipeline.threads, std::memcpy, output);
  }

  /** \brief The same without a copy into a cloud: the points stay in pinned memory until the next call. */
  gpu::PointSpan<PointT> fusePinned(const RigFrame& frame) {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::distributed::FuseFlow");
    const gpu::HomeDevice::Visit visit(home_);
    prepare();
    return lane_->fusePinned(frame);
  }

  /** \brief The points left on the device, for what follows on the same stream; they stay until the next call. */
  gpu::PointSpan<PointT> fuseOnDevice(const RigFrame& frame) {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::distributed::FuseFlow");
    const gpu::HomeDevice::Visit visit(home_);
    prepare();
    const gpu::PointSpan<PointT> points = lane_->fuseOnDevice(frame);
    lane_->pipeline.finish();
    return points;
  }

  /** \brief The same into a cloud of the caller's, for filters that follow on the same stream. */
  void fuse(const RigFrame& frame, gpu::DeviceCloud<PointT>& output) {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::distributed::FuseFlow");
    const gpu::HomeDevice::Visit visit(home_);
    prepare();
    lane_->fuseInto(frame, output);
    output.header.stamp = lane_->pipeline.stamp();
    lane_->pipeline.finish();
  }

  /** \brief Of the whole frame: measured and gated points, missing cameras, noise scales, depth out of range. Of this rank: coarse cells, fused
   *  points, times. */
  const FrameStatistics& getStatistics() const { return lane_->pipeline.statistics; }
  /** \brief What this rank sent, received, and fused in the last frame. */
  const PartStatistics& getPartStatistics() const { return lane_->pipeline.part_statistics; }

  /** \brief Device memory that it holds, bytes. */
  std::size_t getDeviceBytes() const { return lane_->bytes(); }

  /** \brief Measure the stages; default off. */
  gpu::StageTimes& stageTimes() { return lane_->pipeline.times; }

 private:
  using Lane = gpu::FrameLane<PointT, DevicePartPipeline>;

  void prepare() {
    DevicePartPipeline& pipeline = lane_->pipeline;
    pipeline.threads = gpu::copyThreads(threads_);
    pipeline.settings =
        FrameDigest()
            .add(pipeline.parameters)
            .addAll(pipeline.ownership, lane_->compute_normals, lane_->weight_in_intensity, sizeof(PointT), kDeviceTag)
            .value();
  }

  /** \brief What ranks with GPUs send is not what those without do: so their settings differ. */
  static constexpr std::uint32_t kDeviceTag = 0x55504744;

  gpu::HomeDevice home_{"fuse_flow::distributed::FuseFlow"};  // first: nothing else is made without a device
  detail::OneThread one_thread_;
  int threads_{0};
  std::unique_ptr<DeviceExchange> staged_;
  std::unique_ptr<Lane> lane_;
};

}  // namespace distributed
}  // namespace fuse_flow
