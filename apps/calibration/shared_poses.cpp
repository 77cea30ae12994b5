#include "calibration/shared_poses.h"

#include "calibration/poses_by.h"

#include <fuse_flow/distributed/calibration/extrinsic_tracking.h>

namespace fuse_flow::io {
namespace {

class SharedPoseTracking : public PoseTracking {
 public:
  SharedPoseTracking(distributed::Communicator& communicator, const std::vector<Camera>& cameras, double deviation,
                     unsigned int threads, std::uint64_t min_interval)
      : tracking_(communicator, cameras, deviation) {
    tracking_.setNumberOfThreads(threads);
    tracking_.setMinInterval(min_interval);
  }
  bool push(const RigFrame& frame) override { return tracking_.push(frame); }
  void finish() override {}  // push() has
  std::shared_ptr<const TrackedPoses> poses() const override {
    return std::make_shared<const TrackedPoses>(tracking_.poses());
  }
  void apply(RigFrame& frame) const override { tracking_.apply(frame); }

 private:
  distributed::ExtrinsicTracking tracking_;
};

}  // namespace

PoseMakers makersOfSharedPoses(distributed::Communicator& communicator, unsigned int threads,
                               std::uint64_t min_interval) {
  PoseMakers makers;
  makers.estimation = [&communicator, threads](const std::string&, const ExtrinsicParameters& parameters) {
    return std::make_unique<PoseEstimationBy<distributed::ExtrinsicEstimation>>(parameters, threads, communicator);
  };
  makers.tracking = [&communicator, threads, min_interval](const std::string&, const std::vector<Camera>& cameras,
                                                           double deviation) {
    return std::make_unique<SharedPoseTracking>(communicator, cameras, deviation, threads, min_interval);
  };
  return makers;
}

}  // namespace fuse_flow::io
