#include "support/cloud_file.h"
#include "support/png_file.h"
#include "support/tool_fixture.h"

#include <sys/stat.h>

#include <cmath>
#include <sstream>

namespace tool_test {
namespace {

using BadRecording = ToolTest;

/** \brief Conditions that must hold for every wrong input of fuse_flow_fuse. */
#define EXPECT_REFUSED(arguments, ...)                            \
  EXPECT_TRUE(isOneLineError(fuse(arguments), 1, {__VA_ARGS__})); \
  EXPECT_EQ(listing(out_), std::vector<std::string>()) << "something was written"

#define FUSE_RECORDING (std::vector<std::string>{recording(), "-o", out()})

TEST_F(BadRecording, AnEmptyFolderIsNamedAndWhatIsReadIsListed) {
  fs::create_directory(recording_);
  EXPECT_REFUSED(FUSE_RECORDING, recording(), "empty", "rig.json", "7-Scenes", "TUM", "Redwood", ".pcd");
}

TEST_F(BadRecording, AFolderThatIsNotThereIsNamed) { EXPECT_REFUSED(FUSE_RECORDING, recording(), "not found"); }

TEST_F(BadRecording, AFolderOfSomethingElseIsNamed) {
  writeText(recording_ / "holiday.txt", "sun");
  EXPECT_REFUSED(FUSE_RECORDING, recording(), "not a recording", "rig.json");
}

TEST_F(BadRecording, ATruncatedImageIsNamedAtAnyLength) {
  const WallRecording wall{};
  wall.write(recording_);
  const fs::path path = depthFile(recording_, 1, 0);
  const std::string whole = readText(path);
  for (const std::size_t size : {std::size_t{0}, std::size_t{5}, std::size_t{20}, whole.size() / 2, whole.size() - 1}) {
    writeText(path, whole.substr(0, size));
    EXPECT_REFUSED(FUSE_RECORDING, path.string(), "PNG") << size;
  }
}

TEST_F(BadRecording, AnImageThatIsAPipeIsNamedAndNotWaitedFor) {
  for (const fs::path& path : {depthFile(recording_, 1, 0), colorFile(recording_, 1, 0)}) {
    WallRecording{}.write(recording_);
    fs::remove(path);
    ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
    EXPECT_REFUSED(FUSE_RECORDING, path.string(), "is a pipe", "must be a file");
    fs::remove_all(recording_);
  }
}

/** \brief Each has right chunks with right checksums around wrong data. */
TEST_F(BadRecording, AnImageDamagedInsideItsChunksIsNamed) {
  const WallRecording wall{};
  wall.write(recording_);
  const fs::path path = depthFile(recording_, 0, 0);
  const std::string header = pngHeader(wall.width, wall.height, 16, 0);
  const std::string rows(static_cast<std::size_t>(wall.height * (1 + 2 * wall.width)), '\0');
  const std::string filter_9 = "\x09" + rows.substr(1);
  const std::vector<std::pair<std::string, std::string>> damaged = {
      {"no image data", png(header)},
      {"data ends early", png(header + pngChunk("IDAT", zlibStored(rows).substr(0, 100)))},
      {"fewer rows than the header says", png(header + pngChunk("IDAT", zlibStored(rows.substr(0, 65))))},
      {"not compressed data", png(header + pngChunk("IDAT", "garbage"))},
      {"a filter that does not exist", png(header + pngChunk("IDAT", zlibStored(filter_9)))},
      {"a bit depth that does not exist",
       png(pngHeader(wall.width, wall.height, 16, 3) + pngChunk("IDAT", zlibStored(rows)))},
      {"a chunk that nobody knows", png(header + pngChunk("QQQQ", "x") + pngChunk("IDAT", zlibStored(rows)))},
  };
  for (const auto& [what, bytes] : damaged) {
    writeText(path, bytes);
    EXPECT_REFUSED(FUSE_RECORDING, path.string()) << what;
  }
}

TEST_F(BadRecording, ADamagedColorImageIsNamedWhetherPngOrJpeg) {
  WallRecording{}.write(recording_);
  const fs::path path = colorFile(recording_, 0, 0);
  const std::string jpeg_start = "\xff\xd8\xff\xe0", jpeg_end = "\xff\xd9";
  const std::vector<std::pair<std::string, std::string>> damaged = {
      {"neither", "GIF89a"},
      {"a PNG without data", png(pngHeader(32, 24, 8, 2))},
      {"a palette without colours",
       png(pngHeader(32, 24, 8, 3) + pngChunk("IDAT", zlibStored(std::string(24 * 33, '\0'))))},
      {"a JPEG cut short", jpeg_start + "abc"},
      {"a JPEG of nothing", jpeg_start + std::string("\x00\x04xy", 4) + jpeg_end},
      {"an empty file", ""},
  };
  for (const auto& [what, bytes] : damaged) {
    writeText(path, bytes);
    EXPECT_REFUSED(FUSE_RECORDING, path.string()) << what;
  }
}

TEST_F(BadRecording, ADepthImageWithoutDepthIsNamed) {
  const WallRecording wall{};
  wall.write(recording_);
  const fs::path path = depthFile(recording_, 0, 0);
  writeText(path, colorPng(wall.width, wall.height, 1, 2, 3));
  EXPECT_REFUSED(FUSE_RECORDING, path.string(), "8-bit RGB", "16-bit grey");
}

TEST_F(BadRecording, ColorOfAnotherSizeNeedsAColorCamera) {
  WallRecording{}.write(recording_);
  const fs::path path = colorFile(recording_, 1, 0);
  writeText(path, colorPng(64, 48, 200, 100, 50));
  EXPECT_REFUSED(FUSE_RECORDING, path.string(), "64x48", "32x24", "camera_1");
}

TEST_F(BadRecording, ColorOfAnotherSizeIsReadWithAColorCamera) {
  const WallRecording wall{};
  wall.write(recording_);
  nlohmann::json rig = wall.rig();
  for (std::size_t k = 0; k < wall.cameras; ++k) {
    nlohmann::json& color = rig["cameras"][k]["color"];
    color = {{"width", 64}, {"height", 48}, {"fx", 60}, {"fy", 60}, {"cx", 31.5}, {"cy", 23.5}};
    color["T_depth_color"] = {1, 0, 0, 0.02, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    for (std::size_t frame = 0; frame < wall.frames; ++frame)
      writeText(colorFile(recording_, k, frame), colorPng(64, 48, 10, 20, 30));
  }
  writeText(recording_ / "rig.json", rig.dump());
  ASSERT_TRUE(succeeded(fuse(FUSE_RECORDING)));
  const std::vector<FilePoint> points = readCloudFile(out_ / "000000.ply");
  ASSERT_FALSE(points.empty());
  EXPECT_TRUE(std::any_of(points.begin(), points.end(), [](const FilePoint& p) { return p.r == 10 && p.g == 20; }));
}

TEST_F(BadRecording, AnImageOfAnotherSizeThanItsCameraIsNamedWithBothSizes) {
  WallRecording{}.write(recording_);
  const fs::path path = depthFile(recording_, 1, 0);
  writeText(path, depthPng(16, 12, std::vector<std::uint16_t>(16 * 12, 2000)));
  EXPECT_REFUSED(FUSE_RECORDING, path.string(), "16x12", "32x24", "camera_1");
}

/** \brief Everything that can be wrong with a camera names the file, the camera, the key and what it must be. */
TEST_F(BadRecording, ACameraThatIsWrongIsNamedWithItsKey) {
  const WallRecording wall{};
  wall.write(recording_);
  struct Case {
    const char* key;
    nlohmann::json value;
    const char* expected;
  };
  const std::vector<Case> cases = {
      {"T_world_camera", {1.5, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "rigid"},
      {"T_world_camera", {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "rigid"},
      {"T_world_camera", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1}, "0 0 0 1"},
      {"T_world_camera", {1, 0, 0, 1e7, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "50000 m or less"},
      {"T_world_camera", {1, 0, 0}, "16"},
      {"T_world_camera", "here", "16 numbers"},
      {"fx", 0, "positive"},
      {"fx", -1, "positive"},
      {"fx", "wide", "number"},
      {"fx", 1e300, "fx"},
      {"fx", 1e-30, "a thousandth"},
      {"fy", 0, "positive"},
      {"cx", 1e300, "finite"},
      {"depth_scale", 0, "positive"},
      {"depth_scale", 1e300, "depth_scale"},
      {"width", 31.5, "whole number"},
      {"height", 0, "positive"},
      {"distortion", {1, 2}, "8"},
      {"color", 3, "object"},
      {"depth_correction", 3, "object"},
      {"depth_correction", {{"columns", 2}, {"rows", 2}, {"relative", {0, 0, 0, 0}}}, "per_metre"},
      {"depth_correction", {{"columns", 2}, {"rows", 2}, {"relative", {0, 0}}, {"per_metre", {0, 0, 0, 0}}}, "4"},
      {"depth_correction",
       {{"columns", 2}, {"rows", 2}, {"relative", {0, 9, 0, 0}}, {"per_metre", {0, 0, 0, 0}}},
       "0.5"},
      {"depth_correction", {{"columns", 1}, {"rows", 2}, {"relative", {0, 0}}, {"per_metre", {0, 0}}}, "2x2 to 64x64"},
      {"multipath", 3, "object"},
      {"multipath", nlohmann::json::object(), "modulation_frequency"},
      {"multipath", {{"modulation_frequency", 200}}, "1e6 to 1e9"},
      {"multipath", {{"modulation_frequency", 200e6}, {"reflectance", 1.5}}, "(0, 1]"},
      {"depth_correction", {{"columns", 65535}, {"rows", 65535}, {"relative", {0}}, {"per_metre", {0}}}, "numbers"},
  };
  for (const Case& c : cases) {
    nlohmann::json rig = wall.rig();
    rig["cameras"][1][c.key] = c.value;
    writeText(recording_ / "rig.json", rig.dump());
    EXPECT_REFUSED(FUSE_RECORDING, "rig.json", "camera_1", c.key, c.expected) << c.key << " " << c.value;
  }
}

TEST_F(BadRecording, AKeyThatIsMissingIsNamedWithWhatItMustHold) {
  const WallRecording wall{};
  wall.write(recording_);
  for (const auto& [key, expected] : std::vector<std::pair<std::string, std::string>>{{"T_world_camera", "16 numbers"},
                                                                                      {"fx", "number"},
                                                                                      {"cy", "number"},
                                                                                      {"width", "number"},
                                                                                      {"depth_scale", "number"}}) {
    nlohmann::json rig = wall.rig();
    rig["cameras"][1].erase(key);
    writeText(recording_ / "rig.json", rig.dump());
    EXPECT_REFUSED(FUSE_RECORDING, "rig.json", "camera_1", key, "missing", expected);
  }
}

TEST_F(BadRecording, AFileThatIsNotARigIsNamed) {
  WallRecording{}.write(recording_);
  for (const char* text :
       {"", "{\"cameras\": [", "null", "[]", "{\"cameras\": []}", "{\"cameras\": [3]}",
        "{\"cameras\": [{\"name\": 1e999}]}", "{\"cameras\": [{\"name\": \"../up\"}]}", "\xff\xfe"}) {
    writeText(recording_ / "rig.json", text);
    EXPECT_REFUSED(FUSE_RECORDING, "rig.json") << text;
  }
}

TEST_F(BadRecording, TwoCamerasOfOneNameAreRefused) {
  const WallRecording wall{};
  wall.write(recording_);
  nlohmann::json rig = wall.rig();
  rig["cameras"][1]["name"] = "camera_0";
  writeText(recording_ / "rig.json", rig.dump());
  EXPECT_REFUSED(FUSE_RECORDING, "rig.json", "camera_0", "another camera");
}

TEST_F(BadRecording, WithoutAnyDepthImageItIsSaidWhereOneBelongs) {
  const WallRecording wall{};
  writeText(recording_ / "rig.json", wall.rig().dump());
  EXPECT_REFUSED(FUSE_RECORDING, "rig.json", depthFile(recording_, 0, 0).string());
}

TEST_F(BadRecording, FramesBeforeTheBadOneStay) {
  WallRecording wall{};
  wall.frames = 3;
  wall.write(recording_);
  const fs::path bad = depthFile(recording_, 0, 1);
  writeText(bad, "");
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out(), "--report", out("report.json")}), 1, {bad.string()}));
  EXPECT_EQ(listing(out_), std::vector<std::string>{"000000.ply"});
  EXPECT_FALSE(readCloudFile(out_ / "000000.ply").empty());
  EXPECT_FALSE(fs::exists(out("report.json")));
}

TEST_F(BadRecording, AFrameThatEveryCameraMissedIsLeftOutAndNamed) {
  WallRecording wall{};
  wall.frames = 3;
  wall.write(recording_);
  for (std::size_t k = 0; k < wall.cameras; ++k) fs::remove(depthFile(recording_, k, 1));
  const ToolResult result = fuse({recording(), "-o", out(), "--report", out("report.json")});
  ASSERT_TRUE(succeeded(result));
  EXPECT_NE(result.err.find("1 frames between 000000 and 000002 are left out"), std::string::npos) << result.err;
  EXPECT_EQ(listing(out_), (std::vector<std::string>{"000000.ply", "000002.ply"}));
  EXPECT_FALSE(readCloudFile(out_ / "000002.ply").empty());
  const nlohmann::json report = nlohmann::json::parse(readText(out("report.json")));
  ASSERT_EQ(report["frames"].size(), 2u);
  EXPECT_EQ(report["frames"][1]["frame"], 2);
  EXPECT_TRUE(
      isOneLineError(fuse({recording(), "-o", out(), "--frames", "1"}), 2, {"--frames 1", "only 2 frames: 0, 2"}));
}

TEST_F(BadRecording, ACameraThatMissedAFrameLeavesTheOthers) {
  const WallRecording wall{};
  wall.write(recording_);
  fs::remove(depthFile(recording_, 0, 0));
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out(), "--report", out("report.json")})));
  EXPECT_FALSE(readCloudFile(out_ / "000000.ply").empty());
  const nlohmann::json report = nlohmann::json::parse(readText(out("report.json")));
  EXPECT_EQ(report["frames"][0]["missing_cameras"], nlohmann::json{0});
  EXPECT_EQ(report["frames"][0]["points_in"], wall.width * wall.height);
}

/** \brief Its folder is missing, or its files are misnamed: the others are fused, and the summary names the camera. */
TEST_F(BadRecording, ACameraWithoutImagesIsNamedInTheSummary) {
  const WallRecording wall{};
  wall.write(recording_);
  fs::rename(depthFile(recording_, 0, 0), recording_ / "camera_0" / "depth" / "first.png");
  fs::remove_all(recording_ / "camera_1");
  const ToolResult result = fuse(FUSE_RECORDING);
  ASSERT_TRUE(succeeded(result));
  EXPECT_NE(result.err.find("begins at frame 000001"), std::string::npos) << result.err;
  EXPECT_NE(result.out.find("camera camera_1 missed 1 of 1 frames\n  camera 'camera_1' has no depth images\n"),
            std::string::npos)
      << result.out;
}

TEST_F(BadRecording, ACameraWhoseFilesEndEarlyIsNamedInTheSummary) {
  WallRecording wall{};
  wall.frames = 3;
  wall.write(recording_);
  fs::remove(depthFile(recording_, 1, 2));
  const ToolResult result = fuse(FUSE_RECORDING);
  ASSERT_TRUE(succeeded(result));
  EXPECT_NE(result.out.find("camera camera_1 missed 1 of 3 frames\n  camera 'camera_1' ends after 2 of 3 frames\n"),
            std::string::npos)
      << result.out;
}

TEST_F(BadRecording, DepthOfAllZeroIsAnEmptyCloud) {
  WallRecording wall{};
  wall.frames = 1;
  wall.write(recording_);
  for (std::size_t k = 0; k < wall.cameras; ++k)
    writeText(depthFile(recording_, k, 0), depthPng(wall.width, wall.height, std::vector<std::uint16_t>(32 * 24, 0)));
  for (const char* method : {"fuse_flow", "concatenate", "voxel_grid", "approximate_voxel_grid"}) {
    ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("zero.ply"), "--method", method}))) << method;
    EXPECT_TRUE(readCloudFile(out("zero.ply")).empty()) << method;
  }
}

TEST_F(BadRecording, ACameraWithTheWrongUnitIsNamedInTheSummary) {
  WallRecording wall{};
  wall.frames = 1;
  wall.write(recording_);
  std::string rig = readText(recording_ / "rig.json");
  const std::size_t scale = rig.find("0.001");
  ASSERT_NE(scale, std::string::npos);
  rig.replace(scale, 5, "1000 ");
  writeText(recording_ / "rig.json", rig);
  const ToolResult result = fuse({recording(), "-o", out("one.ply")});
  ASSERT_TRUE(succeeded(result));
  EXPECT_NE(result.out.find("camera 'camera_0' measures nothing within 0.1 to 20 m"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("with a depth_scale of 1000 m\n"), std::string::npos) << result.out;
  EXPECT_EQ(result.out.find("camera 'camera_1'"), std::string::npos) << result.out;
}

TEST_F(BadRecording, AFolderThatCannotBeReadIsNamed) {
  WallRecording wall{};
  wall.write(recording_);
  fs::remove_all(recording_ / "camera_1" / "depth");
  fs::create_symlink("depth", recording_ / "camera_1" / "depth");
  EXPECT_REFUSED(FUSE_RECORDING, "camera_1/depth", "cannot be looked at");
}

TEST_F(BadRecording, OneCameraIsEnough) {
  WallRecording wall{};
  wall.cameras = 1;
  wall.frames = 1;
  wall.write(recording_);
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("one.ply")})));
  const std::vector<FilePoint> points = readCloudFile(out("one.ply"));
  ASSERT_FALSE(points.empty());
  for (const FilePoint& p : points) EXPECT_EQ(p.view_count, 1u);
}

TEST_F(BadRecording, TwoIdenticalCamerasAgree) {
  WallRecording wall{};
  wall.frames = 1;
  wall.write(recording_);
  nlohmann::json rig = wall.rig();
  rig["cameras"][1]["T_world_camera"] = rig["cameras"][0]["T_world_camera"];
  writeText(recording_ / "rig.json", rig.dump());
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("two.ply")})));
  const std::vector<FilePoint> points = readCloudFile(out("two.ply"));
  ASSERT_FALSE(points.empty());
  for (const FilePoint& p : points) {
    EXPECT_NEAR(p.z, WallRecording::wallDistance(0), 1e-3);
    EXPECT_EQ(p.view_count, 2u);
  }
}

TEST_F(BadRecording, SixtyFourCamerasAreFused) {
  WallRecording wall{};
  wall.cameras = 64;
  wall.frames = 1;
  wall.width = 16;
  wall.height = 12;
  wall.write(recording_);
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("many.ply"), "--report", out("report.json")})));
  const std::vector<FilePoint> points = readCloudFile(out("many.ply"));
  ASSERT_FALSE(points.empty());
  for (const FilePoint& p : points) EXPECT_NEAR(p.z, WallRecording::wallDistance(0), 1e-3);
  EXPECT_EQ(nlohmann::json::parse(readText(out("report.json")))["frames"][0]["points_in"], 64 * 16 * 12);
}

/** \brief Depth of 2000 units, each of them 5 km. */
TEST_F(BadRecording, APointTenMillionMetresAwayIsOutOfRangeOrRefused) {
  WallRecording wall{};
  wall.frames = 1;
  wall.write(recording_);
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("far.ply"), "--depth-scale", "5000"})));
  EXPECT_TRUE(readCloudFile(out("far.ply")).empty());
  ASSERT_TRUE(succeeded(fuse(
      {recording(), "-o", out("far.ply"), "--depth-scale", "5000", "--max-range", "1e8", "--method", "concatenate"})));
  const std::vector<FilePoint> points = readCloudFile(out("far.ply"));
  ASSERT_FALSE(points.empty());
  for (const FilePoint& p : points) EXPECT_NEAR(p.z, 1e7, 1);
  fs::remove(out("far.ply"));
  // Cells this far away have no number.
  EXPECT_TRUE(isOneLineError(
      fuse({recording(), "-o", out("far.ply"), "--depth-scale", "5000", "--max-range", "1e8", "--max-noise", "0"}), 1,
      {recording(), "frame 0", "1e+07", "0.064 m", "must be nearer", "--max-range", "--cell-size"}));
  EXPECT_FALSE(fs::exists(out("far.ply")));
  // PCL's grids would return their input with a warning, or overflow.
  for (const char* method : {"voxel_grid", "approximate_voxel_grid", "outlier_removal"}) {
    EXPECT_TRUE(isOneLineError(
        fuse({recording(), "-o", out("grid.ply"), "--depth-scale", "5000", "--max-range", "1e8", "--method", method}),
        2, {"--leaf-size", "0.01", "32 bits"}));
    EXPECT_FALSE(fs::exists(out("grid.ply")));
  }
}

/** \brief A wall at z = 2 m as a depth sensor's driver delivers it, 32×24 points in rows. */
std::string organisedPcd(const std::vector<std::pair<std::size_t, std::string>>& replaced = {}) {
  std::vector<std::string> points;
  for (int v = 0; v < 24; ++v)
    for (int u = 0; u < 32; ++u) {
      std::ostringstream point;
      point << 2 * (u - 15.5) / 32 << ' ' << 2 * (v - 11.5) / 32 << " 2";
      points.push_back(point.str());
    }
  for (const auto& [index, text] : replaced) points[index] = text;
  std::string pcd =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 32\nHEIGHT 24\n"
      "VIEWPOINT 0.1 0 0 1 0 0 0\nPOINTS 768\nDATA ascii\n";
  for (const std::string& point : points) pcd += point + "\n";
  return pcd;
}

TEST_F(BadRecording, PointsThatAreNotFiniteOrFarAwayAreLeftOut) {
  const fs::path clean = folder_ / "clean.pcd", dirty = folder_ / "dirty.pcd";
  writeText(clean, organisedPcd());
  writeText(dirty, organisedPcd({{3, "nan nan nan"},
                                 {100, "inf 0 2"},
                                 {200, "0 0 inf"},
                                 {201, "0 0 -inf"},
                                 {300, "0 nan 2"},
                                 {400, "0 -312500 10000000"}}));
  for (const char* method : {"fuse_flow", "concatenate", "voxel_grid", "approximate_voxel_grid"}) {
    ASSERT_TRUE(succeeded(
        fuse({dirty.string(), clean.string(), "-o", out("c.ply"), "--method", method, "--report", out("report.json")})))
        << method;
    const std::vector<FilePoint> points = readCloudFile(out("c.ply"));
    ASSERT_FALSE(points.empty()) << method;
    for (const FilePoint& p : points) EXPECT_NEAR(p.z, 2, 1e-3) << method;
    EXPECT_EQ(nlohmann::json::parse(readText(out("report.json")))["frames"][0]["points_in"], 768 + 768 - 6) << method;
  }
}

TEST_F(BadRecording, ADamagedPcdIsNamed) {
  const fs::path path = folder_ / "cloud.pcd";
  const std::string whole = organisedPcd();
  const auto replaced = [&](const std::string& before, const std::string& after) {
    std::string text = whole;
    return text.replace(text.find(before), before.size(), after);
  };
  const std::vector<std::pair<std::string, std::string>> damaged = {
      {"empty", ""},
      {"a PLY", "ply\nformat ascii 1.0\nelement vertex 0\nend_header\n"},
      {"only a header", whole.substr(0, whole.find("DATA"))},
      {"cut short", whole.substr(0, whole.size() / 2)},
      {"no z", replaced("FIELDS x y z", "FIELDS x y w")},
      {"binary data that is not there", replaced("DATA ascii", "DATA binary").substr(0, 300)},
      {"compressed data that is not there", replaced("DATA ascii", "DATA binary_compressed").substr(0, 300)},
      {"more points than the file holds", replaced("WIDTH 32\nHEIGHT 24", "WIDTH 320\nHEIGHT 240")},
  };
  for (const auto& [what, bytes] : damaged) {
    writeText(path, bytes);
    EXPECT_REFUSED((std::vector<std::string>{path.string(), "-o", out()}), path.string()) << what;
  }
}

/** \brief Without rows and columns nothing tells which rays were measured: a plain cloud, which is said. */
TEST_F(BadRecording, AnUnorganisedPcdIsAPlainCloud) {
  std::string text = organisedPcd();
  text.replace(text.find("WIDTH 32"), 18, "WIDTH 768\nHEIGHT 1");
  writeText(folder_ / "cloud.pcd", text);
  const std::string cloud = (folder_ / "cloud.pcd").string();
  const ToolResult result = fuse({cloud, "-o", out("c.ply")});
  ASSERT_TRUE(succeeded(result));
  EXPECT_NE(result.err.find("clouds without their images"), std::string::npos) << result.err;
  EXPECT_FALSE(readCloudFile(out("c.ply")).empty());
  EXPECT_NE(result.out.find("the clouds must be in metres"), std::string::npos)
      << result.out;  // one point in each cell
  const ToolResult cropped =
      fuse({cloud, "-o", out("e.ply"), "--crop-box", "-1", "-1", "0", "1", "1", "2", "--cell-size", "1"});
  ASSERT_TRUE(succeeded(cropped));
  EXPECT_NE(cropped.err.find("--crop-box has no effect"), std::string::npos) << cropped.err;
  EXPECT_EQ(cropped.err.find("--cell-size"), std::string::npos) << cropped.err;
  const auto refused = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {cloud, "-o", out("d.ply")});
    return isOneLineError(fuse(more), 2, {more[3], "is a cloud"});
  };
  EXPECT_TRUE(refused({"--method", "voxel_grid"}));
  EXPECT_TRUE(refused({"--views", "0"}));
  EXPECT_FALSE(fs::exists(out("d.ply")));
}

TEST_F(BadRecording, ACloudToEvaluateThatIsDamagedIsNamed) {
  WallRecording wall{};
  wall.frames = 1;
  wall.write(recording_);
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("good.ply")})));
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("good.pcd")})));
  for (const char* extension : {".ply", ".pcd"}) {
    const std::string whole = readText(out(std::string("good") + extension));
    const std::string path = out(std::string("bad") + extension);
    for (const std::size_t size :
         {std::size_t{0}, std::size_t{30}, std::size_t{150}, whole.size() / 2, whole.size() - 1}) {
      writeText(path, whole.substr(0, size));
      EXPECT_TRUE(isOneLineError(evaluate({recording(), path}), 1, {path})) << extension << " " << size;
    }
  }
  EXPECT_TRUE(isOneLineError(evaluate({recording(), out("none.ply")}), 1, {"not found, must be a .ply or .pcd file"}));
  for (const char* name : {"none.ply", "recording/rig.json", "recording"})
    EXPECT_TRUE(isOneLineError(evaluate({recording(), out(name)}), 1, {out(name)})) << name;
}

}  // namespace
}  // namespace tool_test
