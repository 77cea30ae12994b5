#pragma once

#include <fuse_flow/calibration/extrinsic_estimation.h>
#include <fuse_flow/distributed/calibration/part_correspondences.h>
#include <fuse_flow/impl/calibration/extrinsic_frames.hpp>

#include <exception>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief ExtrinsicEstimation where each rank has the views of some of the cameras: all ranks get what one process would find with all views,
 *  the same bytes, for any number of ranks and whoever has which camera. On the CPU.
 *
 *  \code
 *  fuse_flow::distributed::ExtrinsicEstimation estimation(ranks);  // a Communicator
 *  estimation.addFrame(frame);                                     // of all cameras, with the views of this rank's
 *  const fuse_flow::ExtrinsicResult result = estimation.estimate();
 *  \endcode
 *
 *  Each rank finds the correspondences in its own views. Some thousand points of each view go to all ranks; then, in each iteration, the sums
 *  of the normal equations go to rank 0, and the poses that it finds go to the others. Images stay where they are.
 *
 *  All ranks must have the same cameras, in the same order, and the same parameters, and call estimate() after equally many frames. A
 *  camera's views are at one rank. Only one thread at a time may use an object. */
class ExtrinsicEstimation {
 public:
  /** \param communicator of this rank; must outlive this object */
  explicit ExtrinsicEstimation(Communicator& communicator) : communicator_(&communicator), system_(communicator) {}

  /** \brief \throws pcl::BadArgumentException for a value out of range */
  void setParameters(const ExtrinsicParameters& parameters) {
    checkParameters(parameters);
    parameters_ = parameters;
  }
  /** \brief What setParameters() set, or the defaults. */
  const ExtrinsicParameters& getParameters() const { return parameters_; }
  /** \brief Threads of this rank; 0, the default, is one per core. */
  void setNumberOfThreads(unsigned int threads) { threads_ = static_cast<int>(threads); }

  /** \brief Forget all frames. */
  void clear() {
    const detail::OneThread::Inside inside(one_thread_, kOwner);
    cameras_.clear();
    system_.clear();
    failure_ = nullptr;
  }

  /** \brief Adds one instant, as ExtrinsicEstimation::addFrame(). Does not throw: what is wrong with a frame estimate() throws, so that the other
   *  ranks hear of it too. \param frame with all cameras of the rig, and the views of those that this rank has */
  void addFrame(const RigFrame& frame) {
    const detail::OneThread::Inside inside(one_thread_, kOwner);
    if (failure_) return;
    try {
      detail::takeCameras(frame, cameras_);
      system_.setThreads(host::resolveThreads(threads_));
      system_.add(frame, parameters_);
    } catch (const std::exception&) {
      failure_ = std::current_exception();
    }
  }

  /** \brief Begins with the poses that rank 0's first frame has. See estimate(initial). */
  ExtrinsicResult estimate() {
    const detail::OneThread::Inside inside(one_thread_, kOwner);
    return estimate(detail::posesOf(cameras_));
  }

  /** \brief Every rank calls this. \param initial where the search begins, one pose for each camera, camera → world; those of rank 0 count
   *  \returns the same at all ranks  \throws RankError where another rank cannot do its part, or has another rig, other parameters, other
   *  frames, or a view of a camera of this one's; what ExtrinsicEstimation throws where this rank cannot. Every rank then throws, and may try
   *  again */
  ExtrinsicResult estimate(const std::vector<Eigen::Isometry3d>& initial) {
    const detail::OneThread::Inside inside(one_thread_, kOwner);
    std::exception_ptr failure = failure_;
    std::string why;
    try {
      if (failure) std::rethrow_exception(failure);
      detail::checkInitialPoses(cameras_, system_.instants(), initial);
    } catch (const std::exception& error) {
      failure = std::current_exception();
      why = error.what();
    }
    system_.setThreads(host::resolveThreads(threads_));
    try {
      system_.meet(FrameDigest().add(cameras_).add(parameters_).value(), why);
    } catch (const RankError&) {
      if (!failure) throw;
    }
    if (failure) std::rethrow_exception(failure);
    return communicator_->rank() == 0 ? lead(initial) : follow();
  }

 private:
  static constexpr const char* kOwner = "fuse_flow::distributed::ExtrinsicEstimation";

  ExtrinsicResult lead(const std::vector<Eigen::Isometry3d>& initial) {
    try {
      const ExtrinsicResult result = host::alignRig(system_, parameters_, initial);
      system_.finish([&](MessageWriter& out) { PoseMessages::put(out, result); });
      return result;
    } catch (const std::exception& error) {
      system_.giveUp(error.what());
      throw;
    }
  }

  ExtrinsicResult follow() {
    const Message found = system_.serve();
    MessageReader in(found, 0);
    PartCorrespondences::skipOrder(in);
    ExtrinsicResult result = PoseMessages::getResult(in, cameras_.size());
    in.finish();
    return result;
  }

  Communicator* communicator_;
  detail::OneThread one_thread_;
  ExtrinsicParameters parameters_;
  int threads_{0};
  std::vector<Camera> cameras_;
  PartCorrespondences system_;
  std::exception_ptr failure_;  ///< of addFrame()
};

}  // namespace distributed
}  // namespace fuse_flow
