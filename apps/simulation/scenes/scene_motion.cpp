#include "simulation/pi.h"
#include "simulation/scenes/person_motions.h"
#include "simulation/scenes/scenes.h"

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector3f;

/** \brief The same for every seed, and slow to make. */
const PersonFigure& figure() {
  static const PersonFigure only;
  return only;
}

/** \brief Somebody stands in the living room and does something. */
class MotionScene : public StaticScene {
 public:
  MotionScene(Objects room, const Eigen::AlignedBox3f& subject, Posture (*motion)(double), const Eigen::Vector3d& at)
      : StaticScene(std::move(room), subject, livingRoom()), motion_(motion), at_(at) {}

  Objects movingObjects(double time) const override {
    Posture posture = motion_(time);
    const Eigen::Translation3d there(at_);
    posture.pelvis = there * posture.pelvis;
    for (SidePosture& side : posture.sides) {
      side.foot = there * side.foot;
      side.wrist += at_;
    }
    return figure().posed(posture);
  }

 private:
  Posture (*motion_)(double);
  Eigen::Vector3d at_;
};

/** \brief As in the scene of the person that walks, so that the same cameras look at it. */
Eigen::AlignedBox3f wholeSubject() { return {Vector3f(-1.35f, -0.85f, 0.0f), Vector3f(1.35f, 0.85f, 1.8f)}; }

Objects roomWithTableAtTheWall(std::uint32_t seed) { return furnishedRoom({-0.1f, 1.55f, 0}, seed); }

}  // namespace

std::unique_ptr<Scene> makePunchScene(std::uint32_t seed) {
  return std::make_unique<MotionScene>(roomWithTableAtTheWall(seed), wholeSubject(), punching, Eigen::Vector3d::Zero());
}

std::unique_ptr<Scene> makeHopScene(std::uint32_t seed) {
  return std::make_unique<MotionScene>(roomWithTableAtTheWall(seed), wholeSubject(), hopping, Eigen::Vector3d::Zero());
}

std::unique_ptr<Scene> makeSitScene(std::uint32_t seed) {
  Objects objects = roomWithTableAtTheWall(seed);
  addChair(objects, {-0.505f, 0, -0.5f * kPiF});  // its front edge is 0.215 m before its middle
  return std::make_unique<MotionScene>(std::move(objects), wholeSubject(), sitting, Eigen::Vector3d::Zero());
}

std::unique_ptr<Scene> makeHandScene(std::uint32_t seed) {
  const Eigen::AlignedBox3f subject(Vector3f(-0.15f, -0.15f, 1.15f), Vector3f(0.15f, 0.15f, 1.45f));
  return std::make_unique<MotionScene>(roomWithTableAtTheWall(seed), subject, showingAHand,
                                       Eigen::Vector3d(-0.42, 0.185, 0));
}

}  // namespace fuse_flow::simulation
