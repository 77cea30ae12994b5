#include "../simulation/mesh_checks.h"

#include "evaluation/truth_parts.h"
#include "simulation/rig_layout.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace fuse_flow::simulation;
using mesh_checks::Vector3f;

/** \brief A rectangle whose normal is u × v. */
Object side(const std::string& part, const Vector3f& corner, const Vector3f& u, const Vector3f& v) {
  Object object;
  object.part = part;
  object.mesh.vertices = {corner, corner + u, corner + u + v, corner + v};
  object.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return object;
}

fuse_flow::Camera cameraAt(const Eigen::Vector3d& position, const Eigen::Vector3d& looks_at) {
  fuse_flow::Camera camera;
  camera.intrinsics = {640, 480, 525, 525, 319.5f, 239.5f, {}};
  camera.T_world_camera = lookAt(position, looks_at);
  return camera;
}

/** \brief Surfaces under one camera 2 m above the origin, or more. */
class TruthParts : public testing::Test {
 protected:
  void look(const RayScene& scene) {
    const std::vector<bool> present(cameras.size(), true);
    visible = visibleSurface(scene, cameras, present, Visibility(), 2);
    views.emplace(cameras, present, Visibility());
    parts.emplace(scene, *views, visible, 2);
    scene_ = &scene;
  }

  /** \brief The samples of some parts, each moved along its normal by so many metres. */
  PlainCloud samplesOf(const std::vector<std::pair<std::string, float>>& wanted) const {
    PlainCloud cloud;
    for (const SurfacePoint& point : visible)
      for (const auto& [part, by] : wanted)
        if (scene_->object(point.object).part == part) cloud.positions.push_back(point.position + by * point.normal);
    return cloud;
  }
  PlainCloud allSamples() const {
    PlainCloud cloud;
    for (const SurfacePoint& point : visible) cloud.positions.push_back(point.position);
    return cloud;
  }

  std::vector<PartQuality> compared(const PlainCloud& cloud) const {
    TruthMatches matches;
    compareWithTruth(cloud, *scene_, visible, 2, &matches);
    return parts->compare(matches);
  }

  static PartQuality of(const std::string& name, const std::vector<PartQuality>& all) {
    const auto found = std::find_if(all.begin(), all.end(), [&](const PartQuality& p) { return p.name() == name; });
    if (found != all.end()) return *found;
    ADD_FAILURE() << "no " << name;
    return PartQuality(name);
  }

  std::vector<fuse_flow::Camera> cameras{cameraAt({0, 0, 2}, {0, 0, 0})};
  std::vector<SurfacePoint> visible;
  std::optional<TrueCameras> views;
  std::optional<PartComparison> parts;

 private:
  const RayScene* scene_{nullptr};
};

/** \brief A box of 0.6 m whose sides have names, its top in the plane z = 0. */
RayScene labelledBox() {
  RayScene scene;
  const Vector3f x(0.6f, 0, 0), y(0, 0.6f, 0), z(0, 0, 0.6f), low(-0.3f, -0.3f, -0.6f), high(0.3f, 0.3f, 0);
  scene.setFixed({side("top", low + z, x, y), side("bottom", low, y, x), side("left", low, z, y),
                  side("right", high, -y, -z), side("front", low, x, z), side("back", high, -z, -x)});
  return scene;
}

TEST_F(TruthParts, OfABoxAreItsSidesAndThoseThatNobodySeesHaveNoSamples) {
  const RayScene scene = labelledBox();
  cameras.push_back(cameraAt({2, 0, -0.3}, {0, 0, -0.3}));
  look(scene);
  const auto all = compared(allSamples());
  for (const char* name : {"top", "right"}) {
    const PartQuality part = of(name, all);
    EXPECT_NEAR(static_cast<double>(part.surfaceSamples()), 0.36 / (0.015 * 0.015), 40) << name;
    EXPECT_EQ(part.points(), part.surfaceSamples()) << name;
    EXPECT_NEAR(part.accuracyMean(), 0, 1e-4) << name;
    EXPECT_EQ(part.completeness10(), 1) << name;
    EXPECT_EQ(part.fScore5(), 1) << name;
  }
  for (const char* name : {"bottom", "left", "front", "back", "person", "near the floor", "under 1 m/s"})
    EXPECT_EQ(of(name, all).surfaceSamples(), 0u) << name;
}

TEST_F(TruthParts, ThatACloudMissesAreNotHiddenByTheOthers) {
  const RayScene scene = labelledBox();
  cameras.push_back(cameraAt({2, 0, -0.3}, {0, 0, -0.3}));
  look(scene);
  const auto all = compared(samplesOf({{"top", 0.0f}}));
  EXPECT_EQ(of("top", all).fScore5(), 1);
  const PartQuality missed = of("right", all);
  EXPECT_GT(missed.surfaceSamples(), 1000u);
  EXPECT_LT(missed.points(), 60u) << "on the edge";
  EXPECT_LT(missed.completeness10(), 0.03) << "beside the edge";
  EXPECT_LT(missed.fScore5(), 0.03);
}

TEST_F(TruthParts, DistancesAreSignedPositiveOutside) {
  const RayScene scene = labelledBox();
  cameras.push_back(cameraAt({2, 0, -0.3}, {0, 0, -0.3}));
  look(scene);
  PlainCloud cloud;
  for (const SurfacePoint& point : visible) {
    const Vector3f& p = point.position;
    if (std::max(std::fabs(p.y()), std::max(p.x() * p.x(), p.z() * p.z())) > 0.25f) continue;  // off the edges
    const bool top = scene.object(point.object).part == "top";
    if (top && std::fabs(p.x()) > 0.25f) continue;
    if (!top && (p.z() > -0.05f || p.z() < -0.55f)) continue;
    cloud.positions.push_back(p + (top ? -0.002f : 0.004f) * point.normal);
  }
  const auto all = compared(cloud);
  EXPECT_NEAR(of("top", all).accuracyMean(), 2, 1e-3);
  EXPECT_NEAR(of("top", all).signedMean(), -2, 1e-3);
  EXPECT_NEAR(of("right", all).accuracyMean(), 4, 1e-3);
  EXPECT_NEAR(of("right", all).signedMean(), 4, 1e-3);
}

TEST_F(TruthParts, PointsOver30MillimetresAwayCountInTheMeanAndAsAShareAndNotInTheSignedMean) {
  RayScene scene;
  scene.setFixed({side("plate", {-0.3f, -0.3f, 0}, {0.6f, 0, 0}, {0, 0.6f, 0})});
  look(scene);
  PlainCloud cloud = samplesOf({{"plate", -0.001f}});
  const PlainCloud ghosts = samplesOf({{"plate", 0.099f}});
  cloud.positions.insert(cloud.positions.end(), ghosts.positions.begin(), ghosts.positions.end());
  const PartQuality plate = of("plate", compared(cloud));
  EXPECT_NEAR(plate.accuracyMean(), 50, 1e-2);
  EXPECT_NEAR(plate.signedMean(), -1, 1e-3);
  EXPECT_DOUBLE_EQ(plate.ghosting(), 0.5);
  EXPECT_DOUBLE_EQ(plate.precision5(), 0.5);
  EXPECT_NEAR(plate.fScore5(), 2.0 / 3, 1e-9);
}

TEST_F(TruthParts, OfAPersonAreAlsoSummedAndThoseNearTheFloorAsWell) {
  RayScene scene;
  cameras = {cameraAt({0, -2, 0.5}, {0, 0, 0.5})};
  const Vector3f x(0.3f, 0, 0);
  scene.setFixed({side("leg", {-0.3f, 0, 0.2f}, x, {0, 0, 0.4f}), side("foot", {-0.3f, 0, 0}, x, {0, 0, 0.2f}),
                  side("chair", {0, 0, 0}, x, {0, 0, 0.6f})});
  look(scene);
  const auto all = compared(allSamples());
  const auto samples = [&](const char* name) { return static_cast<double>(of(name, all).surfaceSamples()); };
  EXPECT_EQ(samples("person"), samples("leg") + samples("foot"));
  EXPECT_NEAR(samples("near the floor") / samples("foot"), 0.2, 0.05);
  EXPECT_NEAR(samples("chair") / samples("person"), 1, 0.03);
}

TEST_F(TruthParts, AreGroupedByTheSpeedOfTheSurface) {
  RayScene scene;
  std::vector<Object> moving;
  const float speeds[] = {0, 0.5f, 2, 6};
  for (int k = 0; k < 4; ++k) {
    moving.push_back(side("stripe " + std::to_string(k), {-0.4f + 0.2f * static_cast<float>(k), -0.3f, 0}, {0.2f, 0, 0},
                          {0, 0.6f, 0}));
    moving.back().mesh.velocities.assign(4, speeds[k] * Vector3f(0, 0.6f, -0.8f));
  }
  scene.setFixed({side("floor", {-1, -1, -0.1f}, {2, 0, 0}, {0, 2, 0})});
  scene.setMoving(moving);
  look(scene);
  const auto all = compared(samplesOf({{"stripe 0", 0.0f}, {"stripe 1", 0.0f}, {"stripe 3", -0.003f}}));
  const auto samples = [&](const std::string& name) { return of(name, all).surfaceSamples(); };
  EXPECT_GT(samples("floor"), 0u);
  EXPECT_EQ(samples("under 1 m/s"), samples("stripe 0") + samples("stripe 1"));
  EXPECT_EQ(samples("1 to 4 m/s"), samples("stripe 2"));
  EXPECT_EQ(samples("over 4 m/s"), samples("stripe 3"));
  EXPECT_LT(of("1 to 4 m/s", all).completeness10(), 0.15) << "but beside the others";
  EXPECT_NEAR(of("over 4 m/s", all).signedMean(), -3, 1e-3);
  EXPECT_EQ(samples("seen by 1 camera"), samples("under 1 m/s") + samples("1 to 4 m/s") + samples("over 4 m/s"))
      << "the floor does not move";
}

TEST_F(TruthParts, AreGroupedByTheBestIncidenceAndTheNumberOfCameras) {
  RayScene scene;
  const auto tilted = [](const std::string& part, float x, float degrees) {
    const float angle = degrees * 0.0174532925f;
    return side(part, {x, -0.02f, 0}, {0.04f * std::cos(angle), 0, -0.04f * std::sin(angle)}, {0, 0.04f, 0});
  };
  // The camera sees them from 2 m above, within 3 degrees of the vertical.
  scene.setFixed({tilted("flat", -0.1f, 30), tilted("slanted", -0.02f, 55), tilted("steep", 0.04f, 72)});
  const auto samplesIn = [&](const std::string& name) {
    look(scene);
    return of(name, compared(allSamples())).surfaceSamples();
  };
  const auto expectSame = [&](const std::string& group, const std::string& part) {
    EXPECT_GT(samplesIn(part), 0u) << part;
    EXPECT_EQ(samplesIn(group), samplesIn(part)) << group;
  };
  expectSame("incidence under 45 deg", "flat");
  expectSame("incidence 45 to 65 deg", "slanted");
  expectSame("incidence over 65 deg", "steep");
  EXPECT_EQ(samplesIn("seen by 2 or more"), 0u);
  cameras.push_back(cameraAt({2, 0, 2}, {0, 0, 0}));  // 15, 10 and 27 degrees from their normals
  EXPECT_EQ(samplesIn("incidence over 65 deg"), 0u);
  EXPECT_EQ(samplesIn("seen by 1 camera"), 0u);
  EXPECT_EQ(samplesIn("incidence under 45 deg"), visible.size());
  EXPECT_EQ(samplesIn("seen by 2 or more"), visible.size());
}

TEST_F(TruthParts, OfSeveralFramesArePointsAndSamplesOfAllOfThem) {
  std::vector<PartQuality> sum, first(1, PartQuality("hand")), second(1, PartQuality("hand"));
  first[0].addPoint(0.001f);
  for (int k = 0; k < 3; ++k) second[0].addPoint(-0.005f);
  first[0].addSample(0.020f);
  for (int k = 0; k < 3; ++k) second[0].addSample(0.007f);
  second.emplace_back("foot");
  addParts(sum, first);
  addParts(sum, second);
  ASSERT_EQ(sum.size(), 2u);
  EXPECT_NEAR(sum[0].accuracyMean(), (1 + 3 * 5) / 4.0, 1e-5);
  EXPECT_NEAR(sum[0].signedMean(), (1 - 3 * 5) / 4.0, 1e-5);
  EXPECT_EQ(sum[0].completeness10(), 0.75);
  EXPECT_EQ(sum[0].completeness5(), 0);
  EXPECT_TRUE(std::isnan(sum[1].accuracyMean())) << "nothing is known of the foot";
  EXPECT_TRUE(std::isnan(sum[1].completeness10()));
}

}  // namespace
