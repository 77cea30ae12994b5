#ifdef FUSE_FLOW_SERVE_TOOL

#include "support/cloud_file.h"
#include "support/tool_fixture.h"

#include "../stream/decoded_jpeg.h"
#include "../stream/foxglove_client.h"

#include <signal.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <set>
#include <thread>

namespace tool_test {
namespace {

class Serve : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    WallRecording wall{};
    wall.frames = 6;
    wall.write(recording_);
    nlohmann::json rig = wall.rig();
    rig["frames_per_second"] = 20;
    writeText(recording_ / "rig.json", rig.dump());
  }

  /** \brief While fuse_flow_serve runs: does something with its link, and then interrupts it. */
  ToolResult serve(std::vector<std::string> arguments, const std::function<void(const std::string& link)>& meanwhile) {
    for (const char* argument : {"--port", "0"}) arguments.emplace_back(argument);
    fs::remove(out("served"));  // an earlier one's link
    RunOptions options;
    options.out_path = out("served");
    options.meanwhile = [&](pid_t tool) {
      std::string text;
      const auto linked = [&] {
        text = fs::exists(out("served")) ? readText(out("served")) : "";
        return text.find("http") != std::string::npos && text.find('\n', text.find("http")) != std::string::npos;
      };
      for (int k = 0; k < 20000 && !linked(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(5));
      const std::size_t begin = text.find("http");
      if (begin != std::string::npos) meanwhile(text.substr(begin, text.find('\n', begin) - begin));
      ::kill(tool, SIGINT);
    };
    return runProgram(FUSE_FLOW_SERVE_TOOL, arguments, options);
  }
  /** \brief Without an error; what they log stands on the standard error stream. */
  static testing::AssertionResult ended(const ToolResult& result) {
    if (result.exit_code == 0) return testing::AssertionSuccess();
    return testing::AssertionFailure() << "exit code " << result.exit_code << ": " << result.err;
  }
  static ToolResult receive(const std::vector<std::string>& arguments) {
    std::vector<std::string> bounded = arguments;
    for (const char* argument : {"--seconds", "100"})
      if (std::find(arguments.begin(), arguments.end(), "--seconds") == arguments.end()) bounded.emplace_back(argument);
    return runProgram(FUSE_FLOW_RECEIVE_TOOL, bounded);
  }
};

TEST_F(Serve, WhatIsFusedIsReceivedAsCloudsAndAsAFileThatIsServedAgain) {
  const auto wallOf = [&](const std::string& folder) {  // near a wall of the recording, which has one a frame
    for (const std::string& name : listing(out(folder))) {
      if (name == "timestamps.txt") continue;
      const std::vector<FilePoint> points = readCloudFile(out(folder + "/" + name));
      ASSERT_GT(points.size(), 1000u) << name;
      double sum = 0;
      for (const FilePoint& point : points) sum += point.z;
      const double frame = (sum / static_cast<double>(points.size()) - WallRecording::wallDistance(0)) / 0.05;
      EXPECT_NEAR(frame, std::round(frame), 0.06) << name;
    }
  };
  const ToolResult served = serve({recording()}, [&](const std::string& link) {
    ASSERT_TRUE(ended(receive({link, "--frames", "3", "-o", out("clouds")})));
    ASSERT_TRUE(ended(receive({link, "--frames", "2", "-o", out("kept.ffs")})));
    const ToolResult draco = receive({link, "--frames", "2", "--format", "drc", "-o", out("draco")});
    if (draco.exit_code == 0)
      EXPECT_EQ(listing(out("draco")), (std::vector<std::string>{"000000.drc", "000001.drc", "timestamps.txt"}));
    else  // built without it
      EXPECT_NE(draco.err.find("install libdraco-dev"), std::string::npos) << draco.err;
  });
  EXPECT_TRUE(ended(served));
  EXPECT_EQ(listing(out("clouds")).size(), 4u);  // with timestamps.txt
  wallOf("clouds");
  const ToolResult again = serve({out("kept.ffs")}, [&](const std::string& link) {
    ASSERT_TRUE(ended(receive({link, "--frames", "1", "-o", out("again")})));
  });
  EXPECT_TRUE(ended(again));
  wallOf("again");
  // The pause after the last frame alone is 33 ms, a hundred times as long here.
  const auto start = std::chrono::steady_clock::now();
  const ToolResult slow =
      runProgram(FUSE_FLOW_SERVE_TOOL, {out("kept.ffs"), "--port", "0", "--once", "--speed", "0.01", "--step", "5"});
  EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(3300));
  EXPECT_TRUE(ended(slow));
  EXPECT_NE(slow.err.find("--step has no effect on a stream that was kept"), std::string::npos) << slow.err;
  EXPECT_EQ(slow.err.find("--speed has no effect"), std::string::npos) << slow.err;
}

TEST_F(Serve, FoxgloveGetsTheImagesOfTheCamerasWithTheStampsOfTheClouds) {
  const ToolResult served = serve({recording()}, [&](const std::string& link) {
    fuse_flow::test::FoxgloveClient client(
        static_cast<std::uint16_t>(std::stoi(link.substr(link.find(':', link.find("//")) + 1))));
    // Channels of images come with the first images.
    std::map<std::string, std::uint32_t> channels;
    const std::string wanted = "/cameras/camera_0/image";
    while (channels.count(wanted) == 0) channels.merge(client.channels());
    client.subscribe(1, channels.at(wanted));
    client.subscribe(2, channels.at("/points"));
    std::map<std::uint32_t, std::set<std::uint64_t>> times;
    std::vector<std::uint64_t> both;
    while (both.size() < 3) {
      const auto data = client.nextData();
      times[data.subscription].insert(data.time);
      if (times[3 - data.subscription].count(data.time) > 0) both.push_back(data.time);
      if (data.subscription != 1) continue;
      const fuse_flow::test::ProtobufMessage message(data.payload);
      EXPECT_EQ(message.text(4), "camera_0");
      const auto image = fuse_flow::test::decodedJpeg(message.text(2));
      const WallRecording wall{};
      ASSERT_EQ(image.width, wall.width);
      ASSERT_EQ(image.height, wall.height);
      for (std::size_t k = 0; k < image.rgb.size(); ++k)
        ASSERT_NEAR(image.rgb[k], k % 3 == 0 ? 200 : k % 3 == 1 ? 100 : 50, 3);
    }
  });
  EXPECT_TRUE(ended(served));
}

TEST_F(Serve, ImagesStayAtHomeIfTheyAreAskedTo) {
  const ToolResult served = serve({recording(), "--no-images"}, [&](const std::string& link) {
    const auto port = static_cast<std::uint16_t>(std::stoi(link.substr(link.find(':', link.find("//")) + 1)));
    fuse_flow::test::FoxgloveClient client(port);
    client.subscribe(1, client.channels().at("/points"));
    for (int clouds = 0; clouds < 3; ++clouds) client.nextData();  // each comes after the images of its frame
    fuse_flow::test::FoxgloveClient later(port);
    const std::map<std::string, std::uint32_t> channels = later.channels();
    EXPECT_EQ(channels.count("/cameras/camera_0/calibration"), 1u);
    EXPECT_EQ(channels.count("/cameras/camera_0/image"), 0u);
  });
  EXPECT_TRUE(ended(served));
}

TEST_F(Serve, ATokenIsNeededBeyondThisMachineAndKeepsOthersOut) {
  const ToolResult open = runProgram(FUSE_FLOW_SERVE_TOOL, {recording(), "--port", "0", "--address", "0.0.0.0"});
  EXPECT_NE(open.exit_code, 0);
  EXPECT_NE(open.err.find("--token-file"), std::string::npos) << open.err;
  writeText(out("token"), "0123456789abcdef\n");
  const ToolResult served = serve({recording(), "--token-file", out("token")}, [&](const std::string& link) {
    EXPECT_NE(link.find("token=0123456789abcdef"), std::string::npos) << link;
    ASSERT_TRUE(ended(receive({link, "--frames", "1", "-o", out("with.ffs")})));
    const std::string without = link.substr(0, link.find('?'));
    EXPECT_NE(receive({without, "--frames", "1", "--seconds", "2", "-o", out("without.ffs")}).exit_code, 0);
    ASSERT_TRUE(ended(receive({without, "--token-file", out("token"), "--frames", "1", "-o", out("file.ffs")})));
  });
  EXPECT_TRUE(ended(served));
  EXPECT_EQ(served.err.find("0123456789abcdef"), std::string::npos) << "its log tells the token";
}

TEST_F(Serve, WhatCannotBeIsRefusedInOneLine) {
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& text) {
    const ToolResult result = runProgram(FUSE_FLOW_SERVE_TOOL, arguments);
    EXPECT_NE(result.exit_code, 0) << text;
    EXPECT_NE(result.err.find(text), std::string::npos) << result.err;
  };
  refused({out("none.ffs")}, "none.ffs");
  refused({recording(), "--certificate", out("nothing.pem")}, "--key");
  refused({recording(), "--address", "nowhere"}, "nowhere");
  refused({recording(), "--token-file", out("nothing")}, "--token-file");
  writeText(out("short"), "secret\n");
  refused({recording(), "--token-file", out("short")}, "--token-file");
  const ToolResult received = receive({"ftp://127.0.0.1/", "--seconds", "1"});
  EXPECT_NE(received.exit_code, 0);
  EXPECT_NE(received.err.find("ftp://127.0.0.1/"), std::string::npos) << received.err;
}

}  // namespace
}  // namespace tool_test

#endif
