#pragma once

#include <fuse_flow/distributed/gathered_cells.h>
#include <fuse_flow/distributed/part_meeting.h>
#include <fuse_flow/distributed/part_statistics.h>
#include <fuse_flow/distributed/refined_messages.h>
#include <fuse_flow/distributed/window_messages.h>
#include <fuse_flow/fuse_flow.h>

#include <exception>
#include <memory>

namespace fuse_flow {
namespace distributed {

/** \brief The frame pipeline over several ranks, each of which has some of the cameras: together they give what FuseFlow gives of all
 *  views, the same bytes, for any number of ranks and whoever has which camera.
 *
 *  \code
 *  fuse_flow::distributed::MpiCommunicator ranks;                          // or ThreadRanks
 *  fuse_flow::distributed::FuseFlow<fuse_flow::PointFused> fusion(ranks);
 *  fusion.fuse(frame, cloud);         // of all cameras, with the views of this rank's; cloud: the points of this rank's cells
 *  fusion.gather(cloud, whole, 0);    // all of them, at rank 0, as one process would give them
 *  \endcode
 *
 *  Every rank turns its own views into depth maps and weighted points. All tell each other in which blocks of cells they have points; each
 *  then knows which blocks are whose (Ownership), and sends of its views what the cells of others look at. A frame costs two exchanges: one
 *  small, one large; and a third before them where measurements need views that agree (AgreementParameters). Nothing is kept from frame to
 *  frame but memory.
 *
 *  All ranks must have the same cameras, in the same order, the same parameters and the same PointT, and call fuse() equally often: each
 *  call is compared. Only one thread at a time may use an object. Source: the paper's section 5; that cells can be fused apart, design.md's
 *  cells. */
template <typename PointT, typename Device = device::Host>
class FuseFlow;

/** \brief On the CPU. \copydetails FuseFlow */
template <typename PointT>
class FuseFlow<PointT, device::Host> {
 public:
  using PointCloud = pcl::PointCloud<PointT>;

  /** \param communicator of this rank; must outlive this object */
  explicit FuseFlow(Communicator& communicator)
      : communicator_(&communicator), writer_(std::make_unique<host::PointWriter<PointT>>(pipeline_)) {}

  /** \brief Throws pcl::BadArgumentException for a value out of range, and for use_spatial_hash off: without cells there is nothing to
   *  share out. */
  void setParameters(const FuseFlowParameters& parameters) {
    checkParameters(parameters);
    if (!parameters.use_spatial_hash)
      detail::throwBadArgument(
          "fuse_flow::distributed::FuseFlow: use_spatial_hash is off, must be on: ranks share out cells");
    pipeline_.parameters = parameters;
  }
  const FuseFlowParameters& getParameters() const { return pipeline_.parameters; }

  /** \brief Threads of this rank; 0, the default, is one per core. */
  void setNumberOfThreads(unsigned int threads) { pipeline_.threads = static_cast<int>(threads); }
  /** \brief As in FuseFlow; the same on all ranks. Default off. */
  void setComputeNormals(bool compute) { compute_normals_ = compute; }
  /** \brief As in FuseFlow; the same on all ranks. Default off. */
  void setWeightInIntensity(bool weight) {
    weight_in_intensity_ = weight;
    writer_->setWeightInIntensity(weight);
  }
  /** \brief Who fuses which cells; the same on all ranks. Default Ownership::Curve. */
  void setOwnership(Ownership ownership) { ownership_ = ownership; }
  /** \brief Whether this rank takes a share of the cells; off for one that only has cameras. At least one must. Default on. */
  void setFusing(bool fusing) { fusing_ = fusing; }

  /** \brief What makes the large messages shorter, without loss: they are coded before they are sent, on all threads. The same on all ranks;
   *  or null, the default, for none. Pays where the network is slower than some 2 Gbit/s, see doc/notes/ranks.md */
  void setCodec(std::shared_ptr<const Codec> codec) { codec_ = std::move(codec); }

  /** \brief Fuses one frame. \param frame with all cameras of the rig, and the views of those that this rank has; other ranks have the
   *  others. A camera of which no rank has a view is missing  \param output the points of this rank's cells; of its header only the stamp
   *  is set, to the latest of the ranks'
   *  \throws RankError where another rank cannot do its part, or has another rig, other parameters or a camera of this one's; what FuseFlow
   *  throws where this rank cannot. Nothing is then fused by any rank, and the next frame may be tried */
  void fuse(const RigFrame& frame, PointCloud& output) {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::distributed::FuseFlow");
    const auto start = Clock::now();
    part_statistics_ = {};
    pipeline_.with_color = point::shows_color<PointT>;
    meet(frame);
    part_statistics_.summary_ms = host::FramePipeline::since(start);
    const auto met = Clock::now();
    owners_.assign(parts_, pipeline_.cameraCount(), ownership_);
    part_statistics_.imbalance = owners_.imbalance();
    exchangeWindows();
    part_statistics_.exchange_ms = host::FramePipeline::since(met);
    fuseCells(output);
    pipeline_.statistics.total_ms = host::FramePipeline::since(start);
  }

  /** \brief Puts the clouds of the last fuse() together at one rank, in the order in which one process would give the points. Every rank calls
   *  this, after the same fuse(). \param part what this rank's fuse() gave  \param whole at \p root all points; at others it becomes empty */
  void gather(const PointCloud& part, PointCloud& whole, int root);

  /** \brief Of the whole frame: measured and gated points, missing cameras, noise scales, depth out of range. Of this rank: coarse cells, fused
   *  points, times. */
  const FrameStatistics& getStatistics() const { return pipeline_.statistics; }
  /** \brief What this rank sent, received, and fused in the last frame; after gather() with what that sent. */
  const PartStatistics& getPartStatistics() const { return part_statistics_; }

 private:
  using Clock = host::FramePipeline::Clock;

  int ranks() const { return communicator_->size(); }
  int own() const { return communicator_->rank(); }

  void meet(const RigFrame& frame);
  void shareRefined();
  void exchangeWindows();
  void fuseCells(PointCloud& output);
  void exchange(const std::vector<Message>& out, const std::vector<Message>& plain) {
    exchangeWithAll(*communicator_, out, plain, in_, part_statistics_);
  }
  void exchangeCoded(const std::vector<Message>& out, const std::vector<MessageParts>& parts);
  void decodeIncoming(const std::vector<int>& from);
  void checkCodecs(const std::vector<int>& from) const;

  Communicator* communicator_;
  detail::OneThread one_thread_;
  PartPipeline pipeline_;
  std::unique_ptr<host::PointWriter<PointT>> writer_;
  bool compute_normals_{false}, weight_in_intensity_{false}, fusing_{true};
  Ownership ownership_{Ownership::Curve};
  std::vector<PartSummary> parts_;  ///< by rank
  BlockOwners owners_;
  WindowWriter window_writer_;
  WindowReader window_reader_;
  std::vector<Message> in_, coded_, plain_;
  std::shared_ptr<const Codec> codec_;
  CodedMessage coding_;
  PartStatistics part_statistics_;
};

}  // namespace distributed
}  // namespace fuse_flow

#include <fuse_flow/distributed/impl/fuse_flow.hpp>
