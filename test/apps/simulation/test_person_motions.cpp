#include "../../test_length.h"
#include "mesh_checks.h"

#include "simulation/people/person_motions.h"
#include "simulation/scene.h"
#include "simulation/scenes/track.h"
#include "simulation/surfaces/ray_scene.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <ostream>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace fuse_flow::simulation;
using mesh_checks::Vector3d;
using mesh_checks::Vector3f;

TEST(Track, PassesThroughItsKeysWithTheirVelocitiesAndRepeats) {
  const Track track{{0, 1}, {0.5, 3, 2, -9.81}, {2, 1}};
  constexpr double step = 1e-4;
  for (const double period : {0.0, 2.0, -4.0}) {
    EXPECT_NEAR(track.at(period), 1, 1e-12);
    EXPECT_NEAR(track.at(0.5 + period), 3, 1e-12);
    for (const double side : {-step, step}) {
      const double at = 0.5 + period + side;
      EXPECT_NEAR((track.at(at + step) - track.at(at - step)) / (2 * step), 2 - 9.81 * side, 1e-5);
      EXPECT_NEAR((track.at(at + step) - 2 * track.at(at) + track.at(at - step)) / (step * step), -9.81, 0.1);
    }
  }
}

struct Motion {
  const char* scene;
  Posture (*posture)(double);
  double period;
  /** \brief Of a wrist, m/s. */
  double slowest_peak, fastest_peak;
};

void PrintTo(const Motion& motion, std::ostream* out) { *out << motion.scene; }

class PersonMotions : public testing::TestWithParam<Motion> {
 protected:
  static const Scene& scene() {
    static std::map<std::string, std::unique_ptr<Scene>> scenes;
    auto& made = scenes[GetParam().scene];
    if (!made) made = makeScene(GetParam().scene, 1);
    return *made;
  }
  static std::vector<double> someTimes(double step) {
    std::vector<double> times;
    for (double time = 0; time < GetParam().period; time += step * timesOver(1, 4)) times.push_back(time);
    return times;
  }
};

TEST_P(PersonMotions, RepeatAfterTheirPeriod) {
  for (const double time : someTimes(0.31)) {
    const Posture now = GetParam().posture(time), later = GetParam().posture(time + GetParam().period);
    EXPECT_TRUE(now.pelvis.isApprox(later.pelvis, 1e-9)) << time;
    for (const double side : {-1.0, 1.0})
      EXPECT_LT((now.side(side).wrist - later.side(side).wrist).norm(), 0.02) << time << ", breath and sway aside";
  }
}

TEST_P(PersonMotions, MoveHandsAsFastAsPeopleDo) {
  constexpr double step = 1.0 / 2000;
  double fastest = 0, hardest = 0;
  for (double time = 0; time < GetParam().period; time += step)
    for (const double side : {-1.0, 1.0}) {
      const auto wrist = [&](double at) { return GetParam().posture(at).side(side).wrist; };
      const Vector3d a = wrist(time - step), b = wrist(time), c = wrist(time + step);
      fastest = std::max(fastest, (c - b).norm() / step);
      hardest = std::max(hardest, (c - 2 * b + a).norm() / (step * step));
    }
  EXPECT_GT(fastest, GetParam().slowest_peak);
  EXPECT_LT(fastest, GetParam().fastest_peak);
  EXPECT_LT(hardest, 300) << "m/s²";
}

TEST_P(PersonMotions, BendTheSurfaceSmoothly) {
  constexpr double step = 1.0 / 240;
  for (const double time : someTimes(0.43)) {
    const std::vector<Object> a = scene().movingObjects(time), b = scene().movingObjects(time + step),
                              c = scene().movingObjects(time + 2 * step);
    ASSERT_EQ(a.size(), c.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
      ASSERT_EQ(a[k].mesh.triangles, c[k].mesh.triangles);
      for (std::size_t i = 0; i < a[k].mesh.vertices.size(); i += 5) {
        const Vector3d ab = (b[k].mesh.vertices[i] - a[k].mesh.vertices[i]).cast<double>() / step;
        const Vector3d bc = (c[k].mesh.vertices[i] - b[k].mesh.vertices[i]).cast<double>() / step;
        ASSERT_LT(bc.norm(), 12) << a[k].part << " at " << time;
        ASSERT_LT((bc - ab).norm() / step, 500) << a[k].part << " at " << time;
      }
    }
  }
}

TEST_P(PersonMotions, AreOfClosedBodiesWithAllParts) {
  for (const double time : {0.0, 0.52, 1.77}) {
    std::vector<const TriangleMesh*> meshes;
    std::set<std::string> parts;
    const std::vector<Object> objects = scene().movingObjects(time);
    for (const Object& object : objects) {
      meshes.push_back(&object.mesh);
      parts.insert(object.part);
      EXPECT_LT(mesh_checks::backwardNormals(object.mesh), 0.01) << object.part << " at " << time;
    }
    EXPECT_EQ(mesh_checks::openEdges(meshes), 0u) << time;
    for (const std::string& part : personParts()) EXPECT_EQ(parts.count(part), 1u) << part;
  }
}

TEST_P(PersonMotions, StayOverTheFloorInTheRoomAndOutOfTheFurniture) {
  RayScene furniture;
  std::vector<Object> fixed;
  for (const Object& object : scene().fixedObjects())
    if (object.name != "floor") fixed.push_back(object);
  furniture.setFixed(fixed);
  float deepest = 1;
  for (const double time : someTimes(0.17)) {
    float lowest = 1e9f;
    for (const Object& object : scene().movingObjects(time))
      for (std::size_t k = 0; k < object.mesh.vertices.size(); ++k) {
        const Vector3f& v = object.mesh.vertices[k];
        lowest = std::min(lowest, v.z());
        ASSERT_TRUE(v.z() < 0.1f || scene().room().contains(v)) << v.transpose() << " at " << time;
        if (k % 11 == 0) deepest = std::min(deepest, furniture.nearest(v, 0.1f).signed_distance);
      }
    EXPECT_GT(lowest, -0.012f) << time;
    if (std::string(GetParam().scene) != "hop") {
      EXPECT_LT(lowest, 0.02f) << time;
    }
  }
  EXPECT_GT(deepest, -0.006f) << "cloth gives way a little";
  if (std::string(GetParam().scene) == "sit") {
    EXPECT_LT(deepest, 0.006f) << "does not sit on the chair";
  } else {
    EXPECT_GT(deepest, 0.05f);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, PersonMotions,
                         testing::Values(Motion{"punch", punching, 4, 6.5, 8}, Motion{"hop", hopping, 1.9, 3, 8},
                                         Motion{"sit", sitting, 6, 0.4, 2.5}, Motion{"hand", showingAHand, 3, 0.02, 1},
                                         Motion{"ball", tossing, 2.2, 4, 6}, Motion{"skirt", twisting, 1.6, 1, 4},
                                         Motion{"handshake", shakingHands, 4, 0.7, 3}),
                         [](const auto& motion) { return std::string(motion.param.scene); });

TEST(Punching, ReachesOutWithAFistAndWithAnOpenHandWhileTheFeetStand) {
  const std::map<double, std::pair<double, bool>> hits{
      {0.53, {1, true}}, {1.53, {-1, true}}, {2.53, {1, false}}, {3.53, {-1, false}}};
  for (const auto& [time, hit] : hits) {
    const auto& [side, fist] = hit;
    const Posture posture = punching(time);
    EXPECT_GT(posture.side(side).wrist.x(), 0.5) << time;
    EXPECT_LT(posture.side(-side).wrist.x(), 0.3) << time;
    EXPECT_EQ(posture.side(side).closed > 0.9, fist) << time;
    EXPECT_EQ(posture.side(side).closed < 0.1, !fist) << time;
    for (const double foot : {-1.0, 1.0})
      EXPECT_TRUE(posture.side(foot).foot.isApprox(punching(0).side(foot).foot)) << time;
  }
}

TEST(Hopping, FallsFreelyWithBothFeetOffTheFloorAndStandsBetween) {
  constexpr double step = 1e-3, middle = 0.9 + 1.98 / 9.81;
  for (const double time : {middle - 0.15, middle, middle + 0.15}) {
    const auto height = [](double at) { return hopping(at).pelvis.translation().z(); };
    // The pelvis also tilts a little about the hips.
    EXPECT_NEAR((height(time + step) - 2 * height(time) + height(time - step)) / (step * step), -9.81, 0.5) << time;
  }
  for (const double side : {-1.0, 1.0}) {
    const auto sole = [&](double at) {
      double lowest = 1;
      for (const double x : {-0.07, 0.19})
        lowest = std::min(lowest, (hopping(at).side(side).foot * Vector3d(x, 0.12 * side, 0)).z());
      return lowest;
    };
    EXPECT_GT(sole(middle), 0.12);
    EXPECT_NEAR(sole(0), 0, 1e-9);
    EXPECT_NEAR(sole(1.8), 0, 1e-9);
  }
}

TEST(ShowingAHand, TurnsSpreadFingersFromSideToSide) {
  const PersonHand hand;
  const Object open = hand.posed(Eigen::Isometry3d::Identity(), 1, 0),
               fist = hand.posed(Eigen::Isometry3d::Identity(), 1, 1);
  const auto extent = [](const Object& object) {
    Eigen::AlignedBox3f box;
    for (const Vector3f& v : object.mesh.vertices) box.extend(v);
    return box;
  };
  EXPECT_NEAR(extent(open).max().z(), 0.19, 0.015) << "from the wrist to the tips";
  EXPECT_GT(extent(open).sizes().x(), 0.13f) << "from the thumb's tip to the little finger's";
  EXPECT_LT(extent(fist).max().z(), 0.135f);
  EXPECT_LT(extent(fist).min().y(), -0.03f) << "towards the palm";
  EXPECT_LT(extent(fist).max().y(), 0.035f);
  const Object right = hand.posed(Eigen::Isometry3d::Identity(), -1, 0);
  EXPECT_GT(mesh_checks::volume(right.mesh), 2e-4);
  EXPECT_NEAR(mesh_checks::volume(right.mesh), mesh_checks::volume(open.mesh), 1e-8);
  EXPECT_NEAR(extent(right).max().x(), -extent(open).min().x(), 1e-6);
  const Vector3d one = showingAHand(0).side(-1).thumb, other = showingAHand(1.5).side(-1).thumb;
  EXPECT_NEAR(std::acos(one.normalized().dot(other.normalized())), 2.8, 0.01);
}

/** \brief The nearest that vertices of some objects come to a surface, metres; negative inside. */
float leastDistance(const std::vector<Object>& objects, const RayScene& surface) {
  float least = 1;
  for (const Object& object : objects)
    for (std::size_t k = 0; k < object.mesh.vertices.size(); k += 3)
      least = std::min(least, surface.nearest(object.mesh.vertices[k], 0.3f).signed_distance);
  return least;
}

/** \brief Those that are of a part, or those that are not. */
std::vector<Object> ofPart(const std::string& part, bool wanted, const std::vector<Object>& objects) {
  std::vector<Object> some;
  for (const Object& object : objects)
    if (((object.part.empty() ? object.name : object.part) == part) == wanted) some.push_back(object);
  return some;
}

TEST(Tossing, TheBallFallsFreelyAndLiesOnThePalmBefore) {
  constexpr double step = 1e-3;
  const auto height = [](double at) { return tossedBall(at).translation().z(); };
  for (const double time : {0.6, 1.0, 1.4})
    EXPECT_NEAR((height(time + step) - 2 * height(time) + height(time - step)) / (step * step), -9.81, 0.01) << time;
  EXPECT_NEAR(height(0.54 + 4.4 / 9.81) - height(0.54), 4.4 * 4.4 / (2 * 9.81), 1e-6);
  for (double time = 0; time < 2.2; time += 0.01)
    EXPECT_LT((tossedBall(time + 0.01).translation() - tossedBall(time).translation()).norm(), 0.05) << time;
  const std::unique_ptr<Scene> scene = makeScene("ball", 1);
  for (const double time : {0.0, 0.42, 0.53, 1.45, 1.9}) {
    const std::vector<Object> objects = scene->movingObjects(time);
    RayScene ball;
    ball.setFixed(ofPart("ball", true, objects));
    const float gap = leastDistance(ofPart("ball", false, objects), ball);
    EXPECT_GT(gap, -0.003f) << time;
    EXPECT_LT(gap, 0.006f) << time;
  }
}

TEST(Skirt, FliesAroundTheLegsWithoutTouchingThem) {
  const std::unique_ptr<Scene> scene = makeScene("skirt", 1);
  float fastest = 0;
  for (double time = 0; time < 1.6; time += 0.1 * timesOver(1, 4)) {
    const std::vector<Object> objects = scene->movingObjects(time), later = scene->movingObjects(time + 0.001);
    const std::vector<Object> sheet = ofPart("skirt", true, objects);
    ASSERT_EQ(sheet.size(), 1u);
    const double area = mesh_checks::area(sheet[0].mesh) / 2;
    EXPECT_NEAR(mesh_checks::volume(sheet[0].mesh) / area, 0.002, 1e-4) << "its thickness";
    RayScene cloth;
    cloth.setFixed(sheet);
    EXPECT_GT(leastDistance(ofPart("skirt", false, objects), cloth), 0.002f) << time;
    for (std::size_t k = 0; k < sheet[0].mesh.vertices.size(); ++k)
      fastest = std::max(fastest, (later.back().mesh.vertices[k] - sheet[0].mesh.vertices[k]).norm() / 0.001f);
  }
  EXPECT_GT(fastest, 1.2f);
  EXPECT_LT(fastest, 4);
}

TEST(ShakingHands, TwoPeopleTouchWithTheirHandsOnly) {
  const std::unique_ptr<Scene> scene = makeScene("handshake", 1);
  for (const double time : {0.0, 1.1, 1.45, 2.3}) {
    const std::vector<Object> objects = scene->movingObjects(time);
    const auto half = static_cast<std::ptrdiff_t>(objects.size() / 2);
    const std::vector<Object> one(objects.begin(), objects.begin() + half),
        other(objects.begin() + half, objects.end());
    RayScene others_hands, other_body;
    others_hands.setFixed(ofPart("hand", true, other));
    other_body.setFixed(ofPart("hand", false, other));
    const float hands = leastDistance(ofPart("hand", true, one), others_hands);
    if (time > 1) {
      EXPECT_GT(hands, -0.006f) << time;
      EXPECT_LT(hands, 0.006f) << time;
    } else {
      EXPECT_GT(hands, 0.2f);
    }
    EXPECT_GT(leastDistance(ofPart("hand", false, one), other_body), 0.05f) << time;
  }
}

TEST(Pass, TwoPeopleComeNearAndDoNotTouch) {
  const std::unique_ptr<Scene> scene = makeScene("pass", 1);
  double nearest = 10;
  for (double time = 0; time < 6; time += 0.25 * timesOver(1, 3)) {
    const std::vector<Object> objects = scene->movingObjects(time);
    const auto half = static_cast<std::ptrdiff_t>(objects.size() / 2);
    RayScene other;
    other.setFixed({objects.begin() + half, objects.end()});
    const float gap = leastDistance({objects.begin(), objects.begin() + half}, other);
    EXPECT_GT(gap, 0.02f) << time;
    nearest = std::min(nearest, static_cast<double>(gap));
  }
  EXPECT_LT(nearest, 0.3);
}

}  // namespace
