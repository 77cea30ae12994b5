#include "input_checks/estimated_depth.h"

#include <gtest/gtest.h>

namespace {

using fuse_flow::FuseFlowParameters;
using fuse_flow::io::estimatedDepthAdvice;

TEST(EstimatedDepthAdvice, IsGivenWherePhotographsAreFusedAsDepthCameras) {
  for (const char* kind : {"mvsnet", "colmap"}) {
    const auto advice = estimatedDepthAdvice(kind, "fuse_flow", {});
    ASSERT_EQ(advice.size(), 1u) << kind;
    EXPECT_NE(advice[0].find("--depth-source network"), std::string::npos);
    EXPECT_TRUE(estimatedDepthAdvice(kind, "fuse_flow", FuseFlowParameters::estimatedDepth()).empty());
    EXPECT_TRUE(estimatedDepthAdvice(kind, "voxel_grid", {}).empty());
  }
  for (const char* kind : {"rig", "tum", "pcd", ""}) EXPECT_TRUE(estimatedDepthAdvice(kind, "fuse_flow", {}).empty());
}

TEST(AgreementCheck, ComplainsWhereNearlyAllIsDroppedOrTooFewCamerasAreThere) {
  const float pixel = 1;
  fuse_flow::RigFrame frame;
  frame.views.resize(4);
  for (fuse_flow::DepthView& view : frame.views) view.depth32 = {&pixel, 1, 1};
  fuse_flow::FrameStatistics statistics;
  statistics.measured_points = 1000;
  FuseFlowParameters parameters;
  const auto complaints = [&](int min_views, std::size_t kept, const char* method = "fuse_flow") {
    parameters.agreement.min_views = min_views;
    fuse_flow::io::AgreementCheck check(method, parameters);
    statistics.gated_points = kept;
    check.look(frame, statistics);
    return check.complaints();
  };
  EXPECT_TRUE(complaints(2, 100).empty());
  EXPECT_TRUE(complaints(0, 0).empty());
  EXPECT_TRUE(complaints(2, 0, "voxel_grid").empty());
  parameters.crop_box = Eigen::AlignedBox3f(Eigen::Vector3f::Zero(), Eigen::Vector3f::Ones());
  EXPECT_TRUE(complaints(2, 0).empty());  // the box may have dropped it
  parameters.crop_box.reset();
  ASSERT_EQ(complaints(2, 99).size(), 1u);
  EXPECT_NE(complaints(2, 99)[0].find("99 of 1000"), std::string::npos);
  frame.views[0] = frame.views[1] = {};
  ASSERT_EQ(complaints(2, 0).size(), 1u);
  EXPECT_NE(complaints(2, 0)[0].find("1 of 1 frames too few cameras"), std::string::npos);
}

}  // namespace
