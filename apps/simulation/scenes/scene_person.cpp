#include "simulation/people/person_walk.h"
#include "simulation/random.h"
#include "simulation/scenes/scenes.h"

namespace fuse_flow::simulation {
namespace {

/** \brief The same for every seed, and slow to make. */
const PersonBody& body() {
  static const PersonBody only;
  return only;
}

/** \brief Somebody walks in the living room, whose table stands at the wall. */
class PersonScene : public Scene {
 public:
  explicit PersonScene(std::uint32_t seed)
      : walk_(0.85, 0.35, Random(seed, 0, 0, 51).uniform()), furniture_(furnishedRoom({-0.1f, 1.55f, 0}, seed)) {}

  Objects fixedObjects() const override { return furniture_; }
  Objects movingObjects(double time) const override { return body().posed(walk_.pose(time)); }
  Eigen::AlignedBox3f subject() const override {
    return {Eigen::Vector3f(-1.35f, -0.85f, 0.0f), Eigen::Vector3f(1.35f, 0.85f, 1.8f)};
  }
  Eigen::AlignedBox3f room() const override { return livingRoom(); }

 private:
  PersonWalk walk_;
  Objects furniture_;
};

}  // namespace

std::unique_ptr<Scene> makePersonScene(std::uint32_t seed) { return std::make_unique<PersonScene>(seed); }

}  // namespace fuse_flow::simulation
