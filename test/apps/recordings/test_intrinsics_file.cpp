#include "recordings/calibrations/intrinsics_file.h"

#include "io_fixture.h"

namespace {

using namespace io_test;

std::vector<float> lensNumbers(const Intrinsics& K) {
  const Distortion& d = K.distortion;
  return {K.fx, K.fy, K.cx, K.cy, d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6};
}

class IntrinsicsFile : public IoTest {
 protected:
  Intrinsics read(const std::string& name, const std::string& text, int width = 0, int height = 0) const {
    return io::readIntrinsicsFile(write(name, text), width, height);
  }
};

// As camera_calibration of ROS writes it.
const std::string kCameraInfo =
    "image_width: 640\nimage_height: 480\ncamera_name: depth\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
    "  data: [525.5, 0.0, 319.25, 0.0, 526.5, 239.75, 0.0, 0.0, 1.0]\ndistortion_model: plumb_bob\n"
    "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.1, -0.2, 0.003, -0.004, 0.05]\n"
    "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [500, 0, 300, 0, 0, 500, 200, 0, 0, 0, 1, 0]\n";
const std::vector<float> kCamera{525.5f, 526.5f, 319.25f, 239.75f, 0.1f, -0.2f, 0.003f, -0.004f, 0.05f, 0, 0, 0};

TEST_F(IntrinsicsFile, CameraInfoOfRos) {
  const Intrinsics K = read("camera.yaml", kCameraInfo);
  EXPECT_EQ(K.width, 640);
  EXPECT_EQ(K.height, 480);
  EXPECT_EQ(lensNumbers(K), kCamera);
}

TEST_F(IntrinsicsFile, TheMessageOfRosAsItIsEchoed) {
  const Intrinsics K = read("info.yml",
                            "header:\n  seq: 1\nheight: 480\nwidth: 640\ndistortion_model: \"rational_polynomial\"\n"
                            "D: [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8]\n"
                            "K: [525.5, 0.0, 319.25, 0.0, 526.5, 239.75, 0.0, 0.0, 1.0]\n");
  EXPECT_EQ(K.width, 640);
  EXPECT_EQ(lensNumbers(K),
            (std::vector<float>{525.5f, 526.5f, 319.25f, 239.75f, 0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f, 0.7f, 0.8f}));
}

TEST_F(IntrinsicsFile, YamlOfOpenCv) {
  const Intrinsics K =
      read("cv.yml",
           "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n"
           "   rows: 3\n   cols: 3\n   dt: d\n   data: [ 525.5, 0., 319.25, 0., 526.5, 239.75, 0., 0., 1. ]\n"
           "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n"
           "   data: [ 0.1, -0.2, 0.003, -0.004, 0.05 ]\n");
  EXPECT_EQ(K.height, 480);
  EXPECT_EQ(lensNumbers(K), kCamera);
}

TEST_F(IntrinsicsFile, JsonOfOpen3dIsColumnByColumn) {
  const Intrinsics K =
      read("camera.json", R"({"width": 64, "height": 48, "intrinsic_matrix": [24, 0, 0, 0, 20, 0, 29, 25.5, 1]})");
  EXPECT_EQ(K.width, 64);
  EXPECT_EQ(lensNumbers(K), (std::vector<float>{24, 20, 29, 25.5f, 0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_TRUE(refuses(
      [&] {
        read("camera.json", R"({"width": 64, "height": 48, "intrinsic_matrix": [24, 0, 29, 0, 20, 25.5, 0, 0, 1]})");
      },
      {path("camera.json"), "column by column"}));
}

TEST_F(IntrinsicsFile, JsonWithTheKeysOfRigJson) {
  const Intrinsics K = read("camera.json",
                            R"({"width": 640, "height": 480, "fx": 525.5, "fy": 526.5, "cx": 319.25, "cy": 239.75,
                                "distortion": [0.1, -0.2, 0.003, -0.004, 0.05, 0, 0, 0]})");
  EXPECT_EQ(lensNumbers(K), kCamera);
}

TEST_F(IntrinsicsFile, AMatrixAsTextOrFourNumbers) {
  const std::vector<float> expected{24, 20, 29, 25.5f, 0, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(lensNumbers(read("K.txt", "24 0 29\n0 20 25.5\n0 0 1\n")), expected);
  EXPECT_EQ(lensNumbers(read("K.txt", "24 0 29 0\n0 20 25.5 0\n0 0 1 0\n0 0 0 1\n")), expected) << "ScanNet's is 4x4";
  EXPECT_EQ(lensNumbers(read("K.txt", "# fx fy cx cy\n24 20 29 25.5\n")), expected);
  EXPECT_TRUE(refuses([&] { read("K.txt", "24 0 29 0 20 25.5\n"); }, {path("K.txt"), "has 6 numbers, must be 9"}));
  EXPECT_TRUE(refuses([&] { read("K.txt", "24 0 29 7\n0 20 25.5 0\n0 0 1 0\n0 0 0 1\n"); }, {path("K.txt"), "4x4"}));
}

TEST_F(IntrinsicsFile, CamerasOfColmapWhosePixelCentresLieAtHalves) {
  const std::string header =
      "# Camera list with one line of data per camera:\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  EXPECT_EQ(lensNumbers(read("cameras.txt", header + "1 PINHOLE 64 48 24 20 29.5 26\n")),
            (std::vector<float>{24, 20, 29, 25.5f, 0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(lensNumbers(read("cameras.txt", header + "1 SIMPLE_RADIAL 64 48 24 29.5 26 0.25\n")),
            (std::vector<float>{24, 24, 29, 25.5f, 0.25f, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(
      lensNumbers(read("cameras.txt", header + "1 OPENCV 640 480 525.5 526.5 319.75 240.25 0.1 -0.2 0.003 -0.004\n")),
      (std::vector<float>{525.5f, 526.5f, 319.25f, 239.75f, 0.1f, -0.2f, 0.003f, -0.004f, 0, 0, 0, 0}));
  EXPECT_TRUE(refuses([&] { read("cameras.txt", header + "1 OPENCV_FISHEYE 64 48 24 20 29 25 0 0 0 0\n"); },
                      {path("cameras.txt"), "OPENCV_FISHEYE", "must be SIMPLE_PINHOLE"}));
  EXPECT_TRUE(refuses([&] { read("cameras.txt", header + "1 PINHOLE 64 48 24 20 29\n"); },
                      {path("cameras.txt"), "has 3 parameters, must be 4"}));
}

TEST_F(IntrinsicsFile, AmongSeveralCamerasOfColmapItIsTheOneOfTheImagesSize) {
  const std::string two = "1 PINHOLE 1280 960 900 900 640 480\n2 PINHOLE 64 48 24 20 29.5 26\n";
  EXPECT_EQ(read("cameras.txt", two, 64, 48).fx, 24);
  EXPECT_TRUE(refuses([&] { read("cameras.txt", two + "3 PINHOLE 64 48 25 20 29.5 26\n", 64, 48); },
                      {path("cameras.txt"), "2 different cameras"}));
}

TEST_F(IntrinsicsFile, LensesThatCannotBeExpressedAreRefused) {
  std::string fisheye = kCameraInfo;
  fisheye.replace(fisheye.find("plumb_bob"), 9, "equidistant");
  EXPECT_TRUE(refuses([&] { read("a.yaml", fisheye); }, {path("a.yaml"), "5 distortion coefficients", "must have 4"}));
  std::string unknown = kCameraInfo;
  unknown.replace(unknown.find("plumb_bob"), 9, "cat_eye");
  EXPECT_TRUE(refuses([&] { read("a.yaml", unknown); }, {path("a.yaml"), "cat_eye", "plumb_bob"}));
  EXPECT_TRUE(refuses([&] { read("b.yaml", "camera_matrix: {data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\nD: [1, 2, 3]\n"); },
                      {path("b.yaml"), "has 3 distortion coefficients"}));
  EXPECT_TRUE(refuses([&] { read("c.yaml", "camera_matrix: {data: [24, 5, 29, 0, 20, 25, 0, 0, 1]}\n"); },
                      {path("c.yaml"), "skew"}));
}

TEST_F(IntrinsicsFile, WhatHasNoneIsRefusedByNameAndPassedOverInAFolder) {
  EXPECT_TRUE(
      refuses([&] { read("settings.json", R"({"max_depth": 3})"); }, {path("settings.json"), "no camera intrinsics"}));
  EXPECT_TRUE(refuses([&] { read("notes.yaml", "who: me\n"); }, {path("notes.yaml"), "no camera intrinsics"}));
  EXPECT_TRUE(refuses([&] { read("damaged.yaml", "K: [1, 2\n"); }, {path("damaged.yaml"), "line"}));
  fs::remove(path("damaged.yaml"));
  write("notes.txt", "24 0 29 0 20 25.5 0 0 1");  // no usual name of intrinsics
  EXPECT_FALSE(io::findIntrinsics(folder_.string(), 64, 48));
  write("camera.json", R"({"width": 64, "height": 48, "intrinsic_matrix": [24, 0, 0, 0, 20, 0, 29, 25.5, 1]})");
  ASSERT_TRUE(io::findIntrinsics(folder_.string(), 64, 48));
}

TEST_F(IntrinsicsFile, OfSeveralThoseOfTheImagesSizeCountAndThenThoseNamedDepth) {
  write("color.json", R"({"width": 1280, "height": 720, "fx": 900, "fy": 900, "cx": 640, "cy": 360})");
  write("other.json", R"({"width": 64, "height": 48, "fx": 24, "fy": 20, "cx": 29, "cy": 25.5})");
  EXPECT_EQ(io::findIntrinsics(folder_.string(), 64, 48)->intrinsics.fx, 24);
  write("third.json", R"({"width": 64, "height": 48, "fx": 25, "fy": 20, "cx": 29, "cy": 25.5})");
  EXPECT_TRUE(
      refuses([&] { io::findIntrinsics(folder_.string(), 64, 48); }, {"other.json", "third.json", "--intrinsics"}));
  write("depth.json", R"({"width": 64, "height": 48, "fx": 26, "fy": 20, "cx": 29, "cy": 25.5})");
  EXPECT_EQ(io::findIntrinsics(folder_.string(), 64, 48)->intrinsics.fx, 26);
  EXPECT_TRUE(refuses([&] { io::findIntrinsics(folder_.string(), 320, 240); }, {"320x240"}));
}

}  // namespace
