#include "simulation/scenes/tableware.h"

#include "simulation/pi.h"
#include "simulation/portable_math.h"
#include "simulation/surfaces/implicit_surface.h"
#include "simulation/surfaces/shapes.h"

#include <cmath>

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

}  // namespace

TriangleMesh bowl(float radius, float wall) {
  const float foot = 0.5f;  // angle between the axis and the foot's rim
  const Vector2f centre(0, radius * portable::cos(foot));
  const auto outside = arc(centre, radius, foot - 0.5f * kPiF, 0);
  const auto inside = arc(centre, radius - wall, 0, foot + 0.05f - 0.5f * kPiF);
  return lathe({{{0, outside.front().y()}, outside.front()},
                outside,
                {outside.back(), inside.front()},
                inside,
                {inside.back(), {0, inside.back().y()}}});
}

TriangleMesh cup(float radius, float height, float wall) {
  const float inside = radius - wall, low = 0.006f, edge = 0.006f;
  const auto bottom = arc({radius - edge, edge}, edge, -0.5f * kPiF, 0);
  TriangleMesh mesh = lathe({{{0, 0}, bottom.front()},
                             bottom,
                             {bottom.back(), {radius, height}},
                             {{radius, height}, {inside, height}},
                             {{inside, height}, {inside, low}},
                             {{inside, low}, {0, low}}});
  const float reach = 0.3f * height;
  std::vector<Vector3f> handle;  // ends within the wall
  for (int k = 0; k <= 40; ++k) {
    const float angle = kPiF * (static_cast<float>(k) / 40 - 0.5f);
    handle.emplace_back(radius - 0.5f * wall + reach * portable::cos(angle), 0.0f,
                        0.52f * height + reach * portable::sin(angle));
  }
  append(mesh, tube(handle, 0.0045f));
  return mesh;
}

TriangleMesh bottle(float radius, float height) {
  const float edge = 0.3f * radius, neck = 0.32f * radius;
  const auto bottom = arc({radius - edge, edge}, edge, -0.5f * kPiF, 0);
  // From the body to the neck: two arcs that turn against each other and meet in the middle.
  const float turn = 1.1f, bend = 0.5f * (radius - neck) / (1 - portable::cos(turn));
  const float low = 0.52f * height;
  const auto shoulder = arc({radius - bend, low}, bend, 0, turn);
  const float high = low + 2 * bend * portable::sin(turn);
  auto throat = arc({neck + bend, high}, bend, kPiF + turn, kPiF);
  throat.front() = shoulder.back();
  return lathe({{{0, 0}, bottom.front()},
                bottom,
                {bottom.back(), shoulder.front()},
                shoulder,
                throat,
                {throat.back(), {neck, height}},
                {{neck, height}, {0, height}}});
}

TriangleMesh gear(float radius, float height, int teeth) {
  std::vector<Vector2f> outline;
  for (int k = 0; k < teeth; ++k) {
    const float pitch = 2 * kPiF / static_cast<float>(teeth), start = pitch * static_cast<float>(k);
    const float corners[4][2] = {
        {0.1f, 0.82f}, {0.28f, 1.0f}, {0.52f, 1.0f}, {0.7f, 0.82f}};  // of the pitch, of the radius
    for (const auto& c : corners) {
      const float angle = start + c[0] * pitch;
      outline.push_back(radius * c[1] * Vector2f(portable::cos(angle), portable::sin(angle)));
    }
  }
  return extrude(outline, height);
}

TriangleMesh duck(float length) {
  const double s = static_cast<double>(length);
  const ImplicitBody body = [s](const Vector3d& p) {
    const Vector3d q = p / s;
    double f = ellipsoidDistance(q, {-0.02, 0, 0.25}, {0.42, 0.29, 0.25});
    f = smoothUnion(f, capsuleDistance(q, {-0.3, 0, 0.32}, {-0.48, 0, 0.46}, 0.14, 0.03), 0.12);  // tail
    f = smoothUnion(f, ellipsoidDistance(q, {0.2, 0, 0.62}, {0.19, 0.18, 0.19}), 0.1);
    f = smoothUnion(f, ellipsoidDistance(q, {0.4, 0, 0.58}, {0.13, 0.09, 0.04}), 0.03);  // beak
    return s * f;
  };
  return polygonise(body, {s * Vector3d(-0.6, -0.4, -0.05), s * Vector3d(0.6, 0.4, 0.9)}, 0.018 * s);
}

}  // namespace fuse_flow::simulation
