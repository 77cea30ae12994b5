#pragma once

#include "calibration/poses.h"

#include <fuse_flow/calibration/extrinsic_tracking.h>

namespace fuse_flow::io {

/** \brief The interface over a class of the library. */
template <typename Estimation>
class PoseEstimationBy : public PoseEstimation {
 public:
  /** \param more that the class itself asks for */
  template <typename... More>
  PoseEstimationBy(const ExtrinsicParameters& parameters, unsigned int threads, More&... more) : estimation_(more...) {
    estimation_.setParameters(parameters);
    estimation_.setNumberOfThreads(threads);
  }
  void addFrame(const RigFrame& frame) override { estimation_.addFrame(frame); }
  ExtrinsicResult estimate(const std::vector<Eigen::Isometry3d>& initial) override {
    return estimation_.estimate(initial);
  }

 private:
  Estimation estimation_;
};

/** \brief The interface over a class of the library. */
template <typename Tracking>
class PoseTrackingBy : public PoseTracking {
 public:
  PoseTrackingBy(const std::vector<Camera>& cameras, double deviation) : tracking_(cameras, deviation) {}
  bool push(const RigFrame& frame) override { return tracking_.push(frame); }
  void finish() override { tracking_.finish(); }
  std::shared_ptr<const TrackedPoses> poses() const override { return tracking_.poses(); }
  void apply(RigFrame& frame) const override { tracking_.apply(frame); }

 private:
  Tracking tracking_;
};

}  // namespace fuse_flow::io
