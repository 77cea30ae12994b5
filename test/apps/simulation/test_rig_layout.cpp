#include "simulation/rig_layout.h"

#include <fuse_flow/recordings/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace {

using namespace fuse_flow::simulation;
using Eigen::Vector3d;

class EmptyRoom : public Scene {
 public:
  EmptyRoom(float half_length = 4, float half_width = 3) : half_length_(half_length), half_width_(half_width) {}
  std::vector<Object> fixedObjects() const override { return {}; }
  Eigen::AlignedBox3f subject() const override {
    return {Eigen::Vector3f(-0.5f, -0.5f, 0), Eigen::Vector3f(0.5f, 0.5f, 1)};
  }
  Eigen::AlignedBox3f room() const override {
    return {Eigen::Vector3f(-half_length_, -half_width_, 0), Eigen::Vector3f(half_length_, half_width_, 3)};
  }

 private:
  float half_length_;
  float half_width_;
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
  for (const std::string rig : {"ring-4", "ring-7", "walls-8", "arc-7", "arc-8-level"})
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

/** \brief From the middle of the subject of an EmptyRoom to each camera. */
std::vector<Vector3d> fromMiddle(const std::string& rig, const Scene& scene) {
  std::vector<Vector3d> directions;
  for (const Eigen::Isometry3d& pose : placeCameras(rig, scene))
    directions.push_back(pose.translation() - Vector3d(0, 0, 0.5));
  return directions;
}

double degreesBetween(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / 3.14159265358979;
}

double azimuthDegreesBetween(const Vector3d& a, const Vector3d& b) {
  return degreesBetween({a.x(), a.y(), 0}, {b.x(), b.y(), 0});
}

TEST(RigLayout, NeighboursOnAnArcAreAsFarApartAsStereoViews) {
  for (const EmptyRoom& scene : {EmptyRoom(), EmptyRoom(1.5f, 1.2f)})
    for (const std::string count : {"2", "3", "8", "16", "33", "64"})
      for (const std::string end : {"", "-level"}) {
        const std::string rig = "arc-" + count + end;
        const std::vector<Vector3d> cameras = fromMiddle(rig, scene);
        ASSERT_EQ(cameras.size(), std::stoul(count));
        for (std::size_t k = 0; k < cameras.size(); ++k)
          for (std::size_t next = k + 1; next < std::min(k + 3, cameras.size()); ++next) {
            EXPECT_GT(degreesBetween(cameras[k], cameras[next]), 5) << rig << ": " << k << ", " << next;
            EXPECT_LT(degreesBetween(cameras[k], cameras[next]), 12) << rig << ": " << k << ", " << next;
          }
      }
}

TEST(RigLayout, AnArcHasStepsOfSixDegreesUntilItsCircleIsFull) {
  const EmptyRoom scene;
  const std::vector<Vector3d> quarter = fromMiddle("arc-16", scene), circle = fromMiddle("arc-64", scene);
  for (std::size_t k = 0; k + 1 < quarter.size(); ++k)
    EXPECT_NEAR(azimuthDegreesBetween(quarter[k], quarter[k + 1]), 6, 1e-6) << k;
  EXPECT_NEAR(azimuthDegreesBetween(quarter.front(), quarter.back()), 90, 1e-6);
  for (std::size_t k = 0; k < circle.size(); ++k)
    EXPECT_NEAR(azimuthDegreesBetween(circle[k], circle[(k + 1) % 64]), 360.0 / 64, 1e-6) << k;
}

TEST(RigLayout, AnArcHasTwoHeightsInTurnAndALevelArcHasOne) {
  const EmptyRoom scene;
  const double radius = std::sqrt(0.5) + 1.1;  // half of the subject's diagonal, and 1.1 m before it
  const std::vector<Vector3d> two = fromMiddle("arc-9", scene), one = fromMiddle("arc-9-level", scene);
  for (std::size_t k = 0; k < 9; ++k) {
    EXPECT_NEAR(two[k].head<2>().norm(), radius, 1e-9) << k;
    EXPECT_NEAR(two[k].z(), (k % 2 == 0 ? 0.2 : 0.4) * radius, 1e-9) << k;
    EXPECT_NEAR(one[k].head<2>().norm(), radius, 1e-9) << k;
    EXPECT_NEAR(one[k].z(), 0.3 * radius, 1e-9) << k;
  }
}

TEST(RigLayout, AnArcIsSmallerInASmallRoom) {
  const EmptyRoom scene(1.5f, 1.2f);
  for (const std::string rig : {"arc-2", "arc-16", "arc-40-level", "arc-64"}) {
    const std::vector<Vector3d> cameras = fromMiddle(rig, scene);
    for (const Vector3d& camera : cameras) {
      EXPECT_LT(std::fabs(camera.x()), 1.5 - 0.15 + 1e-6) << rig << ": a camera is 0.15 m deep";
      EXPECT_LT(std::fabs(camera.y()), 1.2 - 0.15 + 1e-6) << rig;
      EXPECT_NEAR(camera.head<2>().norm(), cameras[0].head<2>().norm(), 1e-9) << rig;
      EXPECT_GT(camera.head<2>().norm(), 1.2 - 0.15 - 1e-6) << rig << ": no smaller than it must be";
    }
  }
}

/** \brief A room whose middle is free. */
class FreeMiddle : public EmptyRoom {
 public:
  std::optional<Eigen::Vector3f> lookout() const override { return Eigen::Vector3f(0.5f, -0.25f, 1.25f); }
};

TEST(RigLayout, LooksOutwardFromTheLookout) {
  const FreeMiddle scene;
  const Vector3d middle(0.5, -0.25, 1.25);
  for (const int count : {2, 3, 6, 64}) {
    const auto poses = placeCameras("surround-" + std::to_string(count), scene);
    ASSERT_EQ(poses.size(), static_cast<std::size_t>(count));
    for (std::size_t k = 0; k < poses.size(); ++k) {
      const Vector3d out = poses[k].translation() - middle, forward = poses[k].linear().col(2);
      EXPECT_NEAR(out.norm(), 0.15, 1e-9);
      EXPECT_NEAR(out.dot(forward), 0.15, 1e-9) << "the way that it stands from the middle";
      EXPECT_NEAR(poses[k].linear().col(1).z(), -1, 1e-9) << "level, the image's y axis points down";
      const Vector3d next = poses[(k + 1) % poses.size()].linear().col(2);
      EXPECT_NEAR(forward.dot(next), std::cos(2 * std::acos(-1.0) / count), 1e-9);
      if (count > 2) {
        EXPECT_GT(forward.cross(next).z(), 0) << "all around, to the left";
      }
    }
  }
}

TEST(RigLayout, LooksOutwardOnlyWhereAPlaceIsFree) {
  EXPECT_TRUE(isRigName("surround-6"));
  EXPECT_THROW(placeCameras("surround-6", EmptyRoom()), fuse_flow::io::InputError);
}

TEST(RigLayout, ARowStandsSideBySideFromLeftToRight) {
  const EmptyRoom scene;
  for (const int count : {2, 3, 8}) {
    const auto poses = placeCameras("row-" + std::to_string(count), scene);
    ASSERT_EQ(poses.size(), static_cast<std::size_t>(count));
    Vector3d middle = Vector3d::Zero();
    for (std::size_t k = 0; k < poses.size(); ++k) {
      EXPECT_TRUE(scene.room().cast<double>().contains(poses[k].translation()));
      EXPECT_EQ(poses[k].linear(), poses[0].linear()) << "one orientation";
      const Vector3d place = poses[0].inverse() * poses[k].translation();
      EXPECT_LT((place - Vector3d(0.12 * static_cast<double>(k), 0, 0)).norm(), 1e-9) << "along the rows of the images";
      middle += poses[k].translation() / count;
    }
    const Vector3d to_subject = scene.subject().center().cast<double>() - middle;
    EXPECT_LT(to_subject.cross(poses[0].linear().col(2)).norm(), 1e-9);
  }
}

TEST(RigLayout, RefusesAnotherName) {
  const EmptyRoom scene;
  for (const std::string rig : {"",
                                "ring",
                                "ring-0",
                                "ring-65",
                                "ring-4-wide",
                                "sphere-4",
                                "ring-100",
                                "arc-1",
                                "arc-65",
                                "arc-4-narrow",
                                "ring-4-level",
                                "arc-4-level-narrow",
                                "arc-",
                                "surround-1",
                                "row-1",
                                "row-9",
                                "row-4-level",
                                "surround-65",
                                "surround-6-narrow",
                                "surround-6-level",
                                "surround"})
    EXPECT_THROW(placeCameras(rig, scene), fuse_flow::io::InputError) << rig;
}

}  // namespace
