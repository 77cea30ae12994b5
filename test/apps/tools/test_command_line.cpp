#include "../../sanitized.h"
#include "support/cloud_file.h"
#include "support/tool_fixture.h"

#include <regex>

namespace tool_test {
namespace {

class CommandLine : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    WallRecording wall{};
    wall.cameras = 3;
    wall.frames = 5;
    wall.write(recording_);
  }

  /** \brief fuse_flow_fuse RECORDING -o OUT with these as well. */
  ToolResult fuseWith(const std::vector<std::string>& more, const RunOptions& options = {}) const {
    std::vector<std::string> arguments{recording(), "-o", out()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return fuse(arguments, options);
  }

  /** \brief The command line is refused, and nothing was written. */
  void expectWrong(const std::vector<std::string>& more, const std::vector<std::string>& words) const {
    EXPECT_TRUE(isOneLineError(fuseWith(more), 2, words)) << testing::PrintToString(more);
    EXPECT_FALSE(fs::exists(out_)) << testing::PrintToString(more);
  }
};

TEST_F(CommandLine, HelpIsASuccessAndListsTheOptions) {
  for (const ToolResult& result : {fuse({"--help"}), evaluate({"--help"})}) {
    EXPECT_TRUE(succeeded(result));
    EXPECT_NE(result.out.find("--max-range"), std::string::npos);
  }
}

TEST_F(CommandLine, TheVersionIsOneLine) {
  const ToolResult result = fuse({"--version"});
  EXPECT_TRUE(succeeded(result));
  EXPECT_TRUE(std::regex_match(result.out, std::regex("fuse_flow_fuse [0-9]+\\.[0-9]+\\.[0-9]+\n"))) << result.out;
}

TEST_F(CommandLine, TheVerboseVersionSaysWhatAReportOfABugNeeds) {
  for (const ToolResult& result : {fuse({"--version", "--verbose"}), evaluate({"--verbose", "--version"}),
                                   runProgram(FUSE_FLOW_SIMULATE_TOOL, {"--version", "--verbose"})}) {
    EXPECT_TRUE(succeeded(result));
    for (const char* begin : {"build ", "system ", "CPU ", "GPU ", "libraries ", "with ", "without "})
      EXPECT_NE(result.out.find(std::string("\n") + begin), std::string::npos) << begin << " in " << result.out;
    for (const char* library : {"PCL ", "Eigen ", "VTK ", "Embree "})
      EXPECT_NE(result.out.find(library), std::string::npos) << library << " in " << result.out;
    EXPECT_EQ(result.out.find("\n\n"), std::string::npos) << result.out;
  }
}

TEST_F(CommandLine, VerboseIsOfTheVersionOnly) {
  EXPECT_TRUE(isOneLineError(fuseWith({"--verbose"}), 2, {"--verbose", "--version"}));
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(CommandLine, WhatIsMissingIsNamed) {
  EXPECT_TRUE(isOneLineError(fuse({}), 2, {"input", "required"}));
  EXPECT_TRUE(isOneLineError(fuse({recording()}), 2, {"--output", "required"}));
  EXPECT_TRUE(isOneLineError(evaluate({}), 2, {"recording", "required"}));
  EXPECT_TRUE(isOneLineError(evaluate({recording()}), 2, {"cloud", "required"}));
  expectWrong({"--sigma"}, {"--sigma"});
}

TEST_F(CommandLine, AFileWithoutANameIsRefused) {
  for (const char* option : {"--report", "--poses"}) {
    expectWrong({option, ""}, {option, "must be a file"});
    expectWrong({option, "--normals"}, {option});
  }
  EXPECT_TRUE(isOneLineError(evaluate({recording(), "a.ply", "--json", ""}), 2, {"--json", "must be a file"}));
}

TEST_F(CommandLine, AnUnknownOptionIsNamed) {
  expectWrong({"--sigmma", "0.02"}, {"--sigmma", "--help"});
  EXPECT_TRUE(isOneLineError(evaluate({recording(), "a.ply", "--sigma", "1"}), 2, {"--sigma", "--help"}));
}

TEST_F(CommandLine, TheDeviceIsChosenAndAMissingGpuIsAnErrorOfOneLine) {
  EXPECT_TRUE(succeeded(fuseWith({"--device", "cpu"})));
  fs::remove_all(out_);
  const ToolResult result = fuseWith({"--device", "gpu"});
  if (result.exit_code == 0) return;  // there is one
  EXPECT_TRUE(isOneLineError(result, 2, {"--device gpu", "--device cpu"}));
  EXPECT_FALSE(fs::exists(out_));
}

/** \brief Named as it is written on the command line, with the value and what it must be. */
TEST_F(CommandLine, AnOptionOutOfRangeIsNamed) {
  expectWrong({"--sigma", "-1"}, {"--sigma", "-1", "positive"});
  expectWrong({"--sigma", "nan"}, {"--sigma", "nan", "number"});
  expectWrong({"--sigma", "inf"}, {"--sigma", "inf", "number"});
  expectWrong({"--sigma", "wide"}, {"--sigma", "wide", "number"});
  expectWrong({"--sigma", ""}, {"--sigma"});
  expectWrong({"--tau", "1.5"}, {"--tau", "1.5", "[0, 1]"});
  expectWrong({"--max-incidence", "2"}, {"--max-incidence", "2", "1.57"});
  expectWrong({"--fill-neighbours", "2"}, {"--fill-neighbours", "2", "[3, 8]"});
  expectWrong({"--fill-neighbours", "3.5"}, {"--fill-neighbours", "3.5"});
  expectWrong({"--min-range", "5", "--max-range", "4"}, {"--max-range", "4", "--min-range", "5"});
  expectWrong({"--alpha", "0", "--gamma", "0"}, {"--alpha", "--gamma", "positive"});
  expectWrong({"--max-views", "1"}, {"--max-views", "1"});
  expectWrong({"--max-candidates", "0"}, {"--max-candidates", "0"});
  expectWrong({"--cell-size", "0"}, {"--cell-size", "0", "positive"});
  expectWrong({"--cell-size", "1e-30"}, {"--cell-size", "1e-30", "0.0001 m or more"});
  expectWrong({"--min-weight", "2"}, {"--min-weight", "2", "[0, 1]"});
  expectWrong({"--occlusion-form", "sometimes"}, {"--occlusion-form", "sometimes", "published", "occlusion_aware"});
  expectWrong({"--method", "magic"}, {"--method", "magic", "fuse_flow", "approximate_voxel_grid"});
  expectWrong({"--format", "xyz"}, {"--format", "xyz", "ply", "pcd"});
  expectWrong({"--leaf-size", "0"}, {"--leaf-size", "0", "positive"});
  expectWrong({"--leaf-size", "nan"}, {"--leaf-size", "nan"});
  expectWrong({"--crop-box", "1", "2", "3"}, {"--crop-box", "6"});
  expectWrong({"--crop-box", "1", "1", "1", "0", "0", "0"}, {"--crop-box", "min"});
  expectWrong({"--crop-box", "nan", "1", "1", "2", "2", "2"}, {"--crop-box"});
  expectWrong({"--device", "abacus"}, {"--device", "abacus", "cpu", "gpu"});
  expectWrong({"--method", "concatenate", "--device", "gpu"}, {"--device gpu", "concatenate"});
  expectWrong({"--threads", "-1"}, {"--threads", "-1"});
  expectWrong({"--threads", "100000"}, {"--threads", "100000"});
  expectWrong({"--depth-scale", "0"}, {"--depth-scale", "0", "positive"});
  expectWrong({"--depth-scale", "nan"}, {"--depth-scale", "nan"});
}

TEST_F(CommandLine, ALengthInMillimetresIsRefusedWithTheUnitThatIsMeant) {
  expectWrong({"--min-cell-size", "30"}, {"--min-cell-size is 30 m", "1 m or less", "30 mm are 0.03 m"});
  expectWrong({"--cell-size", "64"}, {"--cell-size is 64 m", "10 m or less"});
  expectWrong({"--cell-size", "3e38"}, {"--cell-size is 3e+38 m"});
  expectWrong({"--sigma", "20"}, {"--sigma is 20 m"});
  expectWrong({"--max-noise", "70"}, {"--max-noise is 70 m"});
  expectWrong({"--leaf-size", "20"}, {"--leaf-size", "20", "metres, 10 or less"});
  expectWrong({"--coverage-radius", "15"}, {"--coverage-radius", "15", "metres"});
  expectWrong({"--visibility", "50"}, {"--visibility", "50", "metres"});
  EXPECT_TRUE(isOneLineError(
      runProgram(FUSE_FLOW_CALIBRATE_TOOL, {recording(), "-o", out("r.json"), "--max-correspondence-distance", "250"}),
      2, {"--max-correspondence-distance", "250", "metres"}));
}

TEST_F(CommandLine, WhetherIsSaidInWordsOrNumbers) {
  const std::string help = fuse({"--help"}).out;
  // CLI11 writes BOOLEAN=true, and from 2.4 on BOOLEAN [true].
  for (const char* option : {"--adapt-noise BOOLEAN( \\[|=)true", "--bilateral BOOLEAN( \\[|=)false"})
    EXPECT_TRUE(std::regex_search(help, std::regex(option))) << option;
  expectWrong({"--adapt-noise", "maybe"}, {"--adapt-noise", "maybe", "true or false"});
  WallRecording{2, 1, 320, 240, false}.write(folder_ / "large");
  const auto scalesWith = [&](const std::string& value) {
    const ToolResult result = fuse(
        {out("large"), "-o", out("a.ply"), "--no-quality", "--adapt-noise", value, "--report", out("report.json")});
    EXPECT_TRUE(succeeded(result)) << value;
    return nlohmann::json::parse(readText(out("report.json")))["frames"][0]["noise_scales"];
  };
  for (const char* off : {"0", "false"}) EXPECT_EQ(scalesWith(off), (nlohmann::json{1.0, 1.0})) << off;
  for (const char* on : {"1", "true"})
    EXPECT_EQ(scalesWith(on), (nlohmann::json{0.25, 0.25})) << on << ", and the wall has no noise";
}

/** \brief Names come from the author of the recording, and go to terminals. */
TEST_F(CommandLine, WhatATerminalWouldObeyIsNotPrinted) {
  WallRecording wall{};
  nlohmann::json rig = wall.rig();
  const std::string name =
      "\x1b]0;title\x07\x1b[2J\xc2\x9b"
      "31m\x7f\r";
  rig["cameras"][1]["name"] = name;
  writeText(folder_ / "odd/rig.json", rig.dump());
  fs::copy(recording_ / "camera_0", folder_ / "odd/camera_0", fs::copy_options::recursive);
  const auto isClean = [](const std::string& text) {
    return text.find_first_of("\x1b\x07\x7f\r") == std::string::npos && text.find("\xc2\x9b") == std::string::npos;
  };
  const ToolResult fused = fuse({out("odd"), "-o", out()});
  EXPECT_EQ(fused.exit_code, 0);
  EXPECT_NE(fused.out.find("\\x1b]0;title\\x07\\x1b[2J\\xc2\\x9b31m\\x7f\\x0d"), std::string::npos) << fused.out;
  const ToolResult calibrated = runProgram(FUSE_FLOW_CALIBRATE_TOOL, {out("odd"), "-o", out("r.json")});
  EXPECT_EQ(calibrated.exit_code, 0) << calibrated.err;
  EXPECT_NE(calibrated.out.find("title"), std::string::npos);
  rig["cameras"][1]["fx"] = -1;
  writeText(folder_ / "odd/rig.json", rig.dump());
  const ToolResult refused = fuse({out("odd"), "-o", out()});
  EXPECT_TRUE(isOneLineError(refused, 1, {"title", "fx"}));
  const ToolResult option = fuse({out("odd"), "-o", out(), name});
  EXPECT_EQ(option.exit_code, 1);
  for (const std::string& text : {fused.out, fused.err, calibrated.out, calibrated.err, refused.err, option.err})
    EXPECT_TRUE(isClean(text)) << testing::PrintToString(text);
}

TEST_F(CommandLine, ACameraWhoseNameHoldsAZeroIsRefused) {
  nlohmann::json rig = WallRecording{}.rig();
  rig["cameras"][1]["name"] = std::string("camera_1\0x", 10);
  writeText(recording_ / "rig.json", rig.dump());
  const ToolResult result = fuseWith({});
  EXPECT_TRUE(isOneLineError(result, 1, {"camera number 1", "\\u0000"}));
  EXPECT_EQ(result.err.find('\0'), std::string::npos);
}

TEST_F(CommandLine, AnErrorIsShortWhateverItQuotes) {
  nlohmann::json rig = WallRecording{}.rig();
  rig["cameras"][1]["name"] = std::string(100000, 'n');
  rig["cameras"][1]["fx"] = -1;
  writeText(recording_ / "rig.json", rig.dump());
  const ToolResult result = fuseWith({});
  EXPECT_TRUE(isOneLineError(result, 1, {"rig.json", "nnn", "fx is -1, must be positive"}));
  EXPECT_LT(result.err.size(), 1100u);
}

TEST_F(CommandLine, CloudsOfAnEarlierRunAreNamed) {
  writeText(out_ / "000007.pcd", "older");
  writeText(out_ / "000009.ply", "older");
  writeText(out_ / "notes.txt", "of mine");
  const ToolResult first = fuseWith({});
  EXPECT_TRUE(succeeded(first));
  EXPECT_NE(first.out.find(out() + " holds 2 clouds that this run has not written, such as 000007.pcd"),
            std::string::npos)
      << first.out;
  const ToolResult fewer = fuseWith({"--frames", "0:2"});
  EXPECT_NE(fewer.out.find("holds 5 clouds"), std::string::npos) << fewer.out;
  fs::remove_all(out_);
  EXPECT_EQ(fuseWith({}).out.find("holds"), std::string::npos);
  EXPECT_EQ(fuseWith({}).out.find("holds"), std::string::npos) << "they have been replaced";
}

TEST_F(CommandLine, OneCameraAloneIsNotCalibrated) {
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--from-scratch"}}) {
    std::vector<std::string> arguments{recording(), "--views", "1", "-o", out("r.json")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_TRUE(isOneLineError(runProgram(FUSE_FLOW_CALIBRATE_TOOL, arguments), 1,
                               {recording(), "one camera", "two or more", "--views"}));
    EXPECT_FALSE(fs::exists(out("r.json")));
  }
}

TEST_F(CommandLine, AnOptionOutOfRangeIsNamedByEvaluateToo) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("a.ply"), "--frames", "0"})));
  const auto expect = [&](const std::vector<std::string>& more, const std::vector<std::string>& words) {
    std::vector<std::string> arguments{recording(), out("a.ply")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_TRUE(isOneLineError(evaluate(arguments), 2, words)) << testing::PrintToString(more);
  };
  expect({"--frame", "5"}, {"--frame", "5 frames"});
  expect({"--frame", "x"}, {"--frame", "x"});
  expect({"--visibility", "nan"}, {"--visibility", "nan"});
  expect({"--visibility", "1e300"}, {"--visibility", "1e300"});  // more than single precision has
  expect({"--coverage-radius", "1e-320"}, {"--coverage-radius", "1e-320"});
  expect({"--visibility", "0"}, {"--visibility", "0", "positive"});
  expect({"--coverage-radius", "inf"}, {"--coverage-radius", "inf"});
  expect({"--min-range", "-1"}, {"--min-range", "-1"});
  expect({"--min-range", "3", "--max-range", "2"}, {"--min-range", "--max-range"});
  expect({"--views", "7"}, {"--views", "7"});
  expect({"--threads", "100000"}, {"--threads", "100000"});
}

TEST_F(CommandLine, FramesFollowPython) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> cases = {
      {"3", {"000003.ply"}},
      {"4,1", {"000001.ply", "000004.ply"}},
      {"1:4", {"000001.ply", "000002.ply", "000003.ply"}},
      {"0:5:2", {"000000.ply", "000002.ply", "000004.ply"}},
      {"::3", {"000000.ply", "000003.ply"}},
      {"3:", {"000003.ply", "000004.ply"}},
      {"3:900", {"000003.ply", "000004.ply"}},
      {"1:4:18446744073709551615", {"000001.ply"}},
  };
  for (const auto& [frames, expected] : cases) {
    fs::remove_all(out_);
    ASSERT_TRUE(succeeded(fuseWith({"--frames", frames}))) << frames;
    EXPECT_EQ(listing(out_), expected) << frames;
  }
}

TEST_F(CommandLine, FramesThatAreNotThereOrNoNumbersAreRefused) {
  for (const char* frames :
       {"5", "0,9", "7:9", "3:3", "4:2", "0:5:0", "-1", "1:-1", "a", "1.5", "0,", ",", "1:2:3:4", "0;1", "1,1"})
    expectWrong({"--frames", frames}, {"--frames", frames, "A:B:STEP"});
}

TEST_F(CommandLine, ViewsOfARigChooseItsCameras) {
  ASSERT_TRUE(succeeded(fuseWith({"--frames", "0", "--views", "0,2", "--report", out("report.json")})));
  EXPECT_EQ(nlohmann::json::parse(readText(out("report.json")))["frames"][0]["points_in"], 2 * 32 * 24);
  fs::remove_all(out_);
  for (const char* views : {"3", "0,3", "x", "0:3:0"}) expectWrong({"--views", views}, {"--views", views});
}

TEST_F(CommandLine, SlideIsForAMovingCamera) {
  expectWrong({"--slide", "1"}, {"--slide", "rig.json"});
  expectWrong({"--slide", "-1"}, {"--slide", "-1", "whole number from 0"});
  expectWrong({"--slide", "x"}, {"--slide", "x"});
}

/** \brief A 7-Scenes folder: frames 0, 10, 20 and 30 of a camera that does not move. */
TEST_F(CommandLine, ViewsAndSlideMoveARigAlongASequence) {
  const fs::path scene = folder_ / "scene";
  for (const char* number : {"00", "10", "20", "30"}) {
    const std::string stem = std::string("frame-0000") + number;
    fs::create_directories(scene);
    fs::copy(depthFile(recording_, 0, 0), scene / (stem + ".depth.png"));
    writeText(scene / (stem + ".pose.txt"), "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  }
  writeText(scene / "camera-intrinsics.txt", "32 0 15.5\n0 32 11.5\n0 0 1\n");
  const auto fuseScene = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{scene.string(), "-o", out()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return fuse(arguments);
  };
  // Frames 0,10 then 10,20 then 20,30; 30,40 does not exist.
  ASSERT_TRUE(succeeded(fuseScene({"--views", "0,10", "--slide", "10"})));
  EXPECT_EQ(listing(out_), (std::vector<std::string>{"000000.ply", "000001.ply", "000002.ply"}));
  EXPECT_TRUE(
      succeeded(evaluate({scene.string(), out("out/000002.ply"), "--views", "0,10", "--slide", "10", "--frame", "2"})));
  fs::remove_all(out_);
  fs::rename(scene / "frame-000020.pose.txt", scene / "moved.txt");
  EXPECT_TRUE(isOneLineError(fuseScene({"--views", "0:31:20"}), 1, {"frame-000020.pose.txt", "not found"}));
  fs::rename(scene / "moved.txt", scene / "frame-000020.pose.txt");
  fs::remove(scene / "frame-000020.depth.png");
  const ToolResult one_missing = fuseScene({"--views", "0:31:10"});
  ASSERT_TRUE(succeeded(one_missing));
  EXPECT_NE(one_missing.out.find("camera frame-000020 missed 1 of 1 frames"), std::string::npos) << one_missing.out;
  EXPECT_EQ(listing(out_), std::vector<std::string>{"000000.ply"});
  fs::remove_all(out_);

  EXPECT_TRUE(isOneLineError(fuseScene({}), 2, {"--views", scene.string(), "0,10,20,30"}));
  EXPECT_TRUE(isOneLineError(fuseScene({"--views", "0,5"}), 2, {"--views", "5", "4 frames"}));
  EXPECT_TRUE(isOneLineError(fuseScene({"--views", "0,31"}), 2, {"--views", "31"}));
  EXPECT_TRUE(isOneLineError(fuseScene({"--views", "0", "--slide", "-5"}), 2, {"--slide", "-5"}));
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(CommandLine, SeveralInputsMustBePcdFiles) {
  EXPECT_TRUE(isOneLineError(fuse({recording(), recording(), "-o", out()}), 1, {recording(), ".pcd"}));
}

TEST_F(CommandLine, OneFileIsForOneFrame) {
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out("all.ply")}), 2, {"all.ply", "5 frames", "--frames"}));
  EXPECT_FALSE(fs::exists(folder_ / "all.ply"));
  for (const char* name : {"one.ply", "one.pcd", "ONE.PLY"}) {
    EXPECT_TRUE(succeeded(fuse({recording(), "-o", out(name), "--frames", "2"}))) << name;
    EXPECT_TRUE(fs::is_regular_file(folder_ / name)) << name;
  }
}

TEST_F(CommandLine, AnOutputThatIsNeitherAFileOfOursNorAFolderIsRefused) {
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", "", "--frames", "0"}), 2, {"--output", "''", "folder"}));
  for (const char* name : {"out.las", "out.ply.gz", "run.2"})
    EXPECT_TRUE(
        isOneLineError(fuse({recording(), "-o", out(name)}), 2, {name, ".ply or .pcd", std::string(name) + "/"}));
  EXPECT_FALSE(fs::exists(out("out.las")));
  EXPECT_TRUE(succeeded(fuse({recording(), "-o", out("run.2/"), "--frames", "0"})));
  EXPECT_TRUE(succeeded(fuse({recording(), "-o", out("run.2"), "--frames", "1"}))) << "the folder is there by now";
  EXPECT_EQ(listing(folder_ / "run.2"), (std::vector<std::string>{"000000.ply", "000001.ply"}));
}

TEST_F(CommandLine, AnEmptyNameAndTheNextOptionAreNoFile) {
  for (const char* option : {"--report", "--poses", "--config"}) {
    expectWrong({option, ""}, {option, "''", "must be a file"});
    expectWrong({option, "--normals"}, {option, "'--normals'", "must be a file", "./-name"});
  }
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", "--normals"}), 2, {"--output", "'--normals'"}));
  for (const char* option : {"--json", "--error-picture", "--poses"})
    EXPECT_TRUE(isOneLineError(evaluate({recording(), out("a.ply"), option, ""}), 2, {option, "''"})) << option;
}

TEST_F(CommandLine, AConfigFileIsWorthTheSameOptions) {
  const fs::path config = folder_ / "fuse.conf";
  writeText(config,
            "# a comment\nframes = 0:4:2\nviews = 0,2\nsigma = 0.03\nmax-range = 3\nbilateral = true\n"
            "occlusion-form = published\nformat = pcd\ncrop-box = -1 -1 0 1 1 3\nreport = \"" +
                out("config.json") + "\"\n");
  ASSERT_TRUE(succeeded(fuseWith({"--config", config.string()})));
  ASSERT_TRUE(succeeded(fuse({recording(),
                              "-o",
                              out("options"),
                              "--frames",
                              "0:4:2",
                              "--views",
                              "0,2",
                              "--sigma",
                              "0.03",
                              "--max-range",
                              "3",
                              "--bilateral",
                              "true",
                              "--occlusion-form",
                              "published",
                              "--format",
                              "pcd",
                              "--crop-box",
                              "-1",
                              "-1",
                              "0",
                              "1",
                              "1",
                              "3",
                              "--report",
                              out("options.json")})));
  EXPECT_EQ(listing(out_), (std::vector<std::string>{"000000.pcd", "000002.pcd"}));
  EXPECT_EQ(listing(folder_ / "options"), listing(out_));
  for (const std::string& name : listing(out_))
    EXPECT_EQ(readText(out_ / name), readText(folder_ / "options" / name)) << name;
  EXPECT_TRUE(fs::exists(out("config.json")));
}

TEST_F(CommandLine, AListInAConfigFileMayStandInBrackets) {
  writeText(folder_ / "fuse.conf", "frames = [0, 2]  # the first and the third\r\n; another comment\r\n\r\n");
  ASSERT_TRUE(succeeded(fuseWith({"--config", out("fuse.conf")})));
  EXPECT_EQ(listing(out_), (std::vector<std::string>{"000000.ply", "000002.ply"}));
}

TEST_F(CommandLine, AConfigFileMayBeAPipe) {
  const std::string script = "echo frames = 3 | \"$1\" \"$2\" -o \"$3\" --config /dev/stdin";
  ASSERT_TRUE(succeeded(runProgram("/bin/sh", {"-c", script, "sh", FUSE_FLOW_FUSE_TOOL, recording(), out()})));
  EXPECT_EQ(listing(out_), std::vector<std::string>{"000003.ply"});
}

TEST_F(CommandLine, AConfigFileWithoutAnEndIsRefused) {
  if (!fs::exists("/dev/zero")) GTEST_SKIP() << "there is no /dev/zero";
  expectWrong({"--config", "/dev/zero"}, {"/dev/zero", "longer than 1 MiB"});
}

TEST_F(CommandLine, AFlagInAConfigFileIsTheFlag) {
  writeText(folder_ / "fuse.conf", "published = true\nno-quality = true\n");
  ASSERT_TRUE(succeeded(fuseWith({"--config", out("fuse.conf"), "--report", out("report.json")})));
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("options"), "--published"})));
  EXPECT_EQ(readText(out_ / "000000.ply"), readText(folder_ / "options" / "000000.ply"));
  EXPECT_TRUE(nlohmann::json::parse(readText(out("report.json")))["total"]["e_mc_mm"].is_null());
}

TEST_F(CommandLine, AnOptionGivenOutrightOverrulesTheConfigFile) {
  writeText(folder_ / "fuse.conf", "frames = 1\nformat = pcd\n");
  ASSERT_TRUE(succeeded(fuseWith({"--config", out("fuse.conf"), "--frames", "3"})));
  EXPECT_EQ(listing(out_), std::vector<std::string>{"000003.pcd"});
}

TEST_F(CommandLine, AMistakeInAConfigFileIsNamed) {
  const fs::path config = folder_ / "fuse.conf";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"sigmma = 0.03\n", "sigmma"},
      {"[fusion]\nsigma = 0.03\n", "fusion"},
      {"sigma = -3\n", "--sigma"},
      {"sigma = wide\n", "--sigma"},
      {"sigma =\n", "--sigma"},
      {"frames = 9\n", "--frames"},
      {"sigma 0.03\n", "sigma 0.03"},
      {"method = magic\n", "--method"},
      {"frames = 0\ns\n", "line 2 is 's', must be name = value"},
      {"=3\n", "line 1 is '=3', must be name = value"},
      {"o=\n", "line 1 is 'o=', must be name = value"},
      {"views = [0,1\nsigma = 0.03]\n", "line 1 is 'views = [0,1', must close its list with ]"},
      {std::string(2 << 20, '\n'), "is longer than 1 MiB"},
  };
  for (const auto& [text, word] : cases) {
    writeText(config, text);
    expectWrong({"--config", config.string()}, {word});
  }
  EXPECT_TRUE(isOneLineError(fuseWith({"--config", out("none.conf")}), 1, {out("none.conf")}));
  EXPECT_TRUE(isOneLineError(fuseWith({"--config", folder_.string()}), 1, {folder_.string()}));
}

/** \brief The frames would be fused by fewer, and nobody would know. */
TEST_F(CommandLine, ThreadsThatCannotBeStartedAreAnErrorOfOneLine) {
#if defined(FUSE_FLOW_TEST_SANITIZED)
  GTEST_SKIP() << "sanitizers take more addresses than are left here";
#endif
  ASSERT_TRUE(succeeded(fuseWith({"--frames", "0"})));
  const std::string script = "ulimit -v 2000000; tool=$1; shift; exec \"$tool\" \"$@\" --threads 1024";
  const auto limited = [&](const char* tool, const std::vector<std::string>& arguments) {
    std::vector<std::string> all{"-c", script, "sh", tool};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return runProgram("/bin/sh", all);
  };
  EXPECT_TRUE(isOneLineError(limited(FUSE_FLOW_FUSE_TOOL, {recording(), "-o", out("limited")}), 1,
                             {"of 1024 threads only", "--threads"}));
  EXPECT_FALSE(fs::exists(out("limited")));
  EXPECT_TRUE(isOneLineError(limited(FUSE_FLOW_EVALUATE_TOOL, {recording(), out("out/000000.ply")}), 1,
                             {"of 1024 threads only", "--threads"}));
}

}  // namespace
}  // namespace tool_test
