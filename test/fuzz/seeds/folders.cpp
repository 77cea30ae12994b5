#include "../scratch.h"
#include "../seeds.h"
#include "small_images.h"

#include "recordings/files/file_io.h"
#include "recordings/images/jpeg_encode.h"

#include "../../apps/recordings/images/float_files.h"
#include "../../apps/tools/support/png_file.h"

#include <fuse_flow/recordings/rig_json.h>

namespace fuse_flow_fuzz {
namespace {

const std::string kPose = "1 0 0 0.5\n0 1 0 -0.25\n0 0 1 1\n0 0 0 1\n";

std::string plainDepthPng(std::uint16_t value) {
  return tool_test::depthPng(kWidth, kHeight, std::vector<std::uint16_t>(kWidth * kHeight, value));
}

std::string colorJpeg() {
  fuse_flow::io::ColorImage image;
  image.resize(kWidth, kHeight);
  for (auto& pixel : image.data) pixel = {10, 200, 30};
  return fuse_flow::io::encodeJpeg(image, 90);
}

fuse_flow::io::RigDescription rigOfTwo() {
  using namespace fuse_flow;
  io::RigDescription rig;
  for (const char* name : {"left", "right"}) {
    io::RigCamera camera;
    camera.camera.name = name;
    camera.camera.intrinsics = {kWidth, kHeight, 10, 10, 3.5f, 2.5f, {}};
    camera.camera.T_world_camera = Eigen::Translation3d(name[0] == 'l' ? -0.1 : 0.1, 0, 0);
    rig.cameras.push_back(camera);
  }
  rig.frames_per_second = 30;
  return rig;
}

std::string writtenRig(const fuse_flow::io::RigDescription& rig) {
  const std::string path = scratchFile("seed.json", "");
  fuse_flow::io::writeRigJson(path, rig);
  return fuse_flow::io::readFile(path);
}

/** \brief Everything that a camera can have. */
std::string fullRig() {
  using namespace fuse_flow;
  io::RigDescription rig = rigOfTwo();
  io::RigCamera& entry = rig.cameras[0];
  entry.camera.intrinsics.distortion = {0.1f, -0.05f, 0.001f, -0.002f, 0.01f, 0, 0, 0};
  entry.confidence_scale = 0.5f;
  entry.depth = {true, 0.01f};
  entry.camera.depth_correction.columns = entry.camera.depth_correction.rows = 2;
  entry.camera.depth_correction.relative = {0.01f, 0, 0, 0};
  entry.camera.depth_correction.per_metre = {0, 0, 0, 0.01f};
  entry.camera.noise = NoiseModel{0.001f, 0.0f, 0.002f};
  entry.camera.color = ColorCamera{{16, 12, 20, 20, 7.5f, 5.5f, {}}, Eigen::Isometry3d::Identity()};
  rig.cameras[1].camera.multipath.modulation_frequency = 1e8f;
  return writtenRig(rig);
}

std::string mvsnetCamera(const char* x) {
  return "extrinsic\n1 0 0 " + std::string(x) +
         "\n0 1 0 0\n0 0 1 0\n0 0 0 1\n\nintrinsic\n10 0 3.5\n0 10 2.5\n0 0 1\n\n0.5 0.01\n";
}

template <typename... Numbers>
std::string raw(const Numbers&... numbers) {
  return (io_test::rawBytes(numbers) + ...);
}

const std::string kOpen3dCamera =
    "{\"width\": 8, \"height\": 6, \"intrinsic_matrix\": [10, 0, 0, 0, 10, 0, 3.5, 2.5, 1]}";

}  // namespace

void addCalibrationSeeds(Seeds& seeds) {
  seeds["rig_json"] = {
      writtenRig(rigOfTwo()), fullRig(),
      "{\"cameras\": [{\"name\": \"other\", \"width\": 640, \"height\": 480, \"fx\": 300, \"fy\": 300, \"cx\": 319, "
      "\"cy\": 239, \"distortion_model\": \"plumb_bob\", \"distortion\": [0.1, 0.01, 0, 0], \"T_world_camera\": "
      "[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1], \"T_camera_world\": 3}]}"};
  const std::string yaml =
      "image_width: 640\nimage_height: 480\ncamera_name: left\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [525, 0, "
      "319.5, 0, 525, "
      "239.5, 0, 0, 1]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.1, "
      "-0.05, 0.001, 0, 0]\n";
  const std::string opencv =
      "%YAML:1.0\n---\nK: [525, 0, 319.5, 0, 525, 239.5, 0, 0, 1]\nD: [0.1, 0.01, 0.0, 0.0]\ndistortion_model: "
      "radtan\n"
      "width: 640\nheight: 480\n";
  seeds["intrinsics"] = {
      std::string(1, '\0') + yaml,
      std::string(1, '\0') + opencv,
      "\1" + kOpen3dCamera,
      "\1{\"fx\": 500, \"fy\": 500, \"ppx\": 320, \"ppy\": 240, \"width\": 640, \"height\": 480, \"model\": "
      "\"brown_conrady\", "
      "\"coeffs\": [0, 0, 0, 0, 0]}",
      "\2 585 0 320\n0 585 240\n0 0 1\n",
      "\2# fx fy cx cy\n585 585 320 240\n",
      "\3# cameras\n1 OPENCV 640 480 500 500 320 240 0.1 0.01 0 0\n2 SIMPLE_RADIAL 800 600 500 400 300 0.1\n",
      "\4{\"parameters\": [{\"intrinsic\": " + kOpen3dCamera + ", \"extrinsic\": [1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}]}"};
  seeds["lens_model"] = {"equidistant\n0.1 0.01 0 0", "inverse_brown_conrady\n0.1 -0.05 0.001 0 0.01", "ftheta\n0.9",
                         "rational_polynomial\n0.1 0 0 0 0 0 0 0 0.001 0 0 0 0.01 0"};
  seeds["timestamps"] = {"# times\n1.5\n1.6\n1.7\n1.8\n", "1700000000000,000000.png\n1700000000033,000001.png\n",
                         "0 9.0e18\n1 17\n2 1000000000000\n"};
  seeds["image_names"] = {"frame_0001.png\nframe_0002.png\nframe_0003.png\n", "1.50.png\n2.50.png\n3.5.png\n",
                          "0001_1700000000000.png\n0002_1700000000033.png\n0003_1700000000066.png\n",
                          "9200000000000000000.png\n1.png\n1700000000000000000.png\n",
                          "000000.png\n000001.png\nother.txt\n"};
  const std::string lens =
      "\"Intrinsics\": {\"ModelType\": \"CALIBRATION_LensDistortionModelBrownConrady\", \"ModelParameters\": [0.5, "
      "0.5, 0.49, 0.49, 0.5, "
      "-0.02, -0.003, 0.9, 0.08, -0.014, 0, 0, -7e-5, 2e-5]}, \"Rt\": {\"Rotation\": [1, 0, 0, 0, 1, 0, 0, 0, 1], "
      "\"Translation\": "
      "[-0.032, 0.002, 0.004]}";
  seeds["mkv_calibration"] = {
      "{\"CalibrationInformation\": {\"Cameras\": [{\"Location\": \"CALIBRATION_CameraLocationD0\", " + lens +
      ", \"SensorWidth\": 1024, \"SensorHeight\": 1024}, {\"Location\": \"CALIBRATION_CameraLocationPV0\", " + lens +
      ", \"SensorWidth\": 4096, \"SensorHeight\": 3072}]}}"};
}

void addFolderSeeds(Seeds& seeds) {
  const std::string depth = plainDepthPng(1000), jpeg = colorJpeg(),
                    color = tool_test::colorPng(kWidth, kHeight, 10, 20, 30);
  const std::string confidence = tool_test::samplesPng(kWidth, kHeight, 8, 0, std::string(kWidth * kHeight, '\x80'));
  const std::string npy = io_test::npy("<f4", "(6, 8)", io_test::floats(kWidth, kHeight, metresAt));
  seeds["rig"] = {joinedFiles({writtenRig(rigOfTwo()), depth, "II*", color, jpeg, confidence, "1.5\n1.6\n",
                               "1.51\n1.61\n", depth, npy}),
                  joinedFiles({fullRig(), depth}), joinedFiles({writtenRig(rigOfTwo()), depth, depth, color})};
  seeds["seven_scenes"] = {joinedFiles({kPose, depth, "10 0 3.5\n0 10 2.5\n0 0 1\n", jpeg, kPose, depth})};
  seeds["tum"] = {
      joinedFiles({"# depth\n1.00 depth/1.png\n1.03 depth/2.png\n",
                   "1.001 0.1 0.2 0.3 0 0 0 1\n1.04 0 0 0 0.5 0.5 -0.5 0.5\n", depth, "1.01 rgb/1.png\n", color,
                   "image_width: 8\nimage_height: 6\nK: [10, 0, 3.5, 0, 10, 2.5, 0, 0, 1]\nD: [0.1, 0, 0, 0, 0]\n"})};
  const std::string trajectory =
      "{\"parameters\": [{\"extrinsic\": [1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1], \"intrinsic\": " + kOpen3dCamera +
      "}, {\"extrinsic\": [1,0,0,0,0,1,0,0,0,0,1,0,0.1,0,0,1], \"intrinsic\": " + kOpen3dCamera + "}]}";
  seeds["redwood"] = {joinedFiles({trajectory, depth}),
                      joinedFiles({trajectory, depth, "0 0 1\n" + kPose + "1 1 2\n" + kPose, jpeg, kOpen3dCamera})};
  const std::string pfm = io_test::pfm(kWidth, kHeight, metresAt);
  seeds["mvsnet"] = {
      joinedFiles({mvsnetCamera("0"), pfm, color, io_test::pfm(kWidth, kHeight, [](int, int) { return 0.5f; }),
                   mvsnetCamera("0.1"), npy})};
  const std::string map = io_test::colmapMap(kWidth, kHeight, metresAt);
  seeds["colmap"] = {joinedFiles({"# cameras\n1 PINHOLE 8 6 10 10 4 3\n2 OPENCV 8 6 10 10 4 3 0 0 0 0\n",
                                  "1 1 0 0 0 0 0 0 1 a.png\n1 2 -1 3 4 5\n2 0.7071068 0 0.7071068 0 1 0 0 2 b.png\n\n",
                                  color, map, map})};
  // One camera of model 1 (PINHOLE), and one photograph without points.
  const std::string cameras = raw(std::uint64_t{1}, std::uint32_t{1}, std::int32_t{1}, std::uint64_t{8},
                                  std::uint64_t{6}, 10.0, 10.0, 4.0, 3.0);
  const std::string images =
      raw(std::uint64_t{1}, std::uint32_t{1}, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, std::uint32_t{1}) + "a.png" + '\0' +
      raw(std::uint64_t{1}, 1.0, 2.0, std::int64_t{-1});
  seeds["colmap_binary"] = {joinedFiles({cameras, images, color, map})};
}

}  // namespace fuse_flow_fuzz
