#include "mesh_checks.h"

#include "simulation/sensor.h"
#include "simulation/surfaces/ray_scene.h"

#include <fuse_flow/recordings/error.h>

#include <cmath>
#include <vector>

namespace {

using namespace fuse_flow::simulation;
using fuse_flow::io::FloatImage;
using mesh_checks::Vector3f;

/** \brief A wall before a camera at the origin that looks along z, turned about the y axis by an angle. */
RayScene wallAt(float distance, float tilt = 0, float infrared = 0.7f) {
  Object wall = mesh_checks::squareFacingUp(30, 0);
  const Eigen::Matrix3f R = Eigen::AngleAxisf(3.14159265f + tilt, Vector3f::UnitY()).toRotationMatrix();
  for (Vector3f& v : wall.mesh.vertices) v = R * v + Vector3f(0, 0, distance);
  wall.material.infrared = infrared;
  RayScene scene;
  scene.setFixed({wall});
  return scene;
}

FloatImage shoot(const Sensor& sensor, const RayScene& scene, std::uint64_t frame = 0, int threads = 2) {
  FloatImage depth;
  sensor.measure(scene, Eigen::Isometry3d::Identity(), {1, frame, 0}, threads, depth);
  return depth;
}

/** \brief Depths of the middle of the image, a tenth of its sides; several shots. */
std::vector<float> middle(const Sensor& sensor, const RayScene& scene, int shots = 1, int part = 5) {
  std::vector<float> values;
  for (int shot = 0; shot < shots; ++shot) {
    const FloatImage depth = shoot(sensor, scene, static_cast<std::uint64_t>(shot));
    const int w = depth.width / part / 2, h = depth.height / part / 2;
    for (int v = depth.height / 2 - h; v < depth.height / 2 + h; ++v)
      for (int u = depth.width / 2 - w; u < depth.width / 2 + w; ++u) values.push_back(depth.at(u, v));
  }
  return values;
}

double deviation(const std::vector<float>& values, double truth) {
  double sum = 0;
  for (const float z : values) sum += (static_cast<double>(z) - truth) * (static_cast<double>(z) - truth);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float z : values) sum += static_cast<double>(z);
  return sum / static_cast<double>(values.size());
}

double measuredShare(const std::vector<float>& values) {
  std::size_t measured = 0;
  for (const float z : values) measured += z > 0 ? 1 : 0;
  return static_cast<double>(measured) / static_cast<double>(values.size());
}

TEST(Sensor, OfAnUnknownNameOrScaleIsRefused) {
  EXPECT_THROW(makeSensor("lidar"), fuse_flow::io::InputError);
  EXPECT_THROW(makeSensor("ideal", 0), fuse_flow::io::InputError);
  EXPECT_THROW(makeSensor("ideal", 2.5), fuse_flow::io::InputError);
}

TEST(Sensor, IdealMeasuresTheDepthOfAPlaneExactly) {
  const auto sensor = makeSensor("ideal", 0.25);
  for (const float z : shoot(*sensor, wallAt(1.75f)).data) ASSERT_NEAR(z, 1.75f, 2e-6f);
  // z = d / (1 + tan(tilt) · x): the plane through (0, 0, 2), turned by 30°
  const FloatImage depth = shoot(*sensor, wallAt(2, 0.5235988f));
  const fuse_flow::Intrinsics K = sensor->intrinsics();
  for (const int u : {3, 40, 80, 150}) {
    const float x = (static_cast<float>(u) - K.cx) / K.fx;
    EXPECT_NEAR(depth.at(u, 60), 2 / (1 + 0.5773503f * x), 1e-5f);
  }
}

TEST(Sensor, StructuredLightIsAsNoisyAsNguyenMeasured) {
  const auto sensor = makeSensor("structured_light");
  for (const double z : {1.0, 2.0, 3.0}) {
    const double expected = 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
    EXPECT_NEAR(deviation(middle(*sensor, wallAt(static_cast<float>(z)), 3), z) / expected, 1, 0.15) << z;
  }
}

TEST(Sensor, TimeOfFlightIsAsNoisyAsItsModel) {
  const auto sensor = makeSensor("time_of_flight");
  for (const double z : {1.0, 2.0, 3.0}) {
    const double expected = 0.0004 + 0.0002 * z * z;
    EXPECT_NEAR(deviation(middle(*sensor, wallAt(static_cast<float>(z))), z) / expected, 1, 0.15) << z;
  }
}

TEST(Sensor, ActiveStereoIsAsNoisyAsItsDisparity) {
  const auto sensor = makeSensor("active_stereo");
  for (const double z : {1.0, 2.0, 3.0}) {
    const double expected = z * z * 0.08 / (424 * 0.05);
    EXPECT_NEAR(deviation(middle(*sensor, wallAt(static_cast<float>(z)), 4), z) / expected, 1, 0.15) << z;
  }
}

TEST(Sensor, OnBlackTimeOfFlightIsNoisierAsLessLightComesBack) {
  const auto sensor = makeSensor("time_of_flight", 0.5);
  const double bright = deviation(middle(*sensor, wallAt(2)), 2),
               black = deviation(middle(*sensor, wallAt(2, 0, 0.1f)), 2);
  EXPECT_NEAR(black / bright, 7, 0.7);
}

TEST(Sensor, DepthHasTheStepsOfItsDisparity) {
  for (const float z : middle(*makeSensor("structured_light", 0.5), wallAt(2.3f))) {
    const float eighths = 8 * 575.8f * 0.075f / z;
    ASSERT_NEAR(eighths, std::round(eighths), 1e-3f);
  }
  for (const float z : middle(*makeSensor("active_stereo", 0.5), wallAt(2.3f))) {
    const float parts = 32 * 424 * 0.05f / z;
    ASSERT_NEAR(parts, std::round(parts), 1e-3f);
  }
}

TEST(Sensor, SeesAPlaneButNotAtAGrazingAngle) {
  for (const std::string& name : sensorNames()) {
    const auto sensor = makeSensor(name, 0.5);
    EXPECT_GT(measuredShare(middle(*sensor, wallAt(2, 0.5f), 1, 20)), 0.95) << name;
    const double grazing = measuredShare(middle(*sensor, wallAt(2, 1.54f), 1, 60));
    EXPECT_LT(grazing, name == "ideal" ? 1.01 : 0.2) << name;
    EXPECT_GE(grazing, name == "ideal" ? 1 : 0) << name;
  }
}

TEST(Sensor, StructuredLightHasAShadowBesideANearObject) {
  // A board 0.2 m wide at 1 m before a wall at 2 m. The projector, 75 mm to the right, does not light what the board hides
  // from it: on the wall a strip 75 mm wide that the camera sees left of the board.
  Object board = mesh_checks::squareFacingUp(0.1f, 0);
  for (Vector3f& v : board.mesh.vertices) v = Vector3f(v.x(), -10 * v.y(), 1.0f);
  RayScene scene = wallAt(2);
  scene.setMoving({board});
  const auto sensor = makeSensor("structured_light");
  const FloatImage depth = shoot(*sensor, scene);
  const auto share = [&](float from, float to) {  // of measured pixels between two places on the wall
    std::vector<float> values;
    const fuse_flow::Intrinsics K = sensor->intrinsics();
    for (int v = 200; v < 280; ++v)
      for (int u = static_cast<int>(K.cx + K.fx * from / 2); u < static_cast<int>(K.cx + K.fx * to / 2); ++u)
        values.push_back(depth.at(u, v));
    return measuredShare(values);
  };
  EXPECT_LT(share(-0.265f, -0.21f), 0.05);
  EXPECT_GT(share(-0.4f, -0.3f), 0.95);
  EXPECT_GT(share(0.22f, 0.4f), 0.95);
}

TEST(Sensor, MultipathLengthensWhatACornerMeasures) {
  // Two walls that meet in a right angle at 2 m: light goes from one to the other and back.
  RayScene scene = wallAt(2, 0.785398f);
  Object other = mesh_checks::squareFacingUp(30, 0);
  const Eigen::Matrix3f R = Eigen::AngleAxisf(3.14159265f - 0.785398f, Vector3f::UnitY()).toRotationMatrix();
  for (Vector3f& v : other.mesh.vertices) v = R * v + Vector3f(0, 0, 2);
  scene.setMoving({other});
  const double with = mean(middle(*makeSensor("time_of_flight_multipath", 0.25), scene)),
               without = mean(middle(*makeSensor("time_of_flight", 0.25), scene));
  EXPECT_GT(with - without, 0.003);
  EXPECT_LT(with - without, 0.06);
  // A wall alone sends no light to itself.
  EXPECT_NEAR(mean(middle(*makeSensor("time_of_flight_multipath", 0.25), wallAt(2))), 2, 1e-3);
}

TEST(Sensor, GivesTheSameImageForTheSameShotWithAnyNumberOfThreads) {
  const RayScene scene = wallAt(1.5f, 0.3f);
  for (const std::string& name : sensorNames()) {
    const auto sensor = makeSensor(name, 0.2);
    EXPECT_EQ(shoot(*sensor, scene, 4, 1).data, shoot(*sensor, scene, 4, 3).data) << name;
    if (name == "ideal") continue;
    EXPECT_NE(shoot(*sensor, scene, 4).data, shoot(*sensor, scene, 5).data) << name << ": each frame has its own noise";
  }
}

TEST(Sensor, ScaleKeepsTheFieldOfView) {
  for (const std::string& name : sensorNames()) {
    const fuse_flow::Intrinsics whole = makeSensor(name)->intrinsics(), half = makeSensor(name, 0.5)->intrinsics();
    EXPECT_EQ(2 * half.width, whole.width) << name;
    EXPECT_FLOAT_EQ(2 * half.fx, whole.fx) << name;
  }
}

TEST(Sensor, ColourOfASurfaceIsItsAlbedoTimesTheLight) {
  Material grey{Material::Plain, {100, 100, 100}, {}, 0.1f, 0.7f}, double_grey = grey;
  double_grey.first = {200, 200, 200};
  const Vector3f up = litColor(grey, Vector3f::UnitZ(), Vector3f::Zero());
  EXPECT_TRUE(litColor(double_grey, Vector3f::UnitZ(), Vector3f::Zero()).isApprox(2 * up, 1e-5f));
  EXPECT_GT(up.x(), litColor(grey, -Vector3f::UnitZ(), Vector3f::Zero()).x());
}

}  // namespace
