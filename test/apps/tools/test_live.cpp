#include "support/cloud_file.h"
#include "support/png_file.h"
#include "support/tool_fixture.h"

#include <signal.h>

#include <chrono>
#include <thread>

namespace tool_test {
namespace {

class Live : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    WallRecording wall{};
    wall.frames = 6;
    wall.write(recording_);
    nlohmann::json rig = wall.rig();
    rig["frames_per_second"] = 20;
    writeText(recording_ / "rig.json", rig.dump());
  }
  static ToolResult live(std::vector<std::string> arguments, const RunOptions& options = {}) {
    arguments.insert(arguments.begin(), "--no-window");
    return runProgram(FUSE_FLOW_LIVE_TOOL, arguments, options);
  }
  static bool unbuilt(const ToolResult& result) { return result.err.find("was built without") != std::string::npos; }
};

/** \brief Distance of the wall, by the cloud's points. */
double distanceOfWall(const std::string& cloud) {
  double sum = 0;
  const std::vector<FilePoint> points = readCloudFile(cloud);
  for (const FilePoint& point : points) sum += point.z;
  return points.empty() ? 0 : sum / static_cast<double>(points.size());
}

TEST_F(Live, FusesWhatIsPlayedInItsOrder) {
  const ToolResult played = live({recording(), "-o", out("clouds"), "--report", out("live.json"), "--jitter", "5"});
  ASSERT_TRUE(succeeded(played));
  EXPECT_NE(played.out.find("camera_1: 6 views came, 0 were lost before"), std::string::npos) << played.out;
  std::vector<std::string> clouds = listing(out("clouds"));
  ASSERT_FALSE(clouds.empty());
  ASSERT_EQ(clouds.back(), "timestamps.txt");
  clouds.pop_back();
  std::istringstream times(readText(out("clouds/timestamps.txt")));
  double before = 1.9;
  for (const std::string& cloud : clouds) {  // each is one of the frames; a busy machine skips some
    const double distance = distanceOfWall(out("clouds/" + cloud));
    EXPECT_GT(distance, before + 0.04);
    const double frame = (distance - WallRecording::wallDistance(0)) / 0.05;
    EXPECT_NEAR(frame, std::round(frame), 0.05);
    std::string name;
    double time = -1;
    times >> name >> time;
    EXPECT_EQ(name, cloud);
    EXPECT_NEAR(time, 0.05 * std::round(frame), 1e-6);  // 20 a second
    before = distance;
  }
  const nlohmann::json report = nlohmann::json::parse(readText(out("live.json")));
  ASSERT_EQ(report["cameras_that_ran"].size(), 2u);
  EXPECT_EQ(report["cameras_that_ran"][0]["views"], 6);
  EXPECT_EQ(report["frames"].size(), clouds.size());
}

TEST_F(Live, RecordsWhatItFuses) {
  const ToolResult played = live({recording(), "--record", out("live.mcap"), "--status", "0"});
  if (unbuilt(played)) GTEST_SKIP() << played.err;
  ASSERT_TRUE(succeeded(played));
  EXPECT_NE(played.out.find("live.mcap: 12 views"), std::string::npos) << played.out;
  EXPECT_NE(played.err.find("the clouds go nowhere"), std::string::npos) << played.err;
  ASSERT_TRUE(succeeded(runProgram(FUSE_FLOW_FUSE_TOOL, {out("live.mcap"), "-o", out("clouds")})));
  ASSERT_EQ(listing(out("clouds")).size(), 6u);
  EXPECT_NEAR(distanceOfWall(out("clouds/000005.ply")), WallRecording::wallDistance(5), 0.005);
}

TEST_F(Live, ConfidenceThatARecordingHasNoPlaceForIsNamed) {
  const WallRecording wall{};
  const std::string sure(static_cast<std::size_t>(wall.width * wall.height), '\xff');
  writeText(recording_ / "camera_0" / "confidence" / "000002.png", samplesPng(wall.width, wall.height, 8, 0, sure));
  for (const bool fuses : {false, true}) {
    const ToolResult recorded = fuses ? live({recording(), "--record", out("c.mcap")})
                                      : runProgram(FUSE_FLOW_RECORD_TOOL, {recording(), "--play", "-o", out("c.mcap")});
    if (unbuilt(recorded)) GTEST_SKIP() << recorded.err;
    EXPECT_EQ(recorded.exit_code, 0);
    EXPECT_NE(recorded.err.find("images of confidence have no place"), std::string::npos) << recorded.err;
  }
}

TEST_F(Live, RecordingCamerasThatRunLosesNothingAndPlaysAfterAKill) {
  const ToolResult played =
      runProgram(FUSE_FLOW_RECORD_TOOL, {recording(), "--play", "--own-clocks", "-o", out("played.mcap")});
  if (unbuilt(played)) GTEST_SKIP() << played.err;
  ASSERT_TRUE(succeeded(played));
  EXPECT_NE(played.out.find("played.mcap: 12 views of 2 cameras"), std::string::npos) << played.out;
  // Clocks of their own have become one.
  ASSERT_TRUE(succeeded(runProgram(FUSE_FLOW_FUSE_TOOL, {out("played.mcap"), "-o", out("clouds")})));
  EXPECT_EQ(listing(out("clouds")).size(), 6u);
  RunOptions kill;
  kill.meanwhile = [&](pid_t tool) {
    const auto written = [&] { return fs::exists(out("killed.mcap")) && fs::file_size(out("killed.mcap")) > 20000; };
    for (int k = 0; k < 20000 && !written(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ::kill(tool, SIGKILL);
  };
  const ToolResult killed =
      runProgram(FUSE_FLOW_RECORD_TOOL, {recording(), "--play", "--loop", "-o", out("killed.mcap")}, kill);
  EXPECT_EQ(killed.exit_code, 128 + SIGKILL);
  ASSERT_TRUE(succeeded(runProgram(FUSE_FLOW_FUSE_TOOL, {out("killed.mcap"), "-o", out("rest"), "--frames", "0:5"})));
  EXPECT_EQ(listing(out("rest")).size(), 5u);
}

TEST_F(Live, EndsInOrderWhenItIsInterruptedOrItsTimeIsOver) {
  RunOptions interrupt;
  interrupt.meanwhile = [&](pid_t tool) {
    for (int k = 0; k < 20000 && listing(out("clouds")).empty(); ++k)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ::kill(tool, SIGINT);
  };
  const ToolResult ended = live({recording(), "--loop", "-o", out("clouds")}, interrupt);
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(ended.out.find(" fused, in "), std::string::npos) << ended.out;
  const ToolResult over = live({recording(), "--loop", "--seconds", "0.2", "--stall", "camera_1:0:9", "-o", out("b")});
  ASSERT_TRUE(succeeded(over));
  EXPECT_NE(over.out.find("camera_1: 0 views came"), std::string::npos) << over.out;
}

TEST_F(Live, AnImageThatIsNotThereIsNotAnEarlierOne) {
  WallRecording wall{};
  wall.frames = 20;
  wall.write(recording_);
  for (std::size_t frame = 5; frame < 20; ++frame) {
    fs::remove(depthFile(recording_, 1, frame));
    fs::remove(colorFile(recording_, 1, frame));
  }
  for (const std::vector<std::string>& how : {std::vector<std::string>{}, {"--play"}}) {
    std::vector<std::string> arguments{recording(), "-o", out("gaps.mcap")};
    arguments.insert(arguments.end(), how.begin(), how.end());
    const ToolResult recorded = runProgram(FUSE_FLOW_RECORD_TOOL, arguments);
    if (unbuilt(recorded)) GTEST_SKIP() << recorded.err;
    EXPECT_EQ(recorded.exit_code, 0) << recorded.err;
    const ToolResult fused = fuse({out("gaps.mcap"), "-o", out("gaps"), "--report", out("gaps.json"), "--no-quality"});
    EXPECT_EQ(fused.exit_code, 0) << fused.err;
    const nlohmann::json report = nlohmann::json::parse(readText(out("gaps.json")));
    ASSERT_EQ(report["frames"].size(), 20u);
    for (std::size_t frame = 0; frame < 20; ++frame)  // 32 x 24 pixels of each camera
      EXPECT_EQ(report["frames"][frame]["points_in"], frame < 5 ? 1536 : 768) << frame;
  }
}

TEST_F(Live, SaysWhatIsWrong) {
  EXPECT_TRUE(isOneLineError(live({recording(), "--record", out("a.mcap"), "--report", out("a.mcap")}), 2,
                             {"--report", "must be another"}));
  EXPECT_TRUE(isOneLineError(live({recording(), "--report", recording()}), 2, {"--report"}));
  EXPECT_TRUE(isOneLineError(live({}), 2, {"input", "--list"}));
  EXPECT_TRUE(isOneLineError(live({recording(), "-o", out("a.ply")}), 2, {"-o", "must be a folder"}));
  EXPECT_TRUE(isOneLineError(live({recording(), "--record", out("a.bag")}), 2, {"--record", ".mcap"}));
  EXPECT_TRUE(isOneLineError(live({recording(), "--stall", "left"}), 2, {"--stall left", "CAMERA:FROM:SECONDS"}));
  EXPECT_TRUE(isOneLineError(live({recording(), "--stall", "left:1:2"}), 2, {"'left'", "'camera_0', 'camera_1'"}));
  EXPECT_TRUE(isOneLineError(live({recording(), "--stall", "0:1:-2"}), 2, {"--stall 0:1:-2", "seconds"}));
  EXPECT_TRUE(isOneLineError(live({recording(), "--drop", "1.5"}), 2, {"--drop"}));
  EXPECT_TRUE(isOneLineError(live({recording(), "--play-frames", "9"}), 2, {"--play-frames"}));
  EXPECT_TRUE(isOneLineError(live({out("nowhere")}), 1, {"nowhere"}));
  EXPECT_TRUE(isOneLineError(live({recording(), "-o", recording()}), 2, {"-o", "holds files already"}));
  EXPECT_TRUE(isOneLineError(runProgram(FUSE_FLOW_RECORD_TOOL, {recording(), "-o", out("a.mcap"), "--jitter", "3"}), 2,
                             {"--jitter", "--play"}));
  EXPECT_TRUE(
      isOneLineError(runProgram(FUSE_FLOW_RECORD_TOOL, {recording(), "-o", out("a.mcap"), "--play", "--frames", "0"}),
                     2, {"--frames", "--play-frames"}));
  fs::remove(depthFile(recording_, 1, 3));
  writeText(depthFile(recording_, 1, 3), "no image");
  const ToolResult damaged = live({recording(), "--status", "0", "-o", out("c")});
  EXPECT_EQ(damaged.exit_code, 0);
  EXPECT_NE(damaged.err.find("000003.png"), std::string::npos) << damaged.err;
  EXPECT_NE(damaged.out.find("camera_1: 5 views came, 1 were lost before"), std::string::npos) << damaged.out;
}

}  // namespace
}  // namespace tool_test
