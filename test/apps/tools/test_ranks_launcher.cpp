#if defined(FUSE_FLOW_MPIEXEC)

#include "support/tool_fixture.h"

#include <cstdlib>

namespace tool_test {
namespace {

// fuse_flow_ranks: several computers, which are this one under other names. What stands for ssh runs a command here, unless there is a file that says
// that the computer is down.
class RanksLauncher : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    WallRecording wall{};
    wall.cameras = 6;
    wall.frames = 40;  // that a rank which is to end among them does
    wall.width = 128;
    wall.height = 96;
    wall.color = false;
    wall.write(recording_);
    // As root in a container, and over no network but this computer's own.
    for (const auto& [name, value] : {std::pair<const char*, const char*>{"OMPI_ALLOW_RUN_AS_ROOT", "1"},
                                      {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"},
                                      {"OMPI_MCA_mpi_yield_when_idle", "1"},
                                      {"OMPI_MCA_pml", "ob1"},
                                      {"OMPI_MCA_btl", "self,tcp"},
                                      {"OMPI_MCA_btl_tcp_if_include", "lo"},
                                      {"OMPI_MCA_oob_tcp_if_include", "lo"}})
      setenv(name, value, 1);
    writeScript(
        "shell",
        "host=$1; shift\n"
        "if [ -e " +
            out("down.") +
            "$host ]; then echo 'ssh: No route to host' >&2; exit 255; fi\n"
            // Each has a folder of Open MPI's own, as on computers of their own: two would make one at the same time, and fail.
            "mkdir -p " +
            out("t.") + "$host; TMPDIR=" + out("t.") +
            "$host\n"
            "export TMPDIR\n"
            "exec sh -c \"$*\"\n");
    // at CLOUD SIGNAL HOST COMMAND…: the first time a rank sends itself a signal once the cloud is there, and its host is down if it has one.
    writeScript("at",
                "cloud=$1 signal=$2 host=$3; shift 3\n"
                "if [ \"$RUN\" = 0 ]; then\n"
                "  (while [ ! -e \"$cloud\" ]; do :; done\n"
                "   if [ \"$host\" != - ]; then : > " +
                    out("down.") +
                    "$host; fi\n"
                    "   kill -$signal $$) > /dev/null 2>&1 &\n"
                    "fi\n"
                    "exec \"$@\"\n");
  }

  void writeScript(const std::string& name, const std::string& text) const {
    writeText(out(name), "#!/bin/sh\n" + text);
    fs::permissions(out(name), fs::perms::owner_all);
  }

  /** \brief What a rank fuses, in a shell's words. */
  std::string fusion(const std::string& folder) const {
    return std::string(FUSE_FLOW_FUSE_TOOL) + " " + recording() + " -o " + out(folder);
  }
  /** \brief The same, where the second cloud that is written makes the rank send itself a signal. */
  std::string fusionUntil(const std::string& signal, const std::string& host, const std::string& folder) const {
    return out("at") + " " + out(folder) + "/000002.ply " + signal + " " + host + " " + fusion(folder);
  }

  ToolResult launch(const std::vector<std::string>& lines, std::vector<std::string> options = {}) const {
    std::string text = "# a comment\n\n";
    for (const std::string& line : lines) text += line + "\n";
    writeText(out("hosts"), text);
    options.insert(options.end(), {"--mpirun", FUSE_FLOW_MPIEXEC, "--remote-shell", out("shell"), out("hosts")});
    return runProgram(FUSE_FLOW_RANKS_TOOL, options);
  }

  void expectSameClouds(const std::string& folder) const {
    ASSERT_EQ(listing(out(folder)), listing(out_));
    for (const std::string& name : listing(out_))
      EXPECT_EQ(readText(fs::path(out(folder)) / name), readText(out_ / name)) << name;
  }
};

bool says(const ToolResult& result, const std::string& text) { return result.err.find(text) != std::string::npos; }

TEST_F(RanksLauncher, StartsARankOnEachComputer) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out(), "--no-quality"})));
  const ToolResult result = launch(
      {"localhost OMP_NUM_THREADS=1 " + fusion("all"), "127.0.0.2 " + fusion("all"), "127.0.0.3 " + fusion("all")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("3 ranks: "), std::string::npos) << result.out;
  expectSameClouds("all");
  const ToolResult alike =
      runProgram(FUSE_FLOW_RANKS_TOOL, {"--mpirun", FUSE_FLOW_MPIEXEC, "--hosts", "localhost,localhost", "--",
                                        FUSE_FLOW_FUSE_TOOL, recording(), "-o", out("two")});
  ASSERT_EQ(alike.exit_code, 0) << alike.err;
  EXPECT_NE(alike.out.find("2 ranks: "), std::string::npos) << alike.out;
  expectSameClouds("two");
}

TEST_F(RanksLauncher, WaitsForRanksThatEndLaterThanRank0) {
  const ToolResult result = launch({"localhost sleep 1", "127.0.0.2 sleep 10"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  // But not for a computer that is gone.
  writeScript("gone", ": > " + out("down.") + "127.0.0.2; exec sleep 1000\n");
  const ToolResult gone = launch({"localhost sleep 1", "127.0.0.2 " + out("gone")});
  EXPECT_NE(gone.exit_code, 0);
  EXPECT_TRUE(says(gone, "rank 1 on 127.0.0.2 does not answer")) << gone.err;
}

TEST_F(RanksLauncher, SaysWhichRankWasKilledAndEnds) {
  const ToolResult result = launch({"localhost " + fusion("all"), "127.0.0.2 " + fusionUntil("KILL", "-", "all")});
  EXPECT_NE(result.exit_code, 0);
  EXPECT_TRUE(says(result, "fuse_flow_ranks: rank 1 on 127.0.0.2 failed (ended by signal 9")) << result.err;
}

TEST_F(RanksLauncher, GoesOnWhereAKilledRankEndedAll) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out(), "--no-quality"})));
  for (const std::string killed : {"0", "1"}) {
    const ToolResult result =
        launch({"localhost " + (killed == "0" ? fusionUntil("KILL", "-", "of_0") : fusion("of_1")),
                "127.0.0.2 " + (killed == "1" ? fusionUntil("KILL", "-", "of_1") : fusion("of_0"))},
               {"--keep-going"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(says(result, "fuse_flow_ranks: rank " + killed + " on ")) << result.err;
    EXPECT_TRUE(says(result, "clouds are there and stay as they are")) << result.err;
    expectSameClouds("of_" + killed);
  }
}

TEST_F(RanksLauncher, GoesOnWhereAStoppedRankMadeTheOthersWait) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out(), "--no-quality"})));
  const ToolResult result = launch(
      {"localhost " + fusion("all"), "127.0.0.2 " + fusionUntil("STOP", "-", "all"), "127.0.0.3 " + fusion("all")},
      {"--keep-going"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(says(result, "fuse_flow_ranks: rank 1 on 127.0.0.2 failed (has not answered rank ")) << result.err;
  expectSameClouds("all");
}

TEST_F(RanksLauncher, GoesOnWithoutAComputerThatIsLost) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out(), "--no-quality"})));
  const ToolResult result =
      launch({"localhost " + fusion("all"), "127.0.0.2 " + fusionUntil("KILL", "127.0.0.2", "all"),
              "127.0.0.3 " + fusion("all")},
             {"--keep-going"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(says(result, "rank 1 on 127.0.0.2 does not answer (ssh: No route to host): the others share"))
      << result.err;
  EXPECT_TRUE(says(result, "has ended, without rank 1 on 127.0.0.2")) << result.err;
  EXPECT_NE(result.out.find("2 ranks: "), std::string::npos) << result.out;
  expectSameClouds("all");
}

TEST_F(RanksLauncher, LeavesOutTheCamerasOfAComputerThatHadTheirImagesAlone) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out(), "--no-quality"})));
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("without"), "--views", "0,1,4,5", "--no-quality"})));
  const ToolResult result =
      launch({"localhost " + fusion("all"), "127.0.0.2 " + fusionUntil("KILL", "127.0.0.2", "all"),
              "127.0.0.3 " + fusion("all")},
             {"--keep-going", "--own-images", "6"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(says(result, "without its cameras, number 2,3")) << result.err;
  EXPECT_EQ(readText(fs::path(out("all")) / "000000.ply"), readText(out_ / "000000.ply"));
  EXPECT_EQ(readText(fs::path(out("all")) / "000039.ply"), readText(fs::path(out("without")) / "000039.ply"));
}

TEST_F(RanksLauncher, LeavesOutARankThatFailsAgainAndAgain) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out(), "--no-quality"})));
  const ToolResult result =
      launch({"localhost " + fusion("all"), "127.0.0.2 sh -c 'kill -SEGV $$'"}, {"--keep-going", "--failures", "2"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(says(result, "rank 1 on 127.0.0.2 failed 2 times within a minute (ended by signal 11")) << result.err;
  expectSameClouds("all");
  const ToolResult first =
      launch({"localhost sh -c 'kill -SEGV $$'", "127.0.0.2 sleep 60"}, {"--keep-going", "--failures", "2"});
  EXPECT_NE(first.exit_code, 0);
  EXPECT_TRUE(says(first, "and cannot be left out")) << first.err;
}

TEST_F(RanksLauncher, TakesInAComputerThatIsBack) {
  writeText(out("down.127.0.0.2"), "");
  const std::string plays =
      std::string(FUSE_FLOW_LIVE_TOOL) + " " + recording() + " --no-window --loop --max-wait 60000";
  writeScript("first", "if [ $RUN = 0 ]; then rm " + out("down.127.0.0.2") + "; exec " + plays + "; fi\n" + "exec " +
                           plays + " --seconds 1\n");
  const ToolResult result =
      launch({"localhost " + out("first"), "127.0.0.2 " + plays}, {"--keep-going", "--look-every", "1"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(says(result, "rank 1 on 127.0.0.2 does not answer")) << result.err;
  EXPECT_TRUE(says(result, "rank 1 on 127.0.0.2 answers again")) << result.err;
  EXPECT_NE(result.out.find("2 ranks: "), std::string::npos) << result.out;
}

TEST_F(RanksLauncher, EndsInOrderWhenItIsInterrupted) {
  const std::string plays =
      std::string(FUSE_FLOW_LIVE_TOOL) + " " + recording() + " --no-window --loop --max-wait 60000 -o " + out("live");
  writeScript("first", "(while [ ! -e " + out("live") + "/000001.ply ]; do sleep 0.1; done; kill -INT $(cat " +
                           out("pid") + ")) &\nexec " + plays + "\n");
  RunOptions options;
  options.meanwhile = [&](pid_t pid) { writeText(out("pid"), std::to_string(pid)); };
  writeText(out("hosts"), "localhost " + out("first") + "\n127.0.0.2 " + plays + "\n");
  setenv("FUSE_FLOW_TEST_LARGE", std::string(100000, 'x').c_str(), 1);  // rank 0 is found in an environment of any size
  const ToolResult result = runProgram(
      FUSE_FLOW_RANKS_TOOL, {"--mpirun", FUSE_FLOW_MPIEXEC, "--remote-shell", out("shell"), out("hosts")}, options);
  unsetenv("FUSE_FLOW_TEST_LARGE");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("camera_5: "), std::string::npos) << "the summary of live: " << result.out;
}

TEST_F(RanksLauncher, RefusesWhatIsWrong) {
  const std::string live = std::string(FUSE_FLOW_LIVE_TOOL) + " " + recording() + " --no-window -o " + out("live");
  for (const auto& [lines, options, said] :
       std::vector<std::tuple<std::vector<std::string>, std::vector<std::string>, std::string>>{
           {{}, {}, "has no line with a host and a command"},
           {{"localhost"}, {}, "hosts:3: must be a host and a command"},
           {{"-x y"}, {}, "is no name of a host"},
           {{"127.0.0.2 " + fusion("all")}, {}, "rank 0 must be on this computer"},
           {{"localhost a", "127.0.0.2 a", "localhost a"}, {}, "its lines must follow each other"},
           {{"localhost " + live}, {"--keep-going"}, "-o: each start would replace"},
           {{"localhost " + live}, {"--own-images", "4"}, "is for fuse_flow_fuse"},
           {{"localhost " + fusion("all") + " --views 1"}, {"--own-images", "4"}, "--views, which must be left out"},
           {{"localhost a"}, {"--failures", "x"}, "--failures: is x, must be a whole number"},
           {{"localhost a"}, {"--no-such"}, "--no-such: is no option"}})
    EXPECT_TRUE(isOneLineError(launch(lines, options), 2, {said})) << said;
}

}  // namespace
}  // namespace tool_test

#endif
