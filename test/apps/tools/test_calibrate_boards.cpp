#include "../calibration/board_picture.h"
#include "support/png_file.h"
#include "support/tool_fixture.h"

#include <nlohmann/json.hpp>
#ifdef FUSE_FLOW_WITH_OPENCV
#include <opencv2/core/version.hpp>
#endif

#include <array>
#include <cmath>
#include <fstream>

namespace tool_test {
namespace {

using BoardPose = std::array<double, 16>;  // row-major

BoardPose product(const BoardPose& a, const BoardPose& b) {
  BoardPose c{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      for (std::size_t k = 0; k < 4; ++k) c[4 * i + j] += a[4 * i + k] * b[4 * k + j];
  return c;
}

BoardPose inverse(const BoardPose& T) {
  BoardPose I{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      I[4 * i + j] = T[4 * j + i];
      I[4 * i + 3] -= T[4 * j + i] * T[4 * j + 3];
    }
  I[15] = 1;
  return I;
}

/** \brief Turned about x, then y, then z, radians, then moved. */
BoardPose poseOf(double x, double y, double z, std::array<double, 3> at) {
  board_test::Eye eye;
  eye.turn(x, y, z);
  BoardPose T{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) T[4 * i + j] = eye.R[3 * i + j];
    T[4 * i + 3] = at[i];
  }
  T[15] = 1;
  return T;
}

/** \brief Three cameras at whose middle someone holds a board in four ways. The first has depth and colour in one image, the second
 *  a colour camera of its own with a lens that bends lines, the third colour alone. What rig.json says of their poses is wrong. */
class CalibrateByPrint : public ToolTest {
 protected:
  static constexpr int kWidth = 480, kHeight = 360;

  void SetUp() override {
    ToolTest::SetUp();
    for (const double angle : {0.0, 0.5, -0.45}) {  // on a circle, 0.9 m from the middle
      const BoardPose turned = poseOf(0.1 * angle, angle, 0.05, {0, 0, 0});
      poses_.push_back(product(turned, poseOf(0, 0, 0, {0, 0, -0.9})));
    }
    for (const double k : {0.0, 1.0, 2.0, 3.0})
      boards_.push_back(
          poseOf(0.35 * std::sin(2 * k), 0.3 * std::cos(2 * k), 0.8 * k, {0.02 * k - 0.03, 0.01 * k, 0.02 * k}));
  }

  ToolResult calibrate(std::vector<std::string> more) const {
    std::vector<std::string> arguments{recording(), "-o", out("refined.json")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return runProgram(FUSE_FLOW_CALIBRATE_TOOL, arguments);
  }

  static board_test::Eye eyeOf(std::size_t camera) {
    board_test::Eye eye;
    eye.width = kWidth;
    eye.height = kHeight;
    eye.fx = eye.fy = camera == 1 ? 430 : 410;
    eye.cx = 0.5 * kWidth - (camera == 1 ? 6 : 1);
    eye.cy = 0.5 * kHeight + 2;
    if (camera == 1) {
      eye.k1 = 0.06;
      eye.p2 = 0.001;
    }
    return eye;
  }
  static BoardPose depthToColor(std::size_t camera) {
    return camera == 1 ? poseOf(0.01, -0.02, 0.005, {0.05, 0.002, -0.003}) : poseOf(0, 0, 0, {0, 0, 0});
  }

  static void place(const BoardPose& T, board_test::Eye& eye) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) eye.R[3 * i + j] = T[4 * i + j];
      eye.t[i] = T[4 * i + 3];
    }
  }

  void show(const board_test::Print& print) const {
    nlohmann::json rig;
    for (std::size_t camera = 0; camera < 3; ++camera) {
      board_test::Eye eye = eyeOf(camera), depth_eye = eyeOf(0);
      const BoardPose said = camera == 0 ? poses_[0] : poseOf(1, 2, 3, {4, 5, 6});
      nlohmann::json entry = lens(camera == 1 ? depth_eye : eye);
      entry["name"] = "camera_" + std::to_string(camera);
      entry["T_world_camera"] = said;
      if (camera < 2) entry["depth_scale"] = 0.0001;
      if (camera == 1) {
        entry["color"] = lens(eye);
        entry["color"]["T_depth_color"] = depthToColor(1);
      }
      rig["cameras"].push_back(entry);
      for (std::size_t frame = 0; frame < boards_.size(); ++frame) {
        const BoardPose T = product(inverse(poses_[camera]), boards_[frame]);
        place(product(inverse(depthToColor(camera)), T), eye);
        std::string samples;
        for (const std::uint8_t grey : board_test::photograph(print, eye))
          samples += std::string(3, static_cast<char>(grey));
        writeText(colorFile(recording_, camera, frame), samplesPng(kWidth, kHeight, 8, 2, samples));
        place(T, depth_eye);
        if (camera < 2)
          writeText(depthFile(recording_, camera, frame), depthPng(kWidth, kHeight, depthOf(print, depth_eye)));
      }
    }
    writeText(recording_ / "rig.json", rig.dump(2));
  }

  static nlohmann::json lens(const board_test::Eye& eye) {
    nlohmann::json entry{{"width", eye.width}, {"height", eye.height}, {"fx", eye.fx},
                         {"fy", eye.fy},       {"cx", eye.cx},         {"cy", eye.cy}};
    if (eye.k1 != 0) entry["distortion"] = {eye.k1, eye.k2, eye.p1, eye.p2, 0.0, 0.0, 0.0, 0.0};
    return entry;
  }

  /** \brief Of the print's plane where the print is; an ideal lens. */
  static std::vector<std::uint16_t> depthOf(const board_test::Print& print, const board_test::Eye& eye) {
    std::vector<std::uint16_t> depth;
    const auto& R = eye.R;
    const auto& t = eye.t;
    const double away = R[2] * t[0] + R[5] * t[1] + R[8] * t[2];
    for (int v = 0; v < eye.height; ++v)
      for (int u = 0; u < eye.width; ++u) {
        const double x = (u - eye.cx) / eye.fx, y = (v - eye.cy) / eye.fy, z = away / (R[2] * x + R[5] * y + R[8]);
        const double bx = R[0] * (z * x - t[0]) + R[3] * (z * y - t[1]) + R[6] * (z - t[2]);
        const double by = R[1] * (z * x - t[0]) + R[4] * (z * y - t[1]) + R[7] * (z - t[2]);
        const bool on_it = std::fabs(bx) * print.pixels_per_metre < 0.5 * print.width &&
                           std::fabs(by) * print.pixels_per_metre < 0.5 * print.height;
        depth.push_back(on_it ? static_cast<std::uint16_t>(std::lround(10000 * z)) : 0);
      }
    return depth;
  }

  /** \brief That the new poses are the true ones. */
  void expectPoses(double metres, double radians) const {
    std::ifstream file(out("refined.json"));
    const nlohmann::json rig = nlohmann::json::parse(file);
    for (std::size_t camera = 0; camera < 3; ++camera) {
      const BoardPose found = rig["cameras"][camera]["T_world_camera"];
      const BoardPose error = product(inverse(poses_[camera]), found);
      EXPECT_LT(std::hypot(error[3], error[7], error[11]), metres) << camera;
      EXPECT_LT(std::hypot(error[6] - error[9], error[2] - error[8], error[1] - error[4]), 2 * radians) << camera;
    }
    EXPECT_FALSE(rig["cameras"][2].contains("depth_scale")) << "a camera without depth stays one";
  }

  std::vector<BoardPose> poses_;   ///< camera to world
  std::vector<BoardPose> boards_;  ///< board to world, frame by frame
};

#ifdef FUSE_FLOW_WITH_OPENCV

const std::vector<std::string> kCharuco{"--board", "0.05",           "--board-kind", "charuco",        "--board-size",
                                        "5x7",     "--board-marker", "0.0375",       "--board-family", "DICT_4X4_50"};

TEST_F(CalibrateByPrint, ACharucoBoardPlacesDepthCamerasAndColourCameras) {
  show(board_test::charucoPrint(5, 7, 0.05, 0.0375, board_test::kDict4x4));
  const ToolResult result = calibrate(kCharuco);
  ASSERT_TRUE(succeeded(result));
  expectPoses(0.002, 0.003);
  const char* const places = CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR < 6 ? "3 places of the board"  // misses one
                                                                           : "4 places of the board";
  EXPECT_NE(result.out.find(places), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("left where --board placed it"), std::string::npos) << "the camera without depth";
}

TEST_F(CalibrateByPrint, AChessboardPlacesThemToo) {
  show(board_test::chessboardPrint(7, 4, 0.04));
  const ToolResult result = calibrate({"--board", "0.04", "--board-kind", "chessboard", "--board-size", "7x4"});
  ASSERT_TRUE(succeeded(result));
  expectPoses(0.002, 0.003);
}

TEST_F(CalibrateByPrint, AnArucoMarkerPlacesThemToo) {
  show(board_test::markerPrint(0.2, 5, board_test::kDict5x5));
  const ToolResult result = calibrate({"--board", "0.2", "--board-family", "DICT_5X5_100"});
  ASSERT_TRUE(succeeded(result));
  expectPoses(0.004, 0.006);
  EXPECT_NE(result.out.find("4 markers that several cameras saw"), std::string::npos) << result.out;
}

TEST_F(CalibrateByPrint, WhatIsWrongWithABoardIsOneLine) {
  show(board_test::charucoPrint(5, 7, 0.05, 0.0375, board_test::kDict4x4));
  std::vector<std::string> arguments = kCharuco;
  arguments[1] = "0.08";
  arguments[7] = "0.06";
  EXPECT_TRUE(isOneLineError(calibrate(arguments), 1, {"--board: squares of 0.08 m", "about 0.05 m"}));
  EXPECT_TRUE(isOneLineError(calibrate({"--board", "0.04", "--board-kind", "chessboard", "--board-size", "9x6"}), 1,
                             {"the board does not connect", "'camera_0' never saw it", "whole", "inner corners"}));
  arguments = kCharuco;
  arguments[9] = "DICT_7X7_50";
  EXPECT_TRUE(isOneLineError(calibrate(arguments), 1, {"'camera_0' never saw it", "'camera_2' never saw it"}));
}

TEST_F(CalibrateByPrint, AChessboardOfAnotherSizeIsNotTakenForAPartOfIt) {
  show(board_test::chessboardPrint(7, 4, 0.04));
  EXPECT_TRUE(isOneLineError(calibrate({"--board", "0.04", "--board-kind", "chessboard", "--board-size", "5x4"}), 1,
                             {"never saw it", "inner corners"}));
}

#else

TEST_F(CalibrateByPrint, WithoutOpenCvItSaysWhatToInstall) {
  show(board_test::chessboardPrint(7, 4, 0.04));
  EXPECT_TRUE(isOneLineError(calibrate({"--board", "0.04", "--board-kind", "chessboard", "--board-size", "7x4"}), 2,
                             {"--board", "chessboard", "libopencv-contrib-dev"}));
}

#endif

TEST_F(CalibrateByPrint, WrongOptionsAreOneLine) {
  WallRecording().write(recording_);
  const auto wrong = [&](const std::vector<std::string>& more, const std::vector<std::string>& words) {
    std::vector<std::string> arguments{"--board", "0.04"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return isOneLineError(calibrate(arguments), 2, words);
  };
  EXPECT_TRUE(wrong({"--board-kind", "checkers"}, {"--board-kind", "checkers", "chessboard", "charuco"}));
  EXPECT_TRUE(wrong({"--board-family", "DICT_3X3_50"}, {"--board-family", "DICT_4X4_50", "tag36h11"}));
  EXPECT_TRUE(wrong({"--board-kind", "chessboard"}, {"needs --board-size"}));
  EXPECT_TRUE(wrong({"--board-kind", "chessboard", "--board-size", "nine"}, {"--board-size", "nine", "9x6"}));
  EXPECT_TRUE(wrong({"--board-kind", "chessboard", "--board-size", "1x1"}, {"1x1", "3x3"}));
  EXPECT_TRUE(wrong({"--board-kind", "chessboard", "--board-size", "8x6"}, {"8x6", "half a turn"}));
  EXPECT_TRUE(
      wrong({"--board-kind", "charuco", "--board-size", "5x7", "--board-family", "DICT_4X4_50"}, {"--board-marker"}));
  EXPECT_TRUE(wrong({"--board-marker", "-1"}, {"--board-marker"}));
  EXPECT_TRUE(wrong({"--board-size", "9x6"}, {"--board-size 9x6", "markers has none"}));
  EXPECT_TRUE(isOneLineError(calibrate({"--board-kind", "chessboard"}), 2, {"--board"}));
}

}  // namespace
}  // namespace tool_test
