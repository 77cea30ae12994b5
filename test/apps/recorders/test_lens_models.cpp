#include "recordings/calibrations/lens_models.h"

#include "../recordings/io_fixture.h"

#include <fuse_flow/recordings/recording.h>
#include <fuse_flow/recordings/rig_json.h>

#include <nlohmann/json.hpp>

#include "../tools/support/png_file.h"

#include <cmath>

namespace {

using namespace io_test;
using Json = nlohmann::json;

Intrinsics pinhole() { return {640, 480, 500, 510, 320, 240, {}}; }

/** \brief \param worst largest distance, pixels, between where the lens and the formula see rays all over the image */
template <typename Formula>
void expectSame(const Intrinsics& K, const Formula& distorted, double worst) {
  int compared = 0;
  for (double x = -0.7; x <= 0.7; x += 0.1)
    for (double y = -0.5; y <= 0.5; y += 0.1) {
      const Eigen::Vector2d d = distorted(x, y);
      const double u = 500 * d.x() + 320, v = 510 * d.y() + 240;
      if (u < 0 || v < 0 || u > 639 || v > 479) continue;
      const Pixel pixel = project(K, {static_cast<float>(x), static_cast<float>(y), 1});
      EXPECT_NEAR(pixel.u, u, worst) << x << " " << y;
      EXPECT_NEAR(pixel.v, v, worst) << x << " " << y;
      ++compared;
    }
  EXPECT_GT(compared, 60);
}

TEST(LensModels, BrownConradyIsTakenAsItIsByAnyOfItsNames) {
  std::vector<std::string> warnings;
  for (const char* name : {"", "plumb_bob", "Brown Conrady", "RADTAN", "opencv"}) {
    const Intrinsics K = io::withDistortion("file", pinhole(), name, {0.1, -0.2, 0.001, 0.002, 0.05}, warnings);
    EXPECT_FLOAT_EQ(K.distortion.k1, 0.1f) << name;
    EXPECT_FLOAT_EQ(K.distortion.p2, 0.002f);
    EXPECT_FLOAT_EQ(K.distortion.k3, 0.05f);
    EXPECT_EQ(K.fx, 500);
  }
  EXPECT_FLOAT_EQ(
      io::withDistortion("file", pinhole(), "rational_polynomial", {0, 0, 0, 0, 0, 0, 0, 0.5}, warnings).distortion.k6,
      0.5f);
  EXPECT_TRUE(isIdeal(io::withDistortion("file", pinhole(), "no such model", {0, 0, 0, 0}, warnings).distortion));
  EXPECT_TRUE(warnings.empty());
}

TEST(LensModels, ThinPrismAndTiltOfOpencvAreTheNearestLens) {
  // cv::projectPoints() written out for k1 = -0.1 and the prism's s1 = 0.002, s3 = -0.001.
  const std::vector<double> prism{-0.1, 0, 0, 0, 0, 0, 0, 0, 0.002, 0, -0.001, 0};
  std::vector<std::string> warnings;
  expectSame(
      io::withDistortion("file", pinhole(), "opencv", prism, warnings),
      [](double x, double y) {
        const double r2 = x * x + y * y, s = 1 - 0.1 * r2;
        return Eigen::Vector2d(x * s + 0.002 * r2, y * s - 0.001 * r2);
      },
      0.3);
  // A sensor that is tilted about y alone.
  std::vector<double> tilted(14, 0.0);
  tilted[13] = 0.002;
  warnings.clear();
  expectSame(
      io::withDistortion("file", pinhole(), "opencv", tilted, warnings),
      [](double x, double y) {
        const double c = std::cos(0.002), s = std::sin(0.002);
        // R = [c 0 -s; 0 1 0; s 0 c], the tilt [c 0 s; 0 c 0; 0 0 1] R
        const double X = c * x - s, Y = y, Z = s * x + c;
        return Eigen::Vector2d((c * X + s * Z) / Z, c * Y / Z);
      },
      0.5);
  tilted[13] = 0.02;
  EXPECT_TRUE(refuses([&] { io::withDistortion("file", pinhole(), "opencv", tilted, warnings); },
                      {"file", "tilt", "rectified"}));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("thin prism or tilt is taken as the nearest Brown-Conrady lens"), std::string::npos)
      << warnings[0];
}

TEST(LensModels, PixelsThatNoPlaneHoldsAreSaid) {
  std::vector<std::string> warnings;
  Intrinsics wide = pinhole();
  wide.fx = wide.fy = 220;  // corners lie 400 pixels, 1.8 radians, from the axis
  io::withDistortion("file", wide, "equidistant", {0.0001, 0, 0, 0}, warnings);
  ASSERT_FALSE(warnings.empty());
  EXPECT_NE(warnings[0].find("see more than 80 degrees aside"), std::string::npos) << warnings[0];
}

TEST(LensModels, AnEquidistantLensWithoutCoefficientsIsNoPinhole) {
  std::vector<std::string> warnings;
  const Intrinsics K = pinhole();
  EXPECT_FALSE(isIdeal(io::withDistortion("file", K, "equidistant", {0, 0, 0, 0}, warnings).distortion));
  for (const char* model : {"plumb_bob", "inverse_brown_conrady", "none", ""})
    EXPECT_TRUE(isIdeal(io::withDistortion("file", K, model, {0, 0, 0, 0, 0}, warnings).distortion)) << model;
  // Half a radian from the axis is at 0.5 focal lengths, and its ray at tan 0.5.
  const Intrinsics fitted = io::withDistortion("file", K, "equidistant", {0, 0, 0, 0}, warnings);
  const Ray ray = unproject(fitted, {fitted.cx + 0.5f * fitted.fx, fitted.cy});
  EXPECT_NEAR(ray.x, std::tan(0.5), 2e-3);
}

TEST(LensModels, AFisheyeNeedsTheSizeOfItsImages) {
  std::vector<std::string> warnings;
  Intrinsics K = pinhole();
  K.width = K.height = 0;
  EXPECT_TRUE(refuses(
      [&] {
        io::withDistortion("file", K, "equidistant", {0.1, 0, 0, 0}, warnings);
      },
      {"file", "size of its images"}));
}

/** \brief A camera that looks along z, and its rig. */
class DepthMeanings : public IoTest {
 protected:
  static Json cameraOf(const Json& more) {
    Json camera{{"name", "left"}, {"width", 64}, {"height", 48}, {"fx", 40},
                {"fy", 50},       {"cx", 31.5},  {"cy", 23.5},   {"depth_scale", 0.001}};
    camera["T_world_camera"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    camera.update(more);
    return camera;
  }
  std::string writeRig(const std::string& name, const Json& more) const {
    return write(name, Json{{"cameras", {cameraOf(more)}}}.dump());
  }

  /** \brief What a sensor of the distance along the ray measures of a plane at 2 m, in millimetres, as if 30 mm nearer. */
  void writeDistances() const {
    std::vector<std::uint16_t> depth;
    for (int v = 0; v < 48; ++v)
      for (int u = 0; u < 64; ++u) {
        const double x = (u - 31.5) / 40, y = (v - 23.5) / 50;
        depth.push_back(static_cast<std::uint16_t>(std::lround(2000 * std::sqrt(1 + x * x + y * y) - 30)));
      }
    depth[0] = 0;
    depth[1] = 65535;
    write("left/depth/000000.png", tool_test::depthPng(64, 48, depth));
  }
  static void expectPlane(io::Recording& recording) {
    io::LoadedFrame frame;
    recording.read(0, frame);
    ASSERT_FALSE(frame.rig.views[0].depth16);
    ASSERT_TRUE(frame.rig.views[0].depth32);
    EXPECT_EQ(frame.images[0].depth32.at(0, 0), 0);
    EXPECT_EQ(frame.images[0].depth32.at(1, 0), 0);
    for (const auto& [u, v] : {std::pair{2, 0}, {63, 47}, {31, 23}, {0, 47}})
      EXPECT_NEAR(frame.images[0].depth32.at(u, v), 2, 0.0006) << u << " " << v;
  }
};

TEST_F(DepthMeanings, DistanceAlongTheRayWithAnOffsetBecomesZ) {
  const std::string json = writeRig("rig.json", {{"depth_is", "distance"}, {"depth_offset", 0.03}});
  writeDistances();
  const auto recording = io::openRecording({folder_.string()});
  EXPECT_TRUE(recording->warnings().empty());
  EXPECT_TRUE(recording->depthMeaning(0).is_distance);
  expectPlane(*recording);

  // Given again with --poses, as fuse_flow_calibrate keeps it, it is not applied twice.
  io::RecordingOptions options;
  options.poses = writeRig("calibrated.json", {{"depth_is", "distance"}, {"depth_offset", 0.03}});
  expectPlane(*io::openRecording({folder_.string()}, options));

  const io::RigDescription rig = io::readRigJson(json);
  io::writeRigJson(path("written.json"), rig);
  EXPECT_TRUE(io::readRigJson(path("written.json")).cameras[0].depth.is_distance);
  EXPECT_FLOAT_EQ(io::readRigJson(path("written.json")).cameras[0].depth.offset, 0.03f);
}

TEST_F(DepthMeanings, PosesMaySayItOfARecordingThatDoesNot) {
  writeRig("rig.json", Json::object());
  writeDistances();
  io::RecordingOptions options;
  options.poses = writeRig("calibrated.json", {{"depth_is", "distance"}, {"depth_offset", 0.03}});
  expectPlane(*io::openRecording({folder_.string()}, options));
}

TEST_F(DepthMeanings, OtherValuesAreRefused) {
  EXPECT_TRUE(refuses(
      [&] {
        io::readRigJson(writeRig("rig.json", {{"depth_is", "range"}}));
      },
      {"depth_is is \"range\"", "z", "distance"}));
  EXPECT_TRUE(refuses(
      [&] {
        io::readRigJson(writeRig("rig.json", {{"depth_offset", 30}}));
      },
      {"depth_offset is 30", "metres"}));
}

TEST_F(DepthMeanings, ALensOfRigJsonMayHaveAModel) {
  const std::string json =
      writeRig("rig.json", {{"distortion", {0.05, 0.01, 0, 0}}, {"distortion_model", "equidistant"}});
  const io::RigDescription rig = io::readRigJson(json);
  // θ (1 + 0.05 θ² + 0.01 θ⁴) of the angle whose tangent is 0.5
  const double theta = std::atan(0.5), distorted = theta * (1 + 0.05 * theta * theta + 0.01 * std::pow(theta, 4));
  EXPECT_NEAR(project(rig.cameras[0].camera.intrinsics, {0.5f, 0, 1}).u, 40 * distorted + 31.5, 0.02);
  EXPECT_TRUE(refuses(
      [&] {
        io::readRigJson(writeRig("rig.json", {{"distortion", {0.05}}, {"distortion_model", "equidistant"}}));
      },
      {"camera 'left'", "1 distortion coefficients"}));
  EXPECT_TRUE(refuses(
      [&] {
        io::readRigJson(writeRig("rig.json", {{"distortion", {0.05}}, {"distortion_model", 3}}));
      },
      {"distortion_model is 3"}));
}

}  // namespace
