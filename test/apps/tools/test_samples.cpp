#include "support/cloud_file.h"
#include "support/tool_fixture.h"

#include <png.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <sstream>

namespace tool_test {
namespace {

/** \brief The developers' samples, as programs. */
class Samples : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    wall_.cameras = 2;
    wall_.frames = 3;
    wall_.write(recording_);
  }

  /** \brief Starts a program where there is a display, if need be one of its own. */
  static ToolResult runWithDisplay(std::vector<std::string> command) {
    const char* display = std::getenv("DISPLAY");
    if (!display || !*display) command.insert(command.begin(), {"xvfb-run", "-a"});
    return runProgram("/usr/bin/env", command);
  }

  WallRecording wall_;
};

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/** \brief How many pixels of a picture are of a colour. */
std::size_t pixelsOf(const std::string& path, int r, int g, int b) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_file(&image, path.c_str())) throw std::runtime_error(path + ": " + image.message);
  image.format = PNG_FORMAT_RGB;
  std::vector<png_byte> pixels(PNG_IMAGE_SIZE(image));
  if (!png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr))
    throw std::runtime_error(path + ": " + image.message);
  std::size_t count = 0;
  for (std::size_t i = 0; i < pixels.size(); i += 3)
    if (std::abs(pixels[i] - r) < 8 && std::abs(pixels[i + 1] - g) < 8 && std::abs(pixels[i + 2] - b) < 8) ++count;
  return count;
}

TEST_F(Samples, ThePipelineRunsEveryFilterAndLeavesAFusedWall) {
  const ToolResult result = runProgram(FUSE_FLOW_SAMPLE_PCL_PIPELINE, {recording(), out("fused.pcd")});
  ASSERT_TRUE(succeeded(result));
  std::size_t from = 0;
  for (const char* step : {"camera_0", "PassThrough: 768",
                           "ConfidenceEstimation: ", "DepthBackprojection: ", "MultiViewConsistency: ", "camera_1",
                           "PassThrough: 768", "together: ", "AdaptiveHashFusion: ", "StatisticalOutlierRemoval: "}) {
    from = result.out.find(step, from);
    ASSERT_NE(from, std::string::npos) << step << " in\n" << result.out;
  }
  const std::vector<FilePoint> cloud = readCloudFile(out("fused.pcd"));
  EXPECT_GT(cloud.size(), 500u);
  for (const FilePoint& p : cloud) {
    ASSERT_NEAR(p.z, WallRecording::wallDistance(0), 1e-3);
    ASSERT_TRUE(p.r == 200 && p.g == 100 && p.b == 50);
  }
}

TEST_F(Samples, ThePipelineTakesDepthAlongTheAxisOfACameraThatLooksAnywhere) {
  nlohmann::json rig = wall_.rig();
  for (int k = 0; k < 2; ++k)  // its z along the world's x, its x along −y
    rig["cameras"][k]["T_world_camera"] = {0, 0, 1, 0, -1, 0, 0, -0.1 * k, 0, -1, 0, 0, 0, 0, 0, 1};
  writeText(recording_ / "rig.json", rig.dump());
  const ToolResult result = runProgram(FUSE_FLOW_SAMPLE_PCL_PIPELINE, {recording(), out("fused.pcd")});
  ASSERT_TRUE(succeeded(result));
  const std::string step = "ConfidenceEstimation: ";
  EXPECT_GT(std::stoi(result.out.substr(result.out.find(step) + step.size())), 600) << result.out;
  for (const FilePoint& p : readCloudFile(out("fused.pcd"))) ASSERT_NEAR(p.x, WallRecording::wallDistance(0), 1e-3);
}

TEST_F(Samples, TheVisualizerShowsTheFusedCloudInItsColours) {
  const ToolResult result = runWithDisplay({FUSE_FLOW_SAMPLE_VISUALIZE, recording(), out("picture.png")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find(" points from 2 cameras"), std::string::npos) << result.out;
  EXPECT_GT(pixelsOf(out("picture.png"), 200, 100, 50), 2000u);
}

TEST_F(Samples, TheVisualizerSaysHowToGetADisplay) {
  const ToolResult result = runProgram("/usr/bin/env", {"-u", "DISPLAY", FUSE_FLOW_SAMPLE_VISUALIZE, recording()});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("xvfb-run"), std::string::npos) << result.err;
}

TEST_F(Samples, AnExportedRecordingIsOneCloudACameraAndFrameNamedByItsTime) {
  ASSERT_TRUE(succeeded(runProgram(FUSE_FLOW_EXPORT_TOOL, {recording(), "-o", out(), "--fps", "5"})));
  EXPECT_EQ(listing(out_),
            (std::vector<std::string>{"camera_0", "camera_0/000000000000.pcd", "camera_0/000000200000.pcd",
                                      "camera_0/000000400000.pcd", "camera_1", "camera_1/000000000000.pcd",
                                      "camera_1/000000200000.pcd", "camera_1/000000400000.pcd"}));
  // Read as what they are, two organised views with poses of their own, they are the wall again.
  ASSERT_TRUE(succeeded(fuse({out("out/camera_0/000000400000.pcd"), out("out/camera_1/000000400000.pcd"), "-o",
                              out("fused.ply"), "--device", "cpu"})));
  float right = 0;
  for (const FilePoint& p : readCloudFile(out("fused.ply"))) {
    ASSERT_NEAR(p.z, WallRecording::wallDistance(2), 1e-3);
    right = std::max(right, p.x);
  }
  EXPECT_NEAR(right, 2.1 * 15.5 / 32 + 0.1, 2e-3) << "the last column of the second camera, which stands at x = 0.1";
}

TEST_F(Samples, LiveGrabbersAreFusedByTheStampsOfTheirClouds) {
  ASSERT_TRUE(succeeded(runProgram(FUSE_FLOW_EXPORT_TOOL, {recording(), "-o", out(), "--fps", "5"})));
  const ToolResult result = runProgram(FUSE_FLOW_SAMPLE_LIVE, {out("out/camera_0"), out("out/camera_1")});
  ASSERT_TRUE(succeeded(result));
  std::vector<std::string> lines = linesOf(result.out);
  ASSERT_GE(lines.size(), 3u) << result.out;
  int lost = 0;
  for (const char* camera : {"out/camera_0", "out/camera_1"}) {
    const std::string& line = lines[lines.size() - (camera == std::string("out/camera_0") ? 2 : 1)];
    ASSERT_EQ(line.find(out(camera) + ": 3 clouds, "), 0u) << result.out;
    int fused = 0, unmatched = 0, late = 0, overrun = 0;
    const char* pattern = "%d fused; lost: %d unmatched, %d late, %d overrun";
    const std::string counts = line.substr(line.find("clouds, ") + 8);
    ASSERT_EQ(std::sscanf(counts.c_str(), pattern, &fused, &unmatched, &late, &overrun), 4) << line;
    EXPECT_EQ(fused + unmatched + late + overrun, 3) << line;
    lost += unmatched + late + overrun;
  }
  lines.resize(lines.size() - 2);
  // A machine that stands still for a while loses frames, as a live one would: it says how many, and keeps their order.
  const std::vector<std::string> stamps{"0 us", "200000 us", "400000 us"};
  std::size_t last = 0;
  int complete = 0;
  for (const std::string& line : lines) {
    const std::string stamp = line.substr(0, line.find(':'));
    const auto at = std::find(stamps.begin(), stamps.end(), stamp);
    ASSERT_NE(at, stamps.end()) << line;
    const std::size_t position = static_cast<std::size_t>(at - stamps.begin()) + 1;
    EXPECT_GT(position, last) << result.out;
    last = position;
    EXPECT_NE(line.find(", 0 us apart, "), std::string::npos) << line;
    if (line.find(": 2 of 2 cameras, ") != std::string::npos) ++complete;
    EXPECT_GT(std::stoi(line.substr(line.find("apart, ") + 7)), 500) << line;
  }
  EXPECT_GE(complete + lost, 3) << "what is not complete is told\n" << result.out;
  EXPECT_LE(complete + (lost + 1) / 2, 3) << "and nothing else\n" << result.out;
}

TEST_F(Samples, ALiveCameraThatEndsIsMissingAndAFolderWithoutFilesIsNamed) {
  ASSERT_TRUE(succeeded(runProgram(FUSE_FLOW_EXPORT_TOOL, {recording(), "-o", out()})));
  fs::remove(out_ / "camera_1/000000033333.pcd");
  fs::remove(out_ / "camera_1/000000066667.pcd");
  const ToolResult result = runProgram(FUSE_FLOW_SAMPLE_LIVE, {out("out/camera_0"), out("out/camera_1")});
  ASSERT_TRUE(succeeded(result));
  EXPECT_NE(result.out.find("1 of 2 cameras"), std::string::npos) << "after the only cloud of the second\n"
                                                                  << result.out;
  fs::remove(out_ / "camera_1/000000000000.pcd");
  const ToolResult empty = runProgram(FUSE_FLOW_SAMPLE_LIVE, {out("out/camera_0"), out("out/camera_1")});
  EXPECT_EQ(empty.exit_code, 1);
  EXPECT_NE(empty.err.find("camera_1: is no folder of .pcd files"), std::string::npos) << empty.err;
}

TEST_F(Samples, ALiveSourceThatIsNotThereIsNamedInOneLine) {
  for (const std::string& source : {std::string("#7"), out("nowhere")}) {
    const ToolResult result = runProgram(FUSE_FLOW_SAMPLE_LIVE, {source});
    EXPECT_EQ(result.exit_code, 1);
    const std::string line = "sample_live: " + source + ": ";
    ASSERT_NE(result.err.find(line), std::string::npos) << result.err;
    const std::string why = result.err.substr(result.err.find(line) + line.size());
    EXPECT_TRUE(why == "there is no such OpenNI2 device\n" || why == "is no folder of .pcd files\n") << result.err;
  }
}

TEST_F(Samples, WithoutArgumentsTheyTellTheirUsage) {
  for (const char* sample : {FUSE_FLOW_SAMPLE_PCL_PIPELINE, FUSE_FLOW_SAMPLE_VISUALIZE, FUSE_FLOW_SAMPLE_LIVE}) {
    const ToolResult result = runProgram(sample, {});
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_NE(result.err.find("usage: " + fs::path(sample).filename().string()), std::string::npos) << result.err;
  }
}

}  // namespace
}  // namespace tool_test
