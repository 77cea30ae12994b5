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

}  // namespace
