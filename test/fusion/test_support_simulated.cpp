#include "../scenes.h"
#include "evaluation/truth_quality.h"
#include "simulation/simulator.h"

#include <algorithm>

namespace {

using fuse_flow::FuseFlowParameters;

TEST(Support, TakesAwayMostOfWhatFliesAroundThinThings) {
  if (scenes::kSanitized) GTEST_SKIP() << "the code of the other tests";
  fuse_flow::simulation::SimulationOptions options;
  options.scene = "thin";
  options.rig = "ring-4";
  options.sensor = "time_of_flight";
  options.scale = 0.4;
  options.seed = 3;
  fuse_flow::simulation::Simulator simulator(options);
  fuse_flow::io::LoadedFrame frame;
  simulator.measure(0, frame);
  FuseFlowParameters parameters;
  const auto ghosts = [&](int min_support) {
    parameters.min_support = min_support;
    fuse_flow::simulation::PlainCloud cloud;
    for (const auto& point : scenes::fuse(frame.rig, parameters)) cloud.positions.push_back(point.getVector3fMap());
    fuse_flow::simulation::TruthMatches matches;
    compareWithTruth(cloud, simulator.truth(0), {}, 2, &matches);
    return std::count_if(matches.surface.begin(), matches.surface.end(), [](const auto& hit) { return hit.t > 0.03f; });
  };
  const std::ptrdiff_t all = ghosts(0);
  EXPECT_GT(all, 20);
  EXPECT_LT(ghosts(FuseFlowParameters().min_support), all / 2);
}

}  // namespace
