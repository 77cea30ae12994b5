#include "io/demo_scene.h"

#include "io/demo_sensor.h"
#include "io/file_io.h"
#include "io/recording.h"
#include "io_fixture.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace {

using namespace io_test;

class Demo : public IoTest {};

io::DemoOptions smallDemo() {
  io::DemoOptions options;
  options.frames = 2;
  options.width = 80;
  options.height = 60;
  return options;
}

bool sameDepth(const io::DemoRecording& a, const io::DemoRecording& b, std::size_t frame) {
  for (std::size_t camera = 0; camera < a.depth[frame].size(); ++camera)
    if (a.depth[frame][camera].data != b.depth[frame][camera].data) return false;
  return true;
}

bool samePoses(const io::DemoRecording& a, const io::DemoRecording& b) {
  return std::equal(a.cameras.begin(), a.cameras.end(), b.cameras.begin(), [](const Camera& x, const Camera& y) {
    return x.T_world_camera.matrix() == y.T_world_camera.matrix();
  });
}

TEST(PortableRandom, DrawsTheNumbersThatTheStandardSpecifies) {
  // Computed with another implementation of the standard's seed_seq and mt19937.
  io::PortableRandom random(1, 2, 3);
  for (const std::uint32_t draw : {0x65f9fc3bu, 0x29f2d8bcu, 0x2580a78cu, 0xe6b42d25u})
    EXPECT_EQ(random.uniform() * 0x1p32, draw);
}

TEST(PortableRandom, GaussianNumbersHaveMeanZeroAndVarianceOne) {
  io::PortableRandom random(1, 0, 0);
  constexpr int n = 100000;
  double sum = 0, squares = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.gaussian();
    ASSERT_LE(std::abs(x), 6);
    sum += x;
    squares += x * x;
  }
  EXPECT_NEAR(sum / n, 0, 0.02);
  EXPECT_NEAR(squares / n, 1, 0.02);
}

TEST_F(Demo, TheSameSeedGivesTheSameBytes) {
  io::writeDemoRecording(path("a"), io::makeDemoRecording(smallDemo()));
  io::writeDemoRecording(path("b"), io::makeDemoRecording(smallDemo()));
  std::size_t files = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder_ / "a")) {
    if (!entry.is_regular_file()) continue;
    const fs::path other = folder_ / "b" / entry.path().lexically_relative(folder_ / "a");
    EXPECT_EQ(io::readFile(entry.path().string()), io::readFile(other.string())) << entry.path();
    ++files;
  }
  EXPECT_EQ(files, 1u + 2 * 2 * 4);  // rig.json; depth and colour of two frames of four cameras
}

TEST_F(Demo, AnotherSeedGivesOtherNoiseAndOtherPoses) {
  io::DemoOptions options = smallDemo();
  const io::DemoRecording one = io::makeDemoRecording(options);
  options.seed = 2;
  const io::DemoRecording two = io::makeDemoRecording(options);
  EXPECT_FALSE(sameDepth(one, two, 0));
  EXPECT_FALSE(samePoses(one, two));
}

TEST_F(Demo, MoreFramesDoNotChangeTheFirst) {
  io::DemoOptions options = smallDemo();
  const io::DemoRecording two = io::makeDemoRecording(options);
  options.frames = 3;
  const io::DemoRecording three = io::makeDemoRecording(options);
  EXPECT_TRUE(samePoses(two, three));
  EXPECT_TRUE(sameDepth(two, three, 0));
  EXPECT_TRUE(sameDepth(two, three, 1));
}

TEST_F(Demo, SomethingMoves) {
  io::DemoOptions options = smallDemo();
  options.sensor_noise = false;
  const io::DemoRecording demo = io::makeDemoRecording(options);
  EXPECT_NE(demo.depth[0][0].data, demo.depth[1][0].data);
}

/** \brief Distances of all measured points to the true surface, metres, sorted. */
std::vector<double> surfaceDistances(const io::DemoRecording& demo, const std::vector<Camera>& cameras) {
  std::vector<double> distances;
  for (std::size_t frame = 0; frame < demo.depth.size(); ++frame)
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      const io::DepthImage& depth = demo.depth[frame][c];
      const Intrinsics& K = cameras[c].intrinsics;
      for (int v = 0; v < depth.height; ++v)
        for (int u = 0; u < depth.width; ++u) {
          const double z = depth.at(u, v) * static_cast<double>(demo.depth_scale);
          if (z == 0) continue;
          const Eigen::Vector3d p_C((u - K.cx) / K.fx * z, (v - K.cy) / K.fy * z, z);
          distances.push_back(io::demoSurfaceDistance(cameras[c].T_world_camera * p_C, frame));
        }
    }
  std::sort(distances.begin(), distances.end());
  return distances;
}

TEST_F(Demo, WithoutNoiseEveryPointLiesOnASurface) {
  io::DemoOptions options = smallDemo();
  options.sensor_noise = false;
  options.pose_noise = options.pose_noise_deg = 0;
  const io::DemoRecording demo = io::makeDemoRecording(options);
  const std::vector<double> distances = surfaceDistances(demo, demo.cameras);
  ASSERT_GT(distances.size(), 80u * 60 * 4);  // more than half of the pixels of both frames
  EXPECT_LT(distances.back(), 0.001);         // depth is rounded to a millimetre
}

TEST_F(Demo, NoiseIsThatOfTheSensorWithAFewFlyingPixelsAndHoles) {
  const io::DemoRecording demo = io::makeDemoRecording(smallDemo());
  const std::vector<double> distances = surfaceDistances(demo, demo.true_cameras);
  EXPECT_LT(distances[distances.size() / 2], 0.01);
  EXPECT_GT(distances.back(), 0.05);
  io::DemoOptions options = smallDemo();
  options.sensor_noise = false;
  EXPECT_LT(distances.size(), surfaceDistances(io::makeDemoRecording(options), demo.true_cameras).size());
}

TEST_F(Demo, CalibratedPosesAreOffByTheirNoise) {
  io::DemoOptions options = smallDemo();
  options.pose_noise = 0.01;
  options.pose_noise_deg = 1;
  const io::DemoRecording demo = io::makeDemoRecording(options);
  for (std::size_t c = 0; c < demo.cameras.size(); ++c) {
    const Eigen::Isometry3d error = demo.true_cameras[c].T_world_camera.inverse() * demo.cameras[c].T_world_camera;
    EXPECT_GT(error.translation().norm(), 0) << c;
    EXPECT_LT(error.translation().norm(), 0.06) << c;
    EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), 0.1) << c;
  }
}

TEST_F(Demo, ReadsBackAsARecording) {
  const io::DemoRecording demo = io::makeDemoRecording(smallDemo());
  io::writeDemoRecording(path("demo"), demo);
  io::LoadedFrame frame;
  io::openRecording({path("demo")})->read(1, frame);
  ASSERT_EQ(frame.rig.cameras.size(), demo.cameras.size());
  for (std::size_t c = 0; c < demo.cameras.size(); ++c) {
    EXPECT_EQ(frame.rig.cameras[c].T_world_camera.matrix(), demo.cameras[c].T_world_camera.matrix());
    EXPECT_EQ(frame.images[c].depth16.data, demo.depth[1][c].data);
    EXPECT_EQ(frame.images[c].color.at(79, 59).g, demo.color[1][c].at(79, 59).g);
  }
}

TEST_F(Demo, OptionsOutOfRangeAreNamed) {
  const auto isRefused = [](const std::function<void(io::DemoOptions&)>& change, const std::string& word) {
    io::DemoOptions options = smallDemo();
    change(options);
    return refuses([&] { io::makeDemoRecording(options); }, {"demo recording", word});
  };
  EXPECT_TRUE(isRefused([](io::DemoOptions& o) { o.frames = 0; }, "frames is 0"));
  EXPECT_TRUE(isRefused([](io::DemoOptions& o) { o.frames = 101; }, "frames is 101"));
  EXPECT_TRUE(isRefused([](io::DemoOptions& o) { o.width = 15; }, "15x60"));
  EXPECT_TRUE(isRefused([](io::DemoOptions& o) { o.height = 4097; }, "80x4097"));
  EXPECT_TRUE(isRefused([](io::DemoOptions& o) { o.pose_noise = -0.1; }, "pose noise"));
  EXPECT_TRUE(isRefused([](io::DemoOptions& o) { o.pose_noise = std::nan(""); }, "pose noise"));
  EXPECT_TRUE(isRefused([](io::DemoOptions& o) { o.pose_noise_deg = 46; }, "degrees"));
}

TEST_F(Demo, AFolderThatCannotBeMadeIsNamed) {
  write("file", "");
  EXPECT_TRUE(refuses<io::OutputError>(
      [&] { io::writeDemoRecording(path("file/demo"), io::makeDemoRecording(smallDemo())); }, {path("file/demo")}));
}

}  // namespace
