#include "simulation/rig_layout.h"

#include <fuse_flow/recordings/error.h>

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace fuse_flow::simulation;
using Eigen::Vector3d;

class EmptyRoom : public Scene {
 public:
  std::vector<Object> fixedObjects() const override { return {}; }
  Eigen::AlignedBox3f subject() const override {
    return {Eigen::Vector3f(-0.5f, -0.5f, 0), Eigen::Vector3f(0.5f, 0.5f, 1)};
  }
  Eigen::AlignedBox3f room() const override { return {Eigen::Vector3f(-4, -3, 0), Eigen::Vector3f(4, 3, 3)}; }
};

double fromOpticalAxis(const Eigen::Isometry3d& pose, const Vector3d& p) {
  return pose.linear().col(2).cross(p - pose.translation()).norm();
}

TEST(RigLayout, HasAsManyCamerasAsItsNameSaysInsideTheRoom) {
  const EmptyRoom scene;
  for (const std::string layout : {"ring-", "walls-"})
    for (const std::string end : {"", "-narrow"})
      for (const int count : {1, 2, 3, 4, 8, 20, 64}) {
        const auto poses = placeCameras(layout + std::to_string(count) + end, scene);
        EXPECT_EQ(poses.size(), static_cast<std::size_t>(count));
        for (const Eigen::Isometry3d& pose : poses) {
          EXPECT_TRUE(scene.room().cast<double>().contains(pose.translation()));
          EXPECT_TRUE(pose.linear().isUnitary(1e-9));
          EXPECT_NEAR(pose.linear().determinant(), 1, 1e-9);
        }
      }
}

TEST(RigLayout, LooksAtTheMiddleOfTheSubject) {
  const EmptyRoom scene;
  for (const std::string rig : {"ring-4", "ring-7", "walls-8"})
    for (const Eigen::Isometry3d& pose : placeCameras(rig, scene)) {
      EXPECT_LT(fromOpticalAxis(pose, {0, 0, 0.5}), 1e-9) << rig;
      EXPECT_GT(pose.linear().col(2).dot(Vector3d(0, 0, 0.5) - pose.translation()), 0) << rig;
      EXPECT_LT(pose.linear().col(1).z(), 0) << rig << ": the image's y axis points down";
      EXPECT_NEAR(pose.linear().col(0).z(), 0, 1e-9) << rig << ": level";
    }
}

TEST(RigLayout, NarrowCamerasLookAtPartsOfTheSubject) {
  const EmptyRoom scene;
  for (const Eigen::Isometry3d& pose : placeCameras("ring-6-narrow", scene)) {
    EXPECT_GT(fromOpticalAxis(pose, {0, 0, 0.5}), 0.1);
    EXPECT_LT(fromOpticalAxis(pose, {0, 0, 0.5}), 0.87);  // half of the box's diagonal
  }
}

TEST(RigLayout, RingStandsAroundTheSubject) {
  const EmptyRoom scene;
  const auto four = placeCameras("ring-4", scene);
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d a = four[k].translation().head<2>(), b = four[(k + 1) % 4].translation().head<2>();
    EXPECT_NEAR(a.normalized().dot(b.normalized()), 0, 1e-6);
  }
  const auto two = placeCameras("ring-2", scene);
  EXPECT_NEAR(two[0].translation().head<2>().normalized().dot(two[1].translation().head<2>().normalized()), 0.5, 1e-6);
}

TEST(RigLayout, RefusesAnotherName) {
  const EmptyRoom scene;
  for (const std::string rig : {"", "ring", "ring-0", "ring-65", "ring-4-wide", "sphere-4", "ring-100"})
    EXPECT_THROW(placeCameras(rig, scene), fuse_flow::io::InputError) << rig;
}

}  // namespace
