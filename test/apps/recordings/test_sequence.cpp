#include "recordings/readers/sequence_recording.h"

#include "io_fixture.h"
#include "room.h"

namespace {

using namespace io_test;

/** \brief Frames 0, 5, 10 … 35 of the room; each 10 cm from the one before. */
class SequenceRecording : public IoTest {
 protected:
  void SetUp() override {
    IoTest::SetUp();
    sequence_.kind = "test";
    sequence_.path = "somewhere";
    sequence_.usual_intrinsics = {64, 48, 24, 20, 29, 25.5f, {}};
    sequence_.usual_certain = true;
    for (int i = 0; i < 8; ++i) {
      const std::string name = "frame" + std::to_string(5 * i);
      io::SequenceFrame& frame = sequence_.frames[static_cast<std::size_t>(5 * i)];
      frame.name = name;
      frame.stamp = static_cast<std::uint64_t>(1000 * i);
      frame.files.depth = write(name + ".png", cornerView(i).depthPng());
      frame.T_world_camera = cornerView(i).T_world_camera;
    }
  }
  std::unique_ptr<io::Recording> open(const std::string& views, int slide = 0) const {
    io::RecordingOptions options;
    options.views = views;
    options.slide = slide;
    return io::openSequence(sequence_, options);
  }
  /** \brief The names of the views of a frame. */
  static std::vector<std::string> names(io::Recording& recording, std::size_t frame) {
    io::LoadedFrame loaded;
    recording.read(frame, loaded);
    std::vector<std::string> result;
    for (const Camera& camera : loaded.rig.cameras) result.push_back(camera.name);
    return result;
  }

  io::Sequence sequence_;
};

TEST_F(SequenceRecording, WithoutSlideThereIsOneInstant) {
  const auto recording = open("0,10,20");
  EXPECT_EQ(recording->frameCount(), 1u);
  EXPECT_EQ(names(*recording, 0), (std::vector<std::string>{"frame0", "frame10", "frame20"}));
}

TEST_F(SequenceRecording, SlideMovesTheRigAsLongAsAllItsFramesExist) {
  const auto recording = open("0:20:10", 5);
  EXPECT_EQ(recording->frameCount(), 6u);  // 10 + 5 · 5 = 35, the last
  EXPECT_EQ(names(*recording, 0), (std::vector<std::string>{"frame0", "frame10"}));
  EXPECT_EQ(names(*recording, 5), (std::vector<std::string>{"frame25", "frame35"}));
  EXPECT_EQ(open("0,10", 10)->frameCount(), 3u);
  EXPECT_EQ(open("0,10", 3)->frameCount(), 1u);
}

TEST_F(SequenceRecording, APoseFarOutIsRefusedInTheInstantThatItIsOf) {
  sequence_.frames[5].T_world_camera.translation().x() = 1e30;
  EXPECT_TRUE(refuses([&] { open("5"); }, {"somewhere", "frame5", "50000 m or less"}));
  const auto recording = open("0", 5);
  EXPECT_EQ(names(*recording, 0), std::vector<std::string>{"frame0"});
  EXPECT_TRUE(refuses([&] { names(*recording, 1); }, {"somewhere", "frame5", "50000 m or less"}));
}

TEST_F(SequenceRecording, ASlideThatIsNegativeIsRefused) {
  EXPECT_TRUE(refuses<io::OptionError>([&] { open("0", -5); }, {"--slide is -5, must be 0 or more"}));
}

TEST_F(SequenceRecording, EachFrameHasItsOwnPosesAndTime) {
  const auto recording = open("0,10", 5);
  io::LoadedFrame frame;
  for (std::size_t i = 0; i < recording->frameCount(); ++i) {
    recording->read(i, frame);
    EXPECT_EQ(frame.rig.stamp, 1000 * i);
    EXPECT_TRUE(showsRoom(frame, 0)) << i;
    EXPECT_TRUE(showsRoom(frame, 1)) << i;
  }
}

TEST_F(SequenceRecording, TheSizeIsThatOfTheFirstImageThatIsThere) {
  fs::remove(path("frame0.png"));
  const std::string file = write("K.txt", "24 0 29\n0 20 25.5\n0 0 1\n");  // which has no size
  io::RecordingOptions options;
  options.views = "0,10";
  options.intrinsics = file;
  const auto recording = io::openSequence(sequence_, options);
  EXPECT_EQ(recording->cameras()[0].intrinsics.width, 64);
  EXPECT_EQ(recording->cameras()[0].intrinsics.height, 48);
  for (const auto& [number, frame] : sequence_.frames) fs::remove(frame.files.depth);
  EXPECT_TRUE(refuses([&] { open("0"); }, {"somewhere: has no depth image"}));
}

TEST_F(SequenceRecording, AFrameThatIsNotThereIsNamedWithThoseThatAre) {
  EXPECT_TRUE(refuses<io::OptionError>([&] { open("0,7"); },
                                       {"--views 0,7: frame 7 is not in somewhere", "8 frames: 0, 5, 10 ... 35"}));
  EXPECT_TRUE(refuses<io::OptionError>([&] { open(":"); }, {"--views :: frame 1 is not in"}));
  EXPECT_TRUE(refuses<io::OptionError>([&] { open(""); }, {"--views", "e.g. --views 0,10,20,30"}));
  sequence_.frames.clear();
  EXPECT_TRUE(refuses([&] { open("0"); }, {"somewhere: has no frame"}));
}

TEST_F(SequenceRecording, IntrinsicsOfTheDatasetAreForImagesOfItsSizeOnly) {
  EXPECT_TRUE(open("0")->warnings().empty());
  sequence_.usual_certain = false;
  sequence_.usual_camera = "a Kinect";
  ASSERT_EQ(open("0")->warnings().size(), 1u);
  EXPECT_NE(open("0")->warnings()[0].find("those of a Kinect are taken"), std::string::npos);
  sequence_.usual_intrinsics.width = 640;
  EXPECT_TRUE(refuses([&] { open("0"); }, {"somewhere", "images are 64x48", "--intrinsics FILE"}));
}

TEST_F(SequenceRecording, IntrinsicsOfAnotherSizeAreRefused) {
  io::RecordingOptions options;
  options.views = "0";
  options.intrinsics =
      write("camera.json", R"({"width": 640, "height": 480, "fx": 24, "fy": 20, "cx": 29, "cy": 25.5})");
  EXPECT_TRUE(refuses([&] { io::openSequence(sequence_, options); }, {options.intrinsics, "640x480", "64x48"}));
}

TEST_F(SequenceRecording, FramesWithoutAPoseAreCountedAndTheFirstIsNamed) {
  sequence_.unposed[3] = "pose 3 is lost";
  sequence_.unposed[7] = "pose 7 is lost";
  const auto recording = open("0,5");
  ASSERT_EQ(recording->warnings().size(), 1u);
  EXPECT_EQ(recording->warnings()[0],
            "2 of 10 depth images have no pose and cannot be used; the first, frame 3: pose 3 is lost");
  EXPECT_TRUE(refuses([&] { open("0,7"); }, {"pose 7 is lost"}));
}

}  // namespace
