#include "io_fixture.h"
#include "room.h"

#include <algorithm>
#include <sstream>

namespace {

using namespace io_test;

const std::string kIntrinsics = R"({"width": 64, "height": 48, "intrinsic_matrix": [24, 0, 0, 0, 20, 0, 29, 25.5, 1]})";

/** \brief depth/, image/, a trajectory and the intrinsics of three frames. */
class Redwood : public IoTest {
 protected:
  void SetUp() override {
    IoTest::SetUp();
    const std::vector<RoomView> views{levelView(), cornerView(), cornerView(1)};
    std::string log;
    for (std::size_t i = 0; i < views.size(); ++i) {
      const std::string number = std::to_string(i), next = std::to_string(i + 1);
      // The number is that of the frame, what follows is its time: different for depth and colour.
      write("depth/000000" + next + "-00000003336" + number + ".png", views[i].depthPng());
      write("image/000000" + next + "-00000003999" + number + ".png", views[i].colorPng());
      log += number + " " + number + " " + next + "\n" + views[i].poseText();
    }
    write("trajectory.log", log);
    write("camera.json", kIntrinsics);
  }
  std::unique_ptr<io::Recording> open(const std::string& views = "0,1,2") const {
    io::RecordingOptions options;
    options.views = views;
    return io::openRecording({folder_.string()}, options);
  }
};

TEST_F(Redwood, PointsLieOnTheWallsOfTheRoom) {
  const auto recording = open();
  EXPECT_EQ(recording->kind(), "redwood");
  io::LoadedFrame frame;
  recording->read(0, frame);
  ASSERT_EQ(frame.rig.views.size(), 3u);
  for (std::size_t view = 0; view < 3; ++view) {
    EXPECT_TRUE(frame.rig.views[view].color);
    EXPECT_TRUE(showsRoom(frame, view)) << view;
  }
}

TEST_F(Redwood, ColorMayLieInAFolderNamedColor) {
  fs::rename(folder_ / "image", folder_ / "color");
  io::LoadedFrame frame;
  open()->read(0, frame);
  EXPECT_TRUE(frame.rig.views[2].color);
  EXPECT_TRUE(showsRoom(frame, 2));
}

TEST_F(Redwood, WhatItConsistsOfIsKnown) {
  write("report.json", "{}");  // of a tool, which may be written again
  write("second_camera.json", kIntrinsics);
  const std::vector<std::string> inputs = open()->inputs();
  const auto has = [&](const std::string& name) {
    return std::find(inputs.begin(), inputs.end(), path(name)) != inputs.end();
  };
  for (const char* name : {"camera.json", "second_camera.json", "trajectory.log", "depth", "image"})
    EXPECT_TRUE(has(name)) << name;
  EXPECT_FALSE(has("report.json"));
}

TEST_F(Redwood, ADepthImageThatIsGoneIsNoFrameThatTheCameraMissed) {
  const auto recording = open();
  fs::remove_all(path("depth"));
  io::LoadedFrame frame;
  EXPECT_TRUE(refuses([&] { recording->read(0, frame); }, {path("depth"), "no longer there"}));
}

TEST_F(Redwood, WithoutColorThereIsDepth) {
  fs::remove_all(folder_ / "image");
  io::LoadedFrame frame;
  open()->read(0, frame);
  EXPECT_FALSE(frame.rig.views[0].color);
  EXPECT_TRUE(showsRoom(frame, 0));
}

TEST_F(Redwood, NumbersWithoutLeadingZerosAreInTheOrderOfTheirValue) {
  fs::remove_all(folder_ / "depth");
  fs::remove_all(folder_ / "image");
  std::string log;
  for (int i = 0; i < 12; ++i) {
    const std::string number = std::to_string(i);
    write("depth/" + number + ".png", cornerView(i).depthPng());
    write("image/" + number + ".png", cornerView(i).colorPng());
    log += number + " " + number + " " + std::to_string(i + 1) + "\n" + cornerView(i).poseText();
  }
  write("trajectory.log", log);
  const auto recording = open("2,10,11");
  EXPECT_EQ(recording->viewName(0), "2");
  EXPECT_EQ(recording->viewName(1), "10");
  io::LoadedFrame frame;
  recording->read(0, frame);
  for (std::size_t view = 0; view < 3; ++view) EXPECT_TRUE(showsRoom(frame, view)) << view;
}

/** \brief Frames 0 … 5 by plain numbers, each with a view of its own. */
class RedwoodByNumber : public Redwood {
 protected:
  void SetUp() override {
    Redwood::SetUp();
    fs::remove_all(folder_ / "depth");
    fs::remove_all(folder_ / "image");
    std::string log;
    for (int i = 0; i < 6; ++i) {
      const std::string number = std::to_string(i);
      write("depth/0000" + number + ".png", cornerView(i).depthPng());
      write("color/0000" + number + ".png", cornerView(i).colorPng());
      log += number + " " + number + " " + std::to_string(i + 1) + "\n" + cornerView(i).poseText();
    }
    write("trajectory.log", log);
  }
  void expectRoom(const std::string& views) const {
    io::LoadedFrame frame;
    open(views)->read(0, frame);
    for (std::size_t view = 0; view < frame.rig.views.size(); ++view) {
      EXPECT_TRUE(frame.rig.views[view].color) << view;
      EXPECT_TRUE(showsRoom(frame, view)) << view;
    }
  }
};

TEST_F(RedwoodByNumber, LostDepthImagesMoveNoPoseAndNoColour) {
  fs::remove(path("depth/00000.png"));
  fs::remove(path("depth/00001.png"));
  expectRoom("2,5");
  EXPECT_TRUE(open("2,5")->warnings().empty());
  EXPECT_TRUE(refuses<io::OptionError>([&] { open("0"); }, {"frame 0 is not in", "4 frames: 2, 3, 4, 5"}));
}

TEST_F(RedwoodByNumber, LostColourImagesMoveNone) {
  fs::remove(path("color/00002.png"));
  io::LoadedFrame frame;
  open("1,2,3")->read(0, frame);
  EXPECT_FALSE(frame.rig.views[1].color);
  EXPECT_TRUE(frame.rig.views[2].color);
  EXPECT_TRUE(showsRoom(frame, 2));
}

TEST_F(RedwoodByNumber, ImagesThatCountFromOneGetThePosesThatCountFromZeroAndItIsSaid) {
  for (int i = 5; i >= 0; --i)
    for (const std::string folder : {"depth/0000", "color/0000"})
      fs::rename(path(folder + std::to_string(i) + ".png"), path(folder + std::to_string(i + 1) + ".png"));
  expectRoom("0,5");
  ASSERT_EQ(open("0")->warnings().size(), 1u);
  EXPECT_NE(open("0")->warnings()[0].find("count from 1"), std::string::npos);
}

TEST_F(RedwoodByNumber, NamesThatAreTimesAreTakenInTheirOrderAndItIsSaid) {
  for (int i = 0; i < 6; ++i)
    for (const std::string folder : {"depth/", "color/"})
      fs::rename(path(folder + "0000" + std::to_string(i) + ".png"),
                 path(folder + std::to_string(1547171088000 + 33 * i) + ".png"));
  expectRoom("0,5");
  ASSERT_EQ(open("0")->warnings().size(), 1u);
  EXPECT_NE(open("0")->warnings()[0].find("in their order"), std::string::npos);
  fs::remove(path("color/1547171088000.png"));  // now the order of the colours is another
  io::LoadedFrame frame;
  const auto recording = open("1");
  recording->read(0, frame);
  EXPECT_FALSE(frame.rig.views[0].color);
  EXPECT_TRUE(showsRoom(frame, 0));
  ASSERT_EQ(recording->warnings().size(), 2u);
  EXPECT_NE(recording->warnings()[1].find("colour images are not used, 5 beside 6"), std::string::npos);
}

TEST_F(RedwoodByNumber, ColourMayLieInAFolderNamedRgb) {
  fs::rename(path("color"), path("rgb"));
  expectRoom("0,5");
}

TEST_F(RedwoodByNumber, APoseThatIsLostHindersNoOther) {
  std::string log;
  for (int i = 0; i < 6; ++i)
    log += std::to_string(i) + " 0 0\n" +
           (i == 2 ? "nan nan nan nan\nnan nan nan nan\nnan nan nan nan\n0 0 0 1\n" : cornerView(i).poseText());
  write("trajectory.log", log);
  expectRoom("1,3");
  EXPECT_TRUE(refuses([&] { open("2"); }, {path("trajectory.log"), "pose of frame 2", "not finite"}));
}

TEST_F(Redwood, AFrameThatTheTrajectoryLeavesOutHasNoPoseAndIsNamed) {
  write("trajectory.log", "0 0 1\n" + levelView().poseText() + "2 2 3\n" + cornerView(1).poseText());
  EXPECT_TRUE(refuses([&] { open("1"); }, {path("trajectory.log"), "no pose of frame 1", "/depth/", "must have"}));
  EXPECT_TRUE(refuses<io::OptionError>([&] { open("3"); }, {"--views 3"}));
  io::LoadedFrame frame;
  open("2")->read(0, frame);
  EXPECT_TRUE(showsRoom(frame, 0));
}

TEST_F(Redwood, APoseWithoutImagesIsNoFrame) {
  write("trajectory.log", "7 7 8\n" + levelView().poseText());
  EXPECT_TRUE(refuses([&] { open("7"); }, {path("trajectory.log"), "no pose of frame 0"}));
}

TEST_F(Redwood, WhatIsWrongWithATrajectoryIsNamed) {
  const std::string log = path("trajectory.log");
  write("trajectory.log", "");
  EXPECT_TRUE(refuses([&] { open(); }, {log, "has 0 numbers, must be 19 a frame"}));
  write("trajectory.log", "0 0\n" + levelView().poseText());
  EXPECT_TRUE(refuses([&] { open(); }, {log, "has 18 numbers"}));
  for (const char* number : {"-1", "nan", "0.5", "1e12"}) {
    write("trajectory.log", std::string(number) + " 0 1\n" + levelView().poseText());
    EXPECT_TRUE(refuses([&] { open(); }, {log, "pose number 0 has no frame number"})) << number;
  }
  write("trajectory.log", "0 0 1\n1 0 0 0\n0 1 0 0\n0 0 -1 0\n0 0 0 1\n");
  EXPECT_TRUE(refuses([&] { open(); }, {log, "pose of frame 0", "is not rigid"}));
}

TEST_F(Redwood, AmongSeveralTrajectoriesItIsTheOneNamedSo) {
  write("odometry.log", "0 1 3\n" + cornerView(3).poseText());
  io::LoadedFrame frame;
  open()->read(0, frame);
  EXPECT_TRUE(showsRoom(frame, 0));
  fs::rename(path("trajectory.log"), path("second.log"));
  EXPECT_TRUE(refuses([&] { open(); }, {folder_.string(), "2 trajectories", "trajectory.log"}));
  fs::remove(path("odometry.log"));
  open()->read(0, frame);
  EXPECT_TRUE(showsRoom(frame, 0));
}

/** \brief As Open3D writes a PinholeCameraTrajectory: world → camera, column by column. */
std::string trajectoryJson(const std::vector<RoomView>& views, const std::string& intrinsics = kIntrinsics) {
  std::ostringstream json;
  json.precision(17);
  json << R"({"class_name": "PinholeCameraTrajectory", "parameters": [)";
  for (std::size_t k = 0; k < views.size(); ++k) {
    const Eigen::Matrix4d extrinsic = views[k].T_world_camera.inverse().matrix();
    json << (k ? ", " : "") << R"({"class_name": "PinholeCameraParameters", "extrinsic": [)";
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 4; ++row) json << (row + column > 0 ? ", " : "") << extrinsic(row, column);
    json << R"(], "intrinsic": )" << intrinsics << "}";
  }
  json << R"(], "version_major": 1, "version_minor": 0})";
  return json.str();
}

TEST_F(Redwood, PosesAndIntrinsicsMayComeFromOpen3dsTrajectory) {
  fs::remove(path("trajectory.log"));
  fs::remove(path("camera.json"));
  write("camera_trajectory.json", trajectoryJson({levelView(), cornerView(), cornerView(1)}));
  const auto recording = open();
  EXPECT_EQ(recording->kind(), "redwood");
  EXPECT_TRUE(recording->warnings().empty()) << recording->warnings()[0];
  io::LoadedFrame frame;
  recording->read(0, frame);
  for (std::size_t view = 0; view < 3; ++view) EXPECT_TRUE(showsRoom(frame, view)) << view;
  const std::vector<std::string> inputs = recording->inputs();
  EXPECT_NE(std::find(inputs.begin(), inputs.end(), path("camera_trajectory.json")), inputs.end());
  // A file of the camera alone goes before.
  write("camera.json", R"({"width": 64, "height": 48, "intrinsic_matrix": [30, 0, 0, 0, 20, 0, 29, 25.5, 1]})");
  EXPECT_EQ(open()->cameras()[0].intrinsics.fx, 30);
}

TEST_F(Redwood, ALogGoesBeforeOpen3dsTrajectoryAndItIsSaid) {
  write("camera_trajectory.json", trajectoryJson({cornerView(2), cornerView(3), cornerView(4)}));
  const auto recording = open();
  io::LoadedFrame frame;
  recording->read(0, frame);
  EXPECT_TRUE(showsRoom(frame, 0));
  ASSERT_EQ(recording->warnings().size(), 1u);
  EXPECT_NE(recording->warnings()[0].find(path("camera_trajectory.json") + ": is not used"), std::string::npos);
}

TEST_F(Redwood, WhatIsWrongWithOpen3dsTrajectoryIsNamed) {
  fs::remove(path("trajectory.log"));
  const std::string json = path("camera_trajectory.json");
  const std::string identity = "1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1";
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"{", "is not JSON"},
      {"[]", "list parameters"},
      {R"({"parameters": []})", "list parameters"},
      {R"({"parameters": [{"intrinsic": {}}]})", "pose of frame 0: has no extrinsic"},
      {R"({"parameters": [{"extrinsic": [1, 2]}]})", "pose of frame 0: extrinsic must be 16 numbers"},
      {R"({"parameters": [{"extrinsic": [)" + identity + R"(]}, {"extrinsic": ["x", 0, 0, 0, )" + identity.substr(12) +
           "]}]}",
       "pose of frame 1: extrinsic has \"x\""},
      {
          R"({"parameters": [{"extrinsic": [2)" + identity.substr(1) + "]}]}",
          "pose of frame 0",
      },
      {R"({"parameters": [{"extrinsic": [)" + identity + "]}]}", "has no pose of frame 1"}};
  for (const auto& [text, problem] : wrong) {
    write("camera_trajectory.json", text);
    EXPECT_TRUE(refuses([&] { open("0,1,2"); }, {json, problem})) << text;
  }
  fs::remove(path("camera.json"));
  std::string different = trajectoryJson({levelView(), cornerView(), cornerView(1)});
  different.replace(different.rfind("[24,"), 4, "[25,");
  write("camera_trajectory.json", different);
  EXPECT_TRUE(refuses([&] { open(); }, {json, "different intrinsics"}));
}

TEST_F(Redwood, WhatIsWrongWithIntrinsicsIsNamed) {
  const std::string json = path("camera.json");
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"{", "is not a camera"},
      {R"({"width": 64, "height": 48, "intrinsic_matrix": [24, 0, 29]})", "must have 9 numbers"},
      {R"({"width": 64, "height": 48, "intrinsic_matrix": "K"})", "is not a camera"},
      {R"({"width": 64.5, "height": 48, "intrinsic_matrix": [24, 0, 0, 0, 20, 0, 29, 25, 1]})",
       "width is 64.5, must be"},
      {R"({"width": 64, "height": -48, "intrinsic_matrix": [24, 0, 0, 0, 20, 0, 29, 25, 1]})",
       "height is -48, must be"},
      {R"({"width": 1e99, "height": 48, "intrinsic_matrix": [24, 0, 0, 0, 20, 0, 29, 25, 1]})",
       "width is 1e+99, must be"},
      {R"({"width": "64", "height": 48, "intrinsic_matrix": [24, 0, 0, 0, 20, 0, 29, 25, 1]})", "is not a camera"},
      {R"({"width": 64, "height": 48, "intrinsic_matrix": [24, 0, 29, 0, 20, 25.5, 0, 0, 1]})", "column by column"}};
  for (const auto& [text, problem] : wrong) {
    write("camera.json", text);
    EXPECT_TRUE(refuses([&] { open(); }, {json, problem})) << text;
  }
  fs::remove(json);
  EXPECT_TRUE(refuses([&] { open(); }, {folder_.string(), "no file says the intrinsics", "--intrinsics"}));
}

TEST_F(Redwood, JsonFilesOfOtherThingsArePassedOver) {
  write("a_settings.json", R"({"max_depth": 3})");
  write("b_list.json", "[1, 2, 3]");
  io::LoadedFrame frame;
  open()->read(0, frame);
  EXPECT_TRUE(showsRoom(frame, 0));
}

TEST_F(Redwood, WithoutASizeInTheIntrinsicsItIsThatOfTheImages) {
  write("camera.json", R"({"intrinsic_matrix": [24, 0, 0, 0, 20, 0, 29, 25.5, 1]})");
  EXPECT_EQ(open()->cameras()[0].intrinsics.width, 64);
  EXPECT_EQ(open()->cameras()[0].intrinsics.height, 48);
}

TEST_F(Redwood, ColourInAnotherFolderIsSaid) {
  EXPECT_FALSE(saysUnused(*open(), {}));
  fs::rename(folder_ / "image", folder_ / "colour");
  EXPECT_TRUE(saysUnused(*open(), {"3 other images", "colour", "a folder color, rgb or image"}));
  fs::rename(folder_ / "colour", folder_ / "infrared");
  EXPECT_FALSE(saysUnused(*open(), {})) << "it says that it is something else";
}

}  // namespace
