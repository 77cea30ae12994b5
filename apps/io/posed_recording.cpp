#include "io/posed_recording.h"

#include "io/error.h"
#include "io/rig_json.h"

#include <map>

namespace fuse_flow::io {
namespace {

class PosedRecording : public Recording {
 public:
  PosedRecording(std::unique_ptr<Recording> recording, const std::string& rig_json)
      : recording_(std::move(recording)), rig_json_(rig_json), cameras_(recording_->cameras()) {
    for (const RigCamera& entry : readRigJson(rig_json).cameras) calibrations_[entry.camera.name] = entry.camera;
    place(cameras_);
  }

  std::string kind() const override { return recording_->kind(); }
  std::size_t frameCount() const override { return recording_->frameCount(); }
  std::optional<double> framesPerSecond() const override { return recording_->framesPerSecond(); }
  const std::vector<Camera>& cameras() const override { return cameras_; }
  std::vector<std::string> inputs() const override {
    std::vector<std::string> files = recording_->inputs();
    files.push_back(rig_json_);
    return files;
  }
  void read(std::size_t frame, LoadedFrame& out) override {
    recording_->read(frame, out);
    place(out.rig.cameras);
  }

 private:
  void place(std::vector<Camera>& cameras) const {
    for (Camera& camera : cameras) {
      const auto found = calibrations_.find(camera.name);
      if (found == calibrations_.end())
        throw InputError(rig_json_ + ": has no camera '" + camera.name + "', which the recording has");
      camera.T_world_camera = found->second.T_world_camera;
      camera.depth_correction = found->second.depth_correction;
      camera.multipath = found->second.multipath;
    }
  }

  std::unique_ptr<Recording> recording_;
  std::string rig_json_;
  std::vector<Camera> cameras_;
  std::map<std::string, Camera> calibrations_;
};

}  // namespace

std::unique_ptr<Recording> withPoses(std::unique_ptr<Recording> recording, const std::string& rig_json) {
  return std::make_unique<PosedRecording>(std::move(recording), rig_json);
}

}  // namespace fuse_flow::io
