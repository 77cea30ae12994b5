// What becomes of an object when a call of CUDA's fails: each call in turn, once or from then on.

#include "../device_comparison.h"
#include "../furnished_rig.h"
#include "../random_rig.h"
#include "failing_cuda.h"

#include <fuse_flow/gpu/calibration/extrinsic_estimation.h>
#include <fuse_flow/gpu/filters/adaptive_hash_fusion.h>

#include <pcl/point_types.h>

#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>

extern template class fuse_flow::ExtrinsicEstimation<pcl::PointXYZ, fuse_flow::device::Thrust>;

namespace {

using namespace device_comparison;
using failing_cuda::After;
using failing_cuda::failAt;
using fuse_flow::DeviceError;
using random_rig::Random;
using random_rig::RandomFrame;

/** \brief The bytes of several clouds, one after the other. */
using Clouds = std::vector<std::vector<Bytes>>;

/** \brief Makes an object and has it do something, with the call of that number failing. \returns whether there was such a call
 *  \param object null: making it failed */
template <typename Object, typename Make, typename Work, typename Result>
bool withFailure(long call, int error, After after, const Make& make, const Work& work, const Result& expected,
                 std::unique_ptr<Object>& object, long& refused) {
  failAt(call, error, after);
  try {
    object = make();
    EXPECT_TRUE(work(*object) == expected) << "another result after a failed " << failing_cuda::failedFunction();
  } catch (const DeviceError& device_error) {
    ++refused;
    EXPECT_NE(std::string(device_error.what()).find("fuse_flow"), std::string::npos) << device_error.what();
  } catch (const std::exception& other) {
    ADD_FAILURE() << "after a failed " << failing_cuda::failedFunction() << ": " << other.what();
  }
  return !failing_cuda::failedFunction().empty();
}

/** \brief Each call of CUDA's that making an object and its work make fails in turn. Either the object does without, or the work ends with
 *  DeviceError, and the same object then does it as if nothing had been; or, where all later calls fail, too, it goes away.
 *  \param make returns a std::unique_ptr  \param work returns what is to be the same every time */
template <typename Make, typename Work>
void expectEachFailureIsSurvived(const Make& make, const Work& work) {
  using Object = typename decltype(make())::element_type;
  failAt(0, 0);
  const auto expected = work(*make());
  ASSERT_TRUE(work(*make()) == expected);
  const long held_before = failing_cuda::blocksHeld();
  long tried = 0, refused = 0;
  for (const int error : {cudaErrorMemoryAllocation, cudaErrorUnknown})
    for (long call = 1;; ++call) {
      std::unique_ptr<Object> object;
      const bool failed = withFailure(call, error, After::Success, make, work, expected, object, refused);
      const std::string function = failing_cuda::failedFunction();
      failAt(0, 0);
      if (!failed) break;
      ++tried;
      try {
        if (!object) object = make();
        ASSERT_TRUE(work(*object) == expected) << "call " << call << ", " << function;
      } catch (const std::exception& error_afterwards) {
        FAIL() << "after call " << call << ", " << function << ": " << error_afterwards.what();
      }
    }
  for (long call = 1;; call += 1 + call / 8) {
    std::unique_ptr<Object> object;
    const bool failed =
        withFailure(call, cudaErrorIllegalAddress, After::SameError, make, work, expected, object, refused);
    object.reset();
    failAt(0, 0);
    if (!failed) break;
    ++tried;
  }
  EXPECT_GT(refused, tried / 2);
  EXPECT_EQ(failing_cuda::blocksHeld(), held_before) << "memory is gone";
  std::cout << tried << " failures, " << refused << " DeviceError\n";
}

/** \brief A frame of some cameras, of which some measure. */
RandomFrame someFrame(unsigned int seed) {
  Random random(seed);
  RandomFrame frame;
  Host host;
  Cloud cloud;
  do {
    frame.draw(random, 5, 60);
    host.fuse(frame.rig, cloud);
  } while (cloud.size() < 500 || frame.rig.cameras.size() < 3);
  return frame;
}

class CudaFaults : public testing::Test {
 protected:
  void TearDown() override { failAt(0, 0); }
};

TEST_F(CudaFaults, AFrameOnTheDefaultStream) {
  const RandomFrame first = someFrame(61), second = someFrame(62);
  expectEachFailureIsSurvived([] { return std::make_unique<Device>(); },
                              [&](Device& device) {
                                Clouds clouds;
                                Cloud cloud;
                                for (const RandomFrame* frame : {&first, &second}) {
                                  device.fuse(frame->rig, cloud);
                                  clouds.push_back(bytesOf(cloud));
                                }
                                return clouds;
                              });
}

TEST_F(CudaFaults, FramesThatBecomeAGraph) {
  struct OnItsStream {
    fuse_flow::gpu::OwnStream stream;
    Device device;
  };
  const RandomFrame frame = someFrame(63);
  expectEachFailureIsSurvived(
      [] {
        auto object = std::make_unique<OnItsStream>();
        object->device.setStream(object->stream.get());
        return object;
      },
      [&](OnItsStream& object) {
        Clouds clouds;
        Cloud cloud;
        for (int repeat = 0; repeat < 4; ++repeat) {
          object.device.fuse(frame.rig, cloud);
          clouds.push_back(bytesOf(cloud));
        }
        return clouds;
      });
}

TEST_F(CudaFaults, AFrameWithAllThatCanBeAskedFor) {
  RandomFrame frame = someFrame(64);
  Random random(65);
  frame.giveConfidence(random);
  fuse_flow::FuseFlowParameters parameters;
  parameters.adapt_noise = true;
  parameters.preprocessing.bilateral = true;
  expectEachFailureIsSurvived(
      [&] {
        auto device = std::make_unique<Device>();
        device->setParameters(parameters);
        return device;
      },
      [&](Device& device) {
        Cloud cloud;
        device.fuse(frame.rig, cloud);
        return bytesOf(cloud);
      });
}

TEST_F(CudaFaults, FramesInFlight) {
  const RandomFrame frames[] = {someFrame(66), someFrame(67), someFrame(68)};
  expectEachFailureIsSurvived([] { return std::make_unique<Device>(); },
                              [&](Device& device) {
                                Cloud cloud;
                                while (device.inFlight() > 0) {  // of a round that has failed
                                  try {
                                    device.next(cloud);
                                  } catch (const DeviceError&) {
                                  }
                                }
                                Clouds clouds;
                                for (const RandomFrame& frame : frames) device.submit(frame.rig);
                                while (device.inFlight() > 0) {
                                  device.next(cloud);
                                  clouds.push_back(bytesOf(cloud));
                                }
                                return clouds;
                              });
}

TEST_F(CudaFaults, TheFilterOfClouds) {
  using Filter = fuse_flow::AdaptiveHashFusion<PointFused, fuse_flow::device::Thrust>;
  const RandomFrame frame = someFrame(69);
  const auto cloud = std::make_shared<Cloud>();
  Host().fuse(frame.rig, *cloud);
  expectEachFailureIsSurvived(
      [&] {
        auto filter = std::make_unique<Filter>();
        filter->setInputCloud(cloud);
        return filter;
      },
      [](Filter& filter) {
        Cloud fused;
        filter.filter(fused);
        return bytesOf(fused);
      });
}

TEST_F(CudaFaults, TheSearchForPoses) {
  using Poses = fuse_flow::ExtrinsicEstimation<pcl::PointXYZ, fuse_flow::device::Thrust>;
  furnished_rig::Random random(70);
  furnished_rig::FurnishedRig rig(random, {});
  fuse_flow::ExtrinsicParameters parameters;
  parameters.samples = 500;
  parameters.max_iterations = 3;
  const furnished_rig::Poses initial = rig.disturbed(random);
  expectEachFailureIsSurvived(
      [&] {
        auto poses = std::make_unique<Poses>();
        poses->setParameters(parameters);
        return poses;
      },
      [&](Poses& poses) {
        poses.clear();
        poses.addFrame(rig.rig);
        std::vector<double> numbers;
        for (const Eigen::Isometry3d& pose : poses.estimate(initial).T_world_camera)
          numbers.insert(numbers.end(), pose.matrix().data(), pose.matrix().data() + 16);
        return numbers;
      });
}

__global__ void trap() { __trap(); }

/** \brief In a process of its own, whose device is lost. */
[[noreturn]] void loseTheDevice(const RandomFrame& frame) {
  auto device = std::make_unique<Device>();
  Cloud cloud, again;
  device->fuse(frame.rig, cloud);
  trap<<<1, 1>>>();
  int refused = 0;
  for (int attempt = 0; attempt < 3; ++attempt) {
    try {
      device->fuse(frame.rig, cloud);
    } catch (const DeviceError& error) {
      std::cerr << error.what() << "\n";
      ++refused;
    }
    try {
      (void)std::make_unique<Device>()->fuse(frame.rig, cloud);
    } catch (const DeviceError&) {
      ++refused;
    }
  }
  device.reset();
  Host host;
  host.fuse(frame.rig, cloud);
  host.fuse(frame.rig, again);
  std::cerr << refused << " refused, "
            << (bytesOf(cloud) == bytesOf(again) && !cloud.empty() ? "the CPU goes on" : "no CPU") << "\n";
  std::_Exit(refused == 6 ? 0 : 1);
}

TEST(LostDevice, IsSaidAndTheCpuGoesOn) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(loseTheDevice(someFrame(71)), testing::ExitedWithCode(0),
              "fuse_flow.*\n(.*\n)*6 refused, the CPU goes on");
}

}  // namespace
