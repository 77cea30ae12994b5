#include "simulation/people/person_walk.h"
#include "simulation/pi.h"
#include "simulation/random.h"
#include "simulation/scenes/scenes.h"

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector3f;

/** \brief 8 m × 6 m × 2.8 m, its floor around the origin; in the living room nobody could walk past cameras in its middle. */
Eigen::AlignedBox3f hall() { return {Vector3f(-4, -3, 0), Vector3f(4, 3, 2.8f)}; }

Objects furnishedHall(std::uint32_t seed) {
  Objects objects;
  addRoom(objects, hall());
  const Place table{-2.6f, -1.6f, 0.3f};
  addTable(objects, table, {1.3f, 0.75f});
  for (const float side : {-1.0f, 1.0f}) {
    const Vector3f chair = table.pose() * Vector3f(side * 0.82f, 0, 0);
    addChair(objects, {chair.x(), chair.y(), table.angle + side * 0.5f * kPiF + 0.1f});
  }
  addSofa(objects, {0.6f, -2.57f, 0});
  addShelf(objects, {3.84f, 0.1f, 0.5f * kPiF}, 1.5f, seed);
  addFloorLamp(objects, {2.4f, -2.3f, 0});
  addPlant(objects, {-3.4f, 0.6f, 0}, 0, 0.95f, seed);
  addPictures(objects, hall());
  nameFurniture(objects);
  return objects;
}

/** \brief Somebody walks past the middle of a hall, where a robot could stand that looks all around. */
class PasserbyScene : public StaticScene {
 public:
  explicit PasserbyScene(std::uint32_t seed)
      : StaticScene(furnishedHall(seed), {Vector3f(-2.0f, 0.8f, 0), Vector3f(2.0f, 2.2f, 1.8f)}, hall()),
        walk_(1.5, 0.25, Random(seed, 0, 0, 51).uniform()) {}

  Objects movingObjects(double time) const override {
    static const PersonBody body;  // the same for every seed, and slow to make
    Pose pose = walk_.pose(time);
    const Eigen::Isometry3d beside(Eigen::Translation3d(0, 1.5, 0));
    for (Eigen::Isometry3d& bone : pose) bone = beside * bone;
    return body.posed(pose);
  }
  std::optional<Vector3f> lookout() const override { return Vector3f(0, 0, 1.2f); }

 private:
  PersonWalk walk_;
};

}  // namespace

std::unique_ptr<Scene> makePasserbyScene(std::uint32_t seed) { return std::make_unique<PasserbyScene>(seed); }

}  // namespace fuse_flow::simulation
