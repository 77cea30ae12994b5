#include "../../refusal.h"
#include "../../test_length.h"
#include "pose_comparison.h"

#include <fuse_flow/gpu/calibration/extrinsic_tracking.h>

namespace {

using namespace pose_comparison;
using furnished_rig::FurnishedRig;
using furnished_rig::Options;
using furnished_rig::Random;
using refusal::messageOf;

TEST(GpuExtrinsics, OfRandomRigsAreTheHosts) {
  Random random(71);
  HostPoses host;
  DevicePoses device;
  for (int trial = 0; trial < 10; ++trial) {
    SCOPED_TRACE(trial);
    Options options;
    options.cameras = 2 + random.below(4);
    options.width = 120 + random.below(60);
    options.height = 90 + random.below(50);
    options.integers = trial % 2 == 0;
    options.color = trial % 3 != 0;
    options.distortion = trial % 4 == 3;
    FurnishedRig frame(random, options);
    if (trial % 3 == 1) frame.giveNoise();
    if (trial == 4) frame.rig.views[1] = {};
    ExtrinsicParameters parameters;
    parameters.samples = 500 + random.below(3000);
    parameters.max_iterations = 3 + random.below(40);
    if (random.oneIn(3)) parameters.gauge = fuse_flow::Gauge::Mean;
    expectSamePoses(frame.rig, frame.disturbed(random), parameters, host, device);
  }
}

TEST(GpuExtrinsics, CamerasSomeCentimetresOffComeBack) {
  Random random(72);
  Options options;
  options.cameras = 3;
  options.noise = 0.0005;
  const FurnishedRig frame(random, options);
  DevicePoses device;
  device.addFrame(frame.rig);
  const ExtrinsicResult result = device.estimate(frame.disturbed(random));
  const Poses truth = frame.poses();
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_LT(apart(result.T_world_camera[i], truth[i]), 0.003) << i;
    EXPECT_LT(turned(result.T_world_camera[i], truth[i]), 0.002) << i;
  }
  EXPECT_LT(result.residual, 0.7 * result.residual_before);
}

TEST(GpuExtrinsics, TwoInstantsAreTheHosts) {
  Random random(73);
  FurnishedRig frame(random, {});
  const Poses initial = frame.disturbed(random);
  HostPoses host;
  DevicePoses device;
  for (int t = 0; t < 2; ++t) {
    frame.measure(random);
    if (t == 1) frame.rig.views[2] = {};
    host.addFrame(frame.rig);
    device.addFrame(frame.rig);
  }
  expectSamePoses(host.estimate(initial), device.estimate(initial));
  expectSamePoses(host.estimate(frame.poses()), device.estimate(frame.poses()));
}

TEST(GpuExtrinsics, APlaneAloneIsLeftOpenAsOnTheHost) {
  Random random(74);
  Options options;
  options.plane_only = true;
  options.cameras = 2;
  options.color = false;
  const FurnishedRig frame(random, options);
  HostPoses host;
  DevicePoses device;
  expectSamePoses(frame.rig, frame.disturbed(random), {}, host, device);
  const ExtrinsicResult result = device.estimate(frame.poses());
  EXPECT_FALSE(result.corrections[1].constrained);
  EXPECT_EQ(result.corrections[1].free_directions.size(), 3u) << "two slides and a turn";
}

TEST(GpuExtrinsics, ColourTellsWhatAPlaneDoesNot) {
  Random random(75);
  Options options;
  options.plane_only = true;
  options.cameras = 2;
  const FurnishedRig frame(random, options);
  Poses initial = frame.poses();
  initial[1].pretranslate(Eigen::Vector3d(0.02, 0, 0.01));  // along the wall
  HostPoses host;
  DevicePoses device;
  expectSamePoses(frame.rig, initial, {}, host, device);
  EXPECT_LT(apart(device.estimate(initial).T_world_camera[1], frame.poses()[1]), 0.005);
}

TEST(GpuExtrinsics, OneCameraAloneStays) {
  Random random(76);
  Options options;
  options.cameras = 1;
  const FurnishedRig frame(random, options);
  HostPoses host;
  DevicePoses device;
  expectSamePoses(frame.rig, frame.poses(), {}, host, device);
  EXPECT_EQ(device.estimate().T_world_camera[0].matrix(), frame.poses()[0].matrix());
}

TEST(GpuExtrinsics, AnEstimateHasTheSameBytesOnEveryRun) {
  Random random(77);
  const FurnishedRig frame(random, {}), other(random, {});
  const Poses initial = frame.disturbed(random);
  DevicePoses device;
  device.addFrame(frame.rig);
  const ExtrinsicResult first = device.estimate(initial);
  for (int k = 0; k < 5; ++k) {
    EXPECT_TRUE(samePoses(device.estimate(initial), first)) << k;
    device.clear();
    device.addFrame(other.rig);
    device.estimate();
    device.clear();
    device.addFrame(frame.rig);
    DevicePoses fresh;
    fresh.addFrame(frame.rig);
    EXPECT_TRUE(samePoses(fresh.estimate(initial), first)) << k;
  }
}

TEST(GpuExtrinsics, CloudsAreTheSameAsDepthImages) {
  Random random(78);
  Options options;
  options.integers = false;
  options.color = false;
  const FurnishedRig frame(random, options);
  std::vector<pcl::PointCloud<pcl::PointXYZ>::ConstPtr> clouds;
  for (const fuse_flow::DepthView& view : frame.rig.views) {
    const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>(160, 120);
    for (std::size_t k = 0; k < cloud->size(); ++k) (*cloud)[k] = {0, 0, view.depth32.data[k]};
    clouds.push_back(cloud);
  }
  DevicePoses of_images, of_clouds;
  of_images.addFrame(frame.rig);
  of_clouds.addClouds(frame.rig.cameras, clouds);
  const Poses initial = frame.disturbed(random);
  EXPECT_TRUE(samePoses(of_images.estimate(initial), of_clouds.estimate(initial)));
}

TEST(GpuExtrinsics, WhatIsWrongIsRefusedInTheHostsWords) {
  Random random(79);
  const FurnishedRig frame(random, {});
  Options fewer;
  fewer.cameras = 2;
  const FurnishedRig other(random, fewer);
  HostPoses host;
  DevicePoses device;
  const auto sameMessage = [&](const auto& action) {
    const std::string message = messageOf<pcl::PCLException>([&] { action(device); });
    EXPECT_EQ(message.substr(0, message.find(" in ")), [&] {
      const std::string expected = messageOf<pcl::PCLException>([&] { action(host); });
      return expected.substr(0, expected.find(" in "));
    }());
  };
  sameMessage([](auto& estimation) { estimation.estimate(); });
  host.addFrame(frame.rig);
  device.addFrame(frame.rig);
  sameMessage([](auto& estimation) { estimation.estimate({Eigen::Isometry3d::Identity()}); });
  Poses stretched = frame.poses();
  stretched[1].linear() *= 1.1;
  sameMessage([&](auto& estimation) { estimation.estimate(stretched); });
  sameMessage([&](auto& estimation) { estimation.addFrame(other.rig); });
  sameMessage([&](auto& estimation) { estimation.addFrame({}); });
  sameMessage([&](auto& estimation) { estimation.addClouds(frame.rig.cameras, {}); });
  for (const auto set : std::vector<void (*)(ExtrinsicParameters&)>{
           [](ExtrinsicParameters& p) { p.reduction = 0; }, [](ExtrinsicParameters& p) { p.samples = 10; },
           [](ExtrinsicParameters& p) { p.max_correspondence_distance = std::nanf(""); },
           [](ExtrinsicParameters& p) { p.noise.floor = -1; }}) {
    ExtrinsicParameters parameters;
    set(parameters);
    sameMessage([&](auto& estimation) { estimation.setParameters(parameters); });
  }
  expectSamePoses(host.estimate(), device.estimate());  // as if nothing had been asked
}

TEST(GpuExtrinsics, HoldNoMoreMemoryOnceWarm) {
  Random random(80);
  Options large, small;
  large.cameras = 5;
  small.cameras = 2;
  small.width = 100;
  FurnishedRig a(random, large), b(random, small);
  DevicePoses device;
  const auto estimate = [&](const FurnishedRig& frame, int instants) {
    device.clear();
    for (int t = 0; t < instants; ++t) device.addFrame(frame.rig);
    device.estimate(frame.disturbed(random));
  };
  for (int k = 0; k < 3; ++k) {
    estimate(a, 2);
    estimate(b, 1);
  }
  const std::size_t bytes = device.getDeviceBytes();
  EXPECT_GT(bytes, 100000u);
#if FUSE_FLOW_CUDA
  std::size_t free_before = 0, free_after = 0, total = 0;
  fuse_flow::gpu::check(cudaMemGetInfo(&free_before, &total), "cudaMemGetInfo");
#endif
  for (int k = 0; k < timesOver(10, 2); ++k) {
    a.measure(random);
    b.measure(random);
    estimate(a, 2);
    estimate(b, 1);
  }
  EXPECT_EQ(device.getDeviceBytes(), bytes);
#if FUSE_FLOW_CUDA
  fuse_flow::gpu::check(cudaMemGetInfo(&free_after, &total), "cudaMemGetInfo");
  if (!shortTests()) {  // compute-sanitizer takes some too
    EXPECT_EQ(free_after, free_before);
  }
#endif
}

TEST(GpuExtrinsics, ImagesInPinnedAndDeviceMemoryAndWithPaddedRowsAreTheSame) {
  Random random(81);
  const FurnishedRig frame(random, {});
  const Poses initial = frame.disturbed(random);
  const std::size_t stride = 400;  // bytes, of rows of 320
  fuse_flow::gpu::PinnedBuffer<char> pinned;
  fuse_flow::gpu::DeviceBuffer<char> on_device;
  std::vector<char> padded(frame.rig.views.size() * 120 * stride, 0x55);
  fuse_flow::RigFrame of_padded = frame.rig, of_pinned = frame.rig, of_device = frame.rig;
  pinned.resize(padded.size());
  on_device.resize(padded.size());
  for (std::size_t i = 0; i < frame.rig.views.size(); ++i) {
    const std::size_t begin = i * 120 * stride;
    for (int v = 0; v < 120; ++v)
      std::memcpy(padded.data() + begin + static_cast<std::size_t>(v) * stride, frame.rig.views[i].depth16.row(v), 320);
    const auto at = [&](const char* memory) {
      return fuse_flow::ImageView<std::uint16_t>(reinterpret_cast<const std::uint16_t*>(memory + begin), 160, 120,
                                                 stride);
    };
    of_padded.views[i].depth16 = at(padded.data());
    of_pinned.views[i].depth16 = at(pinned.data());
    of_device.views[i].depth16 = at(on_device.data());
  }
  std::memcpy(pinned.data(), padded.data(), padded.size());
  fuse_flow::gpu::Execution run;
  run.copy(on_device.data(), std::as_const(pinned).data(), padded.size());
  run.wait();
  DevicePoses device;
  device.addFrame(frame.rig);
  const ExtrinsicResult expected = device.estimate(initial);
  for (const fuse_flow::RigFrame* other : {&of_padded, &of_pinned, &of_device}) {
    device.clear();
    device.addFrame(*other);
    EXPECT_TRUE(samePoses(device.estimate(initial), expected));
  }
}

TEST(GpuExtrinsics, AStreamOfItsOwnChangesNothing) {
  Random random(82);
  const FurnishedRig frame(random, {});
  const Poses initial = frame.disturbed(random);
  const fuse_flow::gpu::OwnStream stream;
  DevicePoses on_default, on_own;
  on_own.setStream(stream.get());
  on_default.addFrame(frame.rig);
  on_own.addFrame(frame.rig);
  EXPECT_TRUE(samePoses(on_own.estimate(initial), on_default.estimate(initial)));
}

TEST(GpuExtrinsics, TrackingOnTheGpuFollowsWhatTheHostsFollows) {
  Random random(83);
  FurnishedRig frame(random, {});
  std::vector<fuse_flow::Camera> cameras = frame.rig.cameras;
  const Poses initial = frame.disturbed(random, 0.01, 0.005);
  for (std::size_t i = 0; i < cameras.size(); ++i) cameras[i].T_world_camera = initial[i];
  fuse_flow::ExtrinsicTracking<pcl::PointXYZ> host(cameras);
  fuse_flow::ExtrinsicTracking<pcl::PointXYZ, fuse_flow::device::Thrust> device(cameras);
  for (int k = 0; k < 4; ++k) {
    frame.measure(random);
    EXPECT_TRUE(host.push(frame.rig));
    EXPECT_TRUE(device.push(frame.rig));
    host.finish();
    device.finish();
    const auto expected = host.poses(), poses = device.poses();
    EXPECT_EQ(poses->updates, expected->updates);
    for (std::size_t i = 0; i < cameras.size(); ++i)
      EXPECT_LT(apart(poses->T_world_camera[i], expected->T_world_camera[i]), 5e-6) << i;
  }
}

// What sorting finds in the middle, of any bits.
TEST(GpuExtrinsics, TheMedianIsTheOneInTheMiddle) {
  Random random(84);
  for (int trial = 0; trial < 20; ++trial) {
    fuse_flow::gpu::DeviceView view;
    view.model.intrinsics.width = 13 + random.below(60);
    view.model.intrinsics.height = 1 + random.below(40);
    view.pitch = 96;
    view.present = true;
    std::vector<fuse_flow::Vec3> normals(96 * 40);
    for (fuse_flow::Vec3& n : normals) {
      const float x = random.oneIn(3) ? 0.0f : random.uniform(-0.2f, 0.2f);
      n = random.oneIn(5) ? fuse_flow::Vec3{} : fuse_flow::Vec3{x, 0.0f, std::sqrt(1 - x * x)};
    }
    std::vector<float> sines;
    for (int v = 0; v < view.model.intrinsics.height; v += 2)
      for (int u = 0; u + 12 < view.model.intrinsics.width; u += 2) {
        const auto &a = normals[static_cast<std::size_t>(96 * v + u)],
                   &b = normals[static_cast<std::size_t>(96 * v + u + 12)];
        if (a.z > 0 && b.z > 0 && dot(a, b) > 0.9f) sines.push_back(squaredNorm(cross(a, b)));
      }
    fuse_flow::gpu::Execution run;
    fuse_flow::gpu::DeviceBuffer<fuse_flow::gpu::DeviceView> views;
    fuse_flow::gpu::DeviceBuffer<fuse_flow::Vec3> on_device;
    fuse_flow::gpu::PinnedBuffer<fuse_flow::gpu::Median> medians;
    views.resize(1);
    on_device.resize(normals.size());
    medians.resize(1);
    run.copy(views.data(), &view, 1);
    run.copy(on_device.data(), std::as_const(normals).data(), normals.size());
    const fuse_flow::gpu::MeasureNormalNoise measure{{views.data(), nullptr, 1}, on_device.data(), medians.data()};
#if FUSE_FLOW_CUDA
    run.launch("measureNormalNoiseKernel", fuse_flow::gpu::measureNormalNoiseKernel, 1u, 1024u, measure);
#else
    run.forEach(1, measure);
#endif
    run.wait();
    ASSERT_EQ(medians.data()->count, sines.size());
    if (sines.empty()) continue;
    std::sort(sines.begin(), sines.end());
    EXPECT_EQ(medians.data()->value, sines[sines.size() / 2]) << trial;
  }
}

}  // namespace
