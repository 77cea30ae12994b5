#include "../tools/support/run_tool.h"
#include "../tools/support/wall_recording.h"
#include "recordings/images/image_io.h"
#include "viewer_fixture.h"

#include <X11/Xlib.h>
#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <functional>
#include <thread>

namespace viewer_test {
namespace {

using tool_test::RunOptions;
using tool_test::runProgram;
using tool_test::ToolResult;

/** \brief As a window manager does when the cross in the corner is clicked. */
void closeWindow(const std::string& number) {
  Display* display = XOpenDisplay(nullptr);
  ASSERT_NE(display, nullptr);
  XEvent event{};
  event.xclient.type = ClientMessage;
  event.xclient.window = std::stoul(number);
  event.xclient.message_type = XInternAtom(display, "WM_PROTOCOLS", False);
  event.xclient.format = 32;
  event.xclient.data.l[0] = static_cast<long>(XInternAtom(display, "WM_DELETE_WINDOW", False));
  XSendEvent(display, event.xclient.window, False, NoEventMask, &event);
  XCloseDisplay(display);
}

/** \brief The program as it is installed, with a window where it has one, and real keys. */
class ViewerProgram : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "fuse_flow_viewer_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr) << pattern;
    folder_ = pattern;
    tool_test::WallRecording wall{};
    wall.frames = 4;
    wall.write(folder_ / "recording");
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  ToolResult view(const std::vector<std::string>& more, const RunOptions& options = {}) const {
    std::vector<std::string> arguments{path("recording"), "--device", "cpu", "--width", "320", "--height", "240"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return runProgram(FUSE_FLOW_VIEWER_TOOL, arguments, options);
  }

  static void expectError(const ToolResult& result, int code, const std::vector<std::string>& words) {
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_EQ(result.err.rfind("fuse_flow_viewer: ", 0), 0u) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    for (const std::string& word : words) EXPECT_NE(result.err.find(word), std::string::npos) << result.err;
  }

  /** \brief Presses a key of the window, again and again, until the file that it writes is there. */
  static void pressUntil(const std::string& key, const fs::path& file) {
    const std::string press =
        "xdotool key --window $(xdotool search --sync --onlyvisible --name FUSE-Flow | head -1) " + key +
        " 2> /dev/null";
    for (int k = 0; k < 600 && !fs::exists(file); ++k) {
      EXPECT_EQ(std::system(press.c_str()), 0);
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }

  /** \brief Closes the window after what is to be waited for. */
  void expectToEndWithItsWindow(const std::function<void()>& wait) const {
    RunOptions options;
    std::chrono::steady_clock::time_point closed;
    options.meanwhile = [&](pid_t) {
      pressUntil("j", path("screenshot_000.png"));
      const std::string find = "xdotool search --sync --onlyvisible --name FUSE-Flow > " + path("window");
      EXPECT_EQ(std::system(find.c_str()), 0);
      wait();
      closeWindow(tool_test::readText(path("window")));
      closed = std::chrono::steady_clock::now();
    };
    const ToolResult result = view({"--folder", folder_.string()}, options);
    EXPECT_LT(std::chrono::steady_clock::now() - closed, std::chrono::seconds(10))
        << "within a second, were it alone here";
    EXPECT_FALSE(result.timed_out);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }

  fs::path folder_;
};

TEST_F(ViewerProgram, WritesWhatIsAskedWithoutAWindow) {
  const ToolResult result = view({"--offscreen", "--screenshot", path("shot.png"), "--save-cloud", path("cloud.pcd"),
                                  "--orbit", path("orbit"), "--orbit-pictures", "2", "--compare", "concatenate"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  io::ColorImage shot;
  io::readColor(path("shot.png"), shot);
  EXPECT_EQ(shot.width, 320);
  EXPECT_GT(filled(shot), 0.2);
  EXPECT_TRUE(fs::exists(path("cloud.pcd")));
  EXPECT_TRUE(fs::exists(path("orbit/000001.png")));
}

TEST_F(ViewerProgram, SimulatedCamerasNeedNoRecording) {
  const ToolResult result = runProgram(
      FUSE_FLOW_VIEWER_TOOL, {"--simulate", "table", "--rig", "ring-2", "--sensor", "ideal", "--scale", "0.1",
                              "--width", "320", "--height", "240", "--offscreen", "--screenshot", path("shot.png")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(fs::exists(path("shot.png")));
}

TEST_F(ViewerProgram, TakesRealKeysAndEndsWithQ) {
  RunOptions options;
  options.meanwhile = [&](pid_t) {
    pressUntil("j", path("screenshot_000.png"));
    pressUntil("ctrl+w", path("frame_000000_FUSE_Flow_000.ply"));
    // Only what is shown: hidden windows of tests before this one have the same name.
    const char* press =
        "xdotool keydown --window $(xdotool search --onlyvisible --name FUSE-Flow | head -1) q 2> /dev/null";
    EXPECT_EQ(std::system(press), 0);  // not released: the window may be gone by then
  };
  const ToolResult result = view({"--paused", "--folder", folder_.string()}, options);
  EXPECT_FALSE(result.timed_out);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(fs::exists(path("screenshot_000.png")));
  EXPECT_TRUE(fs::exists(path("frame_000000_FUSE_Flow_000.ply")));
}

TEST_F(ViewerProgram, RealKeysChangeWhatIsSeen) {
  RunOptions options;
  options.meanwhile = [&](pid_t) {
    int number = 0;
    const auto screenshot = [&] {
      char name[32];
      std::snprintf(name, sizeof(name), "screenshot_%03d", number++);
      pressUntil("j", path(name + std::string(".cam")));  // written behind the picture
      io::ColorImage image;
      io::readColor(path(name + std::string(".png")), image);
      image.height = 100;  // pixels: above what is said and titles
      image.data.resize(static_cast<std::size_t>(image.width) * 100);
      return image;
    };
    io::ColorImage before = screenshot();
    EXPECT_GT(filled(before), 0.05);
    for (const std::string key : {"1", "v"}) {
      const std::string press =
          "xdotool key --window $(xdotool search --onlyvisible --name FUSE-Flow | head -1) " + key + " 2> /dev/null";
      EXPECT_EQ(std::system(press.c_str()), 0);
      io::ColorImage after = screenshot();
      // What a key asks for takes a while to be fused.
      for (int k = 0; k < 100 && difference(after, before) < 0.005; ++k) after = screenshot();
      EXPECT_GT(difference(after, before), 0.005) << key;
      EXPECT_GT(filled(after), 0.05) << key;
      before = after;
    }
    // Down alone: the window may be gone before the key is released, which xdotool calls a failure.
    EXPECT_EQ(std::system("xdotool keydown --window $(xdotool search --onlyvisible --name FUSE-Flow | head -1) q "
                          "2> /dev/null"),
              0);
  };
  const ToolResult result =
      runProgram(FUSE_FLOW_VIEWER_TOOL,
                 {"--simulate", "table", "--rig", "ring-3", "--scale", "0.2", "--device", "cpu", "--paused", "--width",
                  "320", "--height", "240", "--press", "t,i,y", "--folder", folder_.string()},
                 options);
  EXPECT_FALSE(result.timed_out);
  EXPECT_EQ(result.exit_code, 0) << result.err;
}

TEST_F(ViewerProgram, EndsWithItsWindowWhileItPlays) {
  expectToEndWithItsWindow([] {});
}

// As on a disk that is asleep, or over a network that is gone: who opens a file on which another process has a lease waits.
TEST_F(ViewerProgram, EndsWithItsWindowWhileItWaitsForAFile) {
  fs::path image;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder_ / "recording"))
    if (entry.path().filename() == "000002.png" && entry.path().parent_path().filename() == "depth")
      image = entry.path();
  ASSERT_FALSE(image.empty());
  const int file = open(image.c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_GE(file, 0);
  fcntl(file, F_SETSIG, SIGURG);  // said when someone waits; SIGIO would end this process
  if (fcntl(file, F_SETLEASE, F_WRLCK) != 0) {
    close(file);
    GTEST_SKIP() << "no leases on files where temporary ones are";
  }
  expectToEndWithItsWindow([&] {
    const auto isWaitedFor = [&] { return fcntl(file, F_GETLEASE) != F_WRLCK; };
    for (int k = 0; k < 600 && !isWaitedFor(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    EXPECT_TRUE(isWaitedFor());
  });
  close(file);
}

TEST_F(ViewerProgram, AnInterruptEndsItAsItEndsTheOtherTools) {
  RunOptions options;
  options.meanwhile = [](pid_t viewer) {
    EXPECT_EQ(std::system("xdotool search --sync --onlyvisible --name FUSE-Flow > /dev/null"), 0);
    kill(viewer, SIGINT);
  };
  EXPECT_EQ(view({}, options).exit_code, 130);
}

TEST_F(ViewerProgram, RefinesPosesFromTheStart) {
  for (const char* more : {"--paused", "--refine-extrinsics"})
    EXPECT_EQ(runProgram(FUSE_FLOW_VIEWER_TOOL, {"--simulate", "table", "--rig", "ring-3", "--scale", "0.2",
                                                 "--position-error", "20", more, "--width", "320", "--height", "240",
                                                 "--offscreen", "--screenshot", path(more + std::string(".png"))})
                  .exit_code,
              0);
  io::ColorImage given, refined;
  io::readColor(path("--paused.png"), given);
  io::readColor(path("--refine-extrinsics.png"), refined);
  EXPECT_GT(difference(given, refined), 0.01);
}

TEST_F(ViewerProgram, PressesKeysByItself) {
  const ToolResult result = view({"--paused", "--press", "Right,Right,ctrl+w", "--folder", folder_.string(),
                                  "--offscreen", "--screenshot", path("shot.png")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(fs::exists(path("frame_000002_FUSE_Flow_000.ply")));
}

TEST_F(ViewerProgram, GoesOnAtTheBeginningUnlessItIsToPlayOnce) {
  for (const char* more : {"--paused", "--once"})
    EXPECT_EQ(view({more, "--paused", "--start", "3", "--press", "Right,ctrl+w", "--folder", folder_.string(),
                    "--offscreen", "--screenshot", path("shot.png")})
                  .exit_code,
              0);
  EXPECT_TRUE(fs::exists(path("frame_000000_FUSE_Flow_000.ply")));
  EXPECT_TRUE(fs::exists(path("frame_000003_FUSE_Flow_000.ply")));
}

TEST_F(ViewerProgram, AFilmThatCannotBeWrittenIsNamed) {
  fs::create_directory(path("taken.ogv"));
  expectError(view({"--offscreen", "--orbit", path("taken.ogv"), "--orbit-pictures", "2"}), 1,
              {path("taken.ogv"), "cannot be written"});
}

TEST_F(ViewerProgram, WithoutADisplayItSaysHowToGetOne) {
  expectError(runProgram("/usr/bin/env", {"-u", "DISPLAY", FUSE_FLOW_VIEWER_TOOL, path("recording")}), 1,
              {"DISPLAY is not set", "xvfb-run"});
  expectError(runProgram("/usr/bin/env", {"DISPLAY=:987", FUSE_FLOW_VIEWER_TOOL, path("recording")}), 1,
              {":987", "cannot be opened"});
}

TEST_F(ViewerProgram, ADisplayWithoutOpenGLIsNamed) {
  const std::string script =
      "Xvfb -displayfd 1 -screen 0 640x480x24 -extension GLX > $1/display 2> /dev/null & "
      "until [ -s $1/display ]; do sleep 0.05; done; "
      "DISPLAY=:$(cat $1/display) $0 $1/recording; code=$?; kill $!; exit $code";
  expectError(runProgram("/bin/sh", {"-c", script, FUSE_FLOW_VIEWER_TOOL, folder_.string()}), 1, {"no OpenGL"});
}

TEST_F(ViewerProgram, AWrongInputIsNamedBeforeAWindowOpens) {
  expectError(runProgram(FUSE_FLOW_VIEWER_TOOL, {path("nothing")}), 1, {path("nothing"), "not found"});
  expectError(runProgram(FUSE_FLOW_VIEWER_TOOL, {}), 2, {"--simulate"});
  expectError(runProgram(FUSE_FLOW_VIEWER_TOOL, {"--simulate", "moon"}), 2, {"moon"});
  for (std::size_t camera = 0; camera < 2; ++camera)
    fs::resize_file(tool_test::depthFile(folder_ / "recording", camera, 0), 60);
  expectError(view({}), 1, {"000000.png", "--start"});
}

TEST_F(ViewerProgram, TheHelpOfItsCommandLineIsInWords) {
  const std::string help = runProgram(FUSE_FLOW_VIEWER_TOOL, {"--help"}).out;
  for (const char* words : {"{side,split}", "{camera,confidence,", "--paused  "})
    EXPECT_NE(help.find(words), std::string::npos) << help;
}

TEST_F(ViewerProgram, AnOptionThatCannotBeUsedIsNamed) {
  expectError(view({"--start", "4"}), 2, {"--start", "4"});
  expectError(view({"--press", "space,F12"}), 2, {"--press", "F12"});
  expectError(view({"--color-by", "heat"}), 2, {"--color-by", "'heat'", "must be one of camera,confidence,"});
  expectError(view({"--color-by", "truth"}), 2, {"--color-by truth", "not known"});
  expectError(view({"--press", "3:x"}), 2, {"--press", "3:x"});
  expectError(view({"--screenshot", path("shot.png")}), 2, {"--offscreen"});
  expectError(view({"--orbit", path("film.ogv")}), 2, {"--offscreen", "--folder", "--film-format"});
  expectError(view({"--film-format", "gif"}), 2, {"--film-format", "png"});
  expectError(view({"--offscreen"}), 2, {"--screenshot"});
  expectError(view({"--offscreen", "--save-cloud", path("cloud.stl")}), 2, {"cloud.stl", ".ply", ".ifs"});
  expectError(view({"--rig", "ring-2"}), 2, {"--rig", "--simulate"});
  expectError(view({"--refine-extrinsics", "--slide", "1"}), 2, {"--refine-extrinsics", "--slide"});
  expectError(view({"--compare", "magic"}), 2, {"--compare", "voxel_grid"});
  expectError(view({"--sigma", "-1"}), 2, {"--sigma", "-1"});
  expectError(view({"--point-size", "1e9"}), 2, {"--point-size", "1e9", "100"});
  expectError(view({"--offscreen", "--screenshot", path("shot.gif")}), 2, {"--screenshot", "shot.gif", ".png"});
  expectError(runProgram(FUSE_FLOW_VIEWER_TOOL, {"--simulate", "nowhere"}), 2, {"--simulate", "nowhere", "room"});
}

/** \brief Such a server goes with its last client; others, xvfb-run's too, begin anew then, and sometimes too late. */
TEST_F(ViewerProgram, NeverLeavesTheDisplayWithoutAClient) {
  const std::string script =
      "timeout 60 Xvfb -displayfd 3 -terminate -screen 0 640x480x24 -nolisten tcp 3> \"$1\" 2> /dev/null & "
      "while ! [ -s \"$1\" ]; do sleep 0.05; done; shift; DISPLAY=:$(cat \"$0\") exec \"$@\"";
  const ToolResult result =
      runProgram("/bin/sh", {"-c", script, path("display"), path("display"), FUSE_FLOW_VIEWER_TOOL, path("recording"),
                             "--device", "cpu", "--width", "320", "--height", "240", "--paused", "--offscreen",
                             "--screenshot", path("a.png")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(fs::exists(path("a.png")));
}

/** \brief The text is white on what is dark: more of it is more white. */
TEST_F(ViewerProgram, ACameraWhoseFilesEndEarlyIsNamedInTheText) {
  const auto white = [&](const std::string& name) {
    const ToolResult result =
        runProgram(FUSE_FLOW_VIEWER_TOOL,
                   {path("recording"), "--device", "cpu", "--width", "640", "--height", "480", "--paused", "--from",
                    "0", "0", "-50", "--press", "End,i,y", "--offscreen", "--screenshot", path(name)});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    io::ColorImage image;
    io::readColor(path(name), image);
    return std::count_if(image.data.begin(), image.data.end(), [](const Rgb8& p) {
      return std::min({p.r, p.g, p.b}) > 150;
    });
  };
  const auto all = white("all.png");
  fs::remove(tool_test::depthFile(folder_ / "recording", 1, 3));
  EXPECT_GT(white("ended.png"), all + 300);
}

TEST_F(ViewerProgram, AnExportOverADamagedFrameIsMadeAndTheExitCodeTells) {
  const fs::path damaged = tool_test::depthFile(folder_ / "recording", 1, 2);
  fs::resize_file(damaged, 60);
  const auto expectTold = [&](const ToolResult& result) {
    expectError(result, 1, {"frame 3 (000002)", "'camera_1' is missing", damaged.string()});
  };
  expectTold(view({"--paused", "--press", "Right,Right", "--offscreen", "--screenshot", path("shot.png"),
                   "--save-cloud", path("cloud.ply")}));
  EXPECT_TRUE(fs::exists(path("shot.png")));
  EXPECT_TRUE(fs::exists(path("cloud.ply")));
  expectTold(view({"--offscreen", "--orbit", path("orbit"), "--orbit-pictures", "6"}));
  EXPECT_TRUE(fs::exists(path("orbit/000005.png")));
  expectTold(view({"--offscreen", "--orbit", path("film.ogv"), "--orbit-pictures", "6"}));
  EXPECT_GT(fs::file_size(path("film.ogv")), 1000u);
  expectTold(view({"--start", "2", "--paused", "--offscreen", "--screenshot", path("first.png")}));
  EXPECT_TRUE(fs::exists(path("first.png")));
}

/** \brief fuse_flow_live's window is the same. */
TEST_F(ViewerProgram, CamerasThatRunHaveAWindowThatEndsWithThem) {
  std::vector<std::string> arguments{path("recording"), "--device", "cpu", "--status", "0", "-o", path("live")};
  const ToolResult played = runProgram(FUSE_FLOW_LIVE_TOOL, arguments);
  EXPECT_EQ(played.exit_code, 0) << played.err;
  EXPECT_NE(played.out.find("camera_1: 4 views came, 0 were lost before"), std::string::npos) << played.out;
  EXPECT_TRUE(fs::exists(path("live/000000.ply")));
  RunOptions options;
  io::ColorImage shot;
  options.meanwhile = [&](pid_t) {
    // The window may be there before the first cloud.
    for (int k = 0; k < 100 && (k == 0 || filled(shot) <= 0.05); ++k) {
      const std::string name = "screenshot_" + std::string(k < 10 ? "00" : "0") + std::to_string(k);
      pressUntil("j", path(name + ".cam"));  // written behind the picture
      io::readColor(path(name + ".png"), shot);
    }
    EXPECT_EQ(std::system("xdotool keydown --window $(xdotool search --onlyvisible --name FUSE-Flow | head -1) q"), 0);
  };
  arguments = {path("recording"), "--device", "cpu", "--loop", "--folder", folder_.string()};
  const ToolResult ended = runProgram(FUSE_FLOW_LIVE_TOOL, arguments, options);
  EXPECT_FALSE(ended.timed_out);
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_GT(filled(shot), 0.05);
}

}  // namespace
}  // namespace viewer_test
