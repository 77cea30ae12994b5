#include "simulation/pi.h"
#include "simulation/random.h"
#include "simulation/scenes/scenes.h"
#include "simulation/scenes/tableware.h"
#include "simulation/surfaces/shapes.h"

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector3f;

void addSmallThings(Objects& objects, const Place& table, Random& random) {
  const auto spread = [&](float reach) { return reach * (2 * static_cast<float>(random.uniform()) - 1); };
  const Eigen::Isometry3f on_table = table.pose(kTableHeight);
  const Vector3f at_bowl(-0.3f + spread(0.08f), spread(0.12f), 0);
  objects.push_back({"bowl",
                     moved(bowl(0.12f, 0.004f), on_table * placed(at_bowl, 0)),
                     {Material::Stripes, {226, 228, 232}, {70, 110, 170}, 0.03f, 0.75f}});
  const Vector3f at_vase(0.25f + spread(0.08f), spread(0.1f), 0);
  objects.push_back({"vase",
                     moved(bottle(0.07f, 0.26f), on_table * placed(at_vase, 0)),
                     {Material::Checker, {180, 60, 90}, {236, 214, 190}, 0.03f, 0.7f}});
  const Eigen::Isometry3f book = on_table * placed({spread(0.1f), -0.2f, 0.015f}, spread(0.6f));
  objects.push_back({"book",
                     moved(box({0.21f, 0.15f, 0.03f}), book),
                     {Material::Stripes, {38, 70, 132}, {226, 220, 206}, 0.05f, 0.7f}});
  constexpr float ball = 0.12f;
  objects.push_back({"ball",
                     moved(sphere(ball), {-1.3f + spread(0.15f), 0.9f + spread(0.2f), ball}),
                     {Material::Checker, {220, 96, 40}, {240, 236, 224}, 0.07f, 0.7f}});
}

}  // namespace

Eigen::AlignedBox3f livingRoom() { return {Vector3f(-2.5f, -2.0f, 0.0f), Vector3f(2.5f, 2.0f, 2.6f)}; }

void addPictures(Objects& objects, const Eigen::AlignedBox3f& room) {
  const auto hang = [&](const Vector3f& at, const Vector3f& size, const Material& material) {
    objects.push_back({"picture", moved(box(size), at), material});
  };
  const Vector3f low = room.min(), high = room.max();
  hang({low.x() + 0.015f, 0.4f, 1.45f}, {0.03f, 0.9f, 0.6f},
       {Material::Checker, {196, 84, 60}, {60, 92, 120}, 0.1f, 0.6f});
  hang({0.3f, low.y() + 0.015f, 1.5f}, {1.0f, 0.03f, 0.5f},
       {Material::Noise, {226, 180, 90}, {60, 84, 130}, 0.08f, 0.6f});
  hang({-0.9f, high.y() - 0.015f, 1.5f}, {0.5f, 0.03f, 0.7f},
       {Material::Stripes, {52, 120, 96}, {232, 222, 196}, 0.09f, 0.6f});
}

void nameFurniture(Objects& objects) {
  for (Object& object : objects)
    if (object.name != "floor" && object.name != "ceiling" && object.name != "wall") object.part = "furniture";
}

Objects furnishedRoom(const Place& table, std::uint32_t seed) {
  Objects objects;
  addRoom(objects, livingRoom());
  addTable(objects, table, {1.3f, 0.75f});
  for (const float side : {-1.0f, 1.0f}) {
    const Vector3f chair = table.pose() * Vector3f(side * 0.82f, 0, 0);
    addChair(objects, {chair.x(), chair.y(), table.angle + side * 0.5f * kPiF + 0.1f});
  }
  addSofa(objects, {-0.2f, -1.57f, 0});
  addShelf(objects, {2.34f, 0.1f, 0.5f * kPiF}, 1.5f, seed);
  addFloorLamp(objects, {-2.15f, 1.6f, 0});
  addPlant(objects, {2.05f, -1.5f, 0}, 0, 0.95f, seed);
  addPictures(objects, livingRoom());
  Random random(seed, 0, 0, 21);
  addSmallThings(objects, table, random);
  nameFurniture(objects);
  return objects;
}

std::unique_ptr<Scene> makeRoomScene(std::uint32_t seed) {
  const Eigen::AlignedBox3f subject(Vector3f(-1.3f, -0.9f, 0.0f), Vector3f(1.3f, 0.9f, 1.5f));
  return std::make_unique<StaticScene>(furnishedRoom({0.1f, 0.1f, 0.15f}, seed), subject, livingRoom());
}

}  // namespace fuse_flow::simulation
