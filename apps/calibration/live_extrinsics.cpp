#include "calibration/live_extrinsics.h"

#include <fuse_flow/calibration/extrinsic_tracking.h>

#include <iomanip>
#include <sstream>

namespace fuse_flow::io {
namespace {

constexpr double kDeviation = 0.005;  // metres: of poses estimated from one frame

}  // namespace

void LiveExtrinsics::place(RigFrame& frame) {
  if (!tracking_) {
    ExtrinsicParameters parameters;
    parameters.gauge = Gauge::Mean;  // no camera's pose was given better than the others'
    const std::unique_ptr<PoseEstimation> estimation = makePoseEstimation(device_, parameters);
    estimation->addFrame(frame);
    std::vector<Eigen::Isometry3d> given;
    for (const Camera& camera : frame.cameras) given.push_back(camera.T_world_camera);
    const ExtrinsicResult first = estimation->estimate(given);
    for (std::size_t i = 0; i < frame.cameras.size(); ++i) frame.cameras[i].T_world_camera = first.T_world_camera[i];
    tracking_ = makePoseTracking(device_, frame.cameras, kDeviation);
  }
  tracking_->finish();
  tracking_->apply(frame);
  const std::shared_ptr<const TrackedPoses> poses = tracking_->poses();
  moved_ = poses->updates != updates_ ? poses->moved : std::vector<CameraMotion>();
  updates_ = poses->updates;
  tracking_->push(frame);
}

std::string describe(const CameraMotion& motion, const std::vector<Camera>& cameras) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << "camera '" << cameras[motion.camera].name << "' has moved by "
       << 1000 * motion.translation << " mm and " << std::setprecision(2) << motion.rotation * 180 / 3.14159265358979
       << " degrees";
  return text.str();
}

}  // namespace fuse_flow::io
