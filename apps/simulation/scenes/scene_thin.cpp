#include "simulation/pi.h"
#include "simulation/portable_math.h"
#include "simulation/random.h"
#include "simulation/scenes/scenes.h"
#include "simulation/surfaces/implicit_surface.h"
#include "simulation/surfaces/shapes.h"

#include <cmath>

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/** \brief Bars 5, 8, 10 and 15 mm wide within a frame of 20 mm, standing in the plane y = 0. */
TriangleMesh lattice() {
  constexpr float width = 0.5f, height = 0.42f, rim = 0.02f;
  TriangleMesh mesh;
  const auto bar = [&](float x, float z, float across, float up, float thick) {
    append(mesh, moved(box({across, thick, up}), {x, 0, z}));
  };
  for (const float side : {-1.0f, 1.0f}) bar(side * 0.5f * (width - rim), 0.5f * height, rim, height, rim);
  for (const float z : {0.5f * rim, height - 0.5f * rim}) bar(0, z, width - 2 * rim, rim, rim);
  const float widths[] = {0.005f, 0.008f, 0.010f, 0.015f, 0.010f, 0.008f, 0.005f};
  for (int k = 0; k < 7; ++k)
    bar(0.06f * static_cast<float>(k - 3), 0.5f * height, widths[k], height - 2 * rim, widths[k]);
  const float heights[] = {0.015f, 0.010f, 0.008f, 0.005f};
  for (int k = 0; k < 4; ++k)
    bar(0, 0.085f * static_cast<float>(k + 1), width - 2 * rim, heights[k], 0.7f * heights[k]);
  return mesh;
}

/** \brief A left hand on its wrist, fingers up and spread, palm towards −y. */
TriangleMesh hand() {
  struct Finger {
    Vector3d joints[4];
    double radii[4];
  };
  const auto finger = [](double x, double z, double lean, double bend, double length, double radius) {
    // The three bones of a finger are as 1 : 0.62 : 0.5; each bends further towards the palm.
    Finger f{{Vector3d(x, 0, z)}, {1.1 * radius, radius, 0.9 * radius, 0.75 * radius}};
    const double bones[] = {length / 2.12, 0.62 * length / 2.12, 0.5 * length / 2.12};
    for (int k = 0; k < 3; ++k) {
      const double angle = bend * (k + 0.5);
      f.joints[k + 1] =
          f.joints[k] + bones[k] * Vector3d(portable::sin(lean) * portable::cos(angle), -portable::sin(angle),
                                            portable::cos(lean) * portable::cos(angle));
    }
    return f;
  };
  const std::vector<Finger> fingers = {
      finger(-0.033, 0.145, -0.24, 0.10, 0.072, 0.0085), finger(-0.012, 0.152, -0.08, 0.16, 0.080, 0.0090),
      finger(0.010, 0.150, 0.06, 0.22, 0.076, 0.0088), finger(0.031, 0.140, 0.24, 0.28, 0.060, 0.0078),
      finger(-0.030, 0.085, -0.85, 0.22, 0.075, 0.0105)};
  const ImplicitBody body = [&](const Vector3d& p) {
    double f = capsuleDistance(p.cwiseProduct(Vector3d(1, 1.35, 1)), {0, 0, 0.018}, {0, 0, 0.07}, 0.032, 0.030);
    for (const double x : {-0.024, -0.008, 0.008, 0.024})
      f = smoothUnion(f, capsuleDistance(p, {0.6 * x, 0, 0.07}, {1.15 * x, 0, 0.142}, 0.016, 0.0115), 0.012);
    for (const Finger& finger_of : fingers) {
      double own = 1;
      for (int k = 0; k < 3; ++k)
        own = smoothUnion(own,
                          capsuleDistance(p, finger_of.joints[k], finger_of.joints[k + 1], finger_of.radii[k],
                                          finger_of.radii[k + 1]),
                          0.003);
      f = smoothUnion(f, own, 0.008);
    }
    return f;
  };
  return polygonise(body, {Vector3d(-0.13, -0.09, -0.025), Vector3d(0.09, 0.06, 0.26)}, 0.002);
}

/** \brief Ropes that sag between two posts; x along, from 0 to length. Diameters 4, 6 and 8 mm. */
TriangleMesh ropes(float length) {
  TriangleMesh mesh;
  const float radii[] = {0.002f, 0.003f, 0.004f};
  for (int k = 0; k < 3; ++k) {
    std::vector<Vector3f> path;
    for (int i = 0; i <= 60; ++i) {
      const float t = static_cast<float>(i) / 60;
      path.emplace_back(length * t, 0.0f, 0.36f - 0.09f * static_cast<float>(k) - 0.16f * t * (1 - t));
    }
    append(mesh, tube(path, radii[k]));
  }
  return mesh;
}

/** \brief A rope 7 mm thick, coiled on z = 0. */
TriangleMesh coil() {
  std::vector<Vector3f> path;
  constexpr int steps = 420;
  for (int k = 0; k <= steps; ++k) {
    const float t = static_cast<float>(k) / steps, angle = 7 * kPiF * t;
    const float radius = 0.11f - 0.075f * t;
    path.emplace_back(radius * portable::cos(angle), radius * portable::sin(angle), 0.0036f + 0.02f * t);
  }
  return tube(path, 0.0035f);
}

}  // namespace

std::unique_ptr<Scene> makeThinScene(std::uint32_t seed) {
  const Eigen::AlignedBox3f room(Vector3f(-2.5f, -2.5f, 0.0f), Vector3f(2.5f, 2.2f, 2.6f));
  Objects objects;
  addRoom(objects, room);
  addTable(objects, {0, 0, 0}, {1.6f, 0.9f});
  Random random(seed, 0, 0, 41);
  const auto spread = [&](float reach) { return reach * (2 * static_cast<float>(random.uniform()) - 1); };
  const auto put = [&](const std::string& name, TriangleMesh mesh, float x, float y, float angle,
                       const Material& material) {
    const Eigen::Isometry3f T = placed({x, y, kTableHeight}, angle);
    mesh.rest = mesh.vertices;
    objects.push_back({name, moved(std::move(mesh), T), material});
  };
  put("lattice", lattice(), -0.42f + spread(0.05f), 0.24f + spread(0.03f), spread(0.25f),
      {Material::Plain, {222, 220, 210}, {}, 0.1f, 0.7f});
  put("hand", hand(), 0.1f + spread(0.05f), -0.05f + spread(0.05f), spread(0.6f),
      {Material::Noise, {224, 172, 140}, {206, 146, 118}, 0.02f, 0.6f});
  constexpr float span = 0.55f;
  TriangleMesh posts;
  for (const float x : {0.0f, span}) append(posts, moved(cylinder(0.009f, 0.007f, 0.38f), {x, 0, 0}));
  for (const float x : {0.0f, span}) append(posts, moved(cylinder(0.045f, 0.045f, 0.008f), {x, 0, 0}));
  const float y = -0.26f + spread(0.03f), turn = spread(0.1f);
  put("posts", posts, -0.7f, y, turn, {Material::Plain, {90, 94, 100}, {}, 0.1f, 0.5f});
  put("ropes", ropes(span), -0.7f, y, turn, {Material::Stripes, {206, 60, 52}, {236, 226, 200}, 0.02f, 0.7f});
  put("coil", coil(), 0.55f + spread(0.05f), -0.26f + spread(0.03f), 0,
      {Material::Stripes, {60, 90, 170}, {226, 222, 210}, 0.02f, 0.7f});
  addPlant(objects, {0.52f + spread(0.04f), 0.2f + spread(0.03f), 0}, kTableHeight, 0.42f, seed);
  addChair(objects, {0.15f + spread(0.1f), -0.86f, spread(0.2f)});
  const Eigen::AlignedBox3f subject(Vector3f(-0.8f, -1.1f, 0.3f), Vector3f(0.8f, 0.45f, 1.2f));
  return std::make_unique<StaticScene>(std::move(objects), subject, room);
}

}  // namespace fuse_flow::simulation
