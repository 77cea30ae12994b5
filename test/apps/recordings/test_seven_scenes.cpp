#include "../tools/support/png_file.h"
#include "io_fixture.h"
#include "room.h"

#include <algorithm>
#include <cmath>

namespace {

using namespace io_test;

/** \brief frame-NNNNNN.{depth.png,color.png,pose.txt} of the room, and the intrinsics of its camera. */
class SevenScenes : public IoTest {
 protected:
  void SetUp() override {
    IoTest::SetUp();
    write("camera-intrinsics.txt", "24 0 29\n0 20 25.5\n0 0 1\n");
    writeFrame("frame-000000", levelView());
    writeFrame("frame-000010", cornerView());
    writeFrame("frame-000025", cornerView(1));
  }
  void writeFrame(const std::string& stem, const RoomView& view) const {
    write(stem + ".depth.png", view.depthPng());
    write(stem + ".color.png", view.colorPng());
    write(stem + ".pose.txt", view.poseText());
  }
  std::unique_ptr<io::Recording> open(const std::string& views, int slide = 0) const {
    io::RecordingOptions options;
    options.views = views;
    options.slide = slide;
    return io::openRecording({folder_.string()}, options);
  }
};

TEST_F(SevenScenes, PointsLieOnTheWallsOfTheRoom) {
  const auto recording = open("0,10,25");
  EXPECT_EQ(recording->kind(), "seven_scenes");
  EXPECT_EQ(recording->frameCount(), 1u);
  io::LoadedFrame frame;
  recording->read(0, frame);
  ASSERT_EQ(frame.rig.cameras.size(), 3u);
  for (std::size_t view = 0; view < 3; ++view) {
    EXPECT_TRUE(frame.rig.views[view].color);
    EXPECT_TRUE(showsRoom(frame, view)) << view;
  }
}

TEST_F(SevenScenes, FrameNumbersMayHaveMoreThanSixDigits) {
  writeFrame("frame-1000000", cornerView(1));
  writeFrame("frame-0000003", levelView());  // the name of none: frame 3 is frame-000003
  io::LoadedFrame frame;
  const auto recording = open("0,1000000");
  recording->read(0, frame);
  ASSERT_EQ(frame.rig.views.size(), 2u);
  EXPECT_TRUE(showsRoom(frame, 1));
  EXPECT_TRUE(refuses<io::OptionError>([&] { open("0,3"); }, {"frame 3"}));
}

TEST_F(SevenScenes, AWallTwoMetresAheadIsAtItsPlaceInTheWorld) {
  io::LoadedFrame frame;
  const auto recording = open("0");
  recording->read(0, frame);
  EXPECT_EQ(frame.rig.views[0].depth16.row(25)[29], 2000);
  EXPECT_EQ(frame.rig.cameras[0].depth_scale, 0.001f);
  EXPECT_LT((frame.rig.cameras[0].T_world_camera * Eigen::Vector3d(0, 0, 2) - Eigen::Vector3d(2.5, 0.3, 1.2)).norm(),
            1e-12);
}

TEST_F(SevenScenes, ViewsAreTheNumbersInTheFileNames) {
  const auto recording = open("25,0");
  EXPECT_EQ(recording->viewName(0), "frame-000025");
  EXPECT_EQ(recording->viewName(1), "frame-000000");
  EXPECT_TRUE(
      refuses<io::OptionError>([&] { open("0,20"); }, {"--views 0,20: frame 20 is not in", "3 frames: 0, 10, 25"}));
  EXPECT_TRUE(refuses<io::OptionError>([&] { open("26"); }, {"--views 26"}));
  EXPECT_TRUE(refuses<io::OptionError>([&] { open(""); }, {"--views", folder_.string(), "e.g. --views 0,10,25"}));
}

TEST_F(SevenScenes, WithoutIntrinsicsItIsTheKinectOfTheDatasetForImagesOfItsSize) {
  fs::remove(path("camera-intrinsics.txt"));
  EXPECT_TRUE(refuses([&] { open("0"); }, {folder_.string(), "images are 64x48", "--intrinsics"}));
  RoomView view = levelView();
  view.width = 640;
  view.height = 480;
  fs::remove_all(folder_);
  writeFrame("frame-000000", view);
  const auto recording = open("0");
  const Intrinsics& K = recording->cameras()[0].intrinsics;
  EXPECT_EQ((std::vector<float>{K.fx, K.fy, K.cx, K.cy}), (std::vector<float>{585, 585, 320, 240}));
  EXPECT_EQ(K.width, 640);
  ASSERT_EQ(recording->warnings().size(), 1u);
  EXPECT_NE(recording->warnings()[0].find("7-Scenes' Kinect"), std::string::npos);
}

TEST_F(SevenScenes, AFrameWhosePoseIsLostHindersNoOther) {
  write("frame-000010.pose.txt",
        "-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n");
  io::LoadedFrame frame;
  const auto recording = open("0,25");
  recording->read(0, frame);
  EXPECT_TRUE(showsRoom(frame, 0));
  EXPECT_TRUE(showsRoom(frame, 1));
  ASSERT_EQ(recording->warnings().size(), 1u);
  EXPECT_NE(recording->warnings()[0].find(path("frame-000010.pose.txt") + ": holds a number that is not finite"),
            std::string::npos);
  EXPECT_TRUE(refuses([&] { open("0,10"); }, {path("frame-000010.pose.txt"), "not finite"}));
}

TEST_F(SevenScenes, ColorMayBeAJpegOrNotThere) {
  fs::remove(path("frame-000000.color.png"));
  write("frame-000010.color.png", "damaged");
  io::LoadedFrame frame;
  open("0")->read(0, frame);
  EXPECT_FALSE(frame.rig.views[0].color);
  EXPECT_TRUE(showsRoom(frame, 0));
  EXPECT_TRUE(refuses([&] { open("10")->read(0, frame); }, {path("frame-000010.color.png")}));
}

TEST_F(SevenScenes, ColorThatIsNotWantedIsNotOpened) {
  write("frame-000000.color.png", "damaged");
  io::RecordingOptions options;
  options.views = "0";
  options.read_color = false;
  io::LoadedFrame frame;
  io::openRecording({folder_.string()}, options)->read(0, frame);
  EXPECT_FALSE(frame.rig.views[0].color);
}

TEST_F(SevenScenes, AFrameWithoutDepthIsAMissingView) {
  fs::remove(path("frame-000010.depth.png"));
  io::LoadedFrame frame;
  open("0,10")->read(0, frame);
  EXPECT_FALSE(frame.rig.views[0].missing());
  EXPECT_TRUE(frame.rig.views[1].missing());
}

TEST_F(SevenScenes, AFrameWithDepthButWithoutAPoseIsNamed) {
  fs::remove(path("frame-000025.pose.txt"));
  EXPECT_TRUE(refuses([&] { open("0,25"); }, {path("frame-000025.pose.txt"), "not found", "frame-000025.depth.png"}));
  fs::remove(path("frame-000025.depth.png"));
  EXPECT_TRUE(refuses<io::OptionError>([&] { open("0,25"); }, {"--views 0,25"}));
  EXPECT_EQ(open("0,10")->cameras().size(), 2u);
}

TEST_F(SevenScenes, WhatIsWrongWithACalibrationIsNamedWithItsFile) {
  write("frame-000010.pose.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n");
  EXPECT_TRUE(refuses([&] { open("10"); }, {path("frame-000010.pose.txt"), "has 12 numbers"}));
  writeFrame("frame-000010", cornerView());
  write("camera-intrinsics.txt", "24 0 29 0 20 25.5\n");
  EXPECT_TRUE(refuses([&] { open("0"); }, {path("camera-intrinsics.txt"), "has 6 numbers, must be 9"}));
  write("camera-intrinsics.txt", "24 0 0\n0 20 0\n29 25.5 1\n");
  EXPECT_TRUE(refuses([&] { open("0"); }, {path("camera-intrinsics.txt"), "the last row is 29 25.5 1"}));
  write("camera-intrinsics.txt", "0 0 29\n0 20 25.5\n0 0 1\n");
  EXPECT_TRUE(refuses([&] { open("0"); }, {folder_.string(), "fx is 0"}));
}

TEST_F(SevenScenes, TheDepthScaleCanBeGiven) {
  io::RecordingOptions options;
  options.views = "0";
  options.depth_scale = 0.002f;
  io::LoadedFrame frame;
  io::openRecording({folder_.string()}, options)->read(0, frame);
  EXPECT_EQ(frame.rig.cameras[0].depth_scale, 0.002f);
  for (const float scale : {0.0f, -1.0f, std::nanf("")}) {
    options.depth_scale = scale;
    EXPECT_TRUE(refuses<io::OptionError>([&] { io::openRecording({folder_.string()}, options); }, {"--depth-scale"}));
  }
}

/** \brief Of the points of one view that another sees: the median difference between their depth and what the other
 *  measured there, metres. */
double medianDisagreement(const io::LoadedFrame& frame, std::size_t from, std::size_t to) {
  std::vector<double> differences;
  const Camera &a = frame.rig.cameras[from], &b = frame.rig.cameras[to];
  const Eigen::Isometry3d T_b_a = b.T_world_camera.inverse() * a.T_world_camera;
  for (int v = 0; v < a.intrinsics.height; v += 4)
    for (int u = 0; u < a.intrinsics.width; u += 4) {
      const double z = 0.001 * frame.rig.views[from].depth16.row(v)[u];
      if (z <= 0 || z > 10) continue;
      const Intrinsics &K = a.intrinsics, &L = b.intrinsics;
      const Eigen::Vector3d p = T_b_a * Eigen::Vector3d((u - K.cx) / K.fx * z, (v - K.cy) / K.fy * z, z);
      if (p.z() <= 0) continue;
      const long column = std::lround(L.fx * p.x() / p.z() + L.cx), row = std::lround(L.fy * p.y() / p.z() + L.cy);
      if (column < 0 || row < 0 || column >= L.width || row >= L.height) continue;
      const double measured = 0.001 * frame.rig.views[to].depth16.row(static_cast<int>(row))[column];
      if (measured > 0 && measured < 10) differences.push_back(std::abs(measured - p.z()));
    }
  if (differences.size() < 1000) return std::nan("");
  std::nth_element(differences.begin(), differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2),
                   differences.end());
  return differences[differences.size() / 2];
}

TEST(SevenScenesRecorded, ViewsOfTheRealRecordingAgreeInTheWorld) {
  const std::string folder = FUSE_FLOW_TEST_SHARED_DATA "/seven_scenes";
  if (!fs::is_directory(folder)) GTEST_SKIP() << folder << " is not there";
  io::RecordingOptions options;
  options.views = "0,60,100";
  io::LoadedFrame frame;
  io::openRecording({folder}, options)->read(0, frame);
  const Intrinsics& K = frame.rig.cameras[0].intrinsics;
  EXPECT_EQ((std::vector<float>{K.fx, K.fy, K.cx, K.cy}), (std::vector<float>{585, 585, 320, 240}));
  EXPECT_EQ(K.width, 640);
  EXPECT_EQ(K.height, 480);
  EXPECT_TRUE(frame.rig.views[0].color);
  // The camera measures to about a centimetre at these distances; a wrong pose is off by decimetres.
  EXPECT_LT(medianDisagreement(frame, 0, 1), 0.02);
  EXPECT_LT(medianDisagreement(frame, 1, 2), 0.02);
}

TEST(SevenScenesRecorded, EveryFrameOfTheRealRecordingIsRead) {
  const std::string folder = FUSE_FLOW_TEST_SHARED_DATA "/seven_scenes";
  if (!fs::is_directory(folder)) GTEST_SKIP() << folder << " is not there";
  io::RecordingOptions options;
  options.views = "0:160:40";
  options.slide = 5;
  const auto recording = io::openRecording({folder}, options);
  EXPECT_EQ(recording->frameCount(), 16u);  // 120 + 5 · 15 = 195, the last
  io::LoadedFrame frame;
  recording->read(15, frame);
  EXPECT_EQ(frame.rig.cameras[3].name, "frame-000195");
  EXPECT_FALSE(frame.rig.views[3].missing());
}

TEST_F(SevenScenes, ColourOfAnotherNameIsSaid) {
  EXPECT_FALSE(saysUnused(*open("0,10"), {}));
  for (const char* stem : {"frame-000000", "frame-000010", "frame-000025"})
    fs::rename(folder_ / (std::string(stem) + ".color.png"), folder_ / (std::string(stem) + ".rgb.png"));
  EXPECT_TRUE(saysUnused(*open("0,10"), {"3 other images", "frame-000000.rgb.png", "frame-000000.color.png"}));
  io::RecordingOptions options;
  options.views = "0,10";
  options.read_color = false;
  EXPECT_FALSE(saysUnused(*io::openRecording({folder_.string()}, options), {})) << "nobody asks for colour";
}

}  // namespace
