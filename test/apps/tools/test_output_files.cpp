#include "support/cloud_file.h"
#include "support/tool_fixture.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#include <array>
#include <cerrno>

namespace tool_test {
namespace {

class OutputFiles : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    WallRecording wall{};
    wall.frames = 4;
    wall.write(recording_);
  }
};

TEST_F(OutputFiles, AFolderThatCannotBeMadeIsNamed) {
  writeText(folder_ / "file", "in the way");
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out("file/out")}), 1, {out("file/out"), "cannot be created"}));
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out("file")}), 1, {out("file")}));
  EXPECT_EQ(readText(folder_ / "file"), "in the way");
}

TEST_F(OutputFiles, AFolderInPlaceOfAFileIsNamed) {
  fs::create_directories(out_ / "000001.ply");
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out()}), 1, {out("out/000001.ply"), "folder"}));
  EXPECT_EQ(listing(out_), (std::vector<std::string>{"000000.ply", "000001.ply"}));
}

TEST_F(OutputFiles, AFolderWithoutPermissionIsNamed) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write anywhere";
  fs::create_directory(out_);
  fs::permissions(out_, fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out()}), 1, {out("out/000000.ply"), "cannot be written"}));
  fs::permissions(out_, fs::perms::owner_all);
}

TEST_F(OutputFiles, AReportThatCannotBeWrittenIsNamedAndTheCloudsStay) {
  writeText(folder_ / "file", "in the way");
  EXPECT_EQ(fuse({recording(), "-o", out(), "--report", out("file/report.json")}).exit_code, 1);
  EXPECT_EQ(listing(out_).size(), 4u);
  fs::remove_all(out_);
  fs::create_directory(folder_ / "report.json");
  const ToolResult result = fuse({recording(), "-o", out(), "--report", out("report.json")});
  EXPECT_TRUE(isOneLineError(result, 2, {"--report", out("report.json"), "is a folder"}));
  EXPECT_FALSE(fs::exists(out_));  // found before anything is fused
}

TEST_F(OutputFiles, AReportInThePlaceOfACloudIsRefused) {
  EXPECT_TRUE(isOneLineError(
      fuse({recording(), "-o", out("a.ply"), "--frames", "0", "--report", fs::relative(folder_ / "a.ply").string()}), 2,
      {"--report", "a.ply", "another"}));
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out(), "--report", out("out/000002.ply")}), 2,
                             {"--report", "000002.ply", "another"}));
  EXPECT_FALSE(fs::exists(out("a.ply")));
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(OutputFiles, AnInputIsNotReplaced) {
  const std::string rig = (fs::path(recording()) / "rig.json").string(), before = readText(rig);
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out("a.ply"), "--frames", "0", "--report", rig}), 2,
                             {"--report", rig, "is an input"}));
  EXPECT_EQ(readText(rig), before);
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("a.ply"), "--frames", "0"})));
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("a.ply"), "--frames", "0"})))
      << "what it wrote before is no input";
  EXPECT_TRUE(isOneLineError(runProgram(FUSE_FLOW_EVALUATE_TOOL, {recording(), out("a.ply"), "--json", out("a.ply")}),
                             2, {"--json", "a.ply", "is an input"}));
  ASSERT_TRUE(succeeded(runProgram(FUSE_FLOW_EXPORT_TOOL, {recording(), "-o", out("pcd")})));
  const std::string view = (fs::path(out("pcd/camera_0")) / listing(out("pcd/camera_0")).at(0)).string();
  const std::string bytes = readText(view);
  EXPECT_TRUE(isOneLineError(fuse({view, "-o", view}), 2, {"-o", view, "is an input"}));
  EXPECT_EQ(readText(view), bytes);
}

TEST_F(OutputFiles, WhatIsWithinAnInputIsNotReplaced) {
  const fs::path images = fs::path(recording()) / "camera_0" / "depth";
  const std::string image = (images / listing(images).at(0)).string(), before = readText(image);
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out("a.ply"), "--frames", "0", "--report", image}), 2,
                             {"--report", image, "is an input"}));
  EXPECT_EQ(readText(image), before);
  for (const char* name : {"a.ply", "a.pcd"}) {
    const std::string beside = (fs::path(recording()) / name).string();
    for (int run = 0; run < 2; ++run) EXPECT_TRUE(succeeded(fuse({recording(), "-o", beside, "--frames", "0"})));
  }
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out()})));
  const std::string cloud = out("out/000000.ply");
  EXPECT_TRUE(isOneLineError(evaluate({recording(), out(), "--json", cloud}), 2, {"--json", cloud, "is an input"}));
  EXPECT_TRUE(
      isOneLineError(runProgram(FUSE_FLOW_PICTURE_TOOL, {cloud, "-o", cloud}), 2, {"-o", cloud, "is an input"}));
  writeText(folder_ / "c.ini", "sigma = 0.02\n");
  EXPECT_TRUE(isOneLineError(
      fuse({recording(), "-o", out("a.ply"), "--frames", "0", "--config", out("c.ini"), "--report", out("c.ini")}), 2,
      {"--report", "c.ini", "is an input"}));
}

TEST_F(OutputFiles, ANameThatIsNotUtf8IsReadableInTheFigures) {
  const std::string cloud = out("gr\xfc\xdf.ply");
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", cloud, "--frames", "0"})));
  ASSERT_TRUE(succeeded(evaluate({recording(), cloud, "--json", out("a.json")})));
  EXPECT_TRUE(nlohmann::json::parse(readText(out("a.json"))).contains(out("gr\xef\xbf\xbd\xef\xbf\xbd.ply")));
}

TEST_F(OutputFiles, ADeviceThatIsFullIsNamed) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  fs::create_symlink("/dev/full", folder_ / "full.ply");
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out("full.ply"), "--frames", "0"}), 1,
                             {out("full.ply"), "No space left"}));
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out(), "--report", out("full.ply")}), 1,
                             {out("full.ply"), "No space left"}));
  RunOptions to_full;
  to_full.out_path = "/dev/full";
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out()}, to_full), 1, {"standard output"}));
  EXPECT_TRUE(isOneLineError(evaluate({recording(), out("out/000000.ply")}, to_full), 1, {"standard output"}));
}

TEST_F(OutputFiles, AFileThatWouldGrowTooLargeIsNotLeftHalfWritten) {
  RunOptions limited;
  limited.file_size_limit = 4096;
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out()}, limited), 1, {out("out/000000.ply"), "too large"}));
  EXPECT_EQ(listing(out_), std::vector<std::string>());
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out("single.pcd"), "--frames", "1"}, limited), 1,
                             {out("single.pcd"), "too large"}));
  EXPECT_EQ(listing(folder_ / "single.pcd"), std::vector<std::string>());
  EXPECT_FALSE(fs::exists(out("single.pcd")));
}

TEST_F(OutputFiles, AFileThatWasThereSurvivesAFailure) {
  writeText(folder_ / "cloud.ply", "precious");
  RunOptions limited;
  limited.file_size_limit = 4096;
  EXPECT_EQ(fuse({recording(), "-o", out("cloud.ply"), "--frames", "1"}, limited).exit_code, 1);
  EXPECT_EQ(readText(folder_ / "cloud.ply"), "precious");
  EXPECT_EQ(listing(folder_ / "recording").size(), listing(recording_).size());
}

/** \brief A real disk of a few pages, visible to the one command only; 77 where that is not allowed. */
TEST_F(OutputFiles, AFullDiskKeepsTheWholeFramesAndNothingElse) {
  fs::create_directory(out_);
  const std::string script =
      "mount -t tmpfs -o size=64k none \"$1\" 2>/dev/null || exit 77\n"
      "\"$2\" \"$3\" -o \"$1\" --method concatenate --threads 1; code=$?\n"
      "ls -A \"$1\"; exit $code";
  const ToolResult result =
      runProgram("/bin/sh", {"-c", "exec unshare --user --map-root-user --mount sh -c '" + script + "' sh \"$@\" 2>&1",
                             "sh", out(), FUSE_FLOW_FUSE_TOOL, recording()});
  if (result.out.find("unshare:") != std::string::npos || result.exit_code == 77 || result.exit_code == 127)
    GTEST_SKIP() << "a disk of our own cannot be mounted here: " << result.out;
  EXPECT_EQ(result.exit_code, 1);
  // 32 · 24 · 2 points of 23 bytes are 9 pages of the 16: the second frame does not fit.
  const std::string path = out("out/000001.ply");
  EXPECT_EQ(result.out, "fuse_flow_fuse: " + path + ": cannot be written: No space left on device\n000000.ply\n");
}

/** \brief Of a process that is a child of this one, or of a ForkServer; it remains for the caller that waits for it. */
void waitForEnd(pid_t pid) {
  siginfo_t ended;
  if (waitid(P_PID, static_cast<id_t>(pid), &ended, WEXITED | WNOWAIT) == 0) return;
  const int process = static_cast<int>(syscall(SYS_pidfd_open, pid, 0));
  if (process < 0) {
    ASSERT_EQ(errno, ESRCH);  // else it is not known whether it has ended
    return;
  }
  pollfd polled{process, POLLIN, 0};
  EXPECT_EQ(poll(&polled, 1, 120000), 1);
  close(process);
}

/** \brief Holds the tool at frame 1 for as long as it takes: that frame's file is a pipe, too short for a cloud, which
 *  is read only after the signal. */
class Interrupt : public OutputFiles {
 protected:
  void SetUp() override {
    OutputFiles::SetUp();
    fs::create_directory(out_);
    ASSERT_EQ(mkfifo((out_ / "000001.ply").c_str(), 0600), 0);
  }
  RunOptions interruptAtFrameOne(bool terminal, int signal = SIGINT) {
    RunOptions options;
    options.terminal = terminal;
    options.meanwhile = [this, signal](pid_t pid) {
      const int pipe = open((out_ / "000001.ply").c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
      ASSERT_GE(pipe, 0);
      ASSERT_GT(fcntl(pipe, F_SETPIPE_SZ, 4096), 0);  // less than a cloud
      pollfd polled{pipe, POLLIN, 0};
      const bool begun = poll(&polled, 1, 120000) == 1;
      kill(pid, signal);
      fcntl(pipe, F_SETFL, 0);
      std::array<char, 4096> bytes;
      for (ssize_t count; begun && (count = read(pipe, bytes.data(), bytes.size())) > 0;)
        piped_.append(bytes.data(), static_cast<std::size_t>(count));
      close(pipe);
    };
    return options;
  }
  /** \brief Two signals while frame 2 is being written: a pipe stands where it grows, too. */
  RunOptions interruptTwiceInFrameTwo(int first, int second) {
    RunOptions options;
    options.meanwhile = [=](pid_t pid) {
      const int one = open((out_ / "000001.ply").c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
      ASSERT_GE(one, 0);
      ASSERT_GT(fcntl(one, F_SETPIPE_SZ, 4096), 0);
      pollfd polled{one, POLLIN, 0};
      ASSERT_EQ(poll(&polled, 1, 120000), 1);
      const fs::path part = out_ / ("000002.ply.part" + std::to_string(pid));
      ASSERT_EQ(mkfifo(part.c_str(), 0600), 0);
      const int two = open(part.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
      ASSERT_GE(two, 0);
      ASSERT_GT(fcntl(two, F_SETPIPE_SZ, 4096), 0);
      fcntl(one, F_SETFL, 0);
      std::array<char, 4096> bytes;
      while (read(one, bytes.data(), bytes.size()) > 0) {
      }
      close(one);
      polled.fd = two;
      ASSERT_EQ(poll(&polled, 1, 120000), 1);
      kill(pid, first);
      kill(pid, second);
      waitForEnd(pid);
      close(two);
    };
    return options;
  }
  std::string piped_;
};

TEST_F(Interrupt, FinishesTheFrameAtHandAndExitsWith130) {
  const ToolResult result =
      fuse({recording(), "-o", out(), "--report", out("report.json"), "--no-overlap"}, interruptAtFrameOne(false));
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_EQ(result.err, "fuse_flow_fuse: interrupted after 2 of 4 frames; those are complete\n");
  EXPECT_EQ(listing(out_), (std::vector<std::string>{"000000.ply", "000001.ply"}));
  EXPECT_FALSE(readCloudFile(out_ / "000000.ply").empty());
  EXPECT_EQ(piped_.rfind("ply\n", 0), 0u);
  const nlohmann::json report = nlohmann::json::parse(readText(out("report.json")));
  EXPECT_EQ(report["total"]["frames"], 2);
}

TEST_F(Interrupt, WhatItLeftIsFusedByTheNextRunThatResumes) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("whole")})));
  ASSERT_EQ(fuse({recording(), "-o", out(), "--no-overlap"}, interruptAtFrameOne(false)).exit_code, 130);
  fs::remove(out_ / "000001.ply");  // a pipe
  const std::string first = readText(out_ / "000000.ply");
  ASSERT_EQ(first, readText(out("whole/000000.ply")));
  writeText(out_ / "000000.ply", "of before");
  writeText(out_ / "000002.ply", "");
  const ToolResult result = fuse({recording(), "-o", out(), "--resume", "--report", out("report.json")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("--resume: 1 of 4 clouds are there and stay as they are"), std::string::npos) << result.err;
  EXPECT_EQ(readText(out_ / "000000.ply"), "of before");
  for (const char* name : {"000001.ply", "000002.ply", "000003.ply"})
    EXPECT_EQ(readText(out_ / name), readText(fs::path(out("whole")) / name)) << name;
  EXPECT_EQ(result.out.find("has not written"), std::string::npos) << result.out;
  const nlohmann::json report = nlohmann::json::parse(readText(out("report.json")));
  EXPECT_EQ(report["total"]["frames"], 3);
  EXPECT_EQ(report["clouds_of_before"], 1);

  const ToolResult again = fuse({recording(), "-o", out(), "--resume"});
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_NE(again.err.find("4 of 4 clouds are there"), std::string::npos) << again.err;
  EXPECT_NE(again.err.find("nothing is left to do"), std::string::npos) << again.err;
  EXPECT_EQ(fuse({recording(), "-o", out(), "--resume", "--refine-extrinsics"}).exit_code, 2)
      << "poses are followed from the first frame on";
}

TEST_F(Interrupt, WhoResumesMayReplaceNoMoreThanOthers) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("clouds")})));
  const std::string first = readText(fs::path(out("clouds")) / "000000.ply");
  fs::remove(fs::path(out("clouds")) / "000001.ply");
  const ToolResult report =
      fuse({recording(), "-o", out("clouds"), "--resume", "--report", out("clouds/000000.ply"), "--no-overlap"});
  EXPECT_TRUE(isOneLineError(report, 2, {"--report", "a cloud goes to this file"}));
  EXPECT_EQ(readText(fs::path(out("clouds")) / "000000.ply"), first);
  // Clouds of scanners, into the folder that they are in.
  const ToolResult onto =
      fuse({out("clouds/000000.ply"), out("clouds/000002.ply"), "-o", out("clouds/000000.ply"), "--resume"});
  EXPECT_NE(onto.exit_code, 0) << onto.out;
  EXPECT_EQ(onto.err.find("nothing is left to do"), std::string::npos) << onto.err;
  EXPECT_EQ(readText(fs::path(out("clouds")) / "000000.ply"), first);
}

/** \brief Side by side, some more frames are at hand: each that the message counts is whole, and no other is there. */
TEST_F(Interrupt, SideBySideFinishesTheFramesAtHand) {
  const ToolResult result =
      fuse({recording(), "-o", out(), "--report", out("report.json"), "--threads", "2"}, interruptAtFrameOne(false));
  EXPECT_EQ(result.exit_code, 130);
  const std::vector<std::string> files = listing(out_);
  EXPECT_GE(files.size(), 2u);
  EXPECT_EQ(result.err,
            "fuse_flow_fuse: interrupted after " + std::to_string(files.size()) + " of 4 frames; those are complete\n");
  for (std::size_t k = 0; k < files.size(); ++k)
    if (k != 1) {
      EXPECT_FALSE(readCloudFile(out_ / files[k]).empty());
    }  // which was a pipe
  EXPECT_EQ(nlohmann::json::parse(readText(out("report.json")))["total"]["frames"], files.size());
}

/** \brief Deleted, moved or unmounted: its frames are not those that cameras missed. */
TEST_F(Interrupt, ARecordingThatIsGoneInTheMiddleIsAnError) {
  RunOptions options;
  options.meanwhile = [this](pid_t) {
    const int pipe = open((out_ / "000001.ply").c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    ASSERT_GE(pipe, 0);
    ASSERT_GT(fcntl(pipe, F_SETPIPE_SZ, 4096), 0);  // less than a cloud: the tool waits at frame 1
    pollfd polled{pipe, POLLIN, 0};
    EXPECT_EQ(poll(&polled, 1, 120000), 1);
    fs::remove_all(recording_);
    fcntl(pipe, F_SETFL, 0);
    std::array<char, 4096> bytes;
    while (read(pipe, bytes.data(), bytes.size()) > 0) {
    }
    close(pipe);
  };
  const ToolResult result = fuse({recording(), "-o", out(), "--no-overlap"}, options);
  EXPECT_TRUE(isOneLineError(result, 1, {recording(), "no longer there"}));
  EXPECT_EQ(listing(out_), (std::vector<std::string>{"000000.ply", "000001.ply"})) << "no empty clouds";
}

TEST_F(Interrupt, TheEndOfASessionFinishesTheFrameAtHandToo) {
  for (const int signal : {SIGTERM, SIGHUP}) {
    const ToolResult result = fuse({recording(), "-o", out(), "--no-overlap"}, interruptAtFrameOne(false, signal));
    EXPECT_EQ(result.exit_code, 130) << signal;
    EXPECT_EQ(result.err, "fuse_flow_fuse: interrupted after 2 of 4 frames; those are complete\n") << signal;
    EXPECT_EQ(listing(out_), (std::vector<std::string>{"000000.ply", "000001.ply"})) << signal;
  }
}

TEST_F(Interrupt, ASecondSignalEndsAtOnceAndLeavesNoHalfWrittenFile) {
  for (const auto& [first, second] : {std::make_pair(SIGINT, SIGTERM), std::make_pair(SIGHUP, SIGINT)}) {
    const ToolResult result = fuse({recording(), "-o", out(), "--no-overlap"}, interruptTwiceInFrameTwo(first, second));
    EXPECT_TRUE(result.exit_code == 128 + first || result.exit_code == 128 + second) << result.exit_code;
    EXPECT_EQ(listing(out_), (std::vector<std::string>{"000000.ply", "000001.ply"}));
  }
}

TEST_F(Interrupt, ASignalThatEndsTheProgramLeavesNoHalfWrittenFile) {
  for (const int signal : {SIGQUIT, SIGPIPE, SIGXCPU}) {
    const ToolResult result =
        fuse({recording(), "-o", out(), "--no-overlap"}, interruptTwiceInFrameTwo(signal, signal));
    EXPECT_EQ(result.exit_code, 128 + signal);
    EXPECT_EQ(listing(out_), (std::vector<std::string>{"000000.ply", "000001.ply"})) << signal;
  }
}

TEST_F(Interrupt, OnATerminalTheMessageHasALineOfItsOwn) {
  const ToolResult result = fuse({recording(), "-o", out(), "--no-overlap"}, interruptAtFrameOne(true));
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_NE(result.err.find("\nfuse_flow_fuse: interrupted"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace tool_test
