#include "recordings/calibrations/posed_recording.h"

#include "recordings/calibrations/depth_to_z.h"

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
  DepthMeaning depthMeaning(std::size_t camera) const override { return recording_->depthMeaning(camera); }
  std::size_t imagesWithoutPartner(std::size_t camera) const override {
    return recording_->imagesWithoutPartner(camera);
  }
  std::vector<std::string> inputs() const override { return recording_->inputs(); }
  bool readsConcurrently() const override { return recording_->readsConcurrently(); }
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
    for (const RigCamera& entry : rig.cameras) calibrations_.emplace(entry.camera.name, entry);
    place(cameras_);
    for (std::size_t k = 0; k < cameras_.size(); ++k) {
      // What the recording itself says has been applied.
      const DepthMeaning own = recording_->depthMeaning(k);
      meanings_.push_back(own.isZ() ? calibrations_.at(cameras_[k].name).depth : own);
      to_z_.emplace_back(cameras_[k], own.isZ() ? meanings_.back() : DepthMeaning());
    }
  }

  DepthMeaning depthMeaning(std::size_t camera) const override { return meanings_[camera]; }
  void read(std::size_t frame, LoadedFrame& out) override {
    MovedRecording::read(frame, out);
    for (std::size_t k = 0; k < to_z_.size(); ++k) to_z_[k].convert(out.images[k], out.rig.views[k]);
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
      const Camera& calibrated = found->second.camera;
      camera.T_world_camera = calibrated.T_world_camera;
      camera.depth_correction = calibrated.depth_correction;
      camera.multipath = calibrated.multipath;
      if (calibrated.noise) camera.noise = calibrated.noise;
    }
  }

  std::string rig_json_;
  std::map<std::string, RigCamera> calibrations_;
  std::vector<DepthMeaning> meanings_;
  std::vector<DepthToZ> to_z_;
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
