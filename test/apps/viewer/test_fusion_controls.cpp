#include "viewer/controls/fusion_controls.h"

#include <gtest/gtest.h>

namespace {

using namespace fuse_flow;
using namespace fuse_flow::viewing;

FusionControls defaults() { return FusionControls("fuse_flow", io::MethodOptions()); }

TEST(FusionControls, EachComponentHasASwitchOfItsOwn) {
  FusionControls controls = defaults();
  controls.toggle(Component::DistanceConsistency);
  EXPECT_TRUE(uses(controls.parameters(), Component::MeasurementConfidence));
  EXPECT_FALSE(uses(controls.parameters(), Component::DistanceConsistency));
  EXPECT_TRUE(uses(controls.parameters(), Component::SpatialHash));
  EXPECT_FALSE(controls.fused()->options.parameters.use_distance_consistency);
  controls.toggle(Component::DistanceConsistency);
  EXPECT_TRUE(controls.fused()->options.parameters.use_distance_consistency);
}

TEST(FusionControls, AChangeMakesAnotherSettingAndLeavesTheComparisonAlone) {
  FusionControls controls = defaults();
  controls.compareWith("voxel_grid");
  const FusionSettingPtr fused = controls.fused(), comparison = controls.comparison();
  controls.change([](FuseFlowParameters& p) { p.consistency.sigma = 0.05f; });
  EXPECT_NE(controls.fused(), fused);
  EXPECT_EQ(controls.comparison(), comparison);
  EXPECT_FLOAT_EQ(fused->options.parameters.consistency.sigma, 0.02f) << "what is being fused does not change under it";
}

TEST(FusionControls, TheCropBoxIsForBoth) {
  FusionControls controls = defaults();
  controls.compareWith("concatenate");
  const Eigen::AlignedBox3f box(Eigen::Vector3f::Zero(), Eigen::Vector3f::Ones());
  controls.change([&](FuseFlowParameters& p) { p.crop_box = box; });
  ASSERT_TRUE(controls.comparison()->options.parameters.crop_box);
  EXPECT_TRUE(controls.comparison()->options.parameters.crop_box->isApprox(box));
}

TEST(FusionControls, ResettingKeepsTheCropBox) {
  FusionControls controls = defaults();
  controls.change([&](FuseFlowParameters& p) {
    p.confidence.threshold = 0.9f;
    p.crop_box.emplace(Eigen::Vector3f::Zero(), Eigen::Vector3f::Ones());
  });
  controls.toggle(Component::SpatialHash);
  controls.reset();
  EXPECT_FLOAT_EQ(controls.parameters().confidence.threshold, FuseFlowParameters().confidence.threshold);
  EXPECT_TRUE(uses(controls.parameters(), Component::SpatialHash));
  EXPECT_TRUE(controls.parameters().crop_box);
}

TEST(FusionControls, EveryComparisonHasItsTurnAndNoneComesAgain) {
  FusionControls controls = defaults();
  EXPECT_EQ(controls.comparison(), nullptr);
  std::vector<std::string> titles;
  for (controls.compareWithNext(); controls.comparison(); controls.compareWithNext())
    titles.push_back(controls.comparison()->title);
  EXPECT_EQ(titles.size() + 1, FusionControls::comparisonNames().size());
  EXPECT_EQ(titles[0], "concatenated");
  EXPECT_EQ(titles[1], "pcl::VoxelGrid, 10 mm");
}

TEST(FusionControls, AKeptSettingStaysWhileTheOtherChanges) {
  FusionControls controls = defaults();
  controls.change([](FuseFlowParameters& p) { p.consistency.sigma = 0.03f; });
  controls.keep();
  controls.change([](FuseFlowParameters& p) { p.consistency.sigma = 0.07f; });
  EXPECT_FLOAT_EQ(controls.comparison()->options.parameters.consistency.sigma, 0.03f);
  EXPECT_FLOAT_EQ(controls.fused()->options.parameters.consistency.sigma, 0.07f);
  EXPECT_EQ(controls.comparison()->method, "fuse_flow");
}

TEST(FusionControls, PublishedFormsKeepTheSensorsRange) {
  io::MethodOptions options;
  options.parameters.preprocessing.max_range = 4;
  FusionControls controls("fuse_flow", options);
  controls.compareWith("published");
  const FuseFlowParameters& p = controls.comparison()->options.parameters;
  EXPECT_EQ(p.confidence.form, ConfidenceForm::Published);
  EXPECT_EQ(p.preprocessing.max_range, 4);
}

TEST(FusionControls, PeersAreNeverAskedToRunOnAGpu) {
  io::MethodOptions options;
  options.device = "gpu";
  FusionControls controls("fuse_flow", options);
  controls.compareWith("voxel_grid");
  EXPECT_EQ(controls.comparison()->options.device, "cpu");
  EXPECT_EQ(controls.fused()->options.device, "gpu");
}

}  // namespace
