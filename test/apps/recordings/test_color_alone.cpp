#include "../tools/support/png_file.h"
#include "io_fixture.h"
#include "room.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace {

using namespace io_test;
using Json = nlohmann::json;

/** \brief A rig of three cameras, each with the folders that a test gives it. */
class ColorAlone : public IoTest {
 protected:
  static constexpr const char* kNames[] = {"left", "middle", "right"};

  static Json cameraOf(const char* name, bool depth_scale) {
    Json camera{{"name", name}, {"width", 64}, {"height", 48}, {"fx", 24}, {"fy", 20}, {"cx", 29}, {"cy", 25.5}};
    camera["T_world_camera"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    if (depth_scale) camera["depth_scale"] = 0.001;
    return camera;
  }
  void writeRig(bool depth_scale = false) const {
    Json rig;
    for (const char* name : kNames) rig["cameras"].push_back(cameraOf(name, depth_scale));
    write("rig.json", rig.dump());
  }
  std::string writeColor(const std::string& file, int width = 64) const {
    return write(file, tool_test::colorPng(width, 48, 200, 100, 50));
  }
  void writeDepth(const std::string& file) const { write(file, levelView().depthPng()); }
  void writeColors() const {
    for (const char* name : kNames) writeColor(std::string(name) + "/color/000000.png");
  }
  std::unique_ptr<io::Recording> open(const io::RecordingOptions& options = {}) const {
    return io::openRecording({folder_.string()}, options);
  }
  testing::AssertionResult refusal(const std::vector<std::string>& words, const io::RecordingOptions& options = {}) {
    return refuses([&] { open(options); }, words);
  }
};

TEST_F(ColorAlone, ViewsOfCamerasWithoutDepthAreMissingButHaveColour) {
  writeRig();
  writeColors();
  const auto recording = open();
  EXPECT_TRUE(recording->warnings().empty()) << recording->warnings()[0];
  EXPECT_EQ(recording->frames(), std::vector<std::size_t>{0});
  io::LoadedFrame frame;
  recording->read(0, frame);
  EXPECT_TRUE(frame.ended.empty());
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_FALSE(recording->hasDepth(k));
    EXPECT_TRUE(recording->hasColor(k));
    EXPECT_TRUE(frame.rig.views[k].missing());
    ASSERT_TRUE(frame.rig.views[k].color);
    EXPECT_EQ(frame.rig.views[k].color.row(47)[63].g, 100);
    EXPECT_EQ(frame.images[k].color_file, path(std::string(kNames[k]) + "/color/000000.png"));
  }
}

TEST_F(ColorAlone, ARigMayMixThemWithDepthCameras) {
  writeRig(true);
  writeColors();
  writeDepth("middle/depth/000000.png");
  const auto recording = open();
  io::LoadedFrame frame;
  recording->read(0, frame);
  EXPECT_FALSE(recording->hasDepth(0));
  EXPECT_TRUE(recording->hasDepth(1));
  EXPECT_TRUE(frame.rig.views[0].missing());
  EXPECT_FALSE(frame.rig.views[1].missing());
  EXPECT_TRUE(frame.rig.views[1].color);
  EXPECT_FALSE(frame.images[1].color_file.empty());
}

TEST_F(ColorAlone, AFrameExistsIfACameraHasAnImageOfIt) {
  writeRig(true);
  writeDepth("middle/depth/000001.png");
  writeColor("middle/color/000007.png");  // without its depth it makes no frame
  writeColor("left/color/000002.png");
  writeColor("left/color/000004.png");
  writeColor("right/image/4.jpg");  // by its content a PNG
  const auto recording = open();
  EXPECT_EQ(recording->frames(), (std::vector<std::size_t>{1, 2, 4}));
  ASSERT_EQ(recording->warnings().size(), 2u);
  EXPECT_NE(recording->warnings()[0].find("begins at frame 000001, the first of which a camera has an image"),
            std::string::npos);
  EXPECT_NE(recording->warnings()[1].find("no camera has an image of them, such as 000003"), std::string::npos);
  io::LoadedFrame frame;
  recording->read(1, frame);
  EXPECT_FALSE(frame.rig.views[0].color);
  EXPECT_FALSE(frame.rig.views[1].missing());
  recording->read(4, frame);
  EXPECT_TRUE(frame.rig.views[0].color);
  EXPECT_FALSE(frame.rig.views[1].color) << "its depth is missing, and so is it";
  EXPECT_TRUE(frame.rig.views[2].color);
  ASSERT_EQ(frame.ended.size(), 1u);
  EXPECT_EQ(frame.ended[0].message, "camera 'middle' ends after 1 of 3 frames");
}

TEST_F(ColorAlone, ACameraWithAnEmptyFolderOfDepthIsADepthCamera) {
  writeRig(true);
  writeColors();
  for (const char* name : kNames) fs::create_directories(folder_ / name / "depth");
  EXPECT_TRUE(refusal({"rig.json", "no depth images", path("left/depth/000000.png"), path("left/color/000000.png")}));
  fs::remove(folder_ / "right" / "depth");
  io::LoadedFrame frame;
  open()->read(0, frame);
  EXPECT_FALSE(frame.rig.views[0].color);
  EXPECT_TRUE(frame.rig.views[2].color);
  ASSERT_EQ(frame.ended.size(), 2u);
  EXPECT_EQ(frame.ended[1].message, "camera 'middle' has no depth images");
}

TEST_F(ColorAlone, TheUnitOfDepthIsAskedForWhereThereIsDepth) {
  writeRig();
  writeColors();
  writeDepth("right/depth/000000.png");
  EXPECT_TRUE(refusal({"rig.json: camera 'right': depth_scale is missing, must be a number"}));
  io::RecordingOptions options;
  options.depth_scale = 0.001f;
  EXPECT_NO_THROW(open(options));
  options = {};
  options.views = "0,1";
  EXPECT_NO_THROW(open(options));
}

TEST_F(ColorAlone, ImagesThatDoNotFitAreNamed) {
  writeRig();
  writeColors();
  const std::string wide = writeColor("middle/color/000000.png", 65);
  io::LoadedFrame frame;
  EXPECT_TRUE(refuses([&] { open()->read(0, frame); }, {wide, "65x48", "64x48"}));
  io::RecordingOptions options;
  options.skip_damaged = true;
  open(options)->read(0, frame);
  EXPECT_FALSE(frame.rig.views[1].color);
  ASSERT_EQ(frame.damaged.size(), 1u);
  const auto recording = open();
  fs::remove(folder_ / "left" / "color" / "000000.png");
  EXPECT_TRUE(refuses([&] { recording->read(0, frame); }, {"left/color/000000.png", "no longer there"}));
  writeColor("left/color/000000.png");
  writeColor("left/color/000000.jpg");
  EXPECT_TRUE(refusal({"000000.jpg and 000000.png", "one colour image of a frame"}));
}

TEST_F(ColorAlone, WithoutColourNothingIsLeftOfThem) {
  writeRig();
  writeColors();
  io::RecordingOptions options;
  options.read_color = false;
  const auto recording = open(options);
  EXPECT_FALSE(recording->hasColor(0));
  io::LoadedFrame frame;
  recording->read(0, frame);
  EXPECT_FALSE(frame.rig.views[0].color);
}

TEST_F(ColorAlone, PosesOfAnotherFileAreTheirs) {
  writeRig();
  writeColors();
  Json rig;
  for (const char* name : kNames) {
    rig["cameras"].push_back(cameraOf(name, false));
    rig["cameras"].back()["T_world_camera"][3] = 7;
  }
  io::RecordingOptions options;
  options.poses = write("poses.json", rig.dump());
  const auto recording = open(options);
  EXPECT_EQ(recording->cameras()[1].T_world_camera.translation().x(), 7);
  EXPECT_FALSE(recording->hasDepth(1));
  options.read_color = false;
  EXPECT_FALSE(open(options)->hasColor(1));
}

}  // namespace
