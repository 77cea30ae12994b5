#include "../tools/support/png_file.h"
#include "io_fixture.h"

#include <fuse_flow/recordings/recording.h>

#include <nlohmann/json.hpp>

#include <algorithm>

namespace {

using namespace io_test;

constexpr int kSide = 8;  // of the images, pixels

/** \brief Two cameras, whose images have one value each that says which it is. */
class RigImages : public IoTest {
 protected:
  void SetUp() override {
    IoTest::SetUp();
    nlohmann::json rig;
    for (const char* name : {"left", "right"}) {
      nlohmann::json camera{{"name", name}, {"width", kSide}, {"height", kSide}, {"fx", 10}, {"fy", 10}};
      camera["cx"] = camera["cy"] = 3.5;
      camera["depth_scale"] = 0.001;
      camera["T_world_camera"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
      rig["cameras"].push_back(camera);
    }
    write("rig.json", rig.dump());
  }
  void depth(const std::string& name, int value) const {
    write(name, tool_test::depthPng(kSide, kSide,
                                    std::vector<std::uint16_t>(kSide * kSide, static_cast<std::uint16_t>(value))));
  }
  void color(const std::string& name, int red) const {
    write(name, tool_test::colorPng(kSide, kSide, static_cast<std::uint8_t>(red), 0, 0));
  }
  std::unique_ptr<io::Recording> open(const io::RecordingOptions& options = {}) const {
    return io::openRecording({folder_.string()}, options);
  }
  /** \brief Of each frame, the values of the depth images of left and right; 0 where there is none. */
  static std::vector<std::vector<int>> depths(io::Recording& recording) {
    return values(recording, [](const DepthView& view) { return view.depth16 ? view.depth16.row(0)[0] : 0; });
  }
  /** \brief The same of colour. */
  static std::vector<std::vector<int>> colors(io::Recording& recording) {
    return values(recording, [](const DepthView& view) { return view.color ? view.color.row(0)[0].r : 0; });
  }
  /** \brief Of each frame, microseconds. */
  static std::vector<std::uint64_t> stamps(io::Recording& recording) {
    std::vector<std::uint64_t> result;
    io::LoadedFrame frame;
    for (const std::size_t number : recording.frames()) {
      recording.read(number, frame);
      result.push_back(frame.rig.stamp);
    }
    return result;
  }
  static testing::AssertionResult warns(const io::Recording& recording, const std::vector<std::string>& words) {
    std::string all;
    for (const std::string& line : recording.warnings()) {
      const auto has = [&](const std::string& word) { return line.find(word) != std::string::npos; };
      if (std::all_of(words.begin(), words.end(), has)) return testing::AssertionSuccess();
      all += "\n  " + line;
    }
    return testing::AssertionFailure() << "there are the warnings:" << all;
  }

 private:
  template <typename ValueOf>
  static std::vector<std::vector<int>> values(io::Recording& recording, const ValueOf& value_of) {
    std::vector<std::vector<int>> result;
    io::LoadedFrame frame;
    for (const std::size_t number : recording.frames()) {
      recording.read(number, frame);
      result.emplace_back();
      for (const DepthView& view : frame.rig.views) result.back().push_back(value_of(view));
    }
    return result;
  }
};

using ValuesByFrame = std::vector<std::vector<int>>;
using FrameIndices = std::vector<std::size_t>;
using FrameStamps = std::vector<std::uint64_t>;

TEST_F(RigImages, NumbersMayHaveWordsAroundThemAndOthersInEachFolder) {
  depth("left/depth/frame_0001.png", 101);
  depth("left/depth/frame_0002.png", 102);
  depth("left/depth/frame_0010.png", 110);
  color("left/color/image-1.png", 11);
  color("left/color/image-10.png", 20);
  depth("right/depth/frame-000001.depth.png", 201);
  depth("right/depth/frame-000002.depth.png", 202);
  color("right/rgb/0001_color.jpg", 31);  // a PNG, which the reader tells by its content
  color("right/rgb/0002_color.jpg", 32);
  const auto recording = open();
  EXPECT_EQ(recording->frames(), (FrameIndices{1, 2, 10}));
  EXPECT_EQ(depths(*recording), (ValuesByFrame{{101, 201}, {102, 202}, {110, 0}}));
  EXPECT_EQ(colors(*recording), (ValuesByFrame{{11, 31}, {0, 32}, {20, 0}}));
}

TEST_F(RigImages, OfSeveralNumbersInANameTheOneThatDiffersCounts) {
  for (const int k : {3, 4}) {
    depth("left/depth/cam2_640x480_" + std::to_string(k) + ".png", 100 + k);
    depth("right/depth/" + std::to_string(k) + "_640x480.png", 200 + k);
  }
  EXPECT_EQ(open()->frames(), (FrameIndices{3, 4}));
  EXPECT_EQ(depths(*open()), (ValuesByFrame{{103, 203}, {104, 204}}));
}

TEST_F(RigImages, OfASingleImageTheLongestNumberCounts) {
  depth("left/depth/cam2_0007.png", 107);
  depth("right/depth/0007_3.png", 207);
  EXPECT_EQ(open()->frames(), FrameIndices{7});
  EXPECT_EQ(depths(*open()), (ValuesByFrame{{107, 207}}));
}

TEST_F(RigImages, ImagesThatAreNotReadAreCounted) {
  depth("left/depth/frame_1.png", 101);
  depth("left/depth/frame_2.png", 102);
  depth("left/depth/preview_1.png", 9);
  depth("left/depth/.frame_3.png", 9);  // what another system hides
  depth("right/depth/000001.png", 201);
  depth("right/depth/frame_0002.png", 9);
  depth("right/depth/frame_0003.png", 9);
  const auto recording = open();
  EXPECT_EQ(depths(*recording), (ValuesByFrame{{101, 201}, {102, 0}}));
  EXPECT_TRUE(warns(*recording, {path("left/depth"), "1 image is not read", "preview_1.png", "like frame_1.png"}));
  EXPECT_TRUE(warns(*recording, {path("right/depth"), "2 images are not read", "frame_0002.png", "like 000001.png"}));
}

TEST_F(RigImages, NamesThatTellNoFrameAreRefused) {
  depth("right/depth/a_1.png", 1);
  depth("left/depth/a_1.png", 1);
  depth("left/depth/b_1.png", 1);
  EXPECT_TRUE(refuses([&] { open(); }, {path("left/depth"), "a_1.png and b_1.png", "one way"}));
  fs::rename(path("left/depth/b_1.png"), path("left/depth/a_01.png"));
  EXPECT_TRUE(refuses([&] { open(); }, {path("left/depth"), "a_01.png and a_1.png", "one depth image of a frame"}));
  fs::rename(path("left/depth/a_1.png"), path("left/depth/1-33.png"));
  fs::rename(path("left/depth/a_01.png"), path("left/depth/2-66.png"));
  EXPECT_TRUE(refuses([&] { open(); }, {path("left/depth"), "1-33.png and 2-66.png", "several numbers"}));
}

TEST_F(RigImages, PlainNumbersStayTheNumbersOfFrames) {
  depth("left/depth/000003.png", 103);
  depth("left/depth/99999999999.png", 199);  // one less than what is a time
  depth("right/depth/3.png", 203);
  depth("right/depth/12.5.png", 9);
  const auto recording = open();
  EXPECT_EQ(recording->frames(), (FrameIndices{3, 99999999999}));
  EXPECT_EQ(depths(*recording), (ValuesByFrame{{103, 203}, {199, 0}}));
  EXPECT_TRUE(warns(*recording, {"1 image is not read", "12.5.png"}));
}

/** \brief Names of times in seconds, ms, µs or ns, 100 ms apart; right is 2 ms later, and lost its second image. */
class TimesAsNames : public RigImages, public testing::WithParamInterface<std::pair<const char*, const char*>> {};

TEST_P(TimesAsNames, GroupTheImagesOfCameras) {
  const std::string before = GetParam().first, after = GetParam().second;
  for (const int k : {0, 1, 2, 3}) {
    const std::string tenths = std::to_string(k);
    depth("left/depth/" + before + tenths + "00" + after + ".png", 100 + k);
    if (k != 1) depth("right/depth/d" + before + tenths + "02" + after + ".png", 200 + k);
    color("left/color/" + before + tenths + "01" + after + ".png", 10 + k);
  }
  const bool decimals = before.find('.') != std::string::npos;
  if (decimals)  // d1700000000.002 would be two numbers
    for (const int k : {0, 2, 3}) {
      const std::string name = before + std::to_string(k) + "02" + after + ".png";
      fs::rename(path("right/depth/d" + name), path("right/depth/d_" + name));
    }
  const auto recording = open();
  EXPECT_EQ(recording->frames(), (FrameIndices{0, 1, 2, 3}));
  EXPECT_EQ(depths(*recording), (ValuesByFrame{{100, 200}, {101, 0}, {102, 202}, {103, 203}}));
  EXPECT_EQ(colors(*recording), (ValuesByFrame{{10, 0}, {11, 0}, {12, 0}, {13, 0}}));
  ASSERT_TRUE(recording->framesPerSecond());
  EXPECT_NEAR(*recording->framesPerSecond(), 10, 1e-6);
  constexpr std::uint64_t start = 1700000000000000;
  EXPECT_EQ(stamps(*recording), (FrameStamps{start + 1000, start + 101000, start + 201000, start + 301000}));
  const char* unit = decimals            ? "in seconds"
                     : after.empty()     ? "in milliseconds"
                     : after.size() == 3 ? "in microseconds"
                                         : "in nanoseconds";
  EXPECT_TRUE(warns(*recording, {"put together by the times", unit, "one each 100 ms"}));
  EXPECT_EQ(recording->warnings().size(), 1u);
}

INSTANTIATE_TEST_SUITE_P(OfAllUnits, TimesAsNames,
                         testing::Values(std::pair("1700000000.", ""), std::pair("1700000000.", "000000"),
                                         std::pair("1700000000", ""), std::pair("1700000000", "000"),
                                         std::pair("1700000000", "000000")));

TEST_F(RigImages, SecondsSinceAStartHaveDecimals) {
  for (const char* name : {"0.0", "0.5", "10.25"}) {
    depth(std::string("left/depth/") + name + ".png", 1);
    depth(std::string("right/depth/") + name + ".png", 2);
  }
  const auto recording = open();
  EXPECT_EQ(depths(*recording), (ValuesByFrame{{1, 2}, {1, 2}, {1, 2}}));
  EXPECT_EQ(stamps(*recording), (FrameStamps{0, 500000, 10250000}));
}

TEST_F(RigImages, ColourOfAnotherRateIsTheNearestInTime) {
  for (const int k : {0, 1, 2}) {
    depth("left/depth/100" + std::to_string(k) + ".00.png", 100 + k);
    depth("right/depth/100" + std::to_string(k) + ".00.png", 200 + k);
  }
  for (const int k : {0, 3, 6, 9, 12, 15, 18})  // every 0.3 s: 0.9 and 1.8 are nearest to 1 and 2
    color("right/image/100" + std::to_string(k / 10) + "." + std::to_string(k % 10) + ".png", 10 + k);
  EXPECT_EQ(colors(*open()), (ValuesByFrame{{0, 10}, {0, 19}, {0, 28}}));
}

TEST_F(RigImages, WhatIsWrongWithTheirTimesIsSaid) {
  for (const int k : {0, 1, 2, 3}) {
    const std::string second = std::to_string(k);
    depth("left/depth/100" + second + ".0.png", 100 + k);
    depth("right/depth/500" + second + ".0.png", 200 + k);
  }
  auto recording = open();
  EXPECT_TRUE(
      warns(*recording, {"no two cameras have images of the same time", "1000000000000 ns", "must be of one clock"}));
  for (const int k : {0, 1, 2, 3}) {
    const std::string second = std::to_string(k);
    fs::rename(path("right/depth/500" + second + ".0.png"), path("right/depth/100" + second + ".0.png"));
    depth("left/depth/100" + second + ".5.png", 150 + k);  // twice as fast
  }
  recording = open();
  EXPECT_EQ(depths(*recording), (ValuesByFrame{{100, 200}, {101, 201}, {102, 202}, {103, 203}, {153, 0}}));
  EXPECT_TRUE(warns(*recording, {"camera 'left': 3 of 8 images have no partner"}));
  EXPECT_EQ(recording->imagesWithoutPartner(0), 3u);
  EXPECT_EQ(recording->imagesWithoutPartner(1), 0u);
}

TEST_F(RigImages, TimesBesideNumbersAreRefused) {
  depth("left/depth/1.5.png", 1);
  depth("left/depth/2.5.png", 1);
  depth("right/depth/000000.png", 2);
  EXPECT_TRUE(
      refuses([&] { open(); }, {path("right/depth/000000.png"), "a number", path("left/depth/1.5.png"), "a time"}));
  depth("right/depth/1.50.png", 2);
  depth("right/depth/1.5.png", 2);
  fs::remove(path("right/depth/000000.png"));
  EXPECT_TRUE(refuses([&] { open(); }, {path("right/depth"), "1.5.png and 1.50.png", "one depth image of a time"}));
}

TEST_F(RigImages, ANumberAndATimeMayStandInOneName) {
  for (const int k : {0, 1, 2}) {
    depth("left/depth/" + std::to_string(k) + "_17000000000" + std::to_string(k) + "0.png", 100 + k);
    depth("right/depth/" + std::to_string(k) + "_17000000000" + std::to_string(k) + "2.png", 200 + k);
  }
  const auto recording = open();
  EXPECT_EQ(depths(*recording), (ValuesByFrame{{100, 200}, {101, 201}, {102, 202}}));
  EXPECT_EQ(stamps(*recording)[1], 1700000000011000u);
}

/** \brief Frames 0 … 3 of both cameras, by number. */
class RigTimestamps : public RigImages {
 protected:
  void SetUp() override {
    RigImages::SetUp();
    for (const int k : {0, 1, 2, 3}) {
      const std::string name = "00000" + std::to_string(k) + ".png";
      depth("left/depth/" + name, 100 + k);
      depth("right/depth/" + name, 200 + k);
      color("left/color/" + name, 10 + k);
    }
  }
};

const ValuesByFrame kByNumber{{100, 200}, {101, 201}, {102, 202}, {103, 203}};

TEST_F(RigTimestamps, GiveFramesTheirTime) {
  write("left/timestamps.txt", "# seconds\n5.00\n5.10\n5.20\n\n5.30\n");
  write("right/depth/timestamps.txt", "5.02\r\n5.12\r\n5.22\r\n5.32\r\n");
  const auto recording = open();
  EXPECT_EQ(recording->frames(), (FrameIndices{0, 1, 2, 3}));
  EXPECT_EQ(depths(*recording), kByNumber);
  EXPECT_EQ(colors(*recording), (ValuesByFrame{{10, 0}, {11, 0}, {12, 0}, {13, 0}}));
  EXPECT_EQ(stamps(*recording), (FrameStamps{5010000, 5110000, 5210000, 5310000}));
  EXPECT_NEAR(recording->framesPerSecond().value_or(0), 10, 1e-6);
  EXPECT_TRUE(warns(*recording, {"one frame are taken within 20.0 ms"}));
  const std::vector<std::string> inputs = recording->inputs();
  EXPECT_NE(std::find(inputs.begin(), inputs.end(), path("left/timestamps.txt")), inputs.end());
}

TEST_F(RigTimestamps, MayNameTheImagesBeforeOrBehindTheTime) {
  write("left/timestamps.txt", "000003.png 5.3\n000000.png 5.0\n000001.png 5.1\n000002.png 5.2\n");
  write("right/timestamps.txt",
        "5.01 depth/000000.png\n5.11 depth/000001.png\n5.21 depth/000002.png\n5.31 depth/000003.png\n");
  EXPECT_EQ(depths(*open()), kByNumber);
  EXPECT_EQ(stamps(*open()), (FrameStamps{5005000, 5105000, 5205000, 5305000}));
  write("left/timestamps.txt",
        "1700000000000000003,0\n1700000000100000003,1\n1700000000200000003,2\n1700000000300000003,3\n");
  write("right/timestamps.txt", "000000 1700000000.000\n1 1700000000.1\n2 1700000000.2\n3 1700000000.3\n");
  EXPECT_EQ(depths(*open()), kByNumber);
  EXPECT_EQ(stamps(*open())[3], 1700000000300000u);
}

TEST_F(RigTimestamps, ThatPutOtherImagesTogetherGoBeforeNumbers) {
  write("left/timestamps.txt", "5.0\n5.1\n5.2\n5.3\n");
  write("right/timestamps.txt", "5.1\n5.2\n5.3\n5.4\n");  // its first image was lost
  const auto recording = open();
  EXPECT_EQ(depths(*recording), (ValuesByFrame{{100, 0}, {101, 200}, {102, 201}, {103, 202}, {0, 203}}));
  EXPECT_EQ(colors(*recording), (ValuesByFrame{{10, 0}, {11, 0}, {12, 0}, {13, 0}, {0, 0}}));
  EXPECT_TRUE(warns(*recording, {folder_.string(), "put together by the times", path("left/timestamps.txt"),
                                 "in seconds", "the numbers of the images would put others together"}));
  io::LoadedFrame frame;
  recording->read(4, frame);
  ASSERT_EQ(frame.ended.size(), 1u);
  EXPECT_EQ(frame.ended[0].message, "camera 'left' ends after 4 of 5 frames");
}

TEST_F(RigTimestamps, OfDifferentClocksLeaveTheNumbers) {
  write("left/timestamps.txt", "5.0\n5.1\n5.2\n5.3\n");
  write("right/timestamps.txt", "905.0\n905.1\n905.2\n905.3\n");
  const auto recording = open();
  EXPECT_EQ(depths(*recording), kByNumber);
  EXPECT_FALSE(recording->framesPerSecond());
  EXPECT_TRUE(warns(*recording, {"different clocks", "by number"}));
  EXPECT_EQ(recording->warnings().size(), 1u);
}

TEST_F(RigTimestamps, OfSomeCamerasAreNotUsed) {
  write("left/timestamps.txt", "5.0\n5.1\n5.2\n5.3\n");
  const auto recording = open();
  EXPECT_EQ(depths(*recording), kByNumber);
  EXPECT_TRUE(warns(*recording, {path("left/timestamps.txt"), "are not used", path("right/depth/000000.png")}));
}

TEST_F(RigTimestamps, ThatGoBackAreLeftOut) {
  write("left/timestamps.txt", "5.0\n5.1\n4.2\n5.3\n");
  write("right/timestamps.txt", "5.0\n5.1\n5.2\n5.3\n");
  const auto recording = open();
  EXPECT_EQ(depths(*recording), (ValuesByFrame{{100, 200}, {101, 201}, {0, 202}, {103, 203}}));
  EXPECT_TRUE(
      warns(*recording, {path("left/timestamps.txt"), "1 of 4 images", "not later", "image 2", "900.0 ms back"}));
}

TEST_F(RigTimestamps, LinesAndImagesWithoutTheOtherAreCounted) {
  write("left/timestamps.txt", "0 5.0\n1 5.1\n2 5.2\n7 5.7\n");
  write("right/timestamps.txt", "5.0\n5.1\n5.2\n5.3\n");
  const auto recording = open();
  EXPECT_EQ(depths(*recording), (ValuesByFrame{{100, 200}, {101, 201}, {102, 202}, {0, 203}}));
  EXPECT_TRUE(warns(*recording, {"1 of 4 lines name images that are not in", "such as 7"}));
  EXPECT_TRUE(warns(*recording, {"1 of 4 images of", "have no line", "000003.png"}));
}

TEST_F(RigTimestamps, ThatCannotBeReadHinderNoNumbers) {
  write("right/timestamps.txt", "5.0\n5.1\n5.2\n5.3\n");
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"", "has no time"},
      {"5.0\n5.1\n5.2\n", "has 3 times, must have one for each of the 4 images"},
      {"5.0\n5.1\nsoon\n5.3\n", "line 3 has 'soon'"},
      {"5.0\n5.1\n-1\n5.3\n", "line 3 has '-1'"},
      {"0 5.0 left\n", "line 1 is '0 5.0 left'"},
      {"5.0\n1 5.1\n", "line 2 is '1 5.1'"},
      {"0 5.0\n0 5.1\n", "line 2 names 000000.png a second time"},
      {"8 5.0\n9 5.1\n", "names no image"},
      {"5.0\n5.1\n5.2\n50000000000\n", "line 4 is no time in seconds"}};
  for (const auto& [text, problem] : wrong) {
    write("left/timestamps.txt", text);
    const auto recording = open();
    EXPECT_EQ(depths(*recording), kByNumber) << text;
    EXPECT_TRUE(warns(*recording, {path("left/timestamps.txt"), problem, "its times are not used"})) << text;
  }
}

TEST_F(RigTimestamps, OfColourPutItBesideItsDepth) {
  for (const std::string camera : {"left", "right"}) write(camera + "/timestamps.txt", "5.0\n5.1\n5.2\n5.3\n");
  write("left/color/timestamps.txt", "5.1\n5.2\n5.3\n5.4\n");  // began later
  EXPECT_EQ(colors(*open()), (ValuesByFrame{{0, 0}, {10, 0}, {11, 0}, {12, 0}}));
}

TEST_F(RigTimestamps, WithoutColourNothingIsSaidOfIt) {
  fs::rename(path("left/color/000000.png"), path("left/color/1.5.png"));
  fs::rename(path("left/color/000001.png"), path("left/color/2.5.png"));
  fs::rename(path("left/color/000002.png"), path("left/color/3.5.png"));
  fs::remove(path("left/color/000003.png"));
  const auto recording = open();
  EXPECT_EQ(colors(*recording), (ValuesByFrame(4, {0, 0})));
  EXPECT_TRUE(warns(*recording, {path("left/color"), "not used", "both must have numbers, or both times"}));
  io::RecordingOptions options;
  options.read_color = false;
  EXPECT_TRUE(open(options)->warnings().empty());
}

TEST_F(RigTimestamps, ConfidenceGoesWithItsDepth) {
  const std::string half = tool_test::samplesPng(kSide, kSide, 8, 0, std::string(kSide * kSide, '\x33'));
  write("left/confidence/conf_2.png", half);
  io::LoadedFrame frame;
  const auto recording = open();
  for (const std::size_t number : {0u, 2u}) {
    recording->read(number, frame);
    EXPECT_EQ(static_cast<bool>(frame.rig.views[0].confidence), number == 2) << number;
  }
}

TEST_F(RigImages, CamerasWithoutDepthAreGroupedByTheTimesOfTheirColour) {
  for (const int k : {0, 1, 2, 3}) {
    color("left/color/100" + std::to_string(k) + ".00.png", 10 + k);
    color("right/color/100" + std::to_string(k) + ".01.png", 20 + k);
  }
  fs::remove(path("left/color/1001.00.png"));
  EXPECT_EQ(colors(*open()), (ValuesByFrame{{10, 20}, {0, 21}, {12, 22}, {13, 23}}));
}

}  // namespace
