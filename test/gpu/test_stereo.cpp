#include "../stereo/textured_rig.h"

#include <fuse_flow/gpu/fuse_flow.h>
#include <fuse_flow/gpu/stereo/multi_view_stereo.h>
#include <fuse_flow/point_types.h>

#include <gtest/gtest.h>

#include <cstring>

namespace {

using namespace fuse_flow;

textured::Rig wallAndBall(int cameras = 3, int width = 64) {
  textured::Rig rig = textured::onArc(cameras, width);
  rig.render(textured::wallAndBall(), textured::noise(0.1));
  return rig;
}

template <typename Value>
bool sameBytes(const std::vector<Value>& a, const std::vector<Value>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Value)) == 0);
}

void expectSame(const StereoFrame& a, const StereoFrame& b) {
  ASSERT_EQ(a.views.size(), b.views.size());
  for (std::size_t k = 0; k < a.views.size(); ++k) {
    EXPECT_TRUE(sameBytes(a.views[k].depth, b.views[k].depth)) << k;
    EXPECT_TRUE(sameBytes(a.views[k].confidence, b.views[k].confidence)) << k;
    EXPECT_TRUE(sameBytes(a.views[k].normals, b.views[k].normals)) << k;
    EXPECT_EQ(a.views[k].agreeing, b.views[k].agreeing);
  }
}

StereoFrame byHost(const RigFrame& frame) {
  MultiViewStereo<> stereo;
  StereoFrame found;
  stereo.estimate(frame, found);
  return found;
}

TEST(GpuStereo, HasTheBytesOfTheHost) {
  const textured::Rig rig = wallAndBall();
  MultiViewStereo<device::Thrust> stereo;
  StereoFrame found;
  stereo.estimate(rig.frame, found);
  expectSame(byHost(rig.frame), found);
  EXPECT_GT(found.views[0].agreeing, 1000u);
}

TEST(GpuStereo, LensesMayDistortAndViewsBeMissing) {
  textured::Rig rig = textured::onArc(4, 64);
  rig.frame.cameras[0].intrinsics.distortion.k1 = -0.2f;
  rig.frame.cameras[3].intrinsics.distortion.k1 = 0.1f;
  rig.render(textured::wallAndBall(), textured::noise(0.1));
  rig.frame.views[1] = {};
  MultiViewStereo<device::Thrust> stereo;
  StereoFrame found;
  stereo.estimate(rig.frame, found);
  expectSame(byHost(rig.frame), found);
}

TEST(GpuStereo, NormalsMayBeLeftOut) {
  const textured::Rig rig = wallAndBall();
  MultiViewStereo<device::Thrust> stereo;
  MultiViewStereo<> host;
  stereo.setNormals(false);
  host.setNormals(false);
  StereoFrame found, of_host, whole = byHost(rig.frame);
  stereo.estimate(rig.frame, found);
  host.estimate(rig.frame, of_host);
  EXPECT_TRUE(found.views[0].normals.empty());
  for (StereoView& view : whole.views) view.normals.clear();
  expectSame(whole, found);
  expectSame(whole, of_host);
}

TEST(GpuStereo, KeepsNothingFromAnotherFrame) {
  const textured::Rig rig = wallAndBall(), other = wallAndBall(4, 48);
  MultiViewStereo<device::Thrust> stereo;
  StereoFrame found;
  stereo.estimate(other.frame, found);
  stereo.estimate(rig.frame, found);
  expectSame(byHost(rig.frame), found);
}

TEST(GpuStereo, DepthOnTheDeviceIsFusedThere) {
  const textured::Rig rig = wallAndBall(4);
  MultiViewStereo<device::Thrust> stereo;
  RigFrame on_device;
  stereo.estimateOnDevice(rig.frame, on_device);
  FuseFlow<PointFused, device::Thrust> fusion;
  fusion.setParameters(FuseFlowParameters::estimatedDepth());
  pcl::PointCloud<PointFused> cloud, expected;
  fusion.fuse(on_device, cloud);
  const StereoFrame found = byHost(rig.frame);
  fusion.fuse(found.rig, expected);
  ASSERT_GT(cloud.size(), 300u);
  ASSERT_EQ(cloud.size(), expected.size());
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    EXPECT_EQ(cloud[k].x, expected[k].x);
    EXPECT_EQ(cloud[k].z, expected[k].z);
    EXPECT_EQ(cloud[k].rgba, expected[k].rgba);
  }
}

TEST(GpuStereo, AWarmFrameAllocatesNothing) {
  const textured::Rig rig = wallAndBall();
  MultiViewStereo<device::Thrust> stereo;
  RigFrame on_device;
  stereo.estimateOnDevice(rig.frame, on_device);
  stereo.wait();
  const std::size_t before = gpu::memoryRequests();
  stereo.estimateOnDevice(rig.frame, on_device);
  stereo.wait();
  EXPECT_EQ(gpu::memoryRequests(), before);
}

}  // namespace
