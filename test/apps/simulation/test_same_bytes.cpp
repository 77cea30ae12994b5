#include "instruction_sets.h"
#include "mesh_checks.h"

#include "simulation/scene.h"
#include "simulation/simulator.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

namespace {

using namespace fuse_flow::simulation;
using fuse_flow::io::LoadedFrame;
using mesh_checks::Vector3f;

/** \brief With Embree limited to an instruction set. Without a limit it takes the best that the processor has. */
class OnEveryProcessor : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!instruction_sets::here(GetParam())) GTEST_SKIP() << "this processor has no " << GetParam();
  }
  std::string limited() const { return "isa=" + GetParam(); }
};

std::vector<LoadedFrame> measured(SimulationOptions options, const std::string& embree, int threads) {
  options.embree = embree;
  options.threads = threads;
  Simulator simulator(options);
  std::vector<LoadedFrame> frames(1);
  simulator.measure(3, frames[0]);
  return frames;
}

void expectSame(const std::vector<LoadedFrame>& a, const std::vector<LoadedFrame>& b, const std::string& what) {
  for (std::size_t k = 0; k < a[0].images.size(); ++k) {
    const auto &p = a[0].images[k], &q = b[0].images[k];
    ASSERT_FALSE(p.depth16.data.empty()) << what;
    EXPECT_TRUE(p.depth16.data == q.depth16.data) << what << ", depth of camera " << k;
    ASSERT_EQ(p.color.data.size(), q.color.data.size()) << what;
    EXPECT_EQ(std::memcmp(p.color.data.data(), q.color.data.data(), p.color.data.size() * sizeof(fuse_flow::Rgb8)), 0)
        << what << ", color of camera " << k;
  }
}

TEST_P(OnEveryProcessor, ASimulatedRecordingHasTheSameBytesForAnyNumberOfThreads) {
  SimulationOptions options;
  options.scale = 0.12;
  options.rig = "ring-2";
  options.faults.image = {3, 0.15, 0.3};
  const std::pair<const char*, const char*> rigs[] = {{"person", "structured_light"},
                                                      {"room", "active_stereo"},
                                                      {"table", "time_of_flight"},
                                                      {"table", "time_of_flight_multipath"},
                                                      {"thin", "ideal"}};
  for (const auto& [scene, sensor] : rigs) {
    options.scene = scene;
    options.sensor = sensor;
    const std::string what = std::string(scene) + ", " + sensor;
    const auto reference = measured(options, "", 1);
    const std::vector<int> counts = scene == std::string("person") ? std::vector<int>{1, 2, 3} : std::vector<int>{3};
    for (const int threads : counts)
      expectSame(reference, measured(options, limited() + ",threads=" + std::to_string(threads), threads),
                 what + ", " + std::to_string(threads) + " threads");
  }
}

TEST_P(OnEveryProcessor, ImagesThatTakeTimeHaveTheSameBytes) {
  SimulationOptions options;
  options.scale = 0.12;
  options.rig = "ring-2";
  options.scene = "punch";
  options.frames_per_second = 6.6;  // frame 3 is in the middle of a punch
  options.faults.readout_time = 0.03;
  options.faults.exposure_time = 0.01;
  for (const char* sensor : {"structured_light", "time_of_flight_multipath"}) {
    options.sensor = sensor;
    expectSame(measured(options, "", 1), measured(options, limited() + ",threads=2", 3), sensor);
  }
}

bool sameBits(const Vector3f& a, const Vector3f& b) { return std::memcmp(a.data(), b.data(), 3 * sizeof(float)) == 0; }

TEST_P(OnEveryProcessor, RaysAndNearestPointsAreTheSameToTheBit) {
  const auto scene = makeScene("room", 1);
  RayScene any, some(limited());
  any.setFixed(scene->fixedObjects());
  some.setFixed(scene->fixedObjects());
  std::mt19937 random(5);
  std::uniform_real_distribution<float> number(-1, 1);
  const Vector3f middle = scene->room().center(), half = 0.5f * scene->room().sizes();
  const auto vector = [&] {
    const float x = number(random), y = number(random);
    return Vector3f(x, y, number(random));
  };
  for (int k = 0; k < 20000; ++k) {
    const Vector3f from = middle + half.cwiseProduct(vector()), towards = vector();
    const RayHit a = any.intersect(from, towards), b = some.intersect(from, towards);
    ASSERT_EQ(a.t, b.t);
    ASSERT_EQ(a.object, b.object);
    ASSERT_TRUE(sameBits(a.position, b.position) && sameBits(a.normal, b.normal) && sameBits(a.rest, b.rest));
    const Vector3f to = middle + half.cwiseProduct(vector());
    ASSERT_EQ(any.occluded(from, to), some.occluded(from, to));
    if (k % 10 != 0) continue;
    const NearestHit c = any.nearest(from), d = some.nearest(from);
    ASSERT_EQ(c.signed_distance, d.signed_distance);
    ASSERT_EQ(c.object, d.object);
    ASSERT_TRUE(sameBits(c.position, d.position) && sameBits(c.normal, d.normal) && sameBits(c.rest, d.rest));
  }
}

/** \brief Many sheets in one place: whichever Embree comes to first, the first of them counts. */
TEST_P(OnEveryProcessor, OfSurfacesInOnePlaceTheFirstCounts) {
  RayScene scene(limited());
  std::vector<Object> sheets(30, mesh_checks::squareFacingUp(1, 0));
  sheets.push_back(mesh_checks::squareFacingUp(1, -1));
  scene.setFixed(sheets);
  for (int k = 0; k < 200; ++k) {
    const float x = -0.995f + 0.01f * static_cast<float>(k), y = 0.37f * x;
    EXPECT_EQ(scene.intersect({x, y, 2}, {0, 0, -1}).object, 0u);
    EXPECT_EQ(scene.nearest({x, y, 0.2f}).object, 0u);
    EXPECT_EQ(scene.intersect({x, x, 2}, {0, 0, -1}).object, 0u) << "through the diagonal";
  }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, OnEveryProcessor, testing::ValuesIn(instruction_sets::all()),
                         [](const auto& set) { return set.param == "sse4.2" ? std::string("sse4_2") : set.param; });

}  // namespace
