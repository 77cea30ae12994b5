#include "../../test_length.h"
#include "mesh_checks.h"

#include "simulation/people/person_body.h"
#include "simulation/rig_layout.h"
#include "simulation/scene.h"
#include "simulation/sensor.h"
#include "simulation/surfaces/ray_scene.h"

#include <fuse_flow/recordings/error.h>

#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <string_view>

namespace {

using namespace fuse_flow::simulation;
using mesh_checks::Vector3d;
using mesh_checks::Vector3f;

const Scene& sceneOnce(std::string_view name) {
  static std::map<std::string, std::unique_ptr<Scene>> scenes;
  auto& scene = scenes[std::string(name)];
  if (!scene) scene = makeScene(std::string(name), 1);
  return *scene;
}

bool oneSided(const Object& object) {
  return object.name == "wall" || object.name == "floor" || object.name == "ceiling";
}

bool same(const std::vector<Object>& a, const std::vector<Object>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t k = 0; k < a.size(); ++k)
    if (a[k].name != b[k].name || a[k].mesh.vertices != b[k].mesh.vertices ||
        a[k].mesh.triangles != b[k].mesh.triangles)
      return false;
  return true;
}

class EveryScene : public testing::TestWithParam<std::string> {
 protected:
  const Scene& scene() const { return sceneOnce(GetParam()); }
};

TEST_P(EveryScene, HasFiniteVerticesAndUnitNormalsOnTheOuterSide) {
  for (const auto& objects : {scene().fixedObjects(), scene().movingObjects(0), scene().movingObjects(0.4)}) {
    for (const Object& object : objects) {
      ASSERT_FALSE(object.mesh.triangles.empty()) << object.name;
      EXPECT_TRUE(mesh_checks::allFinite(object.mesh)) << object.name;
      EXPECT_TRUE(mesh_checks::unitNormals(object.mesh)) << object.name;
      EXPECT_TRUE(object.mesh.rest.empty() || object.mesh.rest.size() == object.mesh.vertices.size()) << object.name;
      EXPECT_LT(mesh_checks::backwardNormals(object.mesh), 3e-3) << object.name << ", folds in armpits aside";
    }
  }
}

TEST_P(EveryScene, IsMadeOfClosedSolidsInARoom) {
  for (const Object& object : scene().fixedObjects()) {
    if (oneSided(object)) continue;
    EXPECT_EQ(mesh_checks::openEdges({&object.mesh}), 0u) << object.name;
    EXPECT_GT(mesh_checks::volume(object.mesh), 0) << object.name;
  }
}

TEST_P(EveryScene, LiesWithinItsRoom) {
  Eigen::AlignedBox3f room = scene().room();
  room.min().array() -= 1e-4f;
  room.max().array() += 1e-4f;
  for (const Object& object : scene().fixedObjects())
    for (const Vector3f& v : object.mesh.vertices)
      ASSERT_TRUE(room.contains(v)) << object.name << " at " << v.transpose();
}

TEST_P(EveryScene, IsTheSameForTheSameSeedOnly) {
  const auto again = makeScene(GetParam(), 1), other = makeScene(GetParam(), 2);
  EXPECT_TRUE(same(scene().fixedObjects(), again->fixedObjects()));
  EXPECT_TRUE(same(scene().movingObjects(1.23), again->movingObjects(1.23)));
  EXPECT_FALSE(same(scene().fixedObjects(), other->fixedObjects()));
}

TEST_P(EveryScene, LeavesRoomForTheCameras) {
  RayScene rays;
  rays.setFixed(scene().fixedObjects());
  std::vector<std::string> rigs{"arc-17",       "arc-24", "arc-32", "arc-48", "arc-64",
                                "arc-64-level", "row-2",  "row-5",  "row-8"};
  for (int count = 1; count <= 16; ++count)
    for (const std::string layout : {"ring-", "walls-"}) rigs.push_back(layout + std::to_string(count));
  for (int count = 2; count <= 16; ++count)
    for (const std::string end : {"", "-level"}) rigs.push_back("arc-" + std::to_string(count) + end);
  if (scene().lookout())
    for (int count = 2; count <= 16; ++count) rigs.push_back("surround-" + std::to_string(count));
  for (const std::string& rig : rigs) {
    for (const Eigen::Isometry3d& pose : placeCameras(rig, scene())) {
      const Vector3f at = pose.translation().cast<float>();
      const NearestHit hit = rays.nearest(at);
      EXPECT_GT(hit.signed_distance, 0.04f) << rig << " stands in " << rays.object(hit.object).name;
      const Vector3f forward = pose.linear().col(2).cast<float>();
      const RayHit ahead = rays.intersect(at, forward);
      EXPECT_GT(ahead.t, 0.3f) << rig << " sees only " << rays.object(ahead.object).name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, EveryScene, testing::ValuesIn(sceneNames()),
                         [](const auto& scene) { return scene.param; });

TEST(Scenes, OfAnotherNameAreRefused) { EXPECT_THROW(makeScene("moon", 1), fuse_flow::io::InputError); }

TEST(Scenes, OfSmallThingsAreWhollyInViewOfEveryCameraOfAnArc) {
  const fuse_flow::Intrinsics K = makeSensor("ideal")->intrinsics();
  for (const std::string name : {"table", "hand"}) {
    const Eigen::AlignedBox3f subject = sceneOnce(name).subject();
    for (const std::string rig : {"arc-16", "arc-16-level"})
      for (const Eigen::Isometry3d& pose : placeCameras(rig, sceneOnce(name)))
        for (int corner = 0; corner < 8; ++corner) {
          const auto which = static_cast<Eigen::AlignedBox3f::CornerType>(corner);
          const Vector3f p = pose.inverse().cast<float>() * subject.corner(which);
          EXPECT_GT(p.z(), 0.3f) << name << ", " << rig;
          EXPECT_LT(std::fabs(p.x() / p.z() * K.fx), K.cx) << name << ", " << rig;
          EXPECT_LT(std::fabs(p.y() / p.z() * K.fy), K.cy) << name << ", " << rig;
        }
  }
}

TEST(Scenes, OnlyPeopleMove) {
  for (const std::string& name : sceneNames()) {
    const bool things = name == "room" || name == "table" || name == "thin";
    EXPECT_EQ(sceneOnce(name).movingObjects(1).empty(), things) << name;
  }
}

class Person : public testing::Test {
 protected:
  const Scene& scene = sceneOnce("person");

  std::vector<const TriangleMesh*> meshes(const std::vector<Object>& objects) const {
    std::vector<const TriangleMesh*> all;
    for (const Object& object : objects) all.push_back(&object.mesh);
    return all;
  }
};

TEST_F(Person, IsOneClosedBodyInEveryPose) {
  for (const double time : {0.0, 0.35, 2.1, 7.77}) {
    const std::vector<Object> body = scene.movingObjects(time);
    EXPECT_EQ(mesh_checks::openEdges(meshes(body)), 0u) << time;
    double volume = 0, area = 0;
    for (const Object& object : body) area += mesh_checks::area(object.mesh);
    for (const Object& object : body) volume += mesh_checks::volume(object.mesh);
    EXPECT_GT(volume, 0.05) << time;  // an adult: 50 to 110 l, 1.5 to 2.2 m²
    EXPECT_LT(volume, 0.11) << time;
    EXPECT_GT(area, 1.3) << time;
    EXPECT_LT(area, 2.3) << time;
  }
}

TEST_F(Person, HasTheSameTrianglesAtEveryTime) {
  const std::vector<Object> now = scene.movingObjects(0), later = scene.movingObjects(3.3);
  ASSERT_EQ(now.size(), later.size());
  std::size_t triangles = 0;
  for (std::size_t k = 0; k < now.size(); ++k) {
    EXPECT_EQ(now[k].mesh.triangles, later[k].mesh.triangles);
    EXPECT_EQ(now[k].mesh.rest, later[k].mesh.rest);
    triangles += now[k].mesh.triangles.size();
  }
  EXPECT_GT(triangles, 20000u);
  EXPECT_LT(triangles, 80000u);
}

TEST_F(Person, RestsExactlyOnTheImplicitSurface) {
  for (const Object& object : scene.movingObjects(0))
    for (const Vector3f& v : object.mesh.rest)
      ASSERT_NEAR(PersonBody::distance(v.cast<double>()), 0, 1e-5) << v.transpose();
}

TEST_F(Person, HasPartsWhereABodyHasThem) {
  std::map<std::string, Eigen::AlignedBox3f> at;
  for (const Object& object : scene.movingObjects(0))
    for (const Vector3f& v : object.mesh.rest) at[object.part].extend(v);
  ASSERT_EQ(at.size(), personParts().size());
  for (const std::string& part : personParts()) EXPECT_EQ(at.count(part), 1u) << part;
  EXPECT_GT(at["head"].min().z(), 1.38f);
  EXPECT_LT(at["foot"].max().z(), 0.15f);
  EXPECT_LT(at["leg"].max().z(), 1.0f);
  EXPECT_GT(at["leg"].min().z(), 0.05f);
  for (const double side : {-1.0, 1.0}) {
    const Vector3f wrist = rest_pose::wrist(side).cast<float>();
    for (const Object& object : scene.movingObjects(0))
      for (const Vector3f& v : object.mesh.rest) {
        if (v.y() * static_cast<float>(side) < 0) continue;
        ASSERT_TRUE(object.part != "hand" || (v - wrist).norm() < 0.2f) << v.transpose();
        ASSERT_TRUE(object.part != "arm" || v.z() > wrist.z() - 0.04f) << v.transpose();
      }
  }
}

/** \brief Nowhere does a part of the body begin or end to count from one point to the next: not where a coordinate is a whole number
 *  of centimetres either, where cells end in which some are left out. */
TEST_F(Person, HasADistanceWithoutSteps) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> x(-0.4, 0.4), y(-0.8, 0.8), z(-0.1, 1.9);
  for (int k = 0; k < 20000 * timesOver(10, 1); ++k) {
    const Vector3d p(x(random), y(random), z(random));
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double step = 1e-6;
      Vector3d before = p;
      before[axis] = 0.01 * std::round(100 * p[axis]) - step;
      const Vector3d after = before + 2 * step * Vector3d::Unit(axis);
      ASSERT_NEAR(PersonBody::distance(before), PersonBody::distance(after), 4 * step) << p.transpose();
    }
  }
}

TEST_F(Person, MovesSmoothly) {
  constexpr double step = 1.0 / 120;
  double fastest = 0;
  for (double start = 0; start < 10; start += 0.61 * timesOver(1, 4)) {
    const std::vector<Object> a = scene.movingObjects(start), b = scene.movingObjects(start + step),
                              c = scene.movingObjects(start + 2 * step);
    for (std::size_t k = 0; k < a.size(); ++k)
      for (std::size_t i = 0; i < a[k].mesh.vertices.size(); i += 5) {
        const Vector3d ab = (b[k].mesh.vertices[i] - a[k].mesh.vertices[i]).cast<double>() / step;
        const Vector3d bc = (c[k].mesh.vertices[i] - b[k].mesh.vertices[i]).cast<double>() / step;
        fastest = std::max(fastest, ab.norm());
        ASSERT_LT((bc - ab).norm(), 1.5) << a[k].name << " at " << start;  // under 180 m/s²
      }
  }
  EXPECT_LT(fastest, 8);
  EXPECT_GT(fastest, 2);  // the swinging foot
}

TEST_F(Person, WalksAtAMetreASecond) {
  const auto middle = [&](double time) {
    Vector3d sum = Vector3d::Zero();
    std::size_t count = 0;
    for (const Object& object : scene.movingObjects(time))
      for (const Vector3f& v : object.mesh.vertices) sum += v.cast<double>(), ++count;
    return Vector3d(sum / static_cast<double>(count));
  };
  double length = 0;
  for (int k = 0; k < 20; ++k) length += (middle(0.2 * (k + 1)) - middle(0.2 * k)).norm();
  EXPECT_NEAR(length / 4, 1.0, 0.15);
}

TEST_F(Person, StaysOnTheFloorInsideTheSubjectAndOffTheFurniture) {
  RayScene furniture;
  std::vector<Object> fixed;
  for (const Object& object : scene.fixedObjects())
    if (object.name != "floor") fixed.push_back(object);
  furniture.setFixed(fixed);
  for (double time = 0; time <= 10; time += 0.17 * timesOver(1, 4)) {
    float lowest = 1e9f, highest = 0;
    for (const Object& object : scene.movingObjects(time)) {
      for (std::size_t k = 0; k < object.mesh.vertices.size(); ++k) {
        const Vector3f& v = object.mesh.vertices[k];
        lowest = std::min(lowest, v.z());
        highest = std::max(highest, v.z());
        Eigen::AlignedBox3f subject = scene.subject();
        subject.min().z() -= 0.02f;
        ASSERT_TRUE(subject.contains(v)) << object.name << " at " << v.transpose() << ", time " << time;
        if (k % 23 == 0) {
          ASSERT_GT(furniture.nearest(v).t, 0.05f) << object.name << " at " << time;
        }
      }
    }
    EXPECT_GT(lowest, -0.012f) << time;
    EXPECT_LT(lowest, 0.025f) << time;
    EXPECT_GT(highest, 1.62f) << time;
    EXPECT_LT(highest, 1.8f) << time;
  }
}

}  // namespace
