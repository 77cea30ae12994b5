#pragma once

#include "simulation/surfaces/ray_scene.h"

namespace fuse_flow::simulation {

/** \brief When a camera takes an image, as moments of a scene's motion (RayScene): 0 is its first step, 1 its last. */
struct Shutter {
  /** \brief The middle of the first and of the last row's exposure. The same with a global shutter; a rolling one exposes row after
   *  row. */
  float first_row{0};
  float last_row{0};
  /** \brief How long each row is exposed, as a share of the motion's time; 0: an instant. */
  float duration{0};
};

/** \brief A scene while a camera takes an image of it. The scene must stay, where and as it is. */
class Exposure {
 public:
  /** \brief Parts of an exposure in which a pixel may see different surfaces. */
  static constexpr int kParts = 5;

  /** \brief An instant: nothing moves. */
  Exposure(const RayScene& scene) : scene_(scene) {}  // NOLINT(google-explicit-constructor): a scene is one
  Exposure(const RayScene& scene, const Shutter& shutter) : scene_(scene), shutter_(shutter) {}

  const RayScene& scene() const { return scene_; }
  bool instant() const { return !(shutter_.duration > 0); }
  /** \brief The moment at which a row of an image is exposed. \param part of the exposure, from −0.5 (its begin) to 0.5 (its end) */
  float moment(int row, int rows, float part = 0) const {
    const float down = rows > 1 ? static_cast<float>(row) / static_cast<float>(rows - 1) : 0.5f;
    return shutter_.first_row + down * (shutter_.last_row - shutter_.first_row) + part * shutter_.duration;
  }
  /** \brief The middle of each of equal parts of the exposure, for moment(); one if it is an instant. */
  int parts() const { return instant() ? 1 : kParts; }
  static float middleOf(int part, int parts) {
    return (static_cast<float>(part) + 0.5f) / static_cast<float>(parts) - 0.5f;
  }

 private:
  const RayScene& scene_;
  Shutter shutter_;
};

}  // namespace fuse_flow::simulation
