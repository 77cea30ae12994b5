#pragma once

#include "viewer/frame_source.h"

#include <fuse_flow/recordings/error.h>

#include <atomic>
#include <optional>

namespace viewer_test {

using namespace fuse_flow;

/** \brief Two cameras 0.2 m apart that look along +z, with y down, at a wall at z = 2 m, grey on the left of x = 0 and red on
 *  its right. The image of 160 × 120 pixels, 10 mm each, covers the wall from −0.8 to 0.8 m and −0.6 to 0.6 m around each
 *  camera's axis. */
class WallSource : public viewing::FrameSource {
 public:
  static constexpr float kDistance = 2.0f;
  static constexpr int kWidth = 160, kHeight = 120;

  /** \param frames absent: without an end  \param damaged the first frame that cannot be read */
  explicit WallSource(std::optional<std::size_t> frames = 20, std::optional<std::size_t> damaged = std::nullopt)
      : frames_(frames), damaged_(damaged) {}
  /** \brief In this frame the image of the right camera cannot be read. */
  void damageRight(std::size_t frame) { damaged_right_ = frame; }

  /** \brief In this frame the wall is farther. */
  void shift(std::size_t frame, float metres) {
    shifted_ = frame;
    shift_ = metres;
  }

  static Camera camera(std::size_t k) {
    Camera camera;
    camera.name = k == 0 ? "left" : "right";
    camera.intrinsics = {kWidth, kHeight, 200.0f, 200.0f, 79.5f, 59.5f, {}};
    camera.T_world_camera.translation().x() = k == 0 ? -0.1 : 0.1;
    return camera;
  }

  std::string name() const override { return "wall"; }
  std::optional<std::size_t> frameCount() const override { return frames_; }
  std::optional<double> framesPerSecond() const override { return frames_per_second; }
  bool knowsTruth() const override { return false; }
  const simulation::RayScene& truth(std::size_t) override { throw std::logic_error("not known"); }

  void read(std::size_t frame, io::LoadedFrame& out) override {
    ++reads;
    if (damaged_ && frame >= *damaged_) throw io::InputError("000002.png: is cut short");
    out.damaged.clear();
    out.rig.cameras = {camera(0), camera(1)};
    out.rig.views.assign(2, DepthView());
    out.images.resize(2);
    for (std::size_t k = 0; k < 2; ++k) {
      io::LoadedView& image = out.images[k];
      image.depth32.resize(kWidth, kHeight);
      image.color.resize(kWidth, kHeight);
      for (int v = 0; v < kHeight; ++v)
        for (int u = 0; u < kWidth; ++u) {
          const double x = out.rig.cameras[k].T_world_camera.translation().x() + 0.01 * (u - 79.5);
          image.depth32.at(u, v) = kDistance + (frame == shifted_ ? shift_ : 0.0f);
          image.color.at(u, v) = x < 0 ? Rgb8{200, 200, 200} : Rgb8{220, 30, 30};
        }
      out.rig.views[k].depth32 = image.depth32.view();
      out.rig.views[k].color = image.color.view();
    }
    if (frame != damaged_right_) return;
    out.rig.views[1] = DepthView();
    out.damaged.push_back({1, "right/depth/000003.png: is cut short"});
  }

  std::atomic<int> reads{0};
  std::optional<double> frames_per_second{20};

 private:
  std::optional<std::size_t> frames_;
  std::optional<std::size_t> damaged_;
  std::optional<std::size_t> damaged_right_;
  std::optional<std::size_t> shifted_;
  float shift_{0};
};

}  // namespace viewer_test
