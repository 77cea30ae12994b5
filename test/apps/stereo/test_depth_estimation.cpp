#include "methods/gpu_then_cpu.h"
#include "stereo/depth_estimation.h"

#include <fuse_flow/recordings/error.h>

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace {

using namespace fuse_flow;

/** \brief Leaves a mark; the frame of a number fails. */
class Marking : public io::DepthEstimation {
 public:
  Marking(double mark, int fails_at) : mark_(mark), fails_at_(fails_at) {}
  void estimate(const RigFrame&, StereoFrame& result) override {
    if (frames_++ == fails_at_) throw DeviceError("fuse_flow::gpu: lost");
    result.total_ms = mark_;
  }

 private:
  double mark_;
  int fails_at_, frames_{0};
};

TEST(GpuThenCpu, WhatFailsIsDoneAgainOnTheCpu) {
  std::vector<std::string> said;
  io::GpuThenCpu<io::DepthEstimation> either([] { return std::make_unique<Marking>(1, 1); },
                                             [] { return std::make_unique<Marking>(2, -1); },
                                             [&](const std::string& line) { said.push_back(line); });
  const RigFrame frame;
  StereoFrame result;
  for (const double expected : {1.0, 2.0, 2.0}) {
    result.total_ms = 0;
    either.run([&](io::DepthEstimation& estimation) { estimation.estimate(frame, result); });
    EXPECT_EQ(result.total_ms, expected);
    EXPECT_EQ(either.onGpu(), expected == 1);
  }
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].find("the GPU has failed, and the CPU goes on: "), std::string::npos) << said[0];
}

TEST(GpuThenCpu, OtherErrorsAreNotTheDevices) {
  io::GpuThenCpu<io::DepthEstimation> either([] { return std::make_unique<Marking>(1, -1); },
                                             [] { return std::make_unique<Marking>(2, -1); },
                                             [](const std::string& line) { ADD_FAILURE() << line; });
  EXPECT_THROW(either.run([](io::DepthEstimation&) { throw io::InputError("an image"); }), io::InputError);
  EXPECT_TRUE(either.onGpu());
}

TEST(DepthEstimation, AFrameWithoutImagesIsRefusedWhereverItRuns) {
  for (const char* device : {"cpu", "auto"}) {
    const auto estimation = io::makeDepthEstimation(StereoParameters(), 1, device, {});
    StereoFrame result;
    EXPECT_THROW(estimation->estimate(RigFrame(), result), pcl::PCLException) << device;
  }
}

}  // namespace
