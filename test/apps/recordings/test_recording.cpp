#include "recordings/files/file_io.h"

#include "../tools/support/png_file.h"
#include "io_fixture.h"
#include "room.h"

#include <fuse_flow/recordings/recording.h>

#include <algorithm>
#include <sstream>

namespace {

using namespace io_test;

/** \brief rig.json and the images of two cameras in the room, two frames. */
class Recording : public IoTest {
 protected:
  void writeRig() const {
    std::string cameras;
    for (const auto& [name, view] : {std::pair("level", levelView()), std::pair("corner", cornerView())}) {
      const std::string folder = name;
      for (const char* frame : {"000000", "000001"}) {
        write(folder + "/depth/" + frame + ".png", view.depthPng());
        write(folder + "/color/" + frame + ".png", view.colorPng());
      }
      cameras += (cameras.empty() ? "" : ",") + jsonOf(folder, view);
    }
    write("rig.json", "{\"cameras\": [" + cameras + "]}");
  }
  static std::string jsonOf(const std::string& name, const RoomView& view) {
    std::string pose = view.poseText();
    std::string numbers;
    std::istringstream words(pose);
    for (std::string word; words >> word;) numbers += (numbers.empty() ? "" : ",") + word;
    return "{\"name\": \"" + name + "\", \"width\": 64, \"height\": 48, \"fx\": 24, \"fy\": 20, \"cx\": 29, " +
           "\"cy\": 25.5, \"depth_scale\": 0.001, \"T_world_camera\": [" + numbers + "]}";
  }
  std::unique_ptr<io::Recording> open(const io::RecordingOptions& options = {}) const {
    return io::openRecording({folder_.string()}, options);
  }
};

TEST_F(Recording, PointsOfARigLieOnTheWallsOfTheRoom) {
  writeRig();
  const auto recording = open();
  EXPECT_EQ(recording->kind(), "rig");
  EXPECT_EQ(recording->frameCount(), 2u);
  EXPECT_TRUE(recording->warnings().empty()) << recording->warnings()[0];
  io::LoadedFrame frame;
  for (std::size_t i = 0; i < 2; ++i) {
    recording->read(i, frame);
    EXPECT_TRUE(frame.rig.views[0].color);
    EXPECT_TRUE(showsRoom(frame, 0));
    EXPECT_TRUE(showsRoom(frame, 1));
  }
}

TEST_F(Recording, ARigIsOpenedByItsJsonToo) {
  writeRig();
  const auto recording = io::openRecording({path("rig.json")});
  EXPECT_EQ(recording->kind(), "rig");
  fs::rename(path("rig.json"), path("other.json"));
  EXPECT_EQ(io::openRecording({path("other.json")})->frameCount(), 2u);
}

TEST_F(Recording, AFrameOfARigHasTheTimeThatItsRateGives) {
  writeRig();
  EXPECT_FALSE(open()->framesPerSecond());
  std::string json = io::readFile(path("rig.json"));
  write("rig.json", json.insert(1, "\"frames_per_second\": 12.5, "));
  const auto recording = open();
  EXPECT_EQ(recording->framesPerSecond(), 12.5);
  io::LoadedFrame frame;
  recording->read(1, frame);
  EXPECT_EQ(frame.rig.stamp, 80000u);
  io::RecordingOptions options;
  options.poses = path("rig.json");
  EXPECT_EQ(open(options)->framesPerSecond(), 12.5) << "with other poses it is the same recording";
}

TEST_F(Recording, OtherPosesBringTheirNoiseOrLeaveTheRecordings) {
  writeRig();
  const std::string without = io::readFile(path("rig.json"));
  const auto withNoise = [&](const std::string& floor) {
    std::string json = without;
    return json.insert(json.find("\"name\""), "\"noise\": {\"floor\": " + floor + "}, ");
  };
  const auto noiseOf = [&](const std::string& recording, const std::string& poses) {
    write("rig.json", recording);
    io::RecordingOptions options;
    options.poses = write("poses.json", poses);
    return open(options)->cameras()[0].noise;
  };
  EXPECT_FALSE(noiseOf(without, without));
  EXPECT_EQ(noiseOf(withNoise("0.01"), without), (NoiseModel{0.01f, 0, 0}));
  EXPECT_EQ(noiseOf(without, withNoise("0.02")), (NoiseModel{0.02f, 0, 0}));
  EXPECT_EQ(noiseOf(withNoise("0.01"), withNoise("0.02")), (NoiseModel{0.02f, 0, 0}));
}

using Numbers = std::vector<std::size_t>;

TEST_F(Recording, FramesOfARigAreTheNumbersOfItsDepthImages) {
  writeRig();
  write("corner/depth/000004.png", cornerView().depthPng());
  write("corner/depth/notes.png", "");
  const auto recording = open();
  EXPECT_EQ(recording->frameCount(), 5u);
  EXPECT_EQ(recording->frames(), (Numbers{0, 1, 4}));
  io::LoadedFrame frame;
  recording->read(4, frame);
  EXPECT_TRUE(frame.rig.views[0].missing());
  EXPECT_TRUE(showsRoom(frame, 1));
  recording->read(3, frame);
  EXPECT_TRUE(frame.rig.views[0].missing());
  EXPECT_TRUE(frame.rig.views[1].missing());
}

TEST_F(Recording, ADepthImageThatIsGoneSinceItWasOpenedIsNoFrameThatACameraMissed) {
  writeRig();
  write("corner/depth/000004.png", cornerView().depthPng());
  const auto recording = open();
  fs::remove(path("corner/depth/000004.png"));
  io::LoadedFrame frame;
  EXPECT_TRUE(refuses([&] { recording->read(4, frame); }, {path("corner/depth/000004.png"), "no longer there"}));
  recording->read(0, frame);
  EXPECT_FALSE(frame.rig.views[0].missing());
}

TEST_F(Recording, ARigMayBeginLate) {
  writeRig();
  for (const std::string name : {"level", "corner"}) {
    fs::rename(path(name + "/depth/000000.png"), path(name + "/depth/001000.png"));
    fs::rename(path(name + "/depth/000001.png"), path(name + "/depth/001001.png"));
  }
  const auto recording = open();
  EXPECT_EQ(recording->frames(), (Numbers{1000, 1001}));
  ASSERT_EQ(recording->warnings().size(), 1u);
  EXPECT_NE(recording->warnings()[0].find("begins at frame 001000"), std::string::npos);
  io::LoadedFrame frame;
  recording->read(1000, frame);
  EXPECT_TRUE(showsRoom(frame, 0));
  EXPECT_EQ(io::chooseFrames(*recording, ""), (Numbers{1000, 1001}));
  EXPECT_EQ(io::chooseFrames(*recording, "1001:"), Numbers{1001});
  EXPECT_TRUE(refuses<io::OptionError>([&] { io::chooseFrames(*recording, "0"); },
                                       {"--frames 0", "only 2 frames: 1000, 1001"}));
  EXPECT_TRUE(refuses<io::OptionError>([&] { io::chooseFrames(*recording, ":5"); }, {"--frames :5", "names none"}));
}

TEST_F(Recording, AStrayNumberMakesOneFrameAndTheGapIsNamed) {
  writeRig();
  write("corner/depth/12345678.png", cornerView().depthPng());
  const auto recording = open();
  EXPECT_EQ(recording->frames(), (Numbers{0, 1, 12345678}));
  ASSERT_EQ(recording->warnings().size(), 1u);
  EXPECT_NE(recording->warnings()[0].find("12345676 frames between 000000 and 12345678 are left out"),
            std::string::npos)
      << recording->warnings()[0];
  EXPECT_NE(recording->warnings()[0].find("such as 000002"), std::string::npos);
}

TEST_F(Recording, NumbersMayHaveOtherDigitsThanSix) {
  writeRig();
  for (const std::string folder : {"depth", "color"}) {
    fs::rename(path("corner/" + folder + "/000000.png"), path("corner/" + folder + "/0.png"));
    fs::rename(path("corner/" + folder + "/000001.png"), path("corner/" + folder + "/00000001.png"));
  }
  const auto recording = open();
  EXPECT_EQ(recording->frames(), (Numbers{0, 1}));
  io::LoadedFrame frame;
  for (const std::size_t number : {0u, 1u}) {
    recording->read(number, frame);
    EXPECT_TRUE(frame.rig.views[1].color);
    EXPECT_TRUE(showsRoom(frame, 1));
  }
}

TEST_F(Recording, CamerasThatShareNoNumberAreNamed) {
  writeRig();
  fs::rename(path("corner/depth/000000.png"), path("corner/depth/000007.png"));
  fs::rename(path("corner/depth/000001.png"), path("corner/depth/000008.png"));
  const auto recording = open();
  const auto says = [](const std::string& line) { return line.find("no two cameras") != std::string::npos; };
  EXPECT_TRUE(std::any_of(recording->warnings().begin(), recording->warnings().end(), says));
}

TEST_F(Recording, ColourOfARigMayLieInAFolderNamedRgb) {
  writeRig();
  fs::rename(path("corner/color"), path("corner/rgb"));
  io::LoadedFrame frame;
  open()->read(0, frame);
  EXPECT_TRUE(frame.rig.views[1].color);
  EXPECT_TRUE(showsRoom(frame, 1));
}

TEST_F(Recording, PosesOfOtherConventionsGiveTheSameRoom) {
  writeRig();
  for (const auto convention : {io::PoseConvention::WorldToCamera, io::PoseConvention::OpenGl}) {
    std::string cameras;
    for (auto [name, view] : {std::pair("level", levelView()), std::pair("corner", cornerView())}) {
      if (convention == io::PoseConvention::WorldToCamera) {
        view.T_world_camera = view.T_world_camera.inverse();
      } else {
        view.T_world_camera.linear().col(1) *= -1;  // y up, z backward
        view.T_world_camera.linear().col(2) *= -1;
      }
      cameras += (cameras.empty() ? "" : ",") + jsonOf(name, view);
    }
    write("rig.json", "{\"cameras\": [" + cameras + "]}");
    io::RecordingOptions options;
    options.pose_convention = convention;
    io::LoadedFrame frame;
    open(options)->read(0, frame);
    EXPECT_TRUE(showsRoom(frame, 0));
    EXPECT_TRUE(showsRoom(frame, 1));
    options.pose_convention = io::PoseConvention::CameraToWorld;
    open(options)->read(0, frame);
    EXPECT_FALSE(showsRoom(frame, 0));
  }
}

TEST_F(Recording, ACameraWhoseFilesEndEarlyIsNamedFromThereOn) {
  writeRig();
  write("corner/depth/000003.png", cornerView().depthPng());
  const auto recording = open();
  io::LoadedFrame frame;
  for (const std::size_t number : {2u, 3u}) {
    recording->read(number, frame);
    ASSERT_EQ(frame.ended.size(), 1u);
    EXPECT_EQ(frame.ended[0].view, 0u);
    EXPECT_EQ(frame.ended[0].message, "camera 'level' ends after 2 of 3 frames");
  }
  recording->read(1, frame);
  EXPECT_TRUE(frame.ended.empty());
  fs::remove_all(folder_ / "level");
  const auto without = open();
  without->read(0, frame);
  ASSERT_EQ(frame.ended.size(), 1u);
  EXPECT_EQ(frame.ended[0].message, "camera 'level' has no depth images");
}

TEST_F(Recording, ViewsOfARigAreCamerasByTheirPlace) {
  writeRig();
  io::RecordingOptions options;
  options.views = "1";
  const auto recording = open(options);
  ASSERT_EQ(recording->cameras().size(), 1u);
  EXPECT_EQ(recording->viewName(0), "corner");
  io::LoadedFrame frame;
  recording->read(0, frame);
  EXPECT_TRUE(showsRoom(frame, 0));
  options.views = "2";
  EXPECT_TRUE(refuses<io::OptionError>([&] { open(options); }, {"--views 2", "below 2"}));
  options.views = "";
  options.slide = 1;
  EXPECT_TRUE(refuses<io::OptionError>([&] { open(options); }, {"--slide", path("rig.json")}));
}

TEST_F(Recording, ConfidenceLiesBesideDepth) {
  writeRig();
  write("corner/confidence/000001.png", tool_test::samplesPng(64, 48, 8, 0, std::string(64 * 48, '\x33')));
  io::LoadedFrame frame;
  const auto recording = open();
  recording->read(1, frame);
  EXPECT_FALSE(frame.rig.views[0].confidence);
  ASSERT_TRUE(frame.rig.views[1].confidence);
  EXPECT_FLOAT_EQ(frame.rig.views[1].confidence.row(47)[63], 0.2f);
  EXPECT_FLOAT_EQ(frame.images[1].assumed_confidence_step, 1 / 255.0f);
  recording->read(0, frame);
  EXPECT_FALSE(frame.rig.views[1].confidence);
}

TEST_F(Recording, ConfidenceMayCountInAUnitOfItsOwn) {
  writeRig();
  std::string json = io::readFile(path("rig.json"));
  json.insert(json.find("\"depth_scale\"", json.find("corner")), "\"confidence_scale\": 0.5, ");
  write("rig.json", json);
  write("corner/confidence/000000.png", tool_test::samplesPng(64, 48, 8, 0, std::string(64 * 48, '\x01')));
  io::LoadedFrame frame;
  open()->read(0, frame);
  EXPECT_EQ(frame.rig.views[1].confidence.row(0)[0], 0.5f);
  EXPECT_EQ(frame.images[1].assumed_confidence_step, 0);
}

TEST_F(Recording, OneFrameServesRecordingsOfDifferentKindsAfterEachOther) {
  writeRig();
  io::LoadedFrame frame;
  open()->read(0, frame);
  write("scene/frame-000000.depth.png", cornerView().depthPng());
  write("scene/frame-000000.pose.txt", cornerView().poseText());
  write("scene/camera-intrinsics.txt", "24 0 29 0 20 25.5 0 0 1");
  io::RecordingOptions options;
  options.views = "0";
  io::openRecording({path("scene")}, options)->read(0, frame);
  ASSERT_EQ(frame.rig.views.size(), 1u);
  ASSERT_EQ(frame.rig.cameras.size(), 1u);
  EXPECT_FALSE(frame.rig.views[0].color);
  EXPECT_TRUE(showsRoom(frame, 0));
}

TEST_F(Recording, WhatIsNoRecordingIsNamedWithWhatIs) {
  const std::vector<std::string> kinds{"rig.json", "7-Scenes", "TUM", "Redwood", ".pcd"};
  const auto names = [&](const std::string& input, const std::string& problem) {
    std::vector<std::string> words = kinds;
    words.push_back(input + ": " + problem);
    return refuses([&] { io::openRecording({input}); }, words);
  };
  EXPECT_TRUE(names(path("no_such_folder"), "not found"));
  EXPECT_TRUE(names(folder_.string(), "is an empty folder"));
  write("notes.txt", "");
  EXPECT_TRUE(names(folder_.string(), "is not a recording"));
  EXPECT_TRUE(names(path("notes.txt"), "is not a recording"));
  write("cloud.ply", "ply\n");
  EXPECT_TRUE(names(path("cloud.ply"), "is a cloud, which pcl_viewer shows"));
  EXPECT_TRUE(refuses([&] { io::openRecording({}); }, {"no input was given"}));
}

TEST_F(Recording, SeveralInputsMustBePcdFiles) {
  writeRig();
  EXPECT_TRUE(refuses([&] { io::openRecording({folder_.string(), path("level")}); }, {path("level"), ".pcd"}));
}

TEST_F(Recording, ColourOfARigInAnotherFolderIsSaid) {
  writeRig();
  EXPECT_FALSE(saysUnused(*open(), {}));
  for (const char* camera : {"level", "corner"})
    fs::rename(folder_ / camera / "color", folder_ / camera / "RGB_images");
  EXPECT_TRUE(saysUnused(*open(), {"level", "2 other images", "a folder color, rgb or image"}));
  EXPECT_TRUE(saysUnused(*open(), {"corner"}));
}

TEST_F(Recording, OfARigOnlyPosesThatAreUsedMustBeOnes) {
  writeRig();
  const std::string good = io::readFile(path("rig.json"));
  write("good.json", good);
  std::string text = good;
  const std::size_t at = text.find("\"T_world_camera\": [") + 19;
  text.replace(at, text.find(']', at) - at, "0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0");
  write("rig.json", text);
  EXPECT_TRUE(refuses([&] { open(); }, {"camera 'level': T_world_camera"}));
  io::RecordingOptions other;
  other.views = "1";
  EXPECT_EQ(open(other)->cameras()[0].name, "corner");
  io::RecordingOptions replaced;
  replaced.poses = path("good.json");
  io::LoadedFrame frame;
  open(replaced)->read(0, frame);
  EXPECT_TRUE(showsRoom(frame, 0));
  io::RecordingOptions calibrated;
  calibrated.without_poses = true;
  const auto recording = open(calibrated);
  ASSERT_EQ(recording->warnings().size(), 1u);
  EXPECT_NE(recording->warnings()[0].find("begins at the world's origin"), std::string::npos)
      << recording->warnings()[0];
}

}  // namespace
