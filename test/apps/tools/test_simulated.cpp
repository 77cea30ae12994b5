#include "support/tool_fixture.h"

#include <nlohmann/json.hpp>

#include <fstream>
#include <iterator>
#include <map>

namespace tool_test {
namespace {

/** \brief Simulate, fuse, compare with the truth, all as programs. */
class Simulated : public ToolTest {
 protected:
  ToolResult simulate(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"--scene", "table", "--rig", "ring-3", "--scale", "0.15"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return runProgram(FUSE_FLOW_SIMULATE_TOOL, arguments);
  }

  nlohmann::json truthOf(const std::string& clouds) const {
    EXPECT_TRUE(succeeded(evaluate({recording(), clouds, "--json", out("figures.json")})));
    std::ifstream file(out("figures.json"));
    return nlohmann::json::parse(file)[clouds]["truth"];
  }

  WallRecording wall_recording_;

  /** \brief The bytes of every file in a folder. */
  static std::map<std::string, std::string> contents(const fs::path& folder) {
    std::map<std::string, std::string> result;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
      if (!entry.is_regular_file()) continue;
      std::ifstream file(entry.path(), std::ios::binary);
      result[fs::relative(entry.path(), folder).string()] = {std::istreambuf_iterator<char>(file), {}};
    }
    return result;
  }
};

TEST_F(Simulated, AnIdealRigIsOnTheTrueSurfaceAndDoesNotFlicker) {
  ASSERT_TRUE(succeeded(simulate({"--sensor", "ideal", "--frames", "2", "-o", recording()})));
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out(), "--method", "concatenate"})));
  const nlohmann::json truth = truthOf(out());
  EXPECT_LT(truth["accuracy_p95_mm"], 1.0);
  EXPECT_EQ(truth["ghosting"], 0.0);
  EXPECT_LT(truth["flicker_mm"], 0.01);
  EXPECT_EQ(truth["precision_5mm"], 1.0);
}

TEST_F(Simulated, CloudsAreMeasuredTogetherAsTheyAreAlone) {
  ASSERT_TRUE(succeeded(simulate({"--sensor", "structured_light", "--frames", "4", "-o", recording()})));
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("all"), "--method", "concatenate"})));
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("gap"), "--method", "concatenate"})));
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("late"), "--method", "voxel_grid", "--frames", "2:4"})));
  fs::remove(fs::path(out("gap")) / "000001.ply");
  const auto figures = [&](std::vector<std::string> clouds) {
    clouds.insert(clouds.begin(), recording());
    clouds.insert(clouds.end(), {"--json", out("figures.json")});
    EXPECT_TRUE(succeeded(evaluate(clouds)));
    return nlohmann::json::parse(readText(out("figures.json")));
  };
  const nlohmann::json together = figures({out("late"), out("all"), out("gap")});
  for (const char* name : {"all", "gap", "late"})
    EXPECT_EQ(figures({out(name)})[out(name)], together[out(name)]) << name;
  EXPECT_EQ(together[out("all")]["frames"].size(), 4u);
  EXPECT_TRUE(together[out("gap")]["frames"][1]["flicker_mm"].is_null()) << "the frame before has no cloud";
  EXPECT_TRUE(together[out("gap")]["frames"][2]["flicker_mm"].is_number());
}

TEST_F(Simulated, FiguresByPartAreOfTheFramesTogether) {
  ASSERT_TRUE(succeeded(simulate({"--sensor", "ideal", "--frames", "2", "-o", recording()})));
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out(), "--method", "concatenate"})));
  const nlohmann::json truth = truthOf(out()), parts = truth["by_part"];
  for (const char* name : {"floor", "wall", "furniture", "duck", "seen by 2 or more"}) {
    ASSERT_TRUE(parts.contains(name)) << name;
    EXPECT_LT(parts[name]["accuracy_mean_mm"], 1.0) << name;
    EXPECT_EQ(parts[name]["ghosting"], 0.0) << name;
  }
  EXPECT_FALSE(parts.contains("person")) << "nobody is there";
  std::size_t samples = 0;
  for (const char* name : {"seen by 1 camera", "seen by 2 or more"})
    samples += parts[name]["surface_samples"].get<std::size_t>();
  EXPECT_EQ(samples, 2 * truth["surface_samples"].get<std::size_t>());
  const ToolResult printed = evaluate({recording(), out()});
  EXPECT_NE(printed.out.find("By part of the true surface"), std::string::npos) << printed.out;
  EXPECT_NE(printed.out.find("duck"), std::string::npos) << printed.out;
  const std::string without = evaluate({recording(), out(), "--no-parts"}).out;
  EXPECT_NE(without.find("Against the true surface"), std::string::npos) << without;
  EXPECT_EQ(without.find("part"), std::string::npos) << without;
  fs::path json = fs::path(recording()) / "truth" / "simulation.json";
  std::string described = readText(json);
  for (std::size_t at = 0; (at = described.find("\"part\"", at)) != std::string::npos;)
    described.replace(at, 6, "\"was\"");
  std::ofstream(json) << described;
  EXPECT_NE(evaluate({recording(), out()}).out.find("No figures by part"), std::string::npos);
}

TEST_F(Simulated, ARigWrongBySomeMillimetresIsOffByAsMuch) {
  ASSERT_TRUE(succeeded(simulate({"--sensor", "ideal", "--position-error", "20", "-o", recording()})));
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("cloud.ply"), "--method", "concatenate"})));
  const nlohmann::json truth = truthOf(out("cloud.ply"));
  EXPECT_GT(truth["accuracy_mean_mm"], 3.0);
  EXPECT_LT(truth["accuracy_p95_mm"], 21.0);
  EXPECT_FALSE(truth.contains("flicker_mm")) << "one frame";
}

TEST_F(Simulated, FusionIsNearerToTheTruthThanAVoxelGrid) {
  ASSERT_TRUE(succeeded(simulate({"--sensor", "structured_light", "--position-error", "2", "-o", recording()})));
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("ours.ply")})));
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("grid.ply"), "--method", "voxel_grid"})));
  EXPECT_LT(truthOf(out("ours.ply"))["accuracy_mean_mm"],
            0.7 * truthOf(out("grid.ply"))["accuracy_mean_mm"].get<double>());
}

TEST_F(Simulated, TheSameCommandGivesTheSameBytes) {
  const std::vector<std::string> how{"--sensor", "active_stereo", "--seed", "3", "--drop-rate",
                                     "0.3",      "--frames",      "2",      "-o"};
  for (const std::string& folder : {recording(), out()}) {
    std::vector<std::string> arguments = how;
    arguments.push_back(folder);
    ASSERT_TRUE(succeeded(simulate(arguments)));
  }
  EXPECT_EQ(contents(recording_), contents(out_));
}

TEST_F(Simulated, WhatIsWrongIsSaidInOneLine) {
  EXPECT_TRUE(isOneLineError(simulate({"--sensor", "sonar", "-o", recording()}), 2, {"sonar", "structured_light"}));
  EXPECT_TRUE(isOneLineError(simulate({"--rig", "ring-0", "-o", recording()}), 2, {"--rig", "ring-0", "ring-N"}));
  EXPECT_TRUE(isOneLineError(simulate({"--rig", "arc-1", "-o", recording()}), 2, {"--rig", "arc-1", "arc-N"}));
  EXPECT_TRUE(isOneLineError(simulate({"--scale", "0", "-o", recording()}), 2, {"--scale", "up to 2"}));
  EXPECT_TRUE(isOneLineError(simulate({"--drop-rate", "2", "-o", recording()}), 2, {"--drop-rate", "from 0 to 1"}));
  for (const char* option :
       {"--position-error", "--rotation-error", "--depth-bias", "--depth-distortion", "--bump", "--bump-rotation",
        "--bump-frame", "--marker", "--out-of-sync", "--out-of-step", "--readout-time", "--exposure-time",
        "--image-noise", "--exposure", "--vignetting", "--seed", "--fps"})
    EXPECT_TRUE(isOneLineError(simulate({option, "-1", "-o", recording()}), 2, {option, "-1", "must be"})) << option;
  EXPECT_TRUE(
      isOneLineError(runProgram(FUSE_FLOW_SIMULATE_TOOL, {"--scene", "moon", "-o", recording()}), 2, {"moon", "room"}));
  wall_recording_.frames = 1;
  wall_recording_.write(recording_);
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("cloud.ply")})));
  EXPECT_TRUE(isOneLineError(evaluate({recording(), out("cloud.ply"), "--truth"}), 1, {"truth"}));
  EXPECT_TRUE(isOneLineError(evaluate({recording(), out("cloud.ply"), "--error-picture", "x.png"}), 2,
                             {"--error-picture", "truth"}));
  fs::create_directory(out_);
  EXPECT_TRUE(isOneLineError(evaluate({recording(), out()}), 1, {"no clouds", "000000.ply"}));
}

}  // namespace
}  // namespace tool_test
