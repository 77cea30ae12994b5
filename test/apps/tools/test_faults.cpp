// What tools do when disks, memory and threads fail them: test/faults/faults.cpp makes calls of theirs fail. A tool either does all that it does
// without the fault, or ends with one line that says what is wrong, and leaves nothing half-written.
#include "support/tool_fixture.h"

#include <tbb/version.h>

#include <cerrno>
#include <functional>
#include <map>
#include <memory>

namespace tool_test {
namespace {

/** \brief A tool and what it is to do. */
struct Task {
  std::string name;
  std::string tool;
  std::function<std::vector<std::string>(const std::string& recording, const std::string& output)> arguments;
};

std::vector<Task> tasks() {
  std::vector<Task> result{
      {"fuse", FUSE_FLOW_FUSE_TOOL,
       [](const std::string& recording, const std::string& output) {
         return std::vector<std::string>{recording, "-o", output, "--report", output + "/report.json"};
       }},
      {"export", FUSE_FLOW_EXPORT_TOOL,
       [](const std::string& recording, const std::string& output) {
         return std::vector<std::string>{recording, "-o", output};
       }},
      {"record", FUSE_FLOW_RECORD_TOOL, [](const std::string& recording, const std::string& output) {
         return std::vector<std::string>{recording, "-o", output + "/recording.mcap"};
       }}};
  return result;
}

class Faults : public ToolTest, public testing::WithParamInterface<Task> {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    WallRecording wall{};
    wall.write(recording_);
  }

  /** \brief Files by name, without the bytes of those that depend on how long something took: reports, and the chunks of a recording. */
  std::map<std::string, std::string> files() const {
    std::map<std::string, std::string> result;
    if (!fs::exists(out_)) return result;
    for (const auto& entry : fs::recursive_directory_iterator(out_))
      if (entry.is_regular_file())
        result[fs::relative(entry.path(), out_).string()] =
            entry.path().extension() == ".ply" || entry.path().extension() == ".pcd" ? readText(entry.path()) : "";
    return result;
  }

  /** \brief Runs the tool into an empty folder. */
  ToolResult run(const std::string& faults) {
    fs::remove_all(out_);
    fs::remove(fired_path());
    RunOptions options;
    if (!faults.empty())
      options.environment = {"LD_PRELOAD=" FUSE_FLOW_FAULTS_LIBRARY, "FUSE_FLOW_FAULTS=" + faults,
                             "FUSE_FLOW_FAULTS_IN=" + folder_.string(),
                             "FUSE_FLOW_FAULTS_FIRED=" + fired_path().string()};
    return runProgram(GetParam().tool, GetParam().arguments(recording(), out()), options);
  }

  fs::path fired_path() const { return folder_ / "fired"; }
  bool fired() const { return fs::exists(fired_path()); }

  /** \brief The first call of a kind fails, then the second, … until the tool makes no more of them. \returns how many did */
  int sweep(const std::string& kind) {
    const std::map<std::string, std::string> expected = [&] {
      EXPECT_TRUE(succeeded(run("")));
      return files();
    }();
    for (int n = 1; n < 200; ++n) {
      SCOPED_TRACE(kind + " " + std::to_string(n));
      const ToolResult result = run(kind + ":" + std::to_string(n));
      if (!fired()) {
        EXPECT_TRUE(succeeded(result));
        return n - 1;
      }
      if (result.exit_code == 0) {  // it has done without
        EXPECT_EQ(files(), expected);
      } else {
        EXPECT_TRUE(isOneLineError(result, 1, {}));
        for (const auto& [name, bytes] : files()) {
          EXPECT_EQ(name.find(".part"), std::string::npos) << name;
          EXPECT_TRUE(expected.count(name) == 0 || bytes == expected.at(name)) << name;
        }
      }
      if (HasFailure()) return n;
    }
    ADD_FAILURE() << kind << ": no end";
    return 0;
  }
};

TEST_P(Faults, ReadsAndWritesInPiecesGiveTheSameFiles) {
  ASSERT_TRUE(succeeded(run("")));
  const std::map<std::string, std::string> expected = files();
  ASSERT_FALSE(expected.empty());
  for (const std::string faults : {"short", "interrupt", "slow", "short interrupt"}) {
    SCOPED_TRACE(faults);
    EXPECT_TRUE(succeeded(run(faults)));
    EXPECT_TRUE(fired());
    EXPECT_EQ(files(), expected);
  }
}

TEST_P(Faults, AClockThatJumpsChangesNothing) {
  ASSERT_TRUE(succeeded(run("")));
  const std::map<std::string, std::string> expected = files();
  EXPECT_TRUE(succeeded(run("clock")));
  EXPECT_EQ(files(), expected);
}

TEST_P(Faults, ADiskThatCannotBeReadIsAnError) { EXPECT_GT(sweep("read:" + std::to_string(EIO)), 4); }

TEST_P(Faults, ADiskThatIsFullIsAnError) { EXPECT_GT(sweep("write:" + std::to_string(ENOSPC)), 1); }

TEST_P(Faults, TooManyOpenFilesAreAnError) { EXPECT_GT(sweep("open:" + std::to_string(EMFILE)), 4); }

TEST_P(Faults, MemoryThatCannotBeHadIsAnError) { sweep("memory:20000"); }

/** \brief Embree holds the scenes of the simulator. */
TEST_F(ToolTest, ASceneThatDoesNotFitIntoMemoryIsAnError) {
  const std::vector<std::string> arguments{"--scene", "table", "--rig", "ring-1", "--scale", "0.05", "-o", out()};
#if TBB_VERSION_MAJOR >= 2022 || (TBB_VERSION_MAJOR == 2021 && TBB_VERSION_MINOR >= 11)
  int hangs = 1;  // oneTBB 2021.11 and 2022.1 wait for themselves if the memory that they begin with cannot be had
#else
  int hangs = 0;
#endif
  for (int n = 1; n < 60; ++n) {
    SCOPED_TRACE(n);
    fs::remove_all(out_);
    RunOptions options;
    options.environment = {"LD_PRELOAD=" FUSE_FLOW_FAULTS_LIBRARY,
                           "FUSE_FLOW_FAULTS=memory:300000:" + std::to_string(n),
                           "FUSE_FLOW_FAULTS_FIRED=" + (folder_ / "fired").string()};
    const ToolResult result = runProgram(FUSE_FLOW_SIMULATE_TOOL, arguments, options);
    if (!fs::remove(folder_ / "fired")) {
      EXPECT_EQ(result.exit_code, 0) << result.err;
      EXPECT_GT(n, 2);
      return;
    }
    if (result.timed_out && hangs-- > 0) continue;
    if (result.exit_code != 0) {
      EXPECT_EQ(result.exit_code, 1);
      EXPECT_NE(result.err.find("fuse_flow_simulate: "), std::string::npos) << result.err;  // VTK has a line too
    }
    if (HasFailure()) return;
  }
  ADD_FAILURE() << "no end";
}

TEST_P(Faults, ThreadsThatCannotBeStartedAreAnError) { sweep("thread:0"); }

INSTANTIATE_TEST_SUITE_P(Tools, Faults, testing::ValuesIn(tasks()), [](const auto& task) { return task.param.name; });

}  // namespace
}  // namespace tool_test
