#include "support/tool_fixture.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <fstream>

namespace tool_test {
namespace {

/** \brief A simulated rig that does not stand where its rig.json says, and the tool that finds out. */
class Calibrate : public ToolTest {
 protected:
  ToolResult calibrate(std::vector<std::string> more) const {
    std::vector<std::string> arguments{recording(), "-o", out("refined.json")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return runProgram(FUSE_FLOW_CALIBRATE_TOOL, arguments);
  }
  void simulate(const std::vector<std::string>& more, const std::string& sensor = "ideal") const {
    std::vector<std::string> arguments{"--scene",  "room", "--rig", "ring-3",   "--scale", shortTests() ? "0.4" : "0.5",
                                       "--sensor", sensor, "-o",    recording()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    ASSERT_TRUE(succeeded(runProgram(FUSE_FLOW_SIMULATE_TOOL, arguments)));
  }
  static nlohmann::json read(const std::string& path) {
    std::ifstream file(path);
    return nlohmann::json::parse(file);
  }

  using Pose = std::array<double, 16>;  // row-major
  /** \brief Where the centre of a camera lies in the frame of camera 0. */
  static std::array<double, 3> placeBesideFirst(const nlohmann::json& rig, std::size_t camera) {
    const Pose first = rig["cameras"][0]["T_world_camera"], other = rig["cameras"][camera]["T_world_camera"];
    std::array<double, 3> place{};
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t k = 0; k < 3; ++k) place[row] += first[4 * k + row] * (other[4 * k + 3] - first[4 * k + 3]);
    return place;
  }
  /** \brief How far a camera is from its true place, both seen from camera 0; metres. */
  double error(const std::string& rig_json, std::size_t camera) const {
    const auto found = placeBesideFirst(read(rig_json), camera);
    const auto truth = placeBesideFirst(read((recording_ / "truth" / "rig.json").string()), camera);
    return std::hypot(found[0] - truth[0], found[1] - truth[1], found[2] - truth[2]);
  }
};

TEST_F(Calibrate, BringsCamerasBackToWhereTheyTrulyStand) {
  simulate({"--frames", "2", "--fps", "3", "--position-error", "20", "--rotation-error", "0.5"});
  const ToolResult result = calibrate({"--json", out("figures.json")});
  ASSERT_TRUE(succeeded(result));
  for (std::size_t camera : {1u, 2u}) {
    EXPECT_GT(error((recording_ / "rig.json").string(), camera), 0.005);
    EXPECT_LT(error(out("refined.json"), camera), 0.003);
  }
  EXPECT_NE(result.out.find("camera_02"), std::string::npos);
  const nlohmann::json figures = read(out("figures.json"));
  EXPECT_EQ(figures["cameras"].size(), 3u);
  EXPECT_EQ(figures["cameras"][0]["moved_mm"], 0.0);
  EXPECT_LT(figures["residual_mm"], 0.5 * figures["residual_before_mm"].get<double>());
}

TEST_F(Calibrate, TakesTenFramesMoreOfActiveStereoOrThoseThatAreNamed) {
  const auto figures = [&](const std::string& sensor, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"--json", out("figures.json")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    fs::remove_all(recording_);
    EXPECT_TRUE(succeeded(
        runProgram(FUSE_FLOW_SIMULATE_TOOL, {"--scene", "table", "--rig", "ring-2", "--scale", "0.5", "--frames", "12",
                                             "--sensor", sensor, "--no-color", "-o", recording()})));
    EXPECT_TRUE(succeeded(calibrate(arguments)));
    return read(out("figures.json"));
  };
  EXPECT_EQ(figures("time_of_flight", {})["frames"], 10);
  nlohmann::json stereo = figures("active_stereo", {"--depth-correction", "each"});
  EXPECT_EQ(stereo["frames"], 12);
  EXPECT_EQ(stereo["with_corrections"]["frames"], 10);
  stereo = figures("active_stereo", {"--depth-correction", "each", "--frames", ":11"});
  EXPECT_EQ(stereo["frames"], 11);
  EXPECT_EQ(stereo["with_corrections"]["frames"], 11);
}

TEST_F(Calibrate, TheNewPosesServeTheOtherTools) {
  simulate({"--position-error", "20", "--rotation-error", "0.5"});
  ASSERT_TRUE(succeeded(calibrate({})));
  const auto disagreement = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{recording(), "-o", out("cloud.ply"), "--report", out("report.json")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_TRUE(succeeded(fuse(arguments)));
    return read(out("report.json"))["total"]["e_mc_multi_view_mm"].get<double>();
  };
  const double before = disagreement({});
  EXPECT_LT(disagreement({"--poses", out("refined.json")}), 0.7 * before);
  EXPECT_LT(disagreement({"--refine-extrinsics"}), 0.7 * before);
  EXPECT_TRUE(succeeded(evaluate({recording(), out("cloud.ply"), "--poses", out("refined.json")})));
}

TEST_F(Calibrate, NewPosesKeepWhatTheCamerasAre) {
  simulate({"--position-error", "5"}, "time_of_flight_multipath");
  nlohmann::json given = read(recording() + "/rig.json");
  given["cameras"][0]["noise"] = {{"floor", 0.001}, {"linear", 0.0}, {"quadratic", 0.0005}};
  given["cameras"][1]["confidence_scale"] = 0.5;
  std::ofstream(recording() + "/rig.json") << given;
  ASSERT_TRUE(succeeded(calibrate({})));
  const nlohmann::json refined = read(out("refined.json"));
  EXPECT_EQ(refined["cameras"][0]["noise"], given["cameras"][0]["noise"]);
  EXPECT_FALSE(refined["cameras"][1].contains("noise"));
  EXPECT_EQ(refined["cameras"][1]["confidence_scale"], 0.5);
  EXPECT_FALSE(refined["cameras"][0].contains("confidence_scale"));
  nlohmann::json rig = read(out("refined.json"));
  const auto disagreement = [&] {
    EXPECT_TRUE(succeeded(
        fuse({recording(), "-o", out("cloud.ply"), "--poses", out("refined.json"), "--report", out("report.json")})));
    return read(out("report.json"))["total"]["e_mc_multi_view_mm"].get<double>();
  };
  const double corrected = disagreement();
  for (nlohmann::json& camera : rig["cameras"]) {
    EXPECT_EQ(camera["multipath"]["modulation_frequency"], 200e6);
    camera.erase("multipath");
  }
  std::ofstream(out("refined.json")) << rig;
  EXPECT_NE(disagreement(), corrected) << "what a file of poses says of the lamps counts";
}

TEST_F(Calibrate, TheDeviceIsChosenAndAMissingGpuIsAnErrorOfOneLine) {
  simulate({"--position-error", "20", "--rotation-error", "0.5"});
  ASSERT_TRUE(succeeded(calibrate({"--device", "cpu"})));
  const std::string of_cpu = readText(out("refined.json"));
  fs::remove(out("refined.json"));
  const ToolResult result = calibrate({"--device", "gpu"});
  if (result.exit_code != 0) {
    EXPECT_TRUE(isOneLineError(result, 2, {"--device gpu", "--device cpu"}));
    EXPECT_FALSE(fs::exists(out("refined.json")));
    ASSERT_TRUE(succeeded(calibrate({})));
    EXPECT_EQ(readText(out("refined.json")), of_cpu) << "what is chosen where there is no GPU";
    return;
  }
  const nlohmann::json cpu = nlohmann::json::parse(of_cpu), gpu = read(out("refined.json"));
  for (std::size_t camera = 0; camera < 3; ++camera) {
    const Pose expected = cpu["cameras"][camera]["T_world_camera"], found = gpu["cameras"][camera]["T_world_camera"];
    for (std::size_t k = 0; k < 16; ++k) EXPECT_NEAR(found[k], expected[k], 2e-6) << camera << ", " << k;
  }
  const std::string of_gpu = readText(out("refined.json"));
  ASSERT_TRUE(succeeded(calibrate({})));
  EXPECT_EQ(readText(out("refined.json")), of_gpu) << "what is chosen where there is a GPU, with the same bytes again";
}

TEST_F(Calibrate, ABumpedCameraIsToldWhileFusing) {
  simulate({"--frames", "7", "--fps", "30", "--bump", "60", "--bump-rotation", "1", "--bump-frame", "2"});
  const ToolResult result = fuse({recording(), "-o", out(), "--refine-extrinsics", "--no-quality"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("camera 'camera_02' has moved by"), std::string::npos) << result.err;
}

TEST_F(Calibrate, FusingWithRefinementGivesTheSameBytesAgain) {
  simulate({"--frames", "3", "--fps", "3", "--position-error", "10"});
  std::string first;
  for (int k = 0; k < 2; ++k) {
    ASSERT_TRUE(succeeded(fuse({recording(), "-o", out(), "--refine-extrinsics"})));
    std::ifstream file(out_ / "000002.ply", std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    if (k == 0) first = bytes;
    EXPECT_EQ(bytes, first);
  }
}

TEST_F(Calibrate, AWallAloneIsSaidToLeaveTheCamerasOpen) {
  WallRecording().write(recording_);
  const ToolResult result = calibrate({});
  ASSERT_TRUE(succeeded(result));
  EXPECT_NE(result.out.find("left open: slides along"), std::string::npos) << result.out;
}

TEST_F(Calibrate, CorrectionsThatExplainNothingAreLeftOut) {
  simulate({"--frames", "3", "--fps", "3", "--position-error", "10"});
  ASSERT_TRUE(succeeded(calibrate({})));
  const auto correct = [&](const std::string& poses, const std::string& gain) {
    return runProgram(FUSE_FLOW_CALIBRATE_TOOL,
                      {recording(), "--poses", poses, "--depth-correction", "each", "--least-gain", gain, "--json",
                       out("figures.json"), "-o", out("corrected.json")});
  };
  const std::string given = recording() + "/rig.json";
  const ToolResult result = correct(given, "0.05");
  ASSERT_TRUE(succeeded(result));
  EXPECT_NE(result.out.find("corrections are left out"), std::string::npos) << result.out;
  const nlohmann::json figures = read(out("figures.json"))["with_corrections"];
  EXPECT_TRUE(figures["left_out"]);
  EXPECT_NEAR(figures["residual_of_poses_mm"], figures["residual_mm"], 0.05 * figures["residual_mm"].get<double>());
  EXPECT_GT(figures["correspondences"], 1000);
  // What is written is what poses alone gave.
  const nlohmann::json alone = read(out("refined.json"));
  const auto poseOf = [](const nlohmann::json& rig) { return rig["cameras"][1]["T_world_camera"]; };
  const auto corrected = [&] { return read(out("corrected.json")); };
  const nlohmann::json left_out = corrected();
  for (const nlohmann::json& camera : left_out["cameras"]) EXPECT_FALSE(camera.contains("depth_correction"));
  EXPECT_EQ(poseOf(left_out), poseOf(alone));
  // Unless someone insists. Corrections that cameras have are forgotten, and with them what they did to poses.
  ASSERT_TRUE(succeeded(correct(given, "0")));
  const nlohmann::json kept = corrected();
  for (const nlohmann::json& camera : kept["cameras"]) EXPECT_TRUE(camera.contains("depth_correction"));
  EXPECT_FALSE(read(out("figures.json"))["with_corrections"]["left_out"]);
  nlohmann::json had = read(given);
  for (std::size_t i = 0; i < had["cameras"].size(); ++i) {
    had["cameras"][i]["depth_correction"] = kept["cameras"][i]["depth_correction"];
    for (nlohmann::json& a : had["cameras"][i]["depth_correction"]["relative"]) a = 0.02;
  }
  std::ofstream(out("had.json")) << had;
  ASSERT_TRUE(succeeded(correct(out("had.json"), "0.05")));
  EXPECT_EQ(corrected(), left_out);
  EXPECT_TRUE(isOneLineError(calibrate({"--least-gain", "1.5"}), 2, {"--least-gain"}));
  EXPECT_TRUE(isOneLineError(calibrate({"--least-gain", "nan"}), 2, {"--least-gain"}));
  EXPECT_TRUE(isOneLineError(calibrate({"--least-gain", "0.1"}), 2, {"--least-gain", "--depth-correction"}));
}

TEST_F(Calibrate, FindsWhatDepthCamerasMeasureWrong) {
  simulate({"--frames", "3", "--fps", "3", "--depth-distortion", "25"});
  ASSERT_TRUE(succeeded(calibrate({})));
  const ToolResult result = runProgram(FUSE_FLOW_CALIBRATE_TOOL, {recording(), "--depth-correction", "each", "--json",
                                                                  out("figures.json"), "-o", out("corrected.json")});
  ASSERT_TRUE(succeeded(result));
  EXPECT_NE(result.out.find("with corrections surfaces disagree"), std::string::npos) << result.out;
  const nlohmann::json rig = read(out("corrected.json"));
  for (const nlohmann::json& camera : rig["cameras"]) EXPECT_EQ(camera["depth_correction"]["relative"].size(), 48u);
  EXPECT_NE(rig["cameras"][0]["depth_correction"], rig["cameras"][1]["depth_correction"]);
  const nlohmann::json figures = read(out("figures.json"));
  EXPECT_LT(figures["with_corrections"]["residual_mm"], 0.8 * figures["residual_mm"].get<double>());
  EXPECT_EQ(figures["cameras"].size(), 3u);
  EXPECT_GT(figures["cameras"][1]["depth_correction_at_2_m_mm"], 3.0);
  // Every reader of the rig uses the corrections: the views agree better.
  const auto disagreement = [&](const std::string& poses) {
    EXPECT_TRUE(succeeded(
        fuse({recording(), "-o", out(), "--poses", poses, "--frames", "0:1", "--report", out("report.json")})));
    return read(out("report.json"))["total"]["e_mc_multi_view_mm"].get<double>();
  };
  EXPECT_LT(disagreement(out("corrected.json")), 0.9 * disagreement(out("refined.json")));
  // One for all views, if that is asked for.
  EXPECT_FALSE(figures["with_corrections"]["left_out"]);
  ASSERT_TRUE(succeeded(calibrate({"--depth-correction", "shared", "--least-gain", "0"})));
  const nlohmann::json shared = read(out("refined.json"));
  ASSERT_TRUE(shared["cameras"][0].contains("depth_correction") && shared["cameras"][2].contains("depth_correction"));
  EXPECT_EQ(shared["cameras"][0]["depth_correction"], shared["cameras"][2]["depth_correction"]);
  EXPECT_TRUE(
      isOneLineError(calibrate({"--depth-correction", "some"}), 2, {"--depth-correction", "some", "each", "shared"}));
}

/** \brief A rig whose rig.json is of no use, and someone who shows a marker to it. */
class CalibrateByBoard : public Calibrate {
 protected:
  void SetUp() override {
    Calibrate::SetUp();
    WallRecording().write(recording_);
    const ToolResult result = calibrate({"--board", "0.5"});
    if (result.err.find("libapriltag") == std::string::npos) {
      fs::remove_all(recording_);
      return;
    }
    EXPECT_TRUE(isOneLineError(result, 2, {"--board", "libapriltag-dev"}));
    GTEST_SKIP() << "built without libapriltag";
  }
  void show(const std::string& side) const {
    simulate({"--marker", side, "--frames", "8", "--fps", "2.4", "--position-error", "500", "--rotation-error", "30"});
  }
};

TEST_F(CalibrateByBoard, FindsCamerasOfWhichNothingIsKnown) {
  show("0.5");
  const ToolResult result = calibrate({"--board", "0.5"});
  ASSERT_TRUE(succeeded(result));
  EXPECT_NE(result.out.find("markers that several cameras saw"), std::string::npos) << result.out;
  for (std::size_t camera : {1u, 2u}) {
    EXPECT_GT(error((recording_ / "rig.json").string(), camera), 0.2);
    EXPECT_LT(error(out("refined.json"), camera), 0.003);
  }
}

TEST_F(CalibrateByBoard, WhatIsMissingOrWrongIsOneLine) {
  show("0.5");
  EXPECT_TRUE(isOneLineError(calibrate({"--board", "0.3"}), 1, {"--board", "0.3 m", "0.5"}));
  EXPECT_TRUE(isOneLineError(calibrate({"--board", "0.5", "--frames", "0:1"}), 1, {"--board", "camera_"}));
  EXPECT_TRUE(isOneLineError(calibrate({"--board", "0.5", "--board-family", "tag25h9"}), 1, {"saw none"}));
  EXPECT_TRUE(isOneLineError(calibrate({"--board", "0"}), 2, {"--board"}));
  EXPECT_TRUE(isOneLineError(calibrate({"--board", "0.5", "--from-scratch"}), 2, {"--from-scratch"}));
}

TEST_F(Calibrate, MistakesAreOneLine) {
  EXPECT_TRUE(isOneLineError(calibrate({}), 1, {"recording", "not found"}));
  WallRecording().write(recording_);
  EXPECT_TRUE(isOneLineError(calibrate({"--max-distance", "-1"}), 2, {"--max-correspondence-distance"}));
  EXPECT_TRUE(isOneLineError(calibrate({"--device", "abacus"}), 2, {"--device", "abacus", "cpu", "gpu"}));
  EXPECT_TRUE(isOneLineError(calibrate({"--samples", "3"}), 1, {"samples is 3"}));
  EXPECT_TRUE(isOneLineError(runProgram(FUSE_FLOW_CALIBRATE_TOOL, {recording(), "-o", "/nowhere/rig.json"}), 1,
                             {"/nowhere/rig.json"}));
  std::ofstream(out("other.json"))
      << R"({"cameras": [{"name": "else", "width": 8, "height": 8, "fx": 8, "fy": 8, "cx": 4, "cy": 4,
      "depth_scale": 0.001, "T_world_camera": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]})";
  EXPECT_TRUE(isOneLineError(calibrate({"--poses", out("other.json")}), 1, {"other.json", "camera_0"}));
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out(), "--refine-extrinsics", "--slide", "2"}), 2, {"--slide"}));
}

}  // namespace
}  // namespace tool_test
