#include "simulation/people/person_motions.h"
#include "simulation/people/person_walk.h"
#include "simulation/people/skirt.h"
#include "simulation/pi.h"
#include "simulation/portable_math.h"
#include "simulation/random.h"
#include "simulation/scenes/scenes.h"
#include "simulation/surfaces/shapes.h"

#include <functional>
#include <iterator>

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector3f;

/** \brief The same for every seed, and slow to make. */
const PersonFigure& figure() {
  static const PersonFigure only;
  return only;
}

/** \brief The living room, and what moves in it. */
class MotionScene : public StaticScene {
 public:
  using Moving = std::function<Objects(double time)>;
  MotionScene(Objects room, const Eigen::AlignedBox3f& subject, Moving moving)
      : StaticScene(std::move(room), subject, livingRoom()), moving_(std::move(moving)) {}
  Objects movingObjects(double time) const override { return moving_(time); }

 private:
  Moving moving_;
};

/** \brief A posture at another place. */
Posture standingAt(const Eigen::Isometry3d& place, Posture posture) {
  posture.pelvis = place * posture.pelvis;
  for (SidePosture& side : posture.sides) {
    side.foot = place * side.foot;
    side.wrist = place * side.wrist;
    for (Eigen::Vector3d* direction : {&side.elbow, &side.thumb, &side.fingers})
      *direction = place.linear() * *direction;
  }
  return posture;
}

/** \brief A second person, who can be told from the first. */
Objects inOtherClothes(Objects person) {
  for (Object& object : person) {
    if (object.surface > 0) object.surface += 100;
    if (object.name == "shirt") object.material = {Material::Checker, {60, 110, 180}, {222, 226, 232}, 0.09f, 0.7f};
    if (object.name == "trousers") object.material = {Material::Noise, {96, 88, 76}, {66, 60, 52}, 0.04f, 0.4f};
    if (object.name == "hair") object.material = {Material::Noise, {158, 118, 66}, {116, 82, 42}, 0.015f, 0.2f};
  }
  return person;
}

void append(Objects& objects, Objects more) { std::move(more.begin(), more.end(), std::back_inserter(objects)); }

/** \brief As in the scene of the person that walks, so that the same cameras look at it. */
Eigen::AlignedBox3f wholeSubject() { return {Vector3f(-1.35f, -0.85f, 0.0f), Vector3f(1.35f, 0.85f, 1.8f)}; }

Objects roomWithTableAtTheWall(std::uint32_t seed) { return furnishedRoom({-0.1f, 1.55f, 0}, seed); }

}  // namespace

std::unique_ptr<Scene> makePunchScene(std::uint32_t seed) {
  return std::make_unique<MotionScene>(roomWithTableAtTheWall(seed), wholeSubject(),
                                       [](double time) { return figure().posed(punching(time)); });
}

std::unique_ptr<Scene> makeHopScene(std::uint32_t seed) {
  return std::make_unique<MotionScene>(roomWithTableAtTheWall(seed), wholeSubject(),
                                       [](double time) { return figure().posed(hopping(time)); });
}

std::unique_ptr<Scene> makeSitScene(std::uint32_t seed) {
  Objects objects = roomWithTableAtTheWall(seed);
  addChair(objects, {-0.505f, 0, -0.5f * kPiF});  // its front edge is 0.215 m before its middle
  return std::make_unique<MotionScene>(std::move(objects), wholeSubject(),
                                       [](double time) { return figure().posed(sitting(time)); });
}

std::unique_ptr<Scene> makeHandScene(std::uint32_t seed) {
  const Eigen::AlignedBox3f subject(Vector3f(-0.15f, -0.15f, 1.15f), Vector3f(0.15f, 0.15f, 1.45f));
  return std::make_unique<MotionScene>(roomWithTableAtTheWall(seed), subject, [](double time) {
    const Eigen::Isometry3d behind(Eigen::Translation3d(-0.42, 0.185, 0));
    return figure().posed(standingAt(behind, showingAHand(time)));
  });
}

std::unique_ptr<Scene> makeBallScene(std::uint32_t seed) {
  Eigen::AlignedBox3f subject = wholeSubject();
  subject.max().z() = 2.3f;  // as high as the ball flies
  return std::make_unique<MotionScene>(roomWithTableAtTheWall(seed), subject, [](double time) {
    static const TriangleMesh ball = sphere(static_cast<float>(kBallRadius));
    Objects objects = figure().posed(tossing(time));
    Object thrown{"ball", ball, {Material::Checker, {220, 96, 40}, {240, 236, 224}, 0.04f, 0.7f}};
    thrown.mesh = moved(std::move(thrown.mesh), tossedBall(time).cast<float>());
    thrown.mesh.rest = ball.vertices;
    objects.push_back(std::move(thrown));
    return objects;
  });
}

std::unique_ptr<Scene> makeSkirtScene(std::uint32_t seed) {
  return std::make_unique<MotionScene>(roomWithTableAtTheWall(seed), wholeSubject(), [](double time) {
    Objects objects = figure().posed(twisting(time));
    objects.push_back(skirt(time));
    return objects;
  });
}

std::unique_ptr<Scene> makeHandshakeScene(std::uint32_t seed) {
  return std::make_unique<MotionScene>(roomWithTableAtTheWall(seed), wholeSubject(), [](double time) {
    const Eigen::Isometry3d left(Eigen::Translation3d(-0.45, 0, 0));
    Eigen::Isometry3d right(Eigen::Translation3d(0.45, 0, 0));
    right.rotate(portable::turn(kPi, Eigen::Vector3d::UnitZ()));
    const Posture posture = shakingHands(time);
    Objects objects = figure().posed(standingAt(left, posture));
    append(objects, inOtherClothes(figure().posed(standingAt(right, posture))));
    return objects;
  });
}

std::unique_ptr<Scene> makePassScene(std::uint32_t seed) {
  const double phase = Random(seed, 0, 0, 51).uniform();
  const PersonWalk first(0.85, 0.35, phase), second(0.85, 0.35, phase + 0.25);
  return std::make_unique<MotionScene>(roomWithTableAtTheWall(seed), wholeSubject(), [first, second](double time) {
    static const PersonBody body;
    Objects objects = body.posed(first.pose(time));
    append(objects, inOtherClothes(body.posed(second.pose(time))));
    return objects;
  });
}

}  // namespace fuse_flow::simulation
