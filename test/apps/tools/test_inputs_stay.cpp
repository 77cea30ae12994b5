#include "support/png_file.h"
#include "support/tool_fixture.h"

#include <map>

namespace tool_test {
namespace {

/** \brief No output of any tool takes the place of what a recording is made of. */
class InputsStay : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    const WallRecording wall{};
    wall.write(folder_ / "rig");
    writeText(folder_ / "rig/truth/simulation.json", "{}");
    writeText(folder_ / "rig/truth/moving/000000.ply", "a mesh");
    writeText(folder_ / "rig/truth/notes", "of someone");
    writeText(folder_ / "rig/camera_1/confidence/000000.png", samplesPng(32, 24, 8, 0, std::string(32 * 24, '\xff')));

    const std::string depth = readText(depthFile(folder_ / "rig", 0, 0)), pose = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
    for (const char* name : {"redwood/depth/0.png", "redwood/depth/1.png"}) writeText(folder_ / name, depth);
    writeText(folder_ / "redwood/color/0.png", colorPng(32, 24, 1, 2, 3));
    writeText(folder_ / "redwood/trajectory.log", "0 0 1\n" + pose + "1 1 2\n" + pose);
    writeText(folder_ / "redwood/odometry.log", "0 0 1\n" + pose);
    writeText(folder_ / "redwood/camera.json",
              R"({"width": 32, "height": 24, "intrinsic_matrix": [32, 0, 0, 0, 32, 0, 15.5, 11.5, 1]})");

    writeText(folder_ / "seven/camera-intrinsics.txt", "32 0 15.5\n0 32 11.5\n0 0 1\n");
    for (const char* frame : {"seven/frame-000000", "seven/frame-000001"}) {
      writeText(folder_ / (frame + std::string(".depth.png")), depth);
      writeText(folder_ / (frame + std::string(".pose.txt")), pose);
    }
    for (const char* image : {"tum/depth/0.png", "tum/depth/1.png", "elsewhere/0.png"})
      writeText(folder_ / image, depthPngOfTum());
    writeText(folder_ / "tum/depth.txt", "1.0 depth/0.png\n9.0 ../elsewhere/0.png\n");
    writeText(folder_ / "tum/groundtruth.txt", "1.0 0 0 0 0 0 0 1\n");
  }

  static std::string depthPngOfTum();

  /** \brief Runs a tool that must refuse, and leave every file as it was. */
  void expectRefused(const std::string& tool, std::vector<std::string> arguments, const std::string& option,
                     const std::string& output) {
    arguments.insert(arguments.end(), {option, output});
    const auto before = contents();
    EXPECT_TRUE(isOneLineError(runProgram(tool, arguments), 2, {option, output, "is an input"})) << tool;
    EXPECT_TRUE(contents() == before) << tool << ' ' << option << ' ' << output;
  }
  std::map<std::string, std::string> contents() const {
    std::map<std::string, std::string> files;
    for (const std::string& name : listing(folder_))
      if (fs::is_regular_file(folder_ / name)) files[name] = readText(folder_ / name);
    return files;
  }
};

std::string InputsStay::depthPngOfTum() {
  const WallRecording wall{1, 1, 640, 480, false};
  static const std::string bytes = [&] {
    std::string pattern = (fs::temp_directory_path() / "fuse_flow_tum_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error(pattern);
    wall.write(pattern);
    std::string image = readText(depthFile(pattern, 0, 0));
    fs::remove_all(pattern);
    return image;
  }();
  return bytes;
}

TEST_F(InputsStay, OfARigWithAllItsCamerasAndItsTruth) {
  for (const char* name : {"rig.json", "camera_0/depth/000001.png", "camera_1/color/000000.png",
                           "camera_1/confidence/000000.png", "truth/simulation.json", "truth/moving/000000.ply",
                           "truth/notes", "truth/new.ply", "camera_1/depth/000007.png"}) {
    const std::string file = out(std::string("rig/") + name);
    // Of one camera and one frame: the others belong to the recording as well.
    expectRefused(FUSE_FLOW_FUSE_TOOL, {out("rig"), "--views", "0", "--frames", "0", "-o", out("a.ply")}, "--report",
                  file);
    expectRefused(FUSE_FLOW_CALIBRATE_TOOL, {out("rig")}, "-o", file);
    expectRefused(FUSE_FLOW_CALIBRATE_TOOL, {out("rig"), "-o", out("new.json")}, "--json", file);
  }
  expectRefused(FUSE_FLOW_FUSE_TOOL, {out("rig"), "--frames", "0"}, "-o", out("rig/truth/moving/000000.ply"));
  ASSERT_TRUE(succeeded(fuse({out("rig"), "--frames", "0", "-o", out("a.ply")})));
  expectRefused(FUSE_FLOW_EVALUATE_TOOL, {out("rig"), out("a.ply")}, "--json", out("rig/truth/simulation.json"));
  expectRefused(FUSE_FLOW_EVALUATE_TOOL, {out("rig"), out("a.ply")}, "--json", out("a.ply"));
}

TEST_F(InputsStay, OfFoldersOfOtherDatasets) {
  for (const auto& [folder, name] :
       std::vector<std::pair<std::string, std::string>>{{"redwood", "camera.json"},
                                                        {"redwood", "trajectory.log"},
                                                        {"redwood", "odometry.log"},
                                                        {"redwood", "depth/1.png"},
                                                        {"redwood", "color/0.png"},
                                                        {"seven", "camera-intrinsics.txt"},
                                                        {"seven", "frame-000001.pose.txt"},
                                                        {"seven", "frame-000001.depth.png"},
                                                        {"tum", "groundtruth.txt"},
                                                        {"tum", "depth.txt"},
                                                        {"tum", "depth/1.png"},
                                                        {"tum", "../elsewhere/0.png"}}) {
    const std::string file = (folder_ / folder / name).string();
    expectRefused(FUSE_FLOW_FUSE_TOOL, {out(folder), "--views", "0", "-o", out("a.ply")}, "--report", file);
    expectRefused(FUSE_FLOW_CALIBRATE_TOOL, {out(folder), "--views", "0"}, "-o", file);
  }
}

TEST_F(InputsStay, ThatThePosesCameFrom) {
  fs::copy_file(folder_ / "rig/rig.json", folder_ / "poses.json");
  const std::vector<std::string> arguments{out("rig"), "--poses", out("poses.json")};
  expectRefused(FUSE_FLOW_CALIBRATE_TOOL, arguments, "-o", out("poses.json"));
  fs::create_symlink(folder_ / "poses.json", folder_ / "link.json");
  expectRefused(FUSE_FLOW_CALIBRATE_TOOL, arguments, "-o", out("link.json"));
}

TEST_F(InputsStay, OfPcdFilesThatAreExportedOntoThemselves) {
  ASSERT_TRUE(succeeded(runProgram(FUSE_FLOW_EXPORT_TOOL, {out("rig"), "-o", out("pcd"), "--views", "0"})));
  const fs::path exported = folder_ / "pcd/camera_0/000000000000.pcd";
  ASSERT_TRUE(fs::exists(exported));
  const std::string own = out("own/000000000000/000000000000.pcd");
  writeText(own, readText(exported));
  const std::string before = readText(own);
  EXPECT_TRUE(
      isOneLineError(runProgram(FUSE_FLOW_EXPORT_TOOL, {own, "-o", out("own")}), 2, {"-o", own, "is an input"}));
  EXPECT_EQ(readText(own), before);
}

TEST_F(InputsStay, AndOutputsThatAreNoneOfThemMayLieBesideThem) {
  for (int run = 0; run < 2; ++run) {  // the second replaces what the first wrote
    EXPECT_TRUE(succeeded(fuse({out("rig"), "-o", out("rig/clouds"), "--report", out("rig/report.json")})));
    EXPECT_TRUE(succeeded(
        fuse({out("redwood"), "--views", "0", "-o", out("redwood/a.ply"), "--report", out("redwood/report.json")})));
    EXPECT_TRUE(succeeded(fuse({out("seven"), "--views", "0", "-o", out("seven/a.ply")})));
    EXPECT_TRUE(succeeded(evaluate({out("rig"), out("rig/clouds"), "--json", out("rig/clouds/figures.json")})));
  }
}

TEST_F(InputsStay, AndTwoOutputsAreNotOneFile) {
  EXPECT_TRUE(
      isOneLineError(runProgram(FUSE_FLOW_CALIBRATE_TOOL, {out("rig"), "-o", out("a.json"), "--json", out("a.json")}),
                     2, {"--json", "a.json", "must be another"}));
}

}  // namespace
}  // namespace tool_test
