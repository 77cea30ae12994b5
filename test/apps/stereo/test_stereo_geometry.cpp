#include "stereo/stereo_geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace {

using namespace fuse_flow;

constexpr double kDegree = 3.14159265358979323846 / 180;

/** \brief A camera 2 m from the origin, which it looks at. */
Camera cameraAt(double azimuth, double elevation, const std::string& name) {
  Camera camera;
  camera.name = name;
  camera.intrinsics = {160, 120, 131, 131, 79.5f, 59.5f, {}};
  const Eigen::Vector3d ahead =
      -Eigen::Vector3d(std::cos(elevation * kDegree) * std::cos(azimuth * kDegree),
                       std::cos(elevation * kDegree) * std::sin(azimuth * kDegree), std::sin(elevation * kDegree));
  const Eigen::Vector3d right = ahead.cross(Eigen::Vector3d::UnitZ()).normalized();
  camera.T_world_camera.linear() << right, ahead.cross(right), ahead;
  camera.T_world_camera.translation() = -2 * ahead;
  return camera;
}

void turnAround(Camera& camera) {
  camera.T_world_camera.rotate(Eigen::AngleAxisd(180 * kDegree, Eigen::Vector3d::UnitY()));
}

/** \brief So many degrees from one to the next, in turn at two heights or all at one. */
std::vector<Camera> arc(std::size_t count, double step, double height) {
  std::vector<Camera> cameras;
  for (std::size_t k = 0; k < count; ++k)
    cameras.push_back(
        cameraAt(step * static_cast<double>(k), k % 2 == 0 ? 0 : height, std::string(1, static_cast<char>('a' + k))));
  return cameras;
}

std::vector<std::string> warningsOf(const std::vector<Camera>& cameras, const StereoParameters& parameters = {}) {
  const std::vector<bool> all(cameras.size(), true);
  return io::stereoWarnings(cameras, all, io::stereoSetup(cameras, all, parameters).geometry, parameters);
}

std::size_t linesWith(const std::vector<std::string>& lines, const std::string& words) {
  return static_cast<std::size_t>(std::count_if(
      lines.begin(), lines.end(), [&](const std::string& line) { return line.find(words) != std::string::npos; }));
}

TEST(StereoWarnings, NameTheRangeOfDepthAloneWhereCamerasStandWell) {
  const std::vector<std::string> lines = warningsOf(arc(4, 7, 8));
  ASSERT_EQ(lines.size(), 1u) << lines[0];
  EXPECT_EQ(linesWith(lines, "depth is looked for from "), 1u) << lines[0];
  EXPECT_EQ(linesWith(lines, "--stereo-min-depth and --stereo-max-depth"), 1u) << lines[0];
}

TEST(StereoWarnings, SayNothingWhereTheRangeIsGiven) {
  StereoParameters parameters;
  parameters.min_depth = 0.5f;
  EXPECT_EQ(linesWith(warningsOf(arc(4, 7, 8), parameters), "from 0.5 to "), 1u);
  parameters.max_depth = 4;
  EXPECT_TRUE(warningsOf(arc(4, 7, 8), parameters).empty());
}

TEST(StereoWarnings, NameAViewThatOverlapsNoOther) {
  std::vector<Camera> cameras = arc(4, 7, 8);
  turnAround(cameras[1]);
  EXPECT_EQ(linesWith(warningsOf(cameras), "1 of 4 views (b) overlaps no other"), 1u);
}

TEST(StereoWarnings, NameViewsWhoseBaselinesAreParallel) {
  EXPECT_EQ(linesWith(warningsOf(arc(4, 7, 0)), "4 of 4 views (a, b, c, …) have neighbours in one direction only"), 1u);
}

TEST(StereoWarnings, NameNeighboursThatStandTooCloseOrTooFar) {
  std::vector<Camera> cameras = arc(3, 7, 8);
  cameras.push_back(cameraAt(1, 0, "d"));
  EXPECT_EQ(linesWith(warningsOf(cameras), "2 of 4 views (a, d) have a neighbour less than 2 degrees away (1)"), 1u);
  EXPECT_EQ(linesWith(warningsOf(arc(2, 40, 0)), "2 of 2 views (a, b) have no neighbour less than 30 degrees away"),
            1u);
  EXPECT_EQ(linesWith(warningsOf(arc(2, 10, 0)), "degrees away"), 0u);
}

TEST(StereoWarnings, NameViewsThatLookOutward) {
  // Around a circle of 15 cm, 60 degrees from one to the next, each sees 90 degrees.
  std::vector<Camera> cameras = arc(6, 10, 0);
  for (std::size_t k = 0; k < 6; ++k) {
    Camera& camera = cameras[k];
    camera.intrinsics.fx = camera.intrinsics.fy = 0.5f * static_cast<float>(camera.intrinsics.width);
    const double angle = static_cast<double>(k) * 60 * M_PI / 180;
    const Eigen::Vector3d forward(std::cos(angle), 0, std::sin(angle)), down(0, 1, 0);
    camera.T_world_camera.linear() << down.cross(forward), down, forward;
    camera.T_world_camera.translation() = 0.15 * forward;
  }
  EXPECT_EQ(linesWith(warningsOf(cameras),
                      "6 of 6 views (a, b, c, …) look away from its neighbours, from the nearest by up to 60 degrees: "
                      "depth is found where"),
            1u);
  EXPECT_EQ(linesWith(warningsOf(cameras), "images differ too much"), 0u);
  // Inward, and from one place, they do not look away from each other.
  EXPECT_EQ(linesWith(warningsOf(arc(2, 40, 0)), "away from its neighbours"), 0u);
  for (Camera& camera : cameras) camera.T_world_camera.translation() *= -1;
  EXPECT_EQ(linesWith(warningsOf(cameras), "away from its neighbours"), 0u);
}

TEST(StereoWarnings, AreOfTheViewsWhoseDepthIsEstimated) {
  std::vector<Camera> cameras = arc(4, 7, 8);
  turnAround(cameras[1]);
  const auto geometry = io::stereoSetup(cameras, std::vector<bool>(4, true), {}).geometry;
  EXPECT_EQ(linesWith(io::stereoWarnings(cameras, {true, false, true, true}, geometry, {}), "overlaps"), 0u);
}

TEST(StereoWarnings, CamerasWithoutColourMatchNothing) {
  const std::vector<Camera> cameras = arc(2, 10, 0);
  EXPECT_FALSE(io::stereoSetup(cameras, {true, true}, {}).geometry[0].sources.empty());
  EXPECT_TRUE(io::stereoSetup(cameras, {true, false}, {}).geometry[0].sources.empty());
}

TEST(EpipolarWarning, NamesCamerasWhoseMatchesLieBesideTheirLines) {
  const std::vector<Camera> cameras = arc(3, 7, 8);
  const float none = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(io::epipolarWarning(cameras, {}), "");
  EXPECT_EQ(io::epipolarWarning(cameras, {{0, 1, 100, 0.4f}, {1, 0, 100, 0.5f}, {1, 2, 0, none}}), "");
  EXPECT_EQ(io::epipolarWarning(cameras, {{0, 1, 10, 9}, {1, 0, 10, 9}}), "") << "so few matches say nothing";
  // The last camera is off: of the others half of the pairs are right.
  const std::string line = io::epipolarWarning(
      cameras, {{0, 1, 100, 0.5f}, {1, 0, 100, 0.6f}, {0, 1, 100, 0.4f}, {0, 2, 100, 4}, {2, 1, 100, 5}});
  EXPECT_NE(line.find("1 of 3 views (c: 5) has matches more than 2 pixels beside"), std::string::npos) << line;
}

}  // namespace
