#include "simulation/random.h"
#include "simulation/scenes/scenes.h"
#include "simulation/scenes/tableware.h"
#include "simulation/surfaces/shapes.h"

#include <array>

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector3f;

/** \brief Things of 3 to 15 cm, each standing on z = 0 around the z axis. */
Objects smallThings() {
  Objects things;
  things.push_back(
      {"cup", cup(0.042f, 0.095f, 0.004f), {Material::Stripes, {236, 232, 222}, {188, 60, 52}, 0.03f, 0.75f}});
  things.push_back({"espresso cup", cup(0.03f, 0.06f, 0.003f), {Material::Plain, {64, 120, 150}, {}, 0.1f, 0.7f}});
  things.push_back({"bowl", bowl(0.075f, 0.004f), {Material::Checker, {226, 228, 232}, {70, 110, 170}, 0.02f, 0.75f}});
  things.push_back({"box",
                    moved(box({0.11f, 0.08f, 0.06f}), {0, 0, 0.03f}),
                    {Material::Stripes, {226, 180, 70}, {150, 60, 44}, 0.04f, 0.7f}});
  things.push_back({"bottle", bottle(0.033f, 0.15f), {Material::Noise, {60, 130, 84}, {34, 84, 60}, 0.03f, 0.5f}});
  things.push_back(
      {"ball", moved(sphere(0.04f), {0, 0, 0.04f}), {Material::Checker, {220, 96, 40}, {240, 236, 224}, 0.025f, 0.7f}});
  things.push_back(
      {"cone", cylinder(0.04f, 0, 0.11f), {Material::Stripes, {150, 90, 160}, {226, 206, 226}, 0.025f, 0.7f}});
  things.push_back({"gear", gear(0.055f, 0.03f, 14), {Material::Plain, {132, 136, 142}, {}, 0.1f, 0.5f}});
  things.push_back({"duck", duck(0.12f), {Material::Plain, {240, 200, 52}, {}, 0.1f, 0.75f}});
  things.push_back({"die",
                    moved(roundedBox({0.03f, 0.03f, 0.03f}, 0.004f), {0, 0, 0.015f}),
                    {Material::Checker, {240, 236, 228}, {40, 40, 44}, 0.01f, 0.6f}});
  things.push_back({"ring",
                    moved(torus(0.04f, 0.012f), {0, 0, 0.012f}),
                    {Material::Wood, {196, 152, 98}, {120, 78, 40}, 0.006f, 0.7f}});
  things.push_back({"eraser",
                    moved(roundedBox({0.06f, 0.035f, 0.03f}, 0.005f), {0, 0, 0.015f}),
                    {Material::Stripes, {226, 90, 110}, {90, 120, 200}, 0.05f, 0.7f}});
  return things;
}

}  // namespace

std::unique_ptr<Scene> makeTableScene(std::uint32_t seed) {
  const Eigen::AlignedBox3f room(Vector3f(-2.2f, -2.0f, 0.0f), Vector3f(2.2f, 2.0f, 2.6f));
  Objects objects;
  addRoom(objects, room);
  addTable(objects, {0, 0, 0}, {1.3f, 0.9f});
  Objects things = smallThings();
  Random random(seed, 0, 0, 31);
  for (std::size_t k = things.size() - 1; k > 0; --k)
    std::swap(things[k], things[static_cast<std::size_t>(random.uniform() * static_cast<double>(k + 1))]);
  const auto spread = [&](float reach) { return reach * (2 * static_cast<float>(random.uniform()) - 1); };
  for (std::size_t k = 0; k < things.size(); ++k) {  // in three rows of four
    const std::size_t in_row = k % 4, rows_before = k / 4;
    const float column = static_cast<float>(in_row) - 1.5f, row = static_cast<float>(rows_before) - 1.0f;
    const Vector3f at(0.25f * column + spread(0.03f), 0.24f * row + spread(0.03f), kTableHeight);
    const Eigen::Isometry3f T = placed(at, spread(3.14f));
    things[k].mesh.rest = things[k].mesh.vertices;
    things[k].mesh = moved(things[k].mesh, T);
    objects.push_back(std::move(things[k]));
  }
  const Eigen::AlignedBox3f subject(Vector3f(-0.52f, -0.36f, kTableHeight),
                                    Vector3f(0.52f, 0.36f, kTableHeight + 0.15f));
  return std::make_unique<StaticScene>(std::move(objects), subject, room);
}

}  // namespace fuse_flow::simulation
