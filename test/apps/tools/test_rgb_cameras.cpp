#include "support/cloud_file.h"
#include "support/png_file.h"
#include "support/tool_fixture.h"

#include <nlohmann/json.hpp>

namespace tool_test {
namespace {

/** \brief Colour cameras on an arc around a table: simulated, without the depth. */
class RgbCameras : public ToolTest {
 protected:
  void simulate(const std::string& rig, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"--scene", "table", "--rig",      rig,  "--sensor", "ideal",
                                       "--scale", "0.25",  "--no-depth", "-o", recording()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    ASSERT_TRUE(succeeded(runProgram(FUSE_FLOW_SIMULATE_TOOL, arguments)));
    for (const fs::path& camera : cameras()) ASSERT_FALSE(fs::exists(camera / "depth"));
  }
  std::vector<fs::path> cameras() const {
    std::vector<fs::path> folders;
    for (const fs::directory_entry& entry : fs::directory_iterator(recording_))
      if (entry.path().filename().string().rfind("camera_", 0) == 0) folders.push_back(entry.path());
    std::sort(folders.begin(), folders.end());
    return folders;
  }
  static std::string color(const fs::path& camera) { return (camera / "color" / "000000.png").string(); }
  ToolResult depth(const std::vector<std::string>& arguments) const {
    return runProgram(FUSE_FLOW_DEPTH_TOOL, arguments);
  }
  ToolResult fuseTo(const std::string& cloud, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{recording(), "-o", out(cloud), "--no-quality"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return fuse(arguments);
  }
  static testing::AssertionResult says(const std::string& text, const std::string& words) {
    if (text.find(words) != std::string::npos) return testing::AssertionSuccess();
    return testing::AssertionFailure() << "'" << words << "' is not said in '" << text << "'";
  }
};

TEST_F(RgbCameras, AreFusedNearTheTrueSurface) {
  simulate("arc-6");
  const ToolResult result = fuseTo("cloud.ply", {"--report", out("report.json")});
  ASSERT_TRUE(succeeded(result));
  EXPECT_TRUE(says(result.err,
                   "depth is estimated from the colour images of 6 views (options --stereo-…); "
                   "--depth-source stereo\n"));
  EXPECT_TRUE(says(result.err, "depth is looked for from "));
  EXPECT_TRUE(says(result.out, "depth of 6 views was estimated: "));
  const nlohmann::json report = nlohmann::json::parse(readText(out("report.json")));
  EXPECT_EQ(report["estimated_depth"]["views"].size(), 6u);
  EXPECT_EQ(report["estimated_depth"]["depth_source"], "stereo");
  EXPECT_GT(report["estimated_depth"]["agreeing"], 0.5);
  // The truth is looked at with all cameras, and needs no depth of theirs.
  ASSERT_TRUE(succeeded(evaluate({recording(), out("cloud.ply"), "--no-stereo", "--json", out("figures.json")})));
  const nlohmann::json truth = nlohmann::json::parse(readText(out("figures.json")))[out("cloud.ply")]["truth"];
  // A pixel is 15 mm wide on the table. Poses that are off by 0.2 degrees make it twice as much.
  EXPECT_LT(truth["accuracy_mean_mm"], 20);
  EXPECT_LT(truth["ghosting"], 0.15);
  EXPECT_GT(readCloudFile(out("cloud.ply")).size(), 10000u);
}

TEST_F(RgbCameras, AreAsTheDepthThatIsWrittenOfThem) {
  simulate("arc-3", {"--frames", "2"});
  const ToolResult written = depth({recording(), "-o", out("depth")});
  ASSERT_TRUE(succeeded(written));
  EXPECT_TRUE(says(written.err, "the folder truth is not copied"));
  EXPECT_TRUE(says(written.out, "frame 000001: another view agrees on the depth of "));
  EXPECT_TRUE(says(written.out, out("depth") + ": 2 frames, depth of 3 views was estimated: "));
  ASSERT_TRUE(succeeded(fuseTo("direct/")));
  const ToolResult twice = fuse({out("depth"), "-o", out("twice/"), "--no-quality", "--depth-source", "stereo"});
  ASSERT_TRUE(succeeded(twice));
  EXPECT_FALSE(says(twice.out, "--min-confidence")) << "stereo is unsure of much, as it should be";
  for (const char* frame : {"000000.ply", "000001.ply"}) {
    EXPECT_FALSE(readCloudFile(folder_ / "direct" / frame).empty());
    EXPECT_EQ(readText(folder_ / "direct" / frame), readText(folder_ / "twice" / frame)) << frame;
  }
  const std::vector<std::string> names = listing(folder_ / "depth");
  for (const char* name :
       {"camera_02/color/000001.png", "camera_02/depth/000001.npy", "camera_02/confidence/000001.npy",
        "pictures/camera_02/000001_depth.png", "pictures/camera_02/000001_confidence.png", "rig.json"})
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
  EXPECT_EQ(std::count(names.begin(), names.end(), "truth"), 0);
  EXPECT_EQ(readText(color(cameras()[1])), readText(color(folder_ / "depth" / "camera_01")));
}

TEST_F(RgbCameras, OneFrameAndSomeViewsCanBeWritten) {
  simulate("arc-3", {"--frames", "2"});
  fs::rename(color(cameras()[2]), cameras()[2] / "color" / "0.jpg");  // a PNG by its content
  ASSERT_TRUE(succeeded(depth({recording(), "-o", out("depth"), "--frames", "0", "--views", "1,2", "--threads", "1"})));
  const std::vector<std::string> names = listing(folder_ / "depth");
  EXPECT_EQ(std::count(names.begin(), names.end(), "camera_02/color/000000.png"), 1);
  EXPECT_EQ(std::count(names.begin(), names.end(), "camera_00"), 0);
  EXPECT_EQ(std::count(names.begin(), names.end(), "camera_01/depth/000001.npy"), 0);
}

TEST_F(RgbCameras, OfWhichDepthIsWrittenKeepWhatTheyAre) {
  simulate("arc-2");
  fs::create_directories(folder_ / "full" / "of");
  const std::vector<std::string> before = listing(recording_);
  EXPECT_TRUE(isOneLineError(depth({recording(), "-o", recording()}), 2, {"-o", recording()}));
  for (const char* inside : {"new", "camera_00/color", "camera_00/color/new", "truth/new"})
    EXPECT_TRUE(
        isOneLineError(depth({recording(), "-o", (recording_ / inside).string()}), 2, {"-o", inside, "is an input"}))
        << inside;
  EXPECT_TRUE(isOneLineError(depth({(recording_ / "rig.json").string(), "-o", (recording_ / "new").string()}), 2,
                             {"-o", "is an input"}));
  EXPECT_TRUE(
      isOneLineError(depth({recording(), "-o", out("full")}), 1, {out("full"), "must be a new or empty folder"}));
  EXPECT_EQ(listing(recording_), before);
  EXPECT_EQ(listing(folder_ / "full"), std::vector<std::string>{"of"});
}

TEST_F(RgbCameras, TwoCanOnlyAgreeWithOneAnother) {
  simulate("arc-2");
  const ToolResult result = fuseTo("cloud.ply");
  ASSERT_TRUE(succeeded(result));
  EXPECT_TRUE(says(result.err,
                   "--depth-source stereo --min-agreeing-views 1, as two views can agree with one another alone\n"));
  EXPECT_TRUE(says(result.err, "2 of 2 views (camera_00, camera_01) have neighbours in one direction only"));
  EXPECT_GT(readCloudFile(out("cloud.ply")).size(), 100u);
  const ToolResult own = fuseTo("own.ply", {"--min-agreeing-views", "2", "--depth-source", "stereo"});
  EXPECT_TRUE(says(own.err, "views (options --stereo-…)\n"));
  EXPECT_TRUE(isOneLineError(own, 1, {"agreement.min_views is 2", "1 other", "--min-agreeing-views"}));
}

TEST_F(RgbCameras, OneIsRefused) {
  simulate("arc-2");
  EXPECT_TRUE(
      isOneLineError(fuseTo("cloud.ply", {"--views", "1"}), 1,
                     {recording(), "camera 'camera_01' has no depth", "two or more that see the same", "--no-stereo"}));
}

TEST_F(RgbCameras, WhatMadeTheDepthCanBeSaid) {
  simulate("arc-3");
  const ToolResult result = fuseTo("cloud.ply", {"--depth-source", "camera"});
  ASSERT_TRUE(succeeded(result));
  EXPECT_TRUE(says(result.err, "views (options --stereo-…)\n"));
  EXPECT_TRUE(says(result.err, "is fused as a depth camera's; --depth-source stereo drops"));
  const ToolResult other = fuseTo("other.ply", {"--method", "concatenate"});
  EXPECT_TRUE(says(other.err, "views (options --stereo-…)\n"));
  EXPECT_EQ(readCloudFile(out("other.ply")).size() > readCloudFile(out("cloud.ply")).size(), true);
}

TEST_F(RgbCameras, StayMissingWithNoStereo) {
  simulate("arc-2");
  const ToolResult result = fuseTo("cloud.ply", {"--no-stereo"});
  ASSERT_TRUE(succeeded(result));
  EXPECT_TRUE(says(result.err, "2 of 2 cameras have colour images alone, no depth, and are missing"));
  EXPECT_FALSE(says(result.err, "estimated"));
  EXPECT_TRUE(says(result.out, "camera camera_01 missed 1 of 1 frames"));
  EXPECT_TRUE(readCloudFile(out("cloud.ply")).empty());
}

TEST_F(RgbCameras, OfBlackImagesHaveNoDepthAndItIsSaid) {
  simulate("arc-3");
  for (const fs::path& camera : cameras()) writeText(color(camera), colorPng(160, 120, 2, 0, 1));
  const ToolResult result = fuseTo("cloud.ply");
  ASSERT_TRUE(succeeded(result));
  EXPECT_TRUE(
      says(result.err, "3 images are black or white: camera_00 (black), camera_01 (black), camera_02 (black);"));
  EXPECT_TRUE(says(result.err, "frame 000000: another view agrees on the depth of 0 % of the pixels"));
  EXPECT_TRUE(readCloudFile(out("cloud.ply")).empty());
}

TEST_F(RgbCameras, ThatMissAFrameLeaveTheOthers) {
  simulate("arc-3", {"--frames", "2"});
  fs::remove(color(cameras()[1]));
  const ToolResult result = fuseTo("clouds/");
  ASSERT_TRUE(succeeded(result));
  EXPECT_TRUE(says(result.out, "camera camera_01 missed 1 of 2 frames"));
  EXPECT_FALSE(readCloudFile(folder_ / "clouds" / "000001.ply").empty());
}

TEST_F(RgbCameras, MayStandBesideDepthCameras) {
  WallRecording wall{};
  wall.frames = 1;
  wall.write(recording_);
  fs::remove_all(recording_ / "camera_1" / "depth");
  const ToolResult result = fuseTo("cloud.ply");
  ASSERT_TRUE(succeeded(result));
  EXPECT_TRUE(says(result.err, "depth of 1 of 2 views is estimated from the colour images of 2 views"));
  EXPECT_FALSE(says(result.err, "; --depth-source stereo\n")) << "what a depth camera measured is fused as such";
  ASSERT_TRUE(succeeded(depth({recording(), "-o", out("depth")})));
  EXPECT_EQ(readText(colorFile(recording_, 0, 0)), readText(colorFile(folder_ / "depth", 0, 0)));
  EXPECT_TRUE(fs::exists(depthFile(folder_ / "depth", 0, 0)));
  ASSERT_TRUE(succeeded(fuse({out("depth"), "-o", out("twice.ply"), "--no-quality"})));
  EXPECT_EQ(readText(out("cloud.ply")), readText(out("twice.ply")));
  fs::remove_all(recording_ / "camera_0" / "color");
  const ToolResult alone = fuseTo("alone.ply");
  ASSERT_TRUE(succeeded(alone));
  EXPECT_TRUE(says(alone.err, "camera 'camera_1' has no depth, and no other camera has colour images"));
}

TEST_F(RgbCameras, TheirOptionsAreChecked) {
  simulate("arc-2");
  using Words = std::vector<std::string>;
  for (const auto& [option, value, words] : std::vector<std::tuple<std::string, std::string, Words>>{
           {"--stereo-sources", "9", {"--stereo-sources is 9", "8"}},
           {"--stereo-sources", "0", {"--stereo-sources is 0", "1"}},
           {"--stereo-best-sources", "5", {"--stereo-best-sources is 5"}},
           {"--stereo-min-depth", "-1", {"--stereo-min-depth is -1"}},
           {"--stereo-max-depth", "nan", {"--stereo-max-depth", "nan", "must be a number"}},
           {"--stereo-levels", "6", {"--stereo-levels is 6", "5"}},
           {"--stereo-passes", "17", {"--stereo-passes is 17", "16"}},
           {"--stereo-edge-step", "1", {"--stereo-edge-step is 1", "0.99"}},
           {"--stereo-repetition-reach", "257", {"--stereo-repetition-reach is 257", "256"}},
           {"--stereo-window", "two", {"--stereo-window", "two"}}})
    EXPECT_TRUE(isOneLineError(fuseTo("cloud.ply", {option, value}), 2, words)) << option;
  EXPECT_TRUE(isOneLineError(fuseTo("cloud.ply", {"--stereo-min-depth", "2", "--stereo-max-depth", "1"}), 2,
                             {"--stereo-max-depth is 1, must exceed --stereo-min-depth, 2"}));
  EXPECT_TRUE(isOneLineError(fuseTo("cloud.ply", {"--stereo-max-depth", "0.01"}), 1,
                             {"no two of 2 cameras", "between --stereo-min-depth and --stereo-max-depth"}));
}

TEST_F(RgbCameras, AreReadByTheOtherTools) {
  simulate("arc-3");
  ASSERT_TRUE(succeeded(fuseTo("cloud.ply")));
  ASSERT_TRUE(succeeded(evaluate({recording(), out("cloud.ply"), "--no-truth", "--json", out("figures.json")})));
  EXPECT_TRUE(nlohmann::json::parse(readText(out("figures.json")))[out("cloud.ply")]["e_mc_mm"].is_number());
  ASSERT_TRUE(succeeded(runProgram(FUSE_FLOW_EXPORT_TOOL, {recording(), "-o", out("pcd"), "--stereo-passes", "0"})));
  EXPECT_EQ(listing(folder_ / "pcd").size(), 6u);
  EXPECT_TRUE(isOneLineError(runProgram(FUSE_FLOW_CALIBRATE_TOOL, {recording(), "-o", out("poses.json")}), 1,
                             {recording(), "no camera has depth", "COLMAP"}));
}

TEST_F(RgbCameras, AreExplainedByTheHelpOfTheTools) {
  for (const char* tool : {FUSE_FLOW_FUSE_TOOL, FUSE_FLOW_EVALUATE_TOOL, FUSE_FLOW_EXPORT_TOOL, FUSE_FLOW_LIVE_TOOL,
                           FUSE_FLOW_DEPTH_TOOL}) {
    const ToolResult help = runProgram(tool, {"--help"});
    EXPECT_EQ(help.exit_code, 0);
    for (const char* option : {"Depth of cameras without depth", "--stereo-sources", "--stereo-max-depth",
                               "--stereo-passes", "--stereo-edge-step", "--stereo-repetition-reach"})
      EXPECT_TRUE(says(help.out, option)) << tool;
    EXPECT_EQ(help.out.find("--no-stereo") == std::string::npos, tool == std::string(FUSE_FLOW_DEPTH_TOOL));
  }
}

TEST_F(RgbCameras, ThatRunAreFusedAsTheirRecordingIs) {
  simulate("arc-3", {"--frames", "2"});
  ASSERT_TRUE(succeeded(fuseTo("direct/")));
  const ToolResult played = runProgram(
      FUSE_FLOW_LIVE_TOOL, {recording(), "--no-window", "-o", out("live"), "--speed", "0.02", "--max-wait", "1000"});
  ASSERT_EQ(played.exit_code, 0) << played.err;
  EXPECT_TRUE(says(played.err,
                   "depth is estimated from the colour images of 3 views (options --stereo-…); "
                   "--depth-source stereo\n"));
  EXPECT_TRUE(says(played.out, "depth of 3 views was estimated: "));
  EXPECT_EQ(played.out.find("no point passes"), std::string::npos) << played.out;
  std::vector<std::string> clouds = listing(folder_ / "live");
  ASSERT_GE(clouds.size(), 2u) << played.out << played.err;
  ASSERT_EQ(clouds.back(), "timestamps.txt");
  clouds.pop_back();
  for (const std::string& cloud : clouds) {  // a busy machine skips one
    const std::string bytes = readText(folder_ / "live" / cloud);
    EXPECT_TRUE(bytes == readText(folder_ / "direct" / "000000.ply") ||
                bytes == readText(folder_ / "direct" / "000001.ply"))
        << cloud;
    EXPECT_GT(readCloudFile(folder_ / "live" / cloud).size(), 100u);
  }
}

TEST_F(RgbCameras, TheirVideosAreFusedAsTheirImagesAre) {
  simulate("arc-3", {"--frames", "2"});
  std::vector<std::string> arguments;
  for (const fs::path& camera : cameras()) {
    const std::string video = out(camera.filename().string() + ".mkv");
    const std::string command = "ffmpeg -nostdin -loglevel quiet -framerate 30 -i " + (camera / "color").string() +
                                "/%06d.png -c:v ffv1 -pix_fmt bgr0 " + video;  // without loss
    if (std::system(command.c_str()) != 0) GTEST_SKIP() << "no ffmpeg";
    arguments.push_back(video);
  }
  ASSERT_TRUE(succeeded(fuseTo("direct/")));
  for (const char* more : {"--poses", "", "-o", "", "--no-quality"}) arguments.emplace_back(more);
  arguments[arguments.size() - 4] = (recording_ / "rig.json").string();
  arguments[arguments.size() - 2] = out("videos/");
  const ToolResult videos = fuse(arguments);
  if (videos.err.find("was built without libavformat") != std::string::npos) GTEST_SKIP() << videos.err;
  ASSERT_TRUE(succeeded(videos));
  EXPECT_TRUE(says(videos.err, "--time-offsets says by how many seconds each began later"));
  for (const char* frame : {"000000.ply", "000001.ply"}) {
    EXPECT_GT(readCloudFile(folder_ / "videos" / frame).size(), 100u);
    EXPECT_EQ(readText(folder_ / "videos" / frame), readText(folder_ / "direct" / frame)) << frame;
  }
}

TEST_F(RgbCameras, ThatRunMayStayMissing) {
  simulate("arc-2");
  const ToolResult played =
      runProgram(FUSE_FLOW_LIVE_TOOL, {recording(), "--no-window", "-o", out("live"), "--no-stereo"});
  ASSERT_TRUE(succeeded(played));
  EXPECT_TRUE(says(played.err, "2 of 2 cameras have colour images alone, no depth, and are missing"));
  EXPECT_TRUE(isOneLineError(
      runProgram(FUSE_FLOW_LIVE_TOOL, {recording(), "--no-window", "-o", out("poses"), "--refine-extrinsics"}), 2,
      {"--refine-extrinsics", "measure none"}));
}

TEST_F(RgbCameras, OnAGpuThereMustBeOne) {
  simulate("arc-2");
  for (const ToolResult& result :
       {fuseTo("cloud.ply", {"--device", "gpu"}), depth({recording(), "-o", out("depth"), "--device", "gpu"})}) {
    if (result.exit_code == 0) GTEST_SKIP() << "there is one";
    EXPECT_TRUE(isOneLineError(result, 2, {"--device gpu: ", "--device cpu"}));
  }
  EXPECT_TRUE(succeeded(fuseTo("cloud.ply", {"--device", "cpu"})));
}

TEST_F(RgbCameras, ARecordingWithDepthGetsNoOther) {
  WallRecording{}.write(recording_);
  EXPECT_TRUE(isOneLineError(depth({recording(), "-o", out("depth")}), 1, {recording(), "no view whose depth"}));
  EXPECT_FALSE(fs::exists(out("depth")));
}

}  // namespace
}  // namespace tool_test
