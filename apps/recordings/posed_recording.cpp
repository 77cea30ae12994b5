#include "recordings/posed_recording.h"

#include <fuse_flow/recordings/error.h>
#include <fuse_flow/recordings/rig_json.h>

#include <cmath>
#include <map>

namespace fuse_flow::io {
namespace {

/** \brief Another recording with other cameras. */
class MovedRecording : public Recording {
 public:
  explicit MovedRecording(std::unique_ptr<Recording> recording)
      : recording_(std::move(recording)), cameras_(recording_->cameras()) {
    warnings_ = recording_->warnings();
  }

  std::string kind() const override { return recording_->kind(); }
  std::size_t frameCount() const override { return recording_->frameCount(); }
  std::vector<std::size_t> frames() const override { return recording_->frames(); }
  std::optional<double> framesPerSecond() const override { return recording_->framesPerSecond(); }
  const std::vector<Camera>& cameras() const override { return cameras_; }
  bool hasDepth(std::size_t camera) const override { return recording_->hasDepth(camera); }
  bool hasColor(std::size_t camera) const override { return recording_->hasColor(camera); }
  std::optional<float> confidenceScale(std::size_t camera) const override {
    return recording_->confidenceScale(camera);
  }
  std::vector<std::string> inputs() const override { return recording_->inputs(); }
  void read(std::size_t frame, LoadedFrame& out) override {
    recording_->read(frame, out);
    place(out.rig.cameras);
  }

 protected:
  virtual void place(std::vector<Camera>& cameras) const = 0;

  std::unique_ptr<Recording> recording_;
  std::vector<Camera> cameras_;
};

class ConvertedRecording : public MovedRecording {
 public:
  ConvertedRecording(std::unique_ptr<Recording> recording, PoseConvention convention)
      : MovedRecording(std::move(recording)), convention_(convention) {
    place(cameras_);
  }

 private:
  void place(std::vector<Camera>& cameras) const override {
    for (Camera& camera : cameras) camera.T_world_camera = converted(camera.T_world_camera, convention_);
  }

  PoseConvention convention_;
};

class PosedRecording : public MovedRecording {
 public:
  PosedRecording(std::unique_ptr<Recording> recording, const std::string& rig_json)
      : MovedRecording(std::move(recording)), rig_json_(rig_json) {
    const RigDescription rig = readRigJson(rig_json);
    warnings_.insert(warnings_.end(), rig.warnings.begin(), rig.warnings.end());
    for (const RigCamera& entry : rig.cameras) calibrations_[entry.camera.name] = entry.camera;
    place(cameras_);
  }

  std::vector<std::string> inputs() const override {
    std::vector<std::string> files = MovedRecording::inputs();
    files.push_back(rig_json_);
    return files;
  }

 private:
  void place(std::vector<Camera>& cameras) const override {
    for (Camera& camera : cameras) {
      const auto found = calibrations_.find(camera.name);
      if (found == calibrations_.end())
        throw InputError(rig_json_ + ": has no camera '" + camera.name + "', which the recording has");
      camera.T_world_camera = found->second.T_world_camera;
      camera.depth_correction = found->second.depth_correction;
      camera.multipath = found->second.multipath;
      if (found->second.noise) camera.noise = found->second.noise;
    }
  }

  std::string rig_json_;
  std::map<std::string, Camera> calibrations_;
};

}  // namespace

Eigen::Isometry3d converted(const Eigen::Isometry3d& pose, PoseConvention convention) {
  switch (convention) {
    case PoseConvention::WorldToCamera:
      return pose.inverse();
    case PoseConvention::OpenGl:
      return pose * Eigen::AngleAxisd(std::acos(-1.0), Eigen::Vector3d::UnitX());  // y and z the other way
    default:
      return pose;
  }
}

std::unique_ptr<Recording> withConvention(std::unique_ptr<Recording> recording, PoseConvention convention) {
  if (convention == PoseConvention::CameraToWorld) return recording;
  return std::make_unique<ConvertedRecording>(std::move(recording), convention);
}

std::unique_ptr<Recording> withPoses(std::unique_ptr<Recording> recording, const std::string& rig_json) {
  return std::make_unique<PosedRecording>(std::move(recording), rig_json);
}

}  // namespace fuse_flow::io
