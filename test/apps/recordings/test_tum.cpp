#include "io_fixture.h"
#include "room.h"

#include <Eigen/Geometry>

#include <functional>
#include <iomanip>
#include <sstream>

namespace {

using namespace io_test;

/** \brief The room through the camera that the format implies without a freiburg in its name. */
RoomView tumView(RoomView view) {
  view.width = 640;
  view.height = 480;
  view.fx = view.fy = 525;
  view.cx = 319.5;
  view.cy = 239.5;
  return view;
}

/** \brief "tx ty tz qx qy qz qw" */
std::string poseLine(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond q(T.linear());
  std::ostringstream text;
  text << std::setprecision(12) << T.translation().transpose() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << ' '
       << q.w();
  return text.str();
}

/** \brief depth.txt, rgb.txt, groundtruth.txt and the images of two frames, 100 ms apart. */
class Tum : public IoTest {
 protected:
  void SetUp() override {
    IoTest::SetUp();
    writeImages("1.000000", tumView(levelView()));
    writeImages("1.100000", tumView(cornerView()));
    write("depth.txt", header_ + "1.000000 depth/1.000000.png\n1.100000 depth/1.100000.png\n");
    write("rgb.txt", header_ + "1.010000 rgb/1.000000.png\n1.095000 rgb/1.100000.png\n");
    // Those beside each frame are too far away in time, or farther than the right one.
    write("groundtruth.txt", header_ + "0.970000 " + wrong_ + "\n0.995000 0.5 0.3 1.2 -0.5 0.5 -0.5 0.5\n1.012000 " +
                                 wrong_ + "\n1.088000 " + wrong_ + "\n1.108000 " +
                                 poseLine(cornerView().T_world_camera) + "\n1.150000 " + wrong_ + "\n");
  }
  void writeImages(const std::string& stem, const RoomView& view) const {
    write("depth/" + stem + ".png", view.depthPng(1.0 / 5000));
    write("rgb/" + stem + ".png", view.colorPng());
  }
  std::unique_ptr<io::Recording> open(const std::string& views = "0,1") const {
    io::RecordingOptions options;
    options.views = views;
    return io::openRecording({folder_.string()}, options);
  }

  const std::string header_{"# timestamp, then what it belongs to\n# a second line\n"};
  const std::string wrong_{"7 7 7 0 0 0 1"};
};

TEST_F(Tum, PointsLieOnTheWallsOfTheRoom) {
  const auto recording = open();
  EXPECT_EQ(recording->kind(), "tum");
  io::LoadedFrame frame;
  recording->read(0, frame);
  ASSERT_EQ(frame.rig.views.size(), 2u);
  EXPECT_TRUE(frame.rig.views[0].color);
  EXPECT_TRUE(frame.rig.views[1].color);
  EXPECT_TRUE(showsRoom(frame, 0, 1));  // the level camera sees the wall before it
  EXPECT_TRUE(showsRoom(frame, 1, 3));
}

TEST_F(Tum, AUnitIsAFifthOfAMillimetre) {
  io::LoadedFrame frame;
  const auto recording = open();
  recording->read(0, frame);
  EXPECT_EQ(frame.rig.views[0].depth16.row(240)[320], 10000);
  EXPECT_FLOAT_EQ(frame.rig.cameras[0].depth_scale * 10000, 2.0f);
}

/** \brief The stamps of a day in 2019, 33 ms apart, in another unit. */
void expectMicroseconds(const std::function<std::unique_ptr<io::Recording>(const std::string&)>& write_and_open,
                        const std::string& zeros, const std::string& unit) {
  const auto recording = write_and_open(zeros);
  ASSERT_EQ(recording->frameCount(), 3u);
  io::LoadedFrame frame;
  for (std::size_t k = 0; k < 3; ++k) {
    recording->read(k, frame);
    EXPECT_EQ(frame.rig.stamp, 1547171088126000u + 33000u * k) << unit;
  }
  EXPECT_NEAR(*recording->framesPerSecond(), 1 / 0.033, 1e-6) << unit;
  ASSERT_FALSE(recording->warnings().empty()) << unit;
  EXPECT_NE(recording->warnings()[0].find("taken for " + unit), std::string::npos) << recording->warnings()[0];
}

TEST_F(Tum, StampsInMillisecondsMicrosecondsAndNanosecondsAreTold) {
  const auto write_and_open = [&](const std::string& zeros) {
    std::string depth, poses;
    for (const char* stamp : {"1547171088126", "1547171088159", "1547171088192"}) {
      depth += stamp + zeros + " depth/1.000000.png\n";
      poses += stamp + zeros + " " + poseLine(levelView().T_world_camera) + "\n";
    }
    write("depth.txt", depth);
    write("groundtruth.txt", poses);
    fs::remove(path("rgb.txt"));
    io::RecordingOptions options;
    options.views = "0";
    options.slide = 1;
    return io::openRecording({folder_.string()}, options);
  };
  expectMicroseconds(write_and_open, "", "milliseconds");
  expectMicroseconds(write_and_open, "000", "microseconds");
  expectMicroseconds(write_and_open, "000000", "nanoseconds");
}

TEST_F(Tum, APoseThatIsLostHindersNoOther) {
  write("groundtruth.txt", "0.995 0.5 0.3 1.2 -0.5 0.5 -0.5 0.5\n1.1 nan nan nan 0 0 0 1\n");
  io::LoadedFrame frame;
  open("0")->read(0, frame);
  EXPECT_TRUE(showsRoom(frame, 0, 1));
  EXPECT_TRUE(refuses([&] { open("0,1"); }, {path("groundtruth.txt"), "nan", "tx ty tz"}));
}

TEST_F(Tum, IntrinsicsBesideTheImagesGoBeforeThoseOfTheDataset) {
  write("camera_info.yaml",
        "image_width: 640\nimage_height: 480\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
        "  data: [500, 0, 320, 0, 501, 240, 0, 0, 1]\n");
  const auto recording = open("0");
  EXPECT_EQ(recording->cameras()[0].intrinsics.fx, 500);
  EXPECT_EQ(recording->cameras()[0].intrinsics.fy, 501);
  EXPECT_TRUE(recording->warnings().empty());
}

TEST_F(Tum, TheQuaternionEndsWithItsRealPart) {
  // A quarter turn about z, which takes x to y.
  write("groundtruth.txt", "1.0 1 2 3 0 0 0.70710678118654752 0.70710678118654752\n");
  const auto recording = open("0");
  const Eigen::Isometry3d& T = recording->cameras()[0].T_world_camera;
  EXPECT_LT((T * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 3, 3)).norm(), 1e-12);
  EXPECT_LT((T * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(1, 2, 4)).norm(), 1e-12);
}

TEST_F(Tum, FramesHaveTheTimeOfTheirDepthInMicroseconds) {
  io::LoadedFrame frame;
  open("1,0")->read(0, frame);
  EXPECT_EQ(frame.rig.stamp, 1100000u);
  EXPECT_EQ(frame.rig.cameras[0].name, "1.100000");
}

TEST_F(Tum, TheRateIsThatOfMostFramesAndSlowerWhereTheViewsSlide) {
  // 100 ms apart but for one that was lost.
  std::string depth, poses;
  for (const char* stamp : {"1.0", "1.1", "1.2", "1.4", "1.5"}) {
    depth += std::string(stamp) + " depth/1.000000.png\n";
    poses += std::string(stamp) + " " + poseLine(levelView().T_world_camera) + "\n";
  }
  write("depth.txt", depth);
  write("groundtruth.txt", poses);
  io::RecordingOptions options;
  options.views = "0";
  EXPECT_FALSE(io::openRecording({folder_.string()}, options)->framesPerSecond()) << "a single instant has none";
  options.slide = 1;
  EXPECT_NEAR(*io::openRecording({folder_.string()}, options)->framesPerSecond(), 10, 1e-9);
  options.slide = 2;  // 0.2 s, then 0.3 s: the upper of two
  EXPECT_NEAR(*io::openRecording({folder_.string()}, options)->framesPerSecond(), 1 / 0.3, 1e-9);
}

TEST_F(Tum, DepthWithoutAPoseWithinTwentyMillisecondsIsLeftOut) {
  writeImages("1.050000", tumView(levelView()));
  write("depth.txt",
        "1.000000 depth/1.000000.png\n1.050000 depth/1.050000.png\n1.100000 depth/1.100000.png\n9 depth/9.png\n");
  const auto recording = open();
  EXPECT_EQ(recording->viewName(0), "1.000000");
  EXPECT_EQ(recording->viewName(1), "1.100000");
  EXPECT_TRUE(refuses<io::OptionError>([&] { open("2"); }, {"--views 2"}));
  write("groundtruth.txt", "50 0.5 0.3 1.2 -0.5 0.5 -0.5 0.5\n");
  EXPECT_TRUE(refuses([&] { open(); }, {folder_.string(), "no frame with a pose"}));
}

TEST_F(Tum, DepthWithoutColorWithinTwentyMillisecondsHasNone) {
  write("rgb.txt", "1.010000 rgb/1.000000.png\n1.121000 rgb/1.100000.png\n");
  io::LoadedFrame frame;
  open()->read(0, frame);
  EXPECT_TRUE(frame.rig.views[0].color);
  EXPECT_FALSE(frame.rig.views[1].color);
  fs::remove(path("rgb.txt"));
  open()->read(0, frame);
  EXPECT_FALSE(frame.rig.views[0].color);
}

TEST_F(Tum, EntriesMayComeInAnyOrder) {
  write("depth.txt", "1.100000 depth/1.100000.png\n1.000000 depth/1.000000.png\n");
  const auto recording = open();
  EXPECT_EQ(recording->viewName(0), "1.000000");
}

TEST_F(Tum, WhiteSpaceAroundAnEntryIsNoMistake) {
  write("depth.txt", "1.000000\tdepth/1.000000.png \r\n   \r\n1.100000   depth/1.100000.png\t\n\n");
  write("rgb.txt", "1.010000 rgb/1.000000.png  \n\t\n1.095000 rgb/1.100000.png\r\n");
  io::LoadedFrame frame;
  open()->read(0, frame);
  EXPECT_TRUE(frame.rig.views[0].color);
  EXPECT_TRUE(showsRoom(frame, 0, 1));
  EXPECT_TRUE(showsRoom(frame, 1, 3));
}

TEST_F(Tum, ALineThatCannotBeReadIsNamed) {
  write("depth.txt", "1.0 depth/1.000000.png\nnever depth/x.png\n");
  EXPECT_TRUE(refuses([&] { open(); }, {path("depth.txt") + ": line 2 is 'never depth/x.png'"}));
  write("depth.txt", "1.0\n");
  EXPECT_TRUE(refuses([&] { open(); }, {path("depth.txt") + ": line 1 is '1.0'"}));
  write("depth.txt", "1.0 depth/1.000000.png\n50000000000 depth/x.png\n");  // in the year 3554
  EXPECT_TRUE(refuses([&] { open(); }, {path("depth.txt"), "'depth/x.png' is no time in seconds"}));
  write("depth.txt", "# nothing\n");
  EXPECT_TRUE(refuses([&] { open(); }, {path("depth.txt"), "has no entry"}));
}

TEST_F(Tum, APoseThatIsNoneIsNamed) {
  for (const char* pose : {"0 0 0 0 0 0", "0 0 0 0 0 0 0", "0 0 0 1 1 1 1", "0 0 0 a b c d", "0 0 1e999 0 0 0 1"}) {
    write("groundtruth.txt", std::string("1.0 ") + pose + "\n");
    EXPECT_TRUE(refuses([&] { open(); }, {path("groundtruth.txt"), pose, "tx ty tz qx qy qz qw"}));
  }
}

/** \brief fx, fy, cx, cy, k1, k2, p1, p2, k3 of a recording in a folder of this name. */
std::vector<float> intrinsicsIn(const fs::path& recording, const fs::path& folder) {
  fs::create_directories(folder.parent_path());
  fs::copy(recording, folder, fs::copy_options::recursive);
  io::RecordingOptions options;
  options.views = "0";
  const auto opened = io::openRecording({folder.string()}, options);
  const Intrinsics K = opened->cameras()[0].intrinsics;
  const Distortion& d = K.distortion;
  return {K.fx, K.fy, K.cx, K.cy, d.k1, d.k2, d.p1, d.p2, d.k3};
}

TEST_F(Tum, TheCameraIsThatOfTheFolderName) {
  const fs::path root = folder_.string() + "_cameras";
  const std::vector<float> first{517.306408f, 516.469215f, 318.643040f, 255.313989f, 0.262383f,
                                 -0.953104f,  -0.005358f,  0.002628f,   1.163314f};
  const std::vector<float> second{520.908620f, 521.007327f, 325.141442f, 249.701764f, 0.231222f,
                                  -0.784899f,  -0.003257f,  -0.000105f,  0.917205f};
  const std::vector<float> third{535.433105f, 539.212524f, 320.106653f, 247.632132f, 0, 0, 0, 0, 0};
  EXPECT_EQ(intrinsicsIn(folder_, root / "a" / "rgbd_dataset_freiburg1_xyz"), first);
  EXPECT_EQ(intrinsicsIn(folder_, root / "b" / "rgbd_dataset_freiburg2_desk"), second);
  EXPECT_EQ(intrinsicsIn(folder_, root / "c" / "rgbd_dataset_freiburg3_office"), third);
  EXPECT_EQ(intrinsicsIn(folder_, root / "not_freiburg1" / "rgbd_dataset_freiburg2_desk"), second);
  fs::remove_all(root);
}

TEST_F(Tum, ColourThatIsOfNoDepthImageIsSaid) {
  EXPECT_FALSE(saysUnused(*open(), {}));
  write("rgb.txt", header_ + "5.010000 rgb/1.000000.png\n5.095000 rgb/1.100000.png\n");
  EXPECT_TRUE(saysUnused(*open(), {"2 other images", "1.000000.png", "listed in rgb.txt"}));
  fs::remove(folder_ / "rgb.txt");
  EXPECT_TRUE(saysUnused(*open(), {"listed in rgb.txt"}));
  fs::remove_all(folder_ / "rgb");
  write("preview.png", tumView(levelView()).colorPng());
  EXPECT_FALSE(saysUnused(*open(), {})) << "there is none";
}

}  // namespace
