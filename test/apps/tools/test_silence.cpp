// What would be a wrong result, or none, without a word.

#include "support/tool_fixture.h"

namespace tool_test {
namespace {

class Silence : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    WallRecording().write(recording_);
  }
};

TEST_F(Silence, CloudsThatAreEmptyAreCountedWithTheOptionThatEmptiesThem) {
  const ToolResult full = fuse({recording(), "-o", out("full")});
  ASSERT_TRUE(succeeded(full));
  EXPECT_EQ(full.out.find("are empty"), std::string::npos) << full.out;
  const ToolResult empty = fuse({recording(), "-o", out("empty"), "--max-noise", "0.00001"});
  EXPECT_EQ(empty.exit_code, 0) << empty.err;
  EXPECT_NE(empty.out.find("clouds are empty, the first of frame 0: no point passes --max-noise 1e-05"),
            std::string::npos)
      << empty.out;
}

TEST_F(Silence, WhatIsForSeveralProcessesHasNoEffectInOne) {
  EXPECT_NE(fuse({recording(), "-o", out("a"), "--fuse-at", "first"}).err.find("--fuse-at has no effect"),
            std::string::npos);
  EXPECT_NE(
      fuse({recording(), "-o", out("c"), "--rank-compression", "zstd"}).err.find("--rank-compression has no effect"),
      std::string::npos);
  EXPECT_EQ(fuse({recording(), "-o", out("b")}).err.find("has no effect"), std::string::npos);
}

TEST_F(Silence, OneCameraThatIsToBePlacedIsRefused) {
  const ToolResult result = fuse({recording(), "-o", out("one"), "--views", "0", "--refine-extrinsics"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("must have two or more"), std::string::npos) << result.err;
}

TEST_F(Silence, CloudsOfBeforeInTheFoldersOfAnExportAreNamed) {
  const auto exported = [&] { return runProgram(FUSE_FLOW_EXPORT_TOOL, {recording(), "-o", out("clouds")}); };
  EXPECT_EQ(exported().out.find("has not written"), std::string::npos);
  EXPECT_EQ(exported().out.find("has not written"), std::string::npos) << "they are replaced";
  writeText(folder_ / "clouds" / "camera_0" / "999999999999.pcd", "of another run");
  const std::string said = exported().out;
  EXPECT_NE(said.find("holds 1 cloud that this run has not written, such as camera_0/999999999999.pcd"),
            std::string::npos)
      << said;
}

TEST_F(Silence, TruthOfWhichAFileLacksIsNotTakenForNone) {
  const std::string simulated = out("simulated"), cloud = out("cloud.ply");
  ASSERT_TRUE(succeeded(runProgram(FUSE_FLOW_SIMULATE_TOOL, {"--scene", "table", "--rig", "ring-2", "--scale", "0.15",
                                                             "--frames", "1", "-o", simulated})));
  ASSERT_TRUE(succeeded(fuse({simulated, "-o", cloud})));
  const auto said = [&] { return runProgram(FUSE_FLOW_EVALUATE_TOOL, {simulated, cloud}).out; };
  EXPECT_NE(said().find("Against the true surface"), std::string::npos);
  fs::remove(fs::path(simulated) / "truth" / "rig.json");
  const std::string without = said();
  EXPECT_NE(without.find("The truth is left out: it has no file"), std::string::npos) << without;
  EXPECT_EQ(without.find("Against the true surface"), std::string::npos);
  fs::remove_all(fs::path(simulated) / "truth");
  EXPECT_EQ(said().find("The truth is left out"), std::string::npos);
}

}  // namespace
}  // namespace tool_test
