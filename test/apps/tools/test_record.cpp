#include "support/cloud_file.h"
#include "support/png_file.h"
#include "support/tool_fixture.h"

namespace tool_test {
namespace {

class Record : public ToolTest {
 protected:
  ToolResult record(std::vector<std::string> arguments) {
    const ToolResult result = runProgram(FUSE_FLOW_RECORD_TOOL, arguments);
    unbuilt_ = result.err.find("was built without") != std::string::npos;
    return result;
  }
  bool unbuilt_{false};
};

TEST_F(Record, TheFileGivesTheCloudsOfTheRecording) {
  WallRecording wall{};
  wall.write(recording_);
  const ToolResult recorded = record({recording(), "-o", out("wall.mcap")});
  if (unbuilt_) GTEST_SKIP() << recorded.err;
  ASSERT_TRUE(succeeded(recorded));
  EXPECT_NE(recorded.out.find("wall.mcap: 2 frames of 2 cameras"), std::string::npos) << recorded.out;
  EXPECT_NE(recorded.err.find("30 a second are taken"), std::string::npos) << recorded.err;  // it has no rate
  ASSERT_TRUE(succeeded(runProgram(FUSE_FLOW_FUSE_TOOL, {recording(), "-o", out("a")})));
  ASSERT_TRUE(succeeded(runProgram(FUSE_FLOW_FUSE_TOOL, {out("wall.mcap"), "-o", out("b")})));
  ASSERT_EQ(listing(out("a")), listing(out("b")));
  for (const std::string& name : listing(out("a"))) {
    const std::vector<FilePoint> a = readCloudFile(fs::path(out("a")) / name),
                                 b = readCloudFile(fs::path(out("b")) / name);
    ASSERT_FALSE(a.empty());
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
      EXPECT_NEAR(a[k].x, b[k].x, 1e-6);
      EXPECT_NEAR(a[k].z, b[k].z, 1e-6);
    }
  }
}

TEST_F(Record, WhatHasNoPlaceInTheFileIsSaid) {
  WallRecording wall{};
  wall.frames = 1;
  wall.write(recording_);
  nlohmann::json rig = wall.rig();
  rig["cameras"][1]["noise"] = {{"floor", 0.001}};
  writeText(recording_ / "rig.json", rig.dump());
  writeText(recording_ / "camera_0" / "confidence" / "000000.png",
            samplesPng(wall.width, wall.height, 8, 0,
                       std::string(static_cast<std::size_t>(wall.width * wall.height), '\xff')));
  const ToolResult recorded = record({recording(), "-o", out("wall.mcap")});
  if (unbuilt_) GTEST_SKIP() << recorded.err;
  ASSERT_TRUE(succeeded(recorded));
  EXPECT_NE(recorded.err.find("multipath and noise of 'camera_1' have no place"), std::string::npos) << recorded.err;
  EXPECT_NE(recorded.err.find("images of confidence have no place"), std::string::npos) << recorded.err;
}

TEST_F(Record, CamerasThatMoveAndOtherNamesAreRefused) {
  WallRecording wall{};
  wall.write(recording_);
  EXPECT_TRUE(isOneLineError(record({recording(), "-o", out("wall.bag")}), 2, {"-o", "wall.bag", ".mcap"}));
  // 7-Scenes: one camera that is elsewhere in every frame.
  const fs::path moving = folder_ / "moving";
  for (int k = 0; k < 3; ++k) {
    const std::string stem = "frame-00000" + std::to_string(k);
    writeText(moving / (stem + ".depth.png"), depthPng(640, 480, std::vector<std::uint16_t>(640 * 480, 1000)));
    writeText(moving / (stem + ".pose.txt"), "1 0 0 0." + std::to_string(k) + "\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  }
  const ToolResult slid = record({moving.string(), "--views", "0", "--slide", "1", "-o", out("moving.mcap")});
  if (unbuilt_) GTEST_SKIP() << slid.err;
  EXPECT_EQ(slid.exit_code, 1);
  EXPECT_NE(slid.err.find("is elsewhere than in the first frame"), std::string::npos) << slid.err;
}

TEST_F(Record, ImagesWithoutAPartnerAreCountedInTheReportOfTheFusion) {
  WallRecording wall{};
  wall.frames = 8;
  wall.color = false;
  wall.write(recording_);
  for (std::size_t camera = 0; camera < 2; ++camera)
    for (std::size_t frame = 0; frame < 8; ++frame) {
      const fs::path file = depthFile(recording_, camera, frame);
      // Named by their times, 0.1 s apart; the second camera is half as fast.
      fs::rename(file, file.parent_path() / ("100." + std::to_string(frame) + ".png"));
      if (camera == 1 && frame % 2 == 1) fs::remove(file.parent_path() / ("100." + std::to_string(frame) + ".png"));
    }
  const ToolResult fused = fuse({recording(), "-o", out("clouds"), "--report", out("report.json"), "--no-quality"});
  EXPECT_EQ(fused.exit_code, 0) << fused.err;
  const nlohmann::json report = nlohmann::json::parse(readText(out("report.json")));
  ASSERT_TRUE(report.contains("images_without_partner"));
  EXPECT_EQ(report["images_without_partner"], (nlohmann::json{{"camera_0", 3}}));  // the eighth has nobody after it
}

}  // namespace
}  // namespace tool_test
