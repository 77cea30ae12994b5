#include "mesh_checks.h"

#include "evaluation/truth.h"
#include "recordings/files/file_io.h"
#include "simulation/simulator.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace {

using namespace fuse_flow::simulation;
using fuse_flow::io::LoadedFrame;
using mesh_checks::Vector3f;
namespace fs = std::filesystem;

SimulationOptions smallRig(const std::string& scene = "table", const std::string& sensor = "ideal") {
  SimulationOptions options;
  options.scene = scene;
  options.sensor = sensor;
  options.scale = 0.1;
  options.threads = 1;  // so little work is slower shared out
  return options;
}

bool same(const LoadedFrame& a, const LoadedFrame& b) {
  bool equal = a.images.size() == b.images.size();
  for (std::size_t k = 0; equal && k < a.images.size(); ++k) {
    equal = a.images[k].depth16.data == b.images[k].depth16.data &&
            a.images[k].color.data.size() == b.images[k].color.data.size();
    for (std::size_t i = 0; equal && i < a.images[k].color.data.size(); ++i) {
      const fuse_flow::Rgb8 &p = a.images[k].color.data[i], &q = b.images[k].color.data[i];
      equal = p.r == q.r && p.g == q.g && p.b == q.b;
    }
  }
  return equal;
}

LoadedFrame measured(const SimulationOptions& options, std::size_t frame = 0) {
  Simulator simulator(options);
  LoadedFrame out;
  simulator.measure(frame, out);
  return out;
}

TEST(Simulator, GivesTheSameFramesForTheSameSeedInAnyOrder) {
  for (const std::string sensor : {"structured_light", "time_of_flight", "active_stereo"}) {
    SimulationOptions options = smallRig("person", sensor);
    Simulator forwards(options);
    options.threads = 3;
    Simulator backwards(options);
    LoadedFrame a0, a5, b0, b5;
    forwards.measure(0, a0);
    forwards.measure(5, a5);
    backwards.measure(5, b5);
    backwards.measure(0, b0);
    EXPECT_TRUE(same(a0, b0)) << sensor;
    EXPECT_TRUE(same(a5, b5)) << sensor;
    EXPECT_FALSE(same(a0, a5)) << sensor;
    options.seed = 2;
    EXPECT_FALSE(same(a0, measured(options))) << sensor;
  }
}

TEST(Simulator, IdealDepthIsThatOfTheTrueSurface) {
  Simulator simulator(smallRig("table"));
  LoadedFrame frame;
  simulator.measure(0, frame);
  const RayScene& truth = simulator.truth(0);
  for (std::size_t k = 0; k < frame.images.size(); ++k) {
    const fuse_flow::Intrinsics& K = simulator.cameras()[k].intrinsics;
    for (int v = 0; v < K.height; v += 7)
      for (int u = 0; u < K.width; u += 7) {
        const std::uint16_t depth = frame.images[k].depth16.at(u, v);
        if (depth == 0) continue;
        const double z = 1e-4 * depth;
        const Eigen::Vector3d p((u - static_cast<double>(K.cx)) / static_cast<double>(K.fx) * z,
                                (v - static_cast<double>(K.cy)) / static_cast<double>(K.fy) * z, z);
        const Eigen::Vector3d p_W = simulator.trueCameras()[k].T_world_camera * p;
        ASSERT_LT(truth.nearest(p_W.cast<float>()).t, 1.2e-4f) << k << ' ' << u << ' ' << v;
      }
  }
}

/** \brief Distances of what the true cameras measured to the true surface, metres, sorted. */
std::vector<float> surfaceDistances(const SimulationOptions& options) {
  Simulator simulator(options);
  LoadedFrame frame;
  simulator.measure(0, frame);
  const RayScene& truth = simulator.truth(0);
  std::vector<float> distances;
  for (std::size_t k = 0; k < frame.images.size(); ++k) {
    const fuse_flow::Camera& camera = simulator.trueCameras()[k];
    const fuse_flow::io::DepthImage& depth = frame.images[k].depth16;
    for (int v = 0; v < depth.height; ++v)
      for (int u = 0; u < depth.width; ++u) {
        if (depth.at(u, v) == 0) continue;
        const fuse_flow::Ray ray =
            fuse_flow::unproject(camera.intrinsics, {static_cast<float>(u), static_cast<float>(v)});
        const Vector3f p =
            static_cast<float>(depth.at(u, v)) * frame.rig.cameras[k].depth_scale * Vector3f(ray.x, ray.y, 1);
        distances.push_back(truth.nearest(camera.T_world_camera.cast<float>() * p).t);
      }
  }
  std::sort(distances.begin(), distances.end());
  return distances;
}

TEST(Simulator, ARigSaysThatItsLampsLightHasMultipath) {
  for (const char* sensor : {"time_of_flight_multipath", "time_of_flight", "structured_light"}) {
    const bool multipath = std::string(sensor) == "time_of_flight_multipath";
    const Simulator simulator(smallRig("table", sensor));
    for (const fuse_flow::Camera& camera : simulator.cameras())
      EXPECT_EQ(camera.multipath.modulation_frequency, multipath ? 200e6f : 0.0f) << sensor;
    EXPECT_EQ(simulator.rig().cameras[0].camera.multipath.modulation_frequency, multipath ? 200e6f : 0.0f) << sensor;
  }
}

TEST(Simulator, StructuredLightHasItsNoiseHolesAndAFewFlyingPixels) {
  SimulationOptions options = smallRig();
  options.scale = 0.25;
  const std::vector<float> ideal = surfaceDistances(options);
  options.sensor = "structured_light";
  const std::vector<float> measured = surfaceDistances(options);
  EXPECT_LT(measured.size(), ideal.size());
  EXPECT_GT(measured.size(), ideal.size() / 2);
  EXPECT_LT(measured[measured.size() / 2], 0.01f);
  EXPECT_LT(measured[measured.size() * 9 / 10], 0.04f);
  EXPECT_GT(measured.back(), 0.05f) << "between two surfaces";
}

TEST(Simulator, PoseErrorsHaveTheStatedSize) {
  SimulationOptions options = smallRig();
  options.rig = "ring-6";
  options.faults.position_error = 0.012;
  options.faults.rotation_error = 0.02;
  const Simulator simulator(options);
  for (std::size_t k = 0; k < 6; ++k) {
    const Eigen::Isometry3d &a = simulator.trueCameras()[k].T_world_camera, &b = simulator.cameras()[k].T_world_camera;
    EXPECT_NEAR((a.translation() - b.translation()).norm(), 0.012, 1e-9);
    EXPECT_NEAR(Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle(), 0.02, 1e-7);
  }
  SimulationOptions another = options;
  another.seed = 2;
  EXPECT_FALSE(Simulator(another).cameras()[0].T_world_camera.isApprox(simulator.cameras()[0].T_world_camera));
  SimulationOptions exact = options;
  exact.faults = {};
  EXPECT_TRUE(same(measured(options), measured(exact))) << "what is measured comes from the true places";
}

TEST(Simulator, BiasIsAConstantOfEachCamera) {
  SimulationOptions options = smallRig();
  const LoadedFrame clean = measured(options);
  options.faults.depth_bias = 0.02;
  const LoadedFrame biased = measured(options);
  std::set<int> biases;
  for (std::size_t k = 0; k < clean.images.size(); ++k) {
    int least = 1 << 20, most = -(1 << 20);
    for (std::size_t i = 0; i < clean.images[k].depth16.data.size(); ++i) {
      if (clean.images[k].depth16.data[i] == 0) continue;
      const int difference = biased.images[k].depth16.data[i] - clean.images[k].depth16.data[i];
      least = std::min(least, difference);
      most = std::max(most, difference);
    }
    EXPECT_LE(most - least, 1) << "rounding";
    EXPECT_LE(std::abs(most), 200);  // 0.1 mm each
    biases.insert(most);
  }
  EXPECT_GE(biases.size(), 3u) << "each has its own";
}

TEST(Simulator, DistortedDepthIsPutRightByTheTrueCorrections) {
  SimulationOptions options = smallRig();
  const LoadedFrame clean = measured(options);
  options.faults.depth_distortion = 0.03;
  const LoadedFrame distorted = measured(options);
  const Simulator simulator(options);
  for (std::size_t k = 0; k < clean.images.size(); ++k) {
    EXPECT_TRUE(simulator.cameras()[k].depth_correction.empty()) << "nobody knows";
    const fuse_flow::DepthCorrection& correction = simulator.trueCameras()[k].depth_correction;
    const fuse_flow::io::DepthImage &right = clean.images[k].depth16, &wrong = distorted.images[k].depth16;
    const float scale = distorted.rig.cameras[k].depth_scale;
    int most = 0;
    for (int v = 0; v < right.height; ++v)
      for (int u = 0; u < right.width; ++u) {
        if (right.at(u, v) == 0) continue;
        most = std::max(most, std::abs(wrong.at(u, v) - right.at(u, v)));
        const float z = fuse_flow::correctedDepth(scale * static_cast<float>(wrong.at(u, v)),
                                                  correction.at(u, v, right.width, right.height));
        ASSERT_NEAR(z, scale * static_cast<float>(right.at(u, v)), 1.2f * scale) << k << ": " << u << ", " << v;
      }
    EXPECT_GT(static_cast<float>(most) * scale, 0.003f);
    EXPECT_TRUE(k == 0 || simulator.trueCameras()[0].depth_correction != correction) << "each has its own";
  }
}

TEST(Simulator, LosesTheStatedShareOfFrames) {
  SimulationOptions options = smallRig();
  options.color = false;
  options.scale = 0.02;
  options.scene = "room";
  options.faults.drop_rate = 0.25;
  Simulator simulator(options);
  LoadedFrame frame;
  int lost = 0;
  for (std::size_t k = 0; k < 100; ++k) {
    simulator.measure(k, frame);
    for (const auto& view : frame.rig.views) lost += view.missing() ? 1 : 0;
  }
  EXPECT_NEAR(lost, 100, 30);  // of 400; standard deviation 8.7
  options.faults.drop_rate = 1;
  for (const auto& view : measured(options).rig.views) EXPECT_TRUE(view.missing());
}

TEST(Simulator, CamerasOutOfSyncSeeWhatMovesElsewhereAndTheRestWhereItIs) {
  SimulationOptions options = smallRig("person");
  options.color = false;
  const LoadedFrame in_sync = measured(options, 10);
  options.faults.out_of_sync = 0.2;
  const LoadedFrame late = measured(options, 10);
  for (std::size_t k = 0; k < in_sync.images.size(); ++k) {
    std::size_t changed = 0;
    const auto &a = in_sync.images[k].depth16.data, &b = late.images[k].depth16.data;
    for (std::size_t i = 0; i < a.size(); ++i) changed += a[i] != b[i] ? 1 : 0;
    EXPECT_GT(changed, 5u) << k;
    EXPECT_LT(changed, a.size() / 2) << k;
  }
  SimulationOptions still = smallRig("table");
  const LoadedFrame before = measured(still, 10);
  still.faults.out_of_sync = 0.2;
  EXPECT_TRUE(same(before, measured(still, 10)));
}

TEST(Simulator, CamerasOutOfStepExposeOneAfterTheOther) {
  SimulationOptions options = smallRig("person");
  options.color = false;
  options.rig = "ring-5";
  options.faults.out_of_step = 0.2;
  Simulator simulator(options);
  for (std::size_t k = 0; k < 5; ++k)
    EXPECT_NEAR(simulator.exposureDelay(k), -0.1 + 0.05 * static_cast<double>(k), 1e-12);
  LoadedFrame frame;
  simulator.measure(3, frame);  // at 0.1 s: the last camera at 0.2 s
  options.faults.out_of_step = 0;
  const LoadedFrame in_step = measured(options, 3), next = measured(options, 6);
  const auto depth = [](const LoadedFrame& of, std::size_t k) { return of.images[k].depth16.data; };
  EXPECT_TRUE(depth(frame, 2) == depth(in_step, 2)) << "the middle one's is the nominal time";
  EXPECT_TRUE(depth(frame, 4) == depth(next, 4));
  EXPECT_FALSE(depth(frame, 4) == depth(in_step, 4));
  EXPECT_EQ(frame.rig.stamp, 100000u);
}

TEST(Simulator, RefusesNumbersOutOfRange) {
  const auto refusal = [](const auto& spoil) -> std::string {
    SimulationOptions options = smallRig();
    spoil(options);
    try {
      Simulator simulator(options);
    } catch (const fuse_flow::io::InputError& error) {
      return error.what();
    }
    return "none";
  };
  const auto names = [](const std::string& message, const std::string& part) {
    return message.find(part) != std::string::npos ? testing::AssertionSuccess()
                                                   : testing::AssertionFailure() << message;
  };
  EXPECT_TRUE(names(refusal([](SimulationOptions& o) { o.scene = "moon"; }), "moon"));
  EXPECT_TRUE(names(refusal([](SimulationOptions& o) { o.rig = "pile-3"; }), "pile-3"));
  EXPECT_TRUE(names(refusal([](SimulationOptions& o) { o.sensor = "sonar"; }), "sonar"));
  EXPECT_TRUE(names(refusal([](SimulationOptions& o) { o.frames_per_second = 0; }), "frames per second is 0"));
  EXPECT_TRUE(names(refusal([](SimulationOptions& o) { o.faults.drop_rate = 1.1; }), "drop rate is 1.1"));
  EXPECT_TRUE(
      names(refusal([](SimulationOptions& o) { o.faults.position_error = -1; }), "position error in metres is -1"));
  EXPECT_TRUE(names(refusal([](SimulationOptions& o) { o.faults.rotation_error = std::nan(""); }), "rotation error"));
  EXPECT_TRUE(names(refusal([](SimulationOptions& o) { o.scale = 0; }), "scale"));
  EXPECT_TRUE(
      names(refusal([](SimulationOptions& o) { o.faults.out_of_step = 2; }), "time out of step in seconds is 2"));
  EXPECT_TRUE(
      names(refusal([](SimulationOptions& o) { o.faults.readout_time = -1; }), "readout time in seconds is -1"));
  EXPECT_TRUE(
      names(refusal([](SimulationOptions& o) { o.faults.exposure_time = 1; }), "exposure time in seconds is 1"));
  EXPECT_TRUE(
      names(refusal([](SimulationOptions& o) { o.faults.image.noise = 101; }), "image noise in grey levels is 101"));
  EXPECT_TRUE(names(refusal([](SimulationOptions& o) { o.faults.image.exposure = 1; }), "spread of the exposure is 1"));
  EXPECT_TRUE(names(refusal([](SimulationOptions& o) { o.faults.image.vignetting = -1; }), "vignetting is -1"));
}

/** \brief A folder that is gone when the test is over. */
class TruthFiles : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / (std::string("fuse_flow_truth_") + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(TruthFiles, GiveBackTheSameSurfacesMaterialsAndPoses) {
  SimulationOptions options = smallRig("person", "structured_light");
  options.faults.position_error = 0.01;
  Simulator simulator(options);
  writeTruth(folder_.string(), simulator);
  for (const std::size_t frame : {0, 7}) writeTruth(folder_.string(), simulator, frame);
  Truth truth(folder_.string());
  EXPECT_FLOAT_EQ(truth.minRange(), simulator.sensor().minRange());
  EXPECT_FLOAT_EQ(truth.maxRange(), simulator.sensor().maxRange());
  ASSERT_EQ(truth.cameras().size(), simulator.trueCameras().size());
  for (std::size_t k = 0; k < truth.cameras().size(); ++k)
    EXPECT_TRUE(truth.cameras()[k].T_world_camera.isApprox(simulator.trueCameras()[k].T_world_camera, 1e-9));
  for (const std::size_t frame : {7, 0}) {
    const RayScene &read = truth.frame(frame), &made = simulator.truth(frame);
    ASSERT_EQ(read.objectCount(), made.objectCount());
    for (int k = 0; k < 300; ++k) {
      const Vector3f p(0.015f * static_cast<float>(k) - 2.2f, 0.0037f * static_cast<float>(k) - 0.6f,
                       0.006f * static_cast<float>(k));
      const RayHit a = read.nearest(p), b = made.nearest(p);
      ASSERT_NEAR(a.t, b.t, 1e-6f);
      if ((a.position - b.position).norm() > 1e-5f) continue;  // as near on another surface
      EXPECT_EQ(read.object(a.object).material.first.r, made.object(a.object).material.first.r);
      EXPECT_EQ(read.object(a.object).name, made.object(a.object).name);
      EXPECT_LT((a.rest - b.rest).norm(), 1e-4f);
      EXPECT_EQ(read.moving(a.object), made.moving(a.object));
      const Object& object = made.object(b.object);
      EXPECT_EQ(read.object(a.object).part, object.part.empty() ? object.name : object.part);
    }
  }
}

/** \brief From one frame to the next, a hundredth of a second later, a surface has gone as far as its velocity says. */
TEST_F(TruthFiles, SayHowFastASurfaceMoves) {
  SimulationOptions options = smallRig("person");
  options.frames_per_second = 100;
  const Simulator simulator(options);
  writeTruth(folder_.string(), simulator);
  writeTruth(folder_.string(), simulator, 30);
  Truth truth(folder_.string());
  EXPECT_TRUE(truth.namesParts());
  const RayScene& read = truth.frame(30);
  const std::vector<Object> before = simulator.movingObjects(29), after = simulator.movingObjects(31);
  float fastest = 0;
  for (std::uint32_t k = 0; k < read.objectCount(); ++k) {
    if (!read.moving(k)) {
      EXPECT_TRUE(read.object(k).mesh.velocities.empty()) << read.object(k).name;
      continue;
    }
    const std::size_t number = k - simulator.fixedObjects().size();
    const std::vector<Vector3f>& velocities = read.object(k).mesh.velocities;
    ASSERT_EQ(velocities.size(), before[number].mesh.vertices.size());
    for (std::size_t i = 0; i < velocities.size(); i += 7) {
      const Vector3f mean = (after[number].mesh.vertices[i] - before[number].mesh.vertices[i]) / 0.02f;
      ASSERT_LT((velocities[i] - mean).norm(), 0.03f) << read.object(k).name;
      fastest = std::max(fastest, velocities[i].norm());
    }
  }
  EXPECT_GT(fastest, 1.5f) << "the swinging foot";
}

TEST_F(TruthFiles, OfVersion01NameNoPartsAndAreRead) {
  writeTruth(folder_.string(), Simulator(smallRig("table")));
  const std::string json = (folder_ / "truth" / "simulation.json").string();
  std::string described = fuse_flow::io::readFile(json);
  for (std::size_t at = 0; (at = described.find("\"part\": ", at)) != std::string::npos;)
    described.erase(at, described.find('\n', at) - at);
  fuse_flow::io::writeFile(json, described);
  Truth truth(folder_.string());
  EXPECT_FALSE(truth.namesParts());
  EXPECT_GT(truth.frame(0).objectCount(), 10u);
}

TEST_F(TruthFiles, ThatAreMissingOrDamagedAreRefused) {
  EXPECT_THROW(Truth(folder_.string()), fuse_flow::io::InputError);
  writeTruth(folder_.string(), Simulator(smallRig("table")));
  EXPECT_NO_THROW(Truth(folder_.string()));
  const std::string mesh = (folder_ / "truth" / "fixed.ply").string(),
                    json = (folder_ / "truth" / "simulation.json").string();
  const std::string whole = fuse_flow::io::readFile(mesh), described = fuse_flow::io::readFile(json);
  for (const std::uint32_t corner : {0u, 1000000000u, 0xffffffffu}) {  // of another object, of none, of none
    std::string damaged = whole;
    std::memcpy(&damaged[damaged.size() - sizeof corner], &corner, sizeof corner);
    fuse_flow::io::writeFile(mesh, damaged);
    EXPECT_THROW(Truth(folder_.string()), fuse_flow::io::InputError) << corner;
  }
  fuse_flow::io::writeFile(mesh, whole);
  std::string unknown = described;
  unknown.replace(unknown.find("\"plain\""), 7, "\"plaid\"");
  fuse_flow::io::writeFile(json, unknown);
  EXPECT_THROW(Truth(folder_.string()), fuse_flow::io::InputError);
  fuse_flow::io::writeFile(json, described);
  EXPECT_NO_THROW(Truth(folder_.string()));
  fs::resize_file(json, 100);
  EXPECT_THROW(Truth(folder_.string()), fuse_flow::io::InputError);
}

}  // namespace
