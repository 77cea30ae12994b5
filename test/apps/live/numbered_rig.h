#pragma once

#include <fuse_flow/recordings/recording.h>

#include <set>
#include <string>
#include <utility>
#include <vector>

namespace live_test {

using namespace fuse_flow;

/** \brief Small depth images, each full of its number: 1000 times the camera's, from 1 on, plus the frame's. Frames are 20 ms apart; camera k
 *  stands at x = k metres. */
class NumberedRig : public io::Recording {
 public:
  static constexpr int kWidth = 4, kHeight = 3;

  NumberedRig(std::size_t cameras, std::size_t frames) : frames_(frames) {
    for (std::size_t k = 0; k < cameras; ++k) {
      Camera camera;
      camera.name = "camera_" + std::to_string(k);
      camera.intrinsics.width = kWidth;
      camera.intrinsics.height = kHeight;
      camera.intrinsics.fx = camera.intrinsics.fy = 4;
      camera.intrinsics.cx = 1.5f;
      camera.intrinsics.cy = 1;
      camera.T_world_camera.translation().x() = static_cast<double>(k);
      cameras_.push_back(camera);
    }
  }
  static std::uint16_t valueOf(std::size_t camera, std::size_t frame) {
    return static_cast<std::uint16_t>(1000 * (camera + 1) + frame);
  }
  static io::LoadedView imagesOf(std::size_t camera, std::size_t frame) {
    io::LoadedView images;
    images.depth16.resize(kWidth, kHeight);
    for (std::uint16_t& z : images.depth16.data) z = valueOf(camera, frame);
    return images;
  }

  std::string kind() const override { return "numbers"; }
  std::size_t frameCount() const override { return frames_; }
  std::optional<double> framesPerSecond() const override { return stamps ? std::optional<double>(50) : std::nullopt; }
  const std::vector<Camera>& cameras() const override { return cameras_; }
  bool hasColor(std::size_t) const override { return false; }
  std::vector<std::string> inputs() const override { return {"/numbers"}; }
  void read(std::size_t frame, io::LoadedFrame& out) override {
    if (frame == damaged) throw io::InputError("frame " + std::to_string(frame) + " is damaged");
    out.rig.cameras = cameras_;
    if (frame == moved) out.rig.cameras[0].T_world_camera.translation().y() = 1;
    out.rig.stamp = stamps ? 5000000 + 20000 * frame : 0;
    out.rig.views.assign(cameras_.size(), {});
    out.images.resize(cameras_.size());  // what is missing leaves the pixels of an earlier frame there, as files do
    for (std::size_t k = 0; k < cameras_.size(); ++k) {
      if (missing.count({k, frame}) > 0) continue;
      out.images[k] = imagesOf(k, frame);
      out.rig.views[k].depth16 = out.images[k].depth16.view();
    }
  }

  bool stamps{true};
  std::size_t damaged{~std::size_t{0}}, moved{~std::size_t{0}};
  std::set<std::pair<std::size_t, std::size_t>> missing;  ///< camera and frame

 private:
  std::size_t frames_;
  std::vector<Camera> cameras_;
};

}  // namespace live_test
