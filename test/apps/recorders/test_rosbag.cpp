#include "../recordings/images/float_files.h"
#include "../recordings/io_fixture.h"
#include "recorder_images.h"

#include "recordings/files/file_io.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace {

using namespace io_test;
using namespace recorder_test;

/** \brief The bags that write_bags.py writes with Python's rosbag, once for all tests. */
class RosBag : public IoTest {
 protected:
  static void SetUpTestSuite() {
    std::string pattern = (fs::temp_directory_path() / "fuse_flow_bags_XXXXXX").string();
    if (!mkdtemp(pattern.data())) return;
    bags_ = pattern;
    const std::string command =
        "/usr/bin/python3 " FUSE_FLOW_TEST_SOURCE_DIR "/test/apps/recorders/write_bags.py " + pattern;
    if (std::system((command + " > " + pattern + "/log 2>&1").c_str()) != 0) {
      fs::remove_all(bags_);
      bags_.clear();
    }
  }
  static void TearDownTestSuite() {
    if (!bags_.empty()) fs::remove_all(bags_);
  }
  void SetUp() override {
    IoTest::SetUp();
    if (bags_.empty()) GTEST_SKIP() << "needs Debian's python3-rosbag, python3-sensor-msgs and python3-tf2-msgs";
  }

  static std::string bag(const std::string& name) { return (bags_ / name).string(); }
  static std::unique_ptr<io::Recording> open(const std::string& name, const io::RecordingOptions& options = {}) {
    return io::openRecording({bag(name)}, options);
  }
  static bool warns(const io::Recording& recording, const std::string& words) {
    return std::any_of(recording.warnings().begin(), recording.warnings().end(),
                       [&](const std::string& warning) { return warning.find(words) != std::string::npos; });
  }

  static fs::path bags_;
};
fs::path RosBag::bags_;

class RosBagCompression : public RosBag, public testing::WithParamInterface<const char*> {};

TEST_P(RosBagCompression, CamerasWithTheirImagesLensesAndPoses) {
  const auto recording = open(GetParam());
  EXPECT_EQ(recording->kind(), "bag");
  ASSERT_EQ(recording->cameras().size(), 2u);
  const Camera &left = recording->cameras()[0], &right = recording->cameras()[1];
  EXPECT_EQ(left.name, "left");
  EXPECT_EQ(right.name, "right");
  EXPECT_EQ(recording->frameCount(), 3u);
  EXPECT_NEAR(recording->framesPerSecond().value(), 30, 0.01);

  // image_raw: K and D. CameraInfo of write_bags.py has other numbers in P.
  EXPECT_FLOAT_EQ(left.intrinsics.fx, 60);
  EXPECT_FLOAT_EQ(left.intrinsics.fy, 61);
  EXPECT_FLOAT_EQ(left.intrinsics.cx, 31.5);
  EXPECT_FLOAT_EQ(left.intrinsics.distortion.k1, 0.1f);
  EXPECT_FLOAT_EQ(left.intrinsics.distortion.p2, -0.002f);
  EXPECT_FLOAT_EQ(left.intrinsics.distortion.k3, 0.01f);
  ASSERT_TRUE(left.color);
  EXPECT_FLOAT_EQ(left.color->intrinsics.fx, 70);
  EXPECT_EQ(left.color->intrinsics.width, kColorWidth);
  // Its axes were turned a quarter about y: what is 30 mm along the world's z is to its -x.
  EXPECT_LT((left.color->T_depth_color.translation() - Eigen::Vector3d(-0.03, 0, 0)).norm(), 1e-9);
  EXPECT_LT((left.T_world_camera * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(2, 0.5, 0)).norm(), 1e-9);
  EXPECT_LT((right.T_world_camera * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(0, 0, 3)).norm(), 1e-9);
  EXPECT_FALSE(right.color);
  EXPECT_FALSE(recording->hasColor(1));
  EXPECT_TRUE(warns(*recording, "not used: /left/infra1/image_raw"));

  io::LoadedFrame frame;
  for (const int k : {0, 1, 2, 0}) {  // also back
    recording->read(static_cast<std::size_t>(k), frame);
    expectDepth(frame.images[0].depth16, 0, k);
    expectDepth(frame.images[1].depth16, 1, k);
    expectColor(frame.images[0].color, 0, k);
    EXPECT_FALSE(frame.rig.views[1].color);
    const double middle = 1.7e15 + k * 33333.333 + 2500;  // microseconds, between the two cameras' headers
    EXPECT_NEAR(static_cast<double>(frame.rig.stamp), middle, 2);
  }
}

INSTANTIATE_TEST_SUITE_P(, RosBagCompression, testing::Values("rig.bag", "rig_lz4.bag", "rig_bz2.bag"),
                         [](const auto& bag) {
                           const std::string name = bag.param;
                           return name.substr(0, name.find('.'));
                         });

TEST_F(RosBag, EveryEncodingOfDepthAndColourGivesTheSamePixels) {
  const auto recording = open("encodings.bag");
  io::LoadedFrame frame;
  recording->read(0, frame);
  std::size_t seen = 0;
  for (std::size_t c = 0; c < recording->cameras().size(); ++c) {
    const std::string& name = recording->cameras()[c].name;
    SCOPED_TRACE(name);
    ++seen;
    if (name == "float")
      expectFloatDepth(frame.images[c].depth32, 0, 0, 1e-6);
    else if (name == "inverse")
      expectFloatDepth(frame.images[c].depth32, 0, 0, 1e-4);
    else
      expectDepth(frame.images[c].depth16, 0, 0);
    EXPECT_NE(frame.rig.views[c].depth16.data == nullptr, frame.rig.views[c].depth32.data == nullptr);
    if (name == "plain" || name == "padded") expectColor(frame.images[c].color, 0, 0);
  }
  EXPECT_EQ(seen, 6u);
}

TEST_F(RosBag, RealSensesOwnBagHasItsUnitItsExtrinsicsAndItsLens) {
  const auto recording = open("realsense.bag");
  ASSERT_EQ(recording->cameras().size(), 1u);
  const Camera& camera = recording->cameras()[0];
  EXPECT_EQ(camera.name, "realsense");
  EXPECT_FLOAT_EQ(camera.depth_scale, 0.0005f);
  ASSERT_TRUE(camera.color);
  // Its extrinsics lead from depth to colour: what is at x = 0 for depth is at 0.015 for colour.
  EXPECT_LT((camera.color->T_depth_color.translation() - Eigen::Vector3d(-0.015, 0, 0)).norm(), 1e-6);
  // The inverse polynomial of write_bags.py, applied to a pixel, is the ray that the fitted lens maps to it.
  const Intrinsics& K = camera.color->intrinsics;
  for (const auto& [u, v] : {std::pair{0.0, 0.0}, {79.0, 59.0}, {10.0, 50.0}, {39.5, 29.5}}) {
    const double x = (u - 39.5) / 70, y = (v - 29.5) / 71, r2 = x * x + y * y;
    const double f = 1 - 0.05 * r2 + 0.06 * r2 * r2 - 0.02 * r2 * r2 * r2;
    const double ray_x = x * f + 2 * 0.001 * x * y - 0.0004 * (r2 + 2 * x * x);
    const double ray_y = y * f - 2 * 0.0004 * x * y + 0.001 * (r2 + 2 * y * y);
    const Pixel pixel = project(K, {static_cast<float>(ray_x), static_cast<float>(ray_y), 1});
    EXPECT_NEAR(pixel.u, u, 0.02);
    EXPECT_NEAR(pixel.v, v, 0.02);
  }
  io::LoadedFrame frame;
  recording->read(1, frame);
  expectDepth(frame.images[0].depth16, 2, 1);
  expectColor(frame.images[0].color, 2, 1);
}

TEST_F(RosBag, OfSeveralBagsEachIsACameraAndPosesMustBeGiven) {
  fs::copy_file(bag("realsense.bag"), path("front.bag"));
  fs::copy_file(bag("realsense.bag"), path("back.bag"));
  const std::vector<std::string> bags{path("front.bag"), path("back.bag")};
  EXPECT_TRUE(
      refuses([&] { io::openRecording(bags); }, {"front.bag", "does not say where camera 'front' stands", "--poses"}));
  io::RecordingOptions options;
  options.without_poses = true;
  const auto recording = io::openRecording(bags, options);
  ASSERT_EQ(recording->cameras().size(), 2u);
  EXPECT_EQ(recording->cameras()[1].name, "back");
  EXPECT_TRUE(warns(*recording, "does not say where camera 'front' stands"));
  EXPECT_EQ(recording->frameCount(), 2u);
}

TEST_F(RosBag, TheSameTreeOfTwoBagsIsNotOneWorld) {
  fs::copy_file(bag("rig.bag"), path("a.bag"));
  fs::copy_file(bag("rig.bag"), path("b.bag"));
  EXPECT_TRUE(refuses(
      [&] {
        io::openRecording({path("a.bag"), path("b.bag")});
      },
      {"does not say where camera 'a_left' stands"}));
}

TEST_F(RosBag, WithoutColour) {
  io::RecordingOptions options;
  options.read_color = false;
  const auto recording = open("rig.bag", options);
  EXPECT_FALSE(recording->cameras()[0].color);
  io::LoadedFrame frame;
  recording->read(0, frame);
  EXPECT_FALSE(frame.rig.views[0].color);
}

TEST_F(RosBag, ChosenViews) {
  io::RecordingOptions options;
  options.views = "1";
  const auto recording = open("rig.bag", options);
  ASSERT_EQ(recording->cameras().size(), 1u);
  EXPECT_EQ(recording->cameras()[0].name, "right");
  io::LoadedFrame frame;
  recording->read(2, frame);
  expectDepth(frame.images[0].depth16, 1, 2);
}

TEST_F(RosBag, WhatIsNoRecordingIsRefusedInALine) {
  EXPECT_TRUE(refuses([&] { open("text.bag"); }, {"text.bag: has no images of a depth camera", "std_msgs/String"}));
  EXPECT_TRUE(refuses([&] { open("killed.bag"); }, {"killed.bag: was not closed", "rosbag reindex"}));
  write("no.bag", "#ROSBAG V2.0\n nothing behind it");
  EXPECT_TRUE(refuses([&] { io::openRecording({path("no.bag")}); }, {"no.bag"}));
  write("empty.bag", "");
  EXPECT_TRUE(refuses([&] { io::openRecording({path("empty.bag")}); }, {"empty.bag"}));
  io::RecordingOptions slide;
  slide.slide = 1;
  EXPECT_TRUE(refuses<io::OptionError>([&] { open("rig.bag", slide); }, {"--slide"}));
}

TEST_F(RosBag, ABagWhoseBytesAreDamagedIsReadUpToThereOrRefused) {
  std::ifstream file(bag("rig_lz4.bag"), std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(file)), {});
  for (std::size_t at = 4200; at < whole.size(); at += whole.size() / 60) {
    std::string damaged = whole;
    for (std::size_t k = at; k < std::min(at + 40, whole.size()); ++k)
      damaged[k] = static_cast<char>(damaged[k] ^ 0x5a);
    write("damaged.bag", damaged);
    try {
      const auto recording = io::openRecording({path("damaged.bag")});
      io::LoadedFrame frame;
      for (const std::size_t k : recording->frames()) recording->read(k, frame);
    } catch (const io::InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
}

/** \brief The bytes of a bag with another record of its header, whose padding keeps the rest in its place. */
std::string withHeaderField(std::string bag, const std::string& name, const std::string& value) {
  constexpr std::size_t begin = 13;  // behind "#ROSBAG V2.0\n"
  std::uint32_t header = 0, padding = 0;
  std::memcpy(&header, bag.data() + begin, 4);
  std::memcpy(&padding, bag.data() + begin + 4 + header, 4);
  const std::string field = name + "=" + value;
  const std::string added = rawBytes(static_cast<std::uint32_t>(field.size())) + field;
  std::string fields = bag.substr(begin + 4, header);
  if (const std::size_t old = fields.find(name + "="); old != std::string::npos)
    fields.replace(old, field.size(), field);  // of the same length
  else
    fields += added;
  const std::size_t end = begin + 8 + header + padding;
  const auto left = static_cast<std::uint32_t>(end - begin - 8 - fields.size());
  return bag.substr(0, begin) + rawBytes(static_cast<std::uint32_t>(fields.size())) + fields + rawBytes(left) +
         std::string(left, ' ') + bag.substr(end);
}

TEST_F(RosBag, ChunksThatAreMissingAreSaid) {
  const std::string whole = io::readFile(bag("rig.bag"));
  const std::string file = write("more.bag", withHeaderField(whole, "chunk_count", rawBytes(std::uint32_t{77})));
  EXPECT_TRUE(refuses([&] { io::openRecording({file}); }, {file, "chunks", "77", "cut short"}));
}

TEST_F(RosBag, AnEncryptedOneIsRefused) {
  const std::string whole = io::readFile(bag("rig.bag"));
  const std::string plain = write("plain.bag", withHeaderField(whole, "encryptor", ""));  // as rosbag 1.15 writes
  EXPECT_EQ(io::openRecording({plain})->frameCount(), 3u);
  const std::string file = write("secret.bag", withHeaderField(whole, "encryptor", "rosbag/AesCbcEncryptor"));
  EXPECT_TRUE(refuses([&] { io::openRecording({file}); }, {file, "encrypted", "rosbag/AesCbcEncryptor"}));
}

}  // namespace
