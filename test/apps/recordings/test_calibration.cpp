#include "recordings/calibrations/calibration.h"

#include "io_fixture.h"

#include <limits>

namespace {

using namespace io_test;

class Calibration : public IoTest {};

/** \brief A quarter turn about z and a shift by (1, 2, 3). */
const std::vector<double> kQuarterTurn{0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1};

std::vector<double> changed(std::size_t at, double value) {
  std::vector<double> numbers = kQuarterTurn;
  numbers[at] = value;
  return numbers;
}

TEST_F(Calibration, APoseIsReadRowByRow) {
  const Eigen::Isometry3d T = io::rigidPose("left", kQuarterTurn);
  EXPECT_EQ(T.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(T * Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(1, 3, 3));
  EXPECT_EQ(T * Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 2, 3));
}

TEST_F(Calibration, WhatIsNoPoseIsNamedWithItsOwner) {
  const double infinity = std::numeric_limits<double>::infinity(), nan = std::nan("");
  std::vector<double> short_pose = kQuarterTurn;
  short_pose.pop_back();
  std::vector<double> scaled = kQuarterTurn, mirrored = kQuarterTurn;
  for (const std::size_t i : {0, 1, 2, 4, 5, 6, 8, 9, 10}) scaled[i] *= 1.001;
  mirrored[10] = -1;
  const std::vector<std::pair<std::vector<double>, std::string>> wrong = {
      {{}, "has 0 numbers, must be 16"},
      {short_pose, "has 15 numbers, must be 16"},
      {changed(3, nan), "not finite"},
      {changed(0, infinity), "not finite"},
      {changed(12, 1), "the last row is 1 0 0 1, must be 0 0 0 1"},
      {changed(15, 0), "the last row is 0 0 0 0, must be 0 0 0 1"},
      {std::vector<double>(16, 0), "the last row is 0 0 0 0"},
      {changed(0, 0.1), "is not rigid"},
      {scaled, "is not rigid"},
      {mirrored, "the determinant of the rotation is -1"}};
  for (const auto& [numbers, problem] : wrong)
    EXPECT_TRUE(refuses([&, numbers = numbers] { io::rigidPose("rig.json: T", numbers); }, {"rig.json: T: ", problem}));
}

TEST_F(Calibration, AColumnByColumnPoseIsRefusedForItsLastRow) {
  const std::vector<double> columns{0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1};
  EXPECT_TRUE(refuses([&] { io::rigidPose("left", columns); }, {"the last row is 1 2 3 1"}));
}

TEST_F(Calibration, RoundingInAPoseIsForgiven) {
  EXPECT_NO_THROW(io::rigidPose("left", changed(0, 0.0005)));
  EXPECT_NO_THROW(io::rigidPose("left", changed(12, 1e-7)));
}

TEST_F(Calibration, NumbersStandBetweenWhiteSpaceAndBeforeComments) {
  const std::string file = write("a.txt", "# a comment 1 2 3\n1 -2.5\t3e-2\r\n\n  +4 # 5 6\n1E3");
  EXPECT_EQ(io::readNumbers(file), (std::vector<double>{1, -2.5, 0.03, 4, 1000}));
  EXPECT_TRUE(io::readNumbers(write("b.txt", "")).empty());
}

TEST_F(Calibration, AWordThatIsNoNumberIsNamed) {
  for (const char* word : {"one", "1,2", "1.2.3", "--1"}) {
    const std::string file = write("a.txt", std::string("1 ") + word + " 3\n");
    EXPECT_TRUE(refuses([&] { io::readNumbers(file); }, {file, "'" + std::string(word) + "' is not a number"}));
  }
  EXPECT_TRUE(refuses([&] { io::readNumbers(path("no.txt")); }, {path("no.txt"), "not found"}));
}

TEST_F(Calibration, APoseFileIsNamedInItsErrors) {
  EXPECT_EQ(io::readPose(write("a.txt", "1 0 0 7\n0 1 0 8\n0 0 1 9\n0 0 0 1\n")).translation(),
            Eigen::Vector3d(7, 8, 9));
  const std::string file = write("b.txt", "1 0 0 7\n0 1 0 8\n0 0 1 9\n");
  EXPECT_TRUE(refuses([&] { io::readPose(file); }, {file + ": has 12 numbers"}));
}

TEST_F(Calibration, ACameraThatTheLibraryRefusesIsNamedWithItsFile) {
  Camera camera;
  camera.name = "left";
  EXPECT_TRUE(refuses([&] { io::checkCameraInput("rig.json", camera); }, {"rig.json: ", "left", "0x0"}));
  camera.intrinsics.width = camera.intrinsics.height = 4;
  camera.intrinsics.fx = camera.intrinsics.fy = 4;
  EXPECT_NO_THROW(io::checkCameraInput("rig.json", camera));
}

TEST_F(Calibration, ALensThatNoneIsLikeIsNamedInColorAsInDepth) {
  Camera good;
  good.name = "left";
  good.intrinsics.width = good.intrinsics.height = 100;
  good.intrinsics.fx = good.intrinsics.fy = 100;
  good.color = ColorCamera{};
  good.color->intrinsics = good.intrinsics;
  ASSERT_NO_THROW(io::checkCameraInput("rig.json", good));
  struct Wrong {
    float Intrinsics::*member;
    float value;
    const char* word;
  };
  for (const Wrong& wrong :
       {Wrong{&Intrinsics::fx, 0.05f, "fx and fy are 0.05"},
        Wrong{&Intrinsics::fy, 1e6f, "fx and fy are 100 and 1e+06"}, Wrong{&Intrinsics::cx, 2000, "cx and cy are 2000"},
        Wrong{&Intrinsics::cy, -1e30f, "cx and cy are 0 and -1e+30"}}) {
    Camera camera = good;
    camera.intrinsics.*wrong.member = wrong.value;
    EXPECT_TRUE(refuses([&] { io::checkCameraInput("rig.json", camera); }, {"rig.json: camera 'left': ", wrong.word}));
    camera = good;
    camera.color->intrinsics.*wrong.member = wrong.value;
    EXPECT_TRUE(
        refuses([&] { io::checkCameraInput("rig.json", camera); }, {"rig.json: camera 'left' color: ", wrong.word}));
  }
  Camera camera = good;
  camera.intrinsics.distortion.k6 = -1e30f;
  EXPECT_TRUE(refuses([&] { io::checkCameraInput("rig.json", camera); }, {"distortion has -1e+30"}));
  camera = good;
  camera.color->T_depth_color.translation().x() = 1e6;
  EXPECT_TRUE(refuses([&] { io::checkCameraInput("rig.json", camera); }, {"color: T_depth_color is 1e+06 m long"}));
}

TEST_F(Calibration, PixelsThatAreNoRectanglesAreRefused) {
  EXPECT_NO_THROW(io::checkSkew("K.txt", 0.1, 500));
  EXPECT_TRUE(refuses([] { io::checkSkew("K.txt", -3, 500); }, {"K.txt: the skew", "-3, must be 0"}));
}

}  // namespace
