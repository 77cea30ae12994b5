#include "input_checks/depth_in_range.h"

#include <gtest/gtest.h>

#include <limits>

namespace {

using namespace fuse_flow;
using Lines = std::vector<std::string>;

class DepthInRange : public ::testing::Test {
 protected:
  DepthInRange() {
    frame_.cameras.resize(1);
    frame_.cameras[0].name = "left";
    frame_.views.resize(1);
  }
  void look(const std::vector<std::uint16_t>& pixels, float scale) {
    frame_.views[0].depth16 = {pixels.data(), static_cast<int>(pixels.size()), 1};
    frame_.cameras[0].depth_scale = scale;
    depth_.look(frame_);
    frame_.views[0] = {};
  }

  RigFrame frame_;
  io::DepthInRange depth_{PreprocessingParameters()};
};

TEST_F(DepthInRange, OneMeasurementInRangeIsEnough) {
  look({0, 65535, 50, 2000}, 0.001f);
  EXPECT_EQ(depth_.complaints(), Lines());
}

TEST_F(DepthInRange, AWrongUnitIsNamedWithWhatItMeasures) {
  look({0, 65535, 1500, 4000}, 1.0f);
  look({1200}, 1.0f);
  EXPECT_EQ(depth_.complaints(), Lines{"camera 'left' measures nothing within 0.1 to 20 m, but 1200 to 4000 m with a "
                                       "depth_scale of 1 m"});
  look({15}, 0.1f);  // 1.5 m, at last
  EXPECT_EQ(depth_.complaints(), Lines());
}

TEST_F(DepthInRange, AFewStrayMeasurementsInRangeDoNotMakeAUnitRight) {
  std::vector<std::uint16_t> pixels(23, 1500);  // 1500 m, but for two of 3 m
  pixels[4] = pixels[5] = 3;
  look(pixels, 1.0f);
  EXPECT_EQ(depth_.complaints(), Lines{"camera 'left' measures only 2 of 23 pixels within 0.1 to 20 m, but 3 to 1500 m "
                                       "with a depth_scale of 1 m"});
  look({1, 1, 1, 800}, 1.0f);
  EXPECT_EQ(depth_.complaints(), Lines());
}

TEST_F(DepthInRange, MetresHaveNoScale) {
  const std::vector<float> pixels{std::numeric_limits<float>::quiet_NaN(), 1500, -1,
                                  std::numeric_limits<float>::infinity()};
  frame_.views[0].depth32 = {pixels.data(), 4, 1};
  depth_.look(frame_);
  EXPECT_EQ(depth_.complaints(),
            Lines{"camera 'left' measures nothing within 0.1 to 20 m, but 1500 to 1500 m; depth in float is metres"});
}

TEST_F(DepthInRange, ImagesWithoutDepthAreNamedAndCamerasWithoutImagesAreNot) {
  depth_.look(frame_);
  EXPECT_EQ(depth_.complaints(), Lines());
  look({0, 0, 65535}, 0.001f);
  EXPECT_EQ(depth_.complaints(), Lines{"camera 'left' has images without any depth"});
}

}  // namespace
