#if defined(FUSE_FLOW_MPIEXEC)

#include "support/tool_fixture.h"

#include <cmath>
#include <cstdio>
#include <sstream>

namespace tool_test {
namespace {

// Processes that mpirun starts: they share out the cameras of each frame, or the frames.
class FuseUnderMpirun : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    WallRecording wall{};
    wall.cameras = 5;
    wall.frames = 3;
    wall.write(recording_);
    // As root in a container, with more ranks than cores, and no look for networks: all are here. MPICH knows none of these variables.
    for (const auto& [name, value] :
         {std::pair<const char*, const char*>{"OMPI_ALLOW_RUN_AS_ROOT", "1"},
          {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"},
          {"OMPI_MCA_rmaps_base_oversubscribe", "1"},
          {"PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe"},  // the same of Open MPI 5
          {"OMPI_MCA_mpi_yield_when_idle", "1"},
          {"OMPI_MCA_pml", "ob1"},
          {"OMPI_MCA_btl", "self,vader"}})
      setenv(name, value, 1);
  }

  ToolResult fuseWith(int ranks, std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"-n", std::to_string(ranks), FUSE_FLOW_FUSE_TOOL});
    return runProgram(FUSE_FLOW_MPIEXEC, arguments);
  }

  /** \brief One rank for each command line: by a shell, as mpirun of Open MPI 5.0.7 (Debian 13) ends with a signal at ':'. */
  ToolResult runRanks(const std::vector<std::vector<std::string>>& commands) const {
    std::string script = "case ${OMPI_COMM_WORLD_RANK:-$PMI_RANK} in\n";
    for (std::size_t rank = 0; rank < commands.size(); ++rank) {
      script += std::to_string(rank) + ") exec";
      for (const std::string& word : commands[rank]) script += " '" + word + "'";
      script += ";;\n";
    }
    const std::string file = out("ranks.sh");
    writeText(file, script + "esac\n");
    return runProgram(FUSE_FLOW_MPIEXEC, {"-n", std::to_string(commands.size()), "/bin/sh", file});
  }

  /** \brief The clouds of one process. */
  void expectSameClouds(const std::string& folder) const {
    ASSERT_EQ(listing(folder), listing(out_));
    for (const std::string& name : listing(out_))
      EXPECT_EQ(readText(fs::path(folder) / name), readText(out_ / name)) << name;
  }
};

TEST_F(FuseUnderMpirun, RanksThatShareCamerasWriteTheCloudsOfOneProcess) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out()})));
  for (const int ranks : {2, 3}) {
    const std::string folder = out("of_" + std::to_string(ranks));
    const ToolResult result = fuseWith(ranks, {recording(), "-o", folder});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.out.find(std::to_string(ranks) + " ranks: "), std::string::npos) << result.out;
    EXPECT_NE(result.err.find("nothing is measured"), std::string::npos) << result.err;
    expectSameClouds(folder);
  }
  fs::remove_all(out_);
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out(), "--camera-mask"})));
  ASSERT_EQ(fuseWith(3, {recording(), "-o", out("masks"), "--camera-mask"}).exit_code, 0);
  expectSameClouds(out("masks"));
}

TEST_F(FuseUnderMpirun, RanksThatCompressWhatTheySendWriteTheSameClouds) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out()})));
  const ToolResult result = fuseWith(3, {recording(), "-o", out("of_3"), "--rank-compression", "zstd"});
  if (result.err.find("built without Zstandard") != std::string::npos) GTEST_SKIP() << result.err;
  ASSERT_EQ(result.exit_code, 0) << result.err;
  double plain = 0, compressed = 0;
  const std::size_t said = result.out.find(" messages and ");
  ASSERT_NE(said, std::string::npos) << result.out;
  ASSERT_EQ(std::sscanf(result.out.c_str() + said,
                        " messages and %lf MB a frame between them (%*f MB of it points), compressed to %lf MB", &plain,
                        &compressed),
            2)
      << result.out;
  EXPECT_LT(compressed, 0.7 * plain);
  expectSameClouds(out("of_3"));
}

TEST_F(FuseUnderMpirun, RanksGoOnWhereARunEnded) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out()})));
  for (const std::string shared : {"cameras", "frames"}) {
    const std::string folder = out("resumed_" + shared);
    ASSERT_EQ(fuseWith(2, {recording(), "-o", folder, "--ranks", shared}).exit_code, 0);
    fs::remove(fs::path(folder) / "000001.ply");
    writeText(fs::path(folder) / "000000.ply", "of before");
    const ToolResult result = fuseWith(3, {recording(), "-o", folder, "--ranks", shared, "--resume"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out.find("has not written"), std::string::npos) << result.out;
    EXPECT_EQ(readText(fs::path(folder) / "000000.ply"), "of before");
    EXPECT_EQ(readText(fs::path(folder) / "000001.ply"), readText(out_ / "000001.ply"));
    EXPECT_EQ(listing(folder), listing(out_));
  }
}

TEST_F(FuseUnderMpirun, RanksThatShareFramesWriteTheCloudsOfOneProcess) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out()})));
  const ToolResult result = fuseWith(2, {recording(), "-o", out("shared"), "--ranks", "frames"});
  ASSERT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out.find("has not written"), std::string::npos) << result.out;
  expectSameClouds(out("shared"));
}

TEST_F(FuseUnderMpirun, RanksShareCloudsThatEachOfThemReads) {
  ASSERT_EQ(runProgram(FUSE_FLOW_EXPORT_TOOL, {recording(), "-o", out("clouds")}).exit_code, 0);
  std::vector<std::string> clouds;  // the first of each camera
  fs::path camera;
  for (const std::string& name : listing(out("clouds"))) {
    const fs::path cloud = fs::path(out("clouds")) / name;
    if (cloud.extension() != ".pcd" || cloud.parent_path() == camera) continue;
    camera = cloud.parent_path();
    clouds.push_back(cloud.string());
  }
  ASSERT_EQ(clouds.size(), 5u);
  std::vector<std::string> alone = clouds, together = clouds;
  alone.insert(alone.end(), {"-o", out("alone.ply")});
  together.insert(together.end(), {"-o", out("together.ply")});
  ASSERT_TRUE(succeeded(fuse(alone)));
  ASSERT_EQ(fuseWith(2, together).exit_code, 0);
  EXPECT_EQ(readText(out("together.ply")), readText(out("alone.ply")));
}

TEST_F(FuseUnderMpirun, ARankWithoutAFrameOfItsOwnSaysNothing) {
  const ToolResult result = fuseWith(2, {recording(), "-o", out("one.ply"), "--frames", "0:1", "--ranks", "frames"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(fs::exists(out("one.ply")));
  EXPECT_EQ(result.out.find("nan"), std::string::npos) << result.out;
}

TEST_F(FuseUnderMpirun, AnImageThatOneRankCannotReadIsNamedByThatRank) {
  writeText(depthFile(recording_, 3, 1), "damaged");
  const ToolResult result = fuseWith(2, {recording(), "-o", out()});
  EXPECT_NE(result.exit_code, 0);
  EXPECT_NE(result.err.find("fuse_flow_fuse, rank 1: " + depthFile(recording_, 3, 1).string()), std::string::npos)
      << result.err;
  EXPECT_TRUE(fs::exists(out_ / "000000.ply"));
  EXPECT_FALSE(fs::exists(out_ / "000001.ply"));
}

TEST_F(FuseUnderMpirun, WhatNoRankCanDoIsRefusedOnce) {
  const ToolResult result = fuseWith(2, {recording(), "-o", out(), "--method", "concatenate"});
  EXPECT_NE(result.exit_code, 0);
  const std::size_t said = result.err.find("--method concatenate: runs in one process only");
  ASSERT_NE(said, std::string::npos) << result.err;
  EXPECT_EQ(result.err.find("--method concatenate: runs", said + 1), std::string::npos) << result.err;
  EXPECT_FALSE(fs::exists(out_));
}

#if defined(FUSE_FLOW_SIMULATE_TOOL)
/** \brief Three cameras, whose poses are given wrong by a centimetre; one of them is bumped. At 3 frames a second, so that poses are searched in each. */
class PosesUnderMpirun : public FuseUnderMpirun {
 protected:
  void SetUp() override {
    FuseUnderMpirun::SetUp();
    fs::remove_all(recording_);
    ASSERT_TRUE(succeeded(runProgram(
        FUSE_FLOW_SIMULATE_TOOL,
        {"--scene",          "room", "--rig",        "ring-3", "--scale", "0.25",     "--sensor", "time_of_flight",
         "--position-error", "10",   "--frames",     "7",      "--fps",   "3",        "--bump",   "60",
         "--bump-rotation",  "1",    "--bump-frame", "2",      "-o",      recording()})));
    const ToolResult one = fuse({recording(), "-o", out(), "--refine-extrinsics", "--no-quality"});
    ASSERT_EQ(one.exit_code, 0) << one.err;
    ASSERT_NE(one.err.find("has moved by"), std::string::npos) << one.err;
  }
};

TEST_F(PosesUnderMpirun, RanksFollowCamerasAsOneProcessDoes) {
  for (const int ranks : {2, 3, 4}) {
    const std::string folder = out("of_" + std::to_string(ranks));
    const ToolResult result = fuseWith(ranks, {recording(), "-o", folder, "--refine-extrinsics"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const std::size_t said = result.err.find("camera 'camera_02' has moved by");
    ASSERT_NE(said, std::string::npos) << result.err;
    EXPECT_EQ(result.err.find("has moved by", said + 30), std::string::npos) << "once: " << result.err;
    expectSameClouds(folder);
  }
}

// The first rank alone has to be asked for it.
TEST_F(PosesUnderMpirun, RanksOfCamerasThatRunFollowThem) {
  const ToolResult result = runRanks({{FUSE_FLOW_LIVE_TOOL, recording(), "--no-window", "--max-wait", "60000", "-o",
                                       out("live"), "--refine-extrinsics"},
                                      {FUSE_FLOW_LIVE_TOOL, recording(), "--no-window", "--max-wait", "60000"}});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(fs::exists(fs::path(out("live")) / "timestamps.txt"));
  const std::vector<std::string> clouds = listing(out_);
  if (result.out.find("camera_00: 7 views came, 0 were lost before, 7 are in frames") == std::string::npos)
    GTEST_SKIP() << "frames were skipped on a busy machine: " << result.out;
  EXPECT_NE(result.err.find("camera 'camera_02' has moved by"), std::string::npos) << result.err;
  for (const std::string& name : clouds)
    EXPECT_EQ(readText(fs::path(out("live")) / name), readText(out_ / name)) << name;
}
#endif

// Views may be late on a busy machine: all are waited for. Which frames are skipped then is nobody's promise.
TEST_F(FuseUnderMpirun, CamerasThatRunAtSeveralRanksGiveTheCloudsOfOneProcess) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out()})));
  using Command = std::vector<std::string>;
  const Command plays{FUSE_FLOW_LIVE_TOOL, recording()}, first{FUSE_FLOW_LIVE_TOOL, recording(), "--fuse-at", "first"};
  const std::vector<std::vector<Command>> runs = {
      {plays, plays},
      {first, first, first},
      {{FUSE_FLOW_LIVE_TOOL}, plays, plays}};  // in the last, rank 0 has no camera
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const std::string folder = out("live" + std::to_string(k));
    std::vector<Command> commands = runs[k];
    for (Command& command : commands)
      command.insert(command.end(), {"--no-window", "--max-wait", "60000", "-o", folder});
    const ToolResult result = runRanks(commands);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.out.find("camera_4: 3 views came"), std::string::npos) << result.out;
    EXPECT_NE(result.out.find(", 0 of them without all cameras"), std::string::npos) << result.out;
    EXPECT_NE(result.out.find(" ranks: "), std::string::npos) << result.out;
    std::istringstream times(readText(fs::path(folder) / "timestamps.txt"));
    std::string name;
    double time = 0;
    int clouds = 0;
    for (; times >> name >> time; ++clouds) {
      const auto frame = static_cast<std::size_t>(std::lround(time * 30));  // its rate, where it says none
      char number[16];
      std::snprintf(number, sizeof number, "%06zu.ply", frame);
      EXPECT_EQ(readText(fs::path(folder) / name), readText(out_ / number)) << result.out;
    }
    EXPECT_GT(clouds, 0) << result.out << result.err;
  }
}

// A part is played from where the recording begins, not from where its own cameras do.
TEST_F(FuseUnderMpirun, CamerasThatBeginLaterAreStillInStep) {
  WallRecording wall{};
  wall.cameras = 4;
  wall.frames = 8;
  wall.write(recording_);
  for (const std::size_t camera : {2, 3})
    for (std::size_t frame = 0; frame < 3; ++frame) {
      fs::remove(depthFile(recording_, camera, frame));
      fs::remove(colorFile(recording_, camera, frame));
    }
  const ToolResult result = runProgram(FUSE_FLOW_MPIEXEC, {"-n", "2", FUSE_FLOW_LIVE_TOOL, recording(), "--no-window",
                                                           "--max-wait", "300", "-o", out("live")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("camera_0: 8 views came"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("camera_3: 5 views came"), std::string::npos) << result.out;
  double last = 0;
  std::string name;
  std::istringstream times(readText(fs::path(out("live")) / "timestamps.txt"));
  while (times >> name >> last) {
  }
  EXPECT_LT(last, 7.5 / 30) << "the parts were played one after the other";
}

TEST_F(FuseUnderMpirun, WhatIsWrongAtOneLiveRankIsSaidByIt) {
  for (const auto& [wrong, said] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{recording(), "--no-window", "--views", "0"}, "rank 1: --views: ranks share out all cameras"},
           {{recording(), "--no-window", "--min-range", "5", "--max-range", "1"}, "rank 1: --max-range is 1"},
           {{recording()}, "rank 1: the window: no rank has the images"},
           {{recording(), "--no-window", "--play-frames", "0:2"}, "must be the same recording"},
           {{out("nothing"), "--no-window"}, "rank 1"}}) {
    std::vector<std::string> second = wrong;
    second.insert(second.begin(), FUSE_FLOW_LIVE_TOOL);
    const ToolResult result = runRanks({{FUSE_FLOW_LIVE_TOOL, recording(), "--no-window", "-o", out("live")}, second});
    EXPECT_NE(result.exit_code, 0);
    EXPECT_NE(result.err.find(said), std::string::npos) << result.err;
    EXPECT_EQ(result.err.find("has not answered"), std::string::npos) << result.err;
  }
}

TEST_F(FuseUnderMpirun, WhatNoLiveRankCanDoIsRefused) {
  for (const auto& [arguments, said] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"--no-window", "--record", out("a.mcap")}, "--record: no rank has the images of all cameras"},
           {{"--no-window", "--method", "concatenate"}, "--method concatenate: runs in one process only"},
           {{"--no-window", "--preload"}, "--preload: each rank would begin"},
           {{}, "must be --no-window"}}) {
    std::vector<std::string> all{"-n", "2", FUSE_FLOW_LIVE_TOOL, recording()};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const ToolResult result = runProgram(FUSE_FLOW_MPIEXEC, all);
    EXPECT_NE(result.exit_code, 0);
    EXPECT_NE(result.err.find(said), std::string::npos) << result.err;
  }
}

#if defined(FUSE_FLOW_SERVE_TOOL)
TEST_F(FuseUnderMpirun, RanksServeWhatTheyFuse) {
  const ToolResult result = runProgram(FUSE_FLOW_MPIEXEC, {"-n", "2", FUSE_FLOW_SERVE_TOOL, recording(), "--once",
                                                           "--port", "0", "--max-wait", "60000"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("camera_4: 3 views came"), std::string::npos) << result.out;
  EXPECT_NE((result.out + result.err).find("http://127.0.0.1:"), std::string::npos) << result.out << result.err;
}
#endif

}  // namespace
}  // namespace tool_test

#endif
