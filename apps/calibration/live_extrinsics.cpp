#include "calibration/live_extrinsics.h"

#include <fuse_flow/calibration/extrinsic_tracking.h>
#include <fuse_flow/device_error.h>
#include <fuse_flow/recordings/error.h>

#include <iomanip>
#include <sstream>

namespace fuse_flow::io {
namespace {

constexpr double kDeviation = 0.005;  // metres: of poses estimated from one frame

}  // namespace

void LiveExtrinsics::place(RigFrame& frame) {
  if (frame.cameras.size() < 2)
    throw InputError("one camera alone tells nothing about its pose: --refine-extrinsics must have two or more");
  if (!tracking_) onEither(frame, [&] { begin(frame); });
  onEither(frame, [&] { follow(frame); });
}

template <typename Action>
void LiveExtrinsics::onEither(RigFrame& frame, const Action& action) {
  try {
    action();
  } catch (const DeviceError& error) {
    if (device_ != "auto" || !warn_) throw;
    device_ = "cpu";
    warn_("the GPU has failed, and the CPU follows the poses: " + std::string(error.what()) +
          "; --device gpu ends there instead");
    if (tracking_) {
      tracking_->apply(frame);
      tracking_ = make_.tracking(device_, frame.cameras, kDeviation);
      updates_ = 0;
    }
    action();
  }
}

void LiveExtrinsics::begin(RigFrame& frame) {
  ExtrinsicParameters parameters;
  parameters.gauge = Gauge::Mean;  // no camera's pose was given better than the others'
  const std::unique_ptr<PoseEstimation> estimation = make_.estimation(device_, parameters);
  estimation->addFrame(frame);
  std::vector<Eigen::Isometry3d> given;
  for (const Camera& camera : frame.cameras) given.push_back(camera.T_world_camera);
  const ExtrinsicResult first = estimation->estimate(given);
  RigFrame placed = frame;
  for (std::size_t i = 0; i < frame.cameras.size(); ++i) placed.cameras[i].T_world_camera = first.T_world_camera[i];
  tracking_ = make_.tracking(device_, placed.cameras, kDeviation);
  frame = placed;
}

void LiveExtrinsics::follow(RigFrame& frame) {
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
