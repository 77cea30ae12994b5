#include "../tools/support/png_file.h"
#include "images/float_files.h"
#include "io_fixture.h"
#include "room.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace {

using namespace io_test;

PixelValue depthOf(const RoomView& view, double unit = 1) {
  return [view, unit](int u, int v) { return static_cast<float>(view.depth(u, v) / unit); };
}

/** \brief The same camera with images of twice the size. */
RoomView twiceAsLarge(RoomView view, double first_middle = 0.5) {
  view.width *= 2;
  view.height *= 2;
  view.fx *= 2;
  view.fy *= 2;
  view.cx = 2 * (view.cx + first_middle) - first_middle;
  view.cy = 2 * (view.cy + first_middle) - first_middle;
  return view;
}

std::string numbers(const std::vector<double>& values, int digits = 9) {
  std::ostringstream text;
  text << std::setprecision(digits);
  for (const double value : values) text << value << ' ';
  return text.str();
}

bool warns(const io::Recording& recording, const std::string& words) {
  return std::any_of(recording.warnings().begin(), recording.warnings().end(),
                     [&](const std::string& warning) { return warning.find(words) != std::string::npos; });
}

std::unique_ptr<io::Recording> open(const fs::path& folder, const io::RecordingOptions& options = {}) {
  return io::openRecording({folder.string()}, options);
}

void expectRoom(io::Recording& recording, std::size_t views) {
  io::LoadedFrame frame;
  recording.read(0, frame);
  ASSERT_EQ(frame.rig.views.size(), views);
  EXPECT_NO_THROW(checkRigFrame(frame.rig));
  for (std::size_t view = 0; view < views; ++view) {
    EXPECT_TRUE(frame.rig.views[view].color);
    EXPECT_TRUE(showsRoom(frame, view)) << view;
  }
}

/** \brief The same where photographs are twice as large as their depth: a colour camera of its own, in the same place. */
void expectRoomInLargePhotographs(io::Recording& recording, const RoomView& large) {
  io::LoadedFrame frame;
  recording.read(0, frame);
  EXPECT_NO_THROW(checkRigFrame(frame.rig));
  for (std::size_t view = 0; view < frame.rig.views.size(); ++view) {
    EXPECT_EQ(frame.rig.views[view].color.width, large.width);
    ASSERT_TRUE(frame.rig.cameras[view].color);
    EXPECT_TRUE(frame.rig.cameras[view].color->T_depth_color.isApprox(Eigen::Isometry3d::Identity()));
    const Intrinsics& K = frame.rig.cameras[view].color->intrinsics;
    EXPECT_EQ(K.width, large.width);
    EXPECT_EQ(K.height, large.height);
    EXPECT_NEAR(K.fx, large.fx, 1e-5);
    EXPECT_NEAR(K.fy, large.fy, 1e-5);
    EXPECT_NEAR(K.cx, large.cx, 1e-5);
    EXPECT_NEAR(K.cy, large.cy, 1e-5);
    frame.rig.views[view].color = {};
    EXPECT_TRUE(showsRoom(frame, view)) << view;
  }
}

// ---- MVSNet

/** \brief cams/, images/, depth_est/, confidence/ of three photographs. */
class Mvsnet : public IoTest {
 protected:
  void SetUp() override {
    IoTest::SetUp();
    for (int i = 0; i < 3; ++i) writeView(i, view(i));
  }
  static constexpr double kFirstMiddle = 0;  // coordinates count from it
  static RoomView view(int i) { return i == 0 ? levelView() : cornerView(i - 1); }
  static std::string stem(int i) { return "0000000" + std::to_string(i); }

  static std::string cameraText(const RoomView& view, double unit = 1, int digits = 9) {
    Eigen::Isometry3d T = view.T_world_camera.inverse();
    T.translation() /= unit;
    std::string text = "extrinsic\n";
    for (int row = 0; row < 4; ++row) {
      const Eigen::RowVector4d r = T.matrix().row(row);
      text += numbers({r[0], r[1], r[2], r[3]}, digits) + "\n";
    }
    return text + "\nintrinsic\n" + numbers({view.fx, 0, view.cx}) + "\n" + numbers({0, view.fy, view.cy}) +
           "\n0 0 1\n\n0.5 0.01 192 4.2\n";
  }
  void writeView(int i, const RoomView& view, double unit = 1, int digits = 9) const {
    write("cams/" + stem(i) + "_cam.txt", cameraText(view, unit, digits));
    write("images/" + stem(i) + ".png", view.colorPng());
    write("depth_est/" + stem(i) + ".pfm", pfm(view.width, view.height, depthOf(view, unit)));
    write("confidence/" + stem(i) + ".pfm",
          pfm(view.width, view.height, [i](int, int) { return 0.25f * static_cast<float>(i); }));
  }
};

TEST_F(Mvsnet, PointsLieOnTheWallsOfTheRoomWithTheirConfidence) {
  const auto recording = open(folder_);
  EXPECT_EQ(recording->kind(), "mvsnet");
  EXPECT_EQ(recording->frameCount(), 1u);
  EXPECT_EQ(recording->viewName(1), stem(1));
  expectRoom(*recording, 3);
  io::LoadedFrame frame;
  recording->read(0, frame);
  EXPECT_EQ(frame.rig.views[2].confidence.row(5)[7], 0.5f);
  EXPECT_TRUE(warns(*recording, "unit of length is taken for the metre"));
}

TEST_F(Mvsnet, AnotherUnitIsThatOfDepthAndOfPositions) {
  for (int i = 0; i < 3; ++i) writeView(i, view(i), 0.001);  // millimetres, as DTU has them
  io::RecordingOptions options;
  options.depth_scale = 0.001f;
  const auto recording = open(folder_, options);
  expectRoom(*recording, 3);
  EXPECT_FALSE(warns(*recording, "unit of length"));
}

TEST_F(Mvsnet, ARotationOfFewDigitsBecomesTheNearest) {
  writeView(1, view(1), 1, 3);
  io::LoadedFrame frame;
  open(folder_)->read(0, frame);
  const Eigen::Matrix3d R = frame.rig.cameras[1].T_world_camera.linear();
  EXPECT_LT((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LT((R - view(1).T_world_camera.linear()).norm(), 3e-3);
}

TEST_F(Mvsnet, PhotographsMayBeLargerThanTheirDepthAndTheCamerasBeOfEither) {
  EXPECT_FALSE(warns(*open(folder_), "of which size"));
  for (int i = 0; i < 3; ++i) write("images/" + stem(i) + ".png", twiceAsLarge(view(i), kFirstMiddle).colorPng());
  const auto of_depth = open(folder_);
  EXPECT_TRUE(warns(*of_depth, "taken for those of the depth maps"));
  expectRoomInLargePhotographs(*of_depth, twiceAsLarge(view(0), 0));
  for (int i = 0; i < 3; ++i) write("cams/" + stem(i) + "_cam.txt", cameraText(twiceAsLarge(view(i), kFirstMiddle)));
  const auto of_images = open(folder_);
  EXPECT_TRUE(warns(*of_images, "taken for those of the images"));
  expectRoomInLargePhotographs(*of_images, twiceAsLarge(view(0), 0));
  // Their size is needed even where colour is not wanted.
  io::RecordingOptions options;
  options.read_color = false;
  io::LoadedFrame frame;
  open(folder_, options)->read(0, frame);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_FALSE(frame.rig.views[i].color);
    EXPECT_TRUE(showsRoom(frame, i));
  }
  // One photograph that is not there does not make its camera another.
  fs::remove(folder_ / "images" / "00000001.png");
  EXPECT_TRUE(refuses([&] { open(folder_); }, {"camera '00000001'", "photograph that is not there"}));
  fs::remove_all(folder_ / "images");
  EXPECT_TRUE(refuses([&] { open(folder_); }, {"principal point", "64x48", "another size"}));
}

TEST_F(Mvsnet, PhotographsWithoutDepthAreLeftOutAndItIsSaid) {
  fs::remove(folder_ / "depth_est" / "00000001.pfm");
  const auto recording = open(folder_);
  EXPECT_EQ(recording->cameras().size(), 2u);
  EXPECT_TRUE(warns(*recording, "1 of 3 images have no depth map"));
}

TEST_F(Mvsnet, ViewsAreChosenByTheirPlace) {
  io::RecordingOptions options;
  options.views = "2,0";
  const auto recording = open(folder_, options);
  ASSERT_EQ(recording->cameras().size(), 2u);
  EXPECT_EQ(recording->viewName(0), stem(2));
  expectRoom(*recording, 2);
}

TEST_F(Mvsnet, DepthMayBeNumPys) {
  fs::rename(folder_ / "depth_est", folder_ / "depth");
  fs::remove(folder_ / "depth" / "00000000.pfm");
  write("depth/00000000.npy", npy("<f4", "(48, 64)", floats(64, 48, depthOf(view(0)))));
  expectRoom(*open(folder_), 3);
}

TEST_F(Mvsnet, WhatIsWrongIsRefusedInOneLine) {
  const auto refusal = [&](const std::vector<std::string>& words) { return refuses([&] { open(folder_); }, words); };
  const std::string camera = write("cams/00000001_cam.txt", "extrinsic\n1 0 0\n");
  EXPECT_TRUE(refusal({camera, "too few numbers behind 'extrinsic'"}));
  write("cams/00000001_cam.txt", "K\n1 0 0\n");
  EXPECT_TRUE(refusal({camera, "no 'extrinsic'"}));
  std::string text = cameraText(view(1));
  text.replace(text.find('\n') + 1, 1, "9");
  write("cams/00000001_cam.txt", text);
  EXPECT_TRUE(refusal({camera, "not rigid"}));
  writeView(1, view(1));
  const std::string depth = write("depth_est/00000001.pfm", pfm(64, 20, [](int, int) { return 1.0f; }));
  EXPECT_TRUE(refusal({depth, "64x20", "64x48", "same shape"}));
  fs::remove_all(folder_ / "depth_est");
  write("depth_est/other.pfm", pfm(64, 48, [](int, int) { return 1.0f; }));
  EXPECT_TRUE(refusal({path("depth_est"), "no depth map of the cameras", "00000000.pfm"}));
  fs::remove_all(folder_ / "depth_est");
  fs::remove_all(folder_ / "images");
  EXPECT_TRUE(refusal({folder_.string(), "neither depth maps nor photographs"}));
}

TEST_F(Mvsnet, WithoutDepthMapsItsImagesArePhotographsWithoutDepth) {
  fs::remove_all(folder_ / "depth_est");
  fs::remove_all(folder_ / "confidence");
  const auto recording = open(folder_);
  EXPECT_TRUE(warns(*recording, "its 3 images are photographs without depth"));
  EXPECT_FALSE(warns(*recording, "left out"));
  io::LoadedFrame frame;
  recording->read(0, frame);
  ASSERT_EQ(frame.rig.views.size(), 3u);
  for (std::size_t view = 0; view < 3; ++view) {
    EXPECT_FALSE(recording->hasDepth(view));
    EXPECT_TRUE(frame.rig.views[view].missing());
    EXPECT_EQ(frame.rig.views[view].color.width, 64);
    EXPECT_TRUE(
        frame.rig.cameras[view].T_world_camera.isApprox(this->view(static_cast<int>(view)).T_world_camera, 1e-6));
    EXPECT_EQ(frame.rig.cameras[view].intrinsics.height, 48);
  }
}

TEST_F(Mvsnet, OptionsThatDoNotFitAreRefused) {
  io::RecordingOptions options;
  options.slide = 1;
  EXPECT_TRUE(refuses<io::OptionError>([&] { open(folder_, options); }, {"--slide"}));
  options = {};
  options.intrinsics = "camera.json";
  EXPECT_TRUE(refuses<io::OptionError>([&] { open(folder_, options); }, {"--intrinsics"}));
}

TEST_F(Mvsnet, WhatIsNotFoundIsSaid) {
  fs::rename(folder_ / "images" / "00000000.png", folder_ / "images" / "00000000.PNG");
  EXPECT_FALSE(warns(*open(folder_), "photograph"));
  fs::rename(folder_ / "images" / "00000000.PNG", folder_ / "images" / "rect_0.png");
  fs::remove(folder_ / "confidence" / "00000001.pfm");
  EXPECT_TRUE(warns(*open(folder_), "1 of 3 views have no photograph there"));
  EXPECT_TRUE(warns(*open(folder_), "1 of 3 views have no confidence there"));
  fs::remove(folder_ / "cams" / "00000001_cam.txt");
  write("cams/._00000002_cam.txt", "what another system writes");
  EXPECT_TRUE(warns(*open(folder_), "1 of 3 depth maps have no camera"));
  EXPECT_FALSE(warns(*open(folder_), "have no depth map"));
  write("train.log", "epoch 1\n");
  EXPECT_EQ(open(folder_)->kind(), "mvsnet");
}

TEST_F(Mvsnet, ConfidenceIsFrom0To1) {
  write("confidence/00000001.pfm", pfm(64, 48, [](int, int) { return 255.0f; }));
  io::LoadedFrame frame;
  EXPECT_TRUE(refuses([&] { open(folder_)->read(0, frame); }, {"00000001.pfm", "255", "0 to 1"}));
}

TEST_F(Mvsnet, PosesThatAreCameraToWorldCanBeSaidToBe) {
  for (int i = 0; i < 3; ++i) {
    RoomView inverted = view(i);
    inverted.T_world_camera = inverted.T_world_camera.inverse();
    write("cams/" + stem(i) + "_cam.txt", cameraText(inverted));
  }
  io::RecordingOptions options;
  options.pose_convention = io::PoseConvention::WorldToCamera;
  expectRoom(*open(folder_, options), 3);
}

// ---- COLMAP

/** \brief A workspace of undistorted images: sparse/, images/, stereo/depth_maps/. */
class Colmap : public IoTest {
 protected:
  void SetUp() override {
    IoTest::SetUp();
    for (int i = 0; i < 3; ++i) {
      write("images/" + name(i), view(i).colorPng());
      write("stereo/depth_maps/" + name(i) + ".photometric.bin", colmapMap(64, 48, [](int, int) { return 9.0f; }));
      write("stereo/depth_maps/" + name(i) + ".geometric.bin", colmapMap(64, 48, depthOf(view(i))));
    }
    writeText();
  }
  static constexpr double kFirstMiddle = 0.5;  // coordinates count from the corner of the first pixel
  static RoomView view(int i) { return i == 0 ? levelView() : cornerView(i - 1); }
  static std::string name(int i) { return i == 2 ? "left/b.png" : "a" + std::to_string(i) + ".png"; }
  static Eigen::Quaterniond rotation(int i) { return Eigen::Quaterniond(view(i).T_world_camera.linear().transpose()); }
  static Eigen::Vector3d translation(int i) { return view(i).T_world_camera.inverse().translation(); }
  // Pixel (0, 0) reaches from 0 to 1 there.
  static std::vector<double> pinhole() { return {24, 20, 29.5, 26}; }

  void writeText(const std::string& camera = "7 PINHOLE 64 48 24 20 29.5 26\n") const {
    write("sparse/cameras.txt", "# Camera list\n" + camera);
    std::string images = "# Image list with two lines of data per image:\n";
    for (int i = 0; i < 3; ++i) {
      const Eigen::Quaterniond q = rotation(i);
      const Eigen::Vector3d t = translation(i);
      images += std::to_string(i + 1) + " " + numbers({q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}, 17) + "7 " +
                name(i) + "\n" + (i == 1 ? "" : "12.5 13.5 -1 20 21 44") + "\n";
    }
    write("sparse/images.txt", images);
  }
  void writeBinary(std::int32_t model = 1) const {
    std::string cameras = rawBytes(std::uint64_t{1}) + rawBytes(std::uint32_t{7}) + rawBytes(model) +
                          rawBytes(std::uint64_t{64}) + rawBytes(std::uint64_t{48});
    for (const double p : pinhole()) cameras += rawBytes(p);
    write("sparse/cameras.bin", cameras);
    std::string images = rawBytes(std::uint64_t{3});
    for (int i = 0; i < 3; ++i) {
      const Eigen::Quaterniond q = rotation(i);
      const Eigen::Vector3d t = translation(i);
      images += rawBytes(static_cast<std::uint32_t>(i + 1));
      for (const double x : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) images += rawBytes(x);
      images += rawBytes(std::uint32_t{7}) + name(i) + std::string(1, '\0') + rawBytes(static_cast<std::uint64_t>(i));
      for (int k = 0; k < i; ++k) images += rawBytes(1.5) + rawBytes(2.5) + rawBytes(std::uint64_t{44});
    }
    write("sparse/images.bin", images);
  }
};

TEST_F(Colmap, PointsLieOnTheWallsOfTheRoomFromText) {
  const auto recording = open(folder_);
  EXPECT_EQ(recording->kind(), "colmap");
  EXPECT_FALSE(warns(*recording, "photometric"));
  EXPECT_EQ(recording->viewName(2), "left_b.png");
  expectRoom(*recording, 3);
}

TEST_F(Colmap, AndFromBinary) {
  fs::remove(folder_ / "sparse" / "cameras.txt");
  fs::remove(folder_ / "sparse" / "images.txt");
  writeBinary();
  expectRoom(*open(folder_), 3);
}

TEST_F(Colmap, TheModelMayLieInSparse0) {
  fs::rename(folder_ / "sparse", folder_ / "model");
  fs::create_directories(folder_ / "sparse");
  fs::rename(folder_ / "model", folder_ / "sparse" / "0");
  expectRoom(*open(folder_), 3);
}

TEST_F(Colmap, PhotometricDepthServesWhereNothingElseIsThere) {
  for (int i = 0; i < 3; ++i) {
    fs::remove(folder_ / "stereo" / "depth_maps" / (name(i) + ".geometric.bin"));
    write("stereo/depth_maps/" + name(i) + ".photometric.bin", colmapMap(64, 48, depthOf(view(i))));
  }
  const auto recording = open(folder_);
  EXPECT_TRUE(warns(*recording, "3 of 3 depth maps are photometric"));
  expectRoom(*recording, 3);
}

TEST_F(Colmap, DepthMayBeSmallerThanTheImages) {
  // max_image_size of patch_match_stereo: the model is of the images.
  for (int i = 0; i < 3; ++i) write("images/" + name(i), twiceAsLarge(view(i), kFirstMiddle).colorPng());
  writeText("7 PINHOLE 128 96 48 40 59 52\n");
  expectRoomInLargePhotographs(*open(folder_), twiceAsLarge(view(0)));
}

TEST_F(Colmap, WhatIsWrongIsRefusedInOneLine) {
  const auto refusal = [&](const std::vector<std::string>& words) { return refuses([&] { open(folder_); }, words); };
  writeText("7 OPENCV 64 48 24 20 29.5 26 0.1 0 0 0\n");
  EXPECT_TRUE(refusal({"cameras.txt", "camera 7", "image_undistorter"}));
  writeText("8 PINHOLE 64 48 24 20 29.5 26\n");
  EXPECT_TRUE(refusal({"images.txt", "a0.png", "camera 7"}));
  writeText("7 FOV 64 48 24 20 29.5 26 1\n");
  EXPECT_TRUE(refusal({"cameras.txt", "FOV"}));
  writeText();
  write("sparse/images.txt", "1 2 0 0 0 0 0 0 7 a0.png\n\n");
  EXPECT_TRUE(refusal({"images.txt", "a0.png", "quaternion of length 1"}));
  write("sparse/images.txt", "1 1 0 0 0 0 0 7 a0.png\n\n");
  EXPECT_TRUE(refusal({"images.txt", "is no image"}));
  write("sparse/images.txt", "1 1 0 0 0 0 0 0 7 a0.png\n2 1 0 0 0 0 0 0 7 a1.png\n");
  EXPECT_TRUE(refusal({"images.txt", "behind image a0.png", "empty line"}));
  writeBinary(12);
  EXPECT_TRUE(refusal({"cameras.bin", "number 12"}));
  writeBinary();
  std::string images = rawBytes(std::uint64_t{1} << 60);
  const std::string binary = write("sparse/images.bin", images);
  EXPECT_TRUE(refusal({binary, "cut short"}));
  fs::remove(folder_ / "sparse" / "images.bin");
  writeText();
  fs::remove_all(folder_ / "stereo");
  write("stereo/depth_maps/other.png.geometric.bin", colmapMap(64, 48, [](int, int) { return 1.0f; }));
  EXPECT_TRUE(refusal({path("stereo/depth_maps"), "no depth map of the images", "images.txt"}));
}

TEST_F(Colmap, WithoutDepthMapsItsImagesArePhotographsWithoutDepth) {
  fs::remove_all(folder_ / "stereo");
  fs::create_directories(folder_ / "stereo" / "depth_maps");  // empty, as image_undistorter leaves it
  writeText("7 OPENCV 64 48 24 20 29.5 26 0.1 0 0 0\n");
  const auto recording = open(folder_);
  EXPECT_TRUE(warns(*recording, "its 3 images are photographs without depth"));
  io::LoadedFrame frame;
  recording->read(0, frame);
  ASSERT_EQ(frame.rig.views.size(), 3u);
  for (std::size_t view = 0; view < 3; ++view) {
    EXPECT_FALSE(recording->hasDepth(view));
    EXPECT_TRUE(recording->hasColor(view));
    EXPECT_TRUE(frame.rig.views[view].missing());
    EXPECT_EQ(frame.rig.views[view].color.width, 64);
    EXPECT_EQ(frame.images[view].color_file, path("images/" + name(static_cast<int>(view))));
  }
  EXPECT_EQ(frame.rig.cameras[0].intrinsics.distortion.k1, 0.1f) << "lenses may be as they are";
  EXPECT_FLOAT_EQ(frame.rig.cameras[0].intrinsics.cx, 29);
  fs::remove(folder_ / "images" / name(0));
  EXPECT_EQ(open(folder_)->cameras().size(), 2u);
  EXPECT_TRUE(warns(*open(folder_), "1 of 3 images are not there"));
}

/** \brief The points of points3D.txt, and the numbers of the images that see each. */
struct SparsePoint {
  Eigen::Vector3d p;
  std::vector<int> images;
};

std::vector<SparsePoint> readSparsePoints(const fs::path& file) {
  std::vector<SparsePoint> points;
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    double skipped = 0;
    SparsePoint point;
    words >> skipped >> point.p.x() >> point.p.y() >> point.p.z();
    for (int k = 0; k < 4; ++k) words >> skipped;
    for (int image = 0; words >> image >> skipped;) point.images.push_back(image);
    points.push_back(point);
  }
  return points;
}

TEST_F(Colmap, ColmapsPointsFallIntoThePhotographsThatSeeThem) {
  const fs::path sceaux = fs::path(FUSE_FLOW_TEST_SHARED_DATA) / "sceaux";
  if (!fs::exists(sceaux)) GTEST_SKIP() << sceaux << " is not there";
  const auto recording = open(sceaux);
  EXPECT_TRUE(warns(*recording, "its 11 images are photographs without depth"));
  ASSERT_EQ(recording->cameras().size(), 11u);  // their names are in the order of their numbers
  std::size_t seen = 0, of = 0;
  for (const SparsePoint& point : readSparsePoints(sceaux / "sparse" / "points3D.txt"))
    for (const int image : point.images) {
      const Camera& camera = recording->cameras().at(static_cast<std::size_t>(image - 1));
      const Eigen::Vector3d p = camera.T_world_camera.inverse() * point.p;
      const Pixel pixel =
          project(camera.intrinsics, {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
      seen += p.z() > 0 && pixel.u > -0.5f && pixel.v > -0.5f && pixel.u < 959.5f && pixel.v < 712.5f ? 1 : 0;
      ++of;
    }
  EXPECT_GT(of, 40000u);
  EXPECT_GT(static_cast<double>(seen), 0.999 * static_cast<double>(of));
}

TEST_F(Colmap, CamerasBesideItDoNotHideItsDepth) {
  write("cams/00000000_cam.txt", "extrinsic");
  EXPECT_EQ(open(folder_)->kind(), "colmap");
}

TEST_F(Colmap, ADamagedViewCanBeLeftOut) {
  io::RecordingOptions options;
  options.skip_damaged = true;
  const auto recording = open(folder_, options);
  write("stereo/depth_maps/a1.png.geometric.bin", "64&48&1&");
  io::LoadedFrame frame;
  recording->read(0, frame);
  ASSERT_EQ(frame.damaged.size(), 1u);
  EXPECT_EQ(frame.damaged[0].view, 1u);
  EXPECT_TRUE(frame.rig.views[1].missing());
  EXPECT_TRUE(showsRoom(frame, 0));
}

// ---- Rigs

TEST_F(Mvsnet, ARigMayHaveDepthInFloat) {
  const RoomView view = levelView();
  const auto T = [&] {
    std::string text;
    for (int row = 0; row < 4; ++row) {
      const Eigen::RowVector4d r = view.T_world_camera.matrix().row(row);
      for (int k = 0; k < 4; ++k) text += (text.empty() ? "" : ", ") + numbers({r[k]});
    }
    return text;
  }();
  const auto rig = [&](const std::string& scale) {
    return R"({"cameras": [{"name": "left", "width": 64, "height": 48, "fx": 24, "fy": 20, "cx": 29, "cy": 25.5, )"
           R"("depth_scale": )" +
           scale + R"(, "T_world_camera": [)" + T + "]}]}";
  };
  write("rig/left/color/000000.png", view.colorPng());
  write("rig/left/confidence/000000.npy", npy("<f4", "(48, 64)", floats(64, 48, [](int, int) { return 0.75f; })));
  for (const bool metres : {true, false}) {
    write("rig/rig.json", rig(metres ? "1" : "0.001"));
    write("rig/left/depth/000000.pfm", pfm(64, 48, depthOf(view, metres ? 1 : 0.001)));
    const auto recording = open(folder_ / "rig");
    EXPECT_EQ(warns(*recording, "multiplied by its depth_scale, 0.001"), !metres);
    expectRoom(*recording, 1);
    io::LoadedFrame frame;
    recording->read(0, frame);
    EXPECT_EQ(frame.rig.views[0].confidence.row(3)[4], 0.75f);
  }
  fs::rename(folder_ / "rig/left/depth/000000.pfm", folder_ / "rig/left/depth/000000.PFM");
  expectRoom(*open(folder_ / "rig"), 1);
  fs::rename(folder_ / "rig/left/depth/000000.PFM", folder_ / "rig/left/depth/000000.pfm");
  write("rig/left/depth/000000.png", view.depthPng());
  EXPECT_TRUE(refuses([&] { open(folder_ / "rig"); }, {"000000.pfm and 000000.png", "one depth image"}));
}

}  // namespace
