#include <fuse_flow/gpu/runtime/execution.h>
#include <fuse_flow/math/exponential.h>

#include <gtest/gtest.h>

namespace {

/** \brief e^x for x from 0 downwards. */
struct Exponentials {
  float* results;

  FUSE_FLOW_HD static float argument(std::uint32_t k) { return -1.25e-3f * static_cast<float>(k); }
  FUSE_FLOW_HD void operator()(std::uint32_t k) const { results[k] = fuse_flow::expOfNegative(argument(k)); }
};

TEST(GpuExponential, HasTheBitsOfTheHost) {
  constexpr std::uint32_t n = 72000;
  fuse_flow::gpu::Execution run;
  fuse_flow::gpu::DeviceBuffer<float> on_device;
  fuse_flow::gpu::PinnedBuffer<float> results;
  on_device.resize(n);
  results.resize(n);
  run.forEach(n, Exponentials{on_device.data()});
  run.copy(results.data(), static_cast<const float*>(on_device.data()), n);
  run.wait();
  for (std::uint32_t k = 0; k < n; ++k)
    ASSERT_EQ(results.data()[k], fuse_flow::expOfNegative(Exponentials::argument(k))) << Exponentials::argument(k);
}

}  // namespace
