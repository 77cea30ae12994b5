#include "../refusal.h"
#include "textured_rig.h"

#include <fuse_flow/stereo/epipolar_errors.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace {

using namespace fuse_flow;

textured::Rig fourViews() {
  textured::Rig rig = textured::onArc(4, 160);
  rig.render(textured::wallAndBall(), textured::noise(0.08));
  return rig;
}

/** \brief The median over the pairs that a camera is in. */
float medianOf(const std::vector<EpipolarError>& errors, std::size_t camera) {
  std::vector<float> medians;
  for (const EpipolarError& error : errors)
    if ((error.view == camera || error.source == camera) && error.matches > 0) medians.push_back(error.median);
  if (medians.empty()) return NAN;
  std::sort(medians.begin(), medians.end());
  return medians[medians.size() / 2];
}

TEST(EpipolarErrors, AreSmallWhereTheCalibrationIsRight) {
  const textured::Rig rig = fourViews();
  const std::vector<EpipolarError> errors = epipolarErrors(rig.frame);
  ASSERT_EQ(errors.size(), 12u);  // four views with three others each
  for (const EpipolarError& error : errors) EXPECT_GT(error.matches, 5u) << error.view << " " << error.source;
  for (std::size_t k = 0; k < 4; ++k) EXPECT_LT(medianOf(errors, k), 0.7f) << k;
}

TEST(EpipolarErrors, ShowTheCameraThatHasBeenTurned) {
  textured::Rig rig = fourViews();
  // About its x axis by 4 pixels, across the lines to its neighbours, which stand beside it.
  rig.frame.cameras[2].T_world_camera.rotate(Eigen::AngleAxisd(4.0 / 144, Eigen::Vector3d::UnitX()));
  const std::vector<EpipolarError> errors = epipolarErrors(rig.frame);
  EXPECT_GT(medianOf(errors, 2), 1.5f);
  float others = 1e9f;
  for (const std::size_t k : {0u, 1u, 3u}) others = std::min(others, medianOf(errors, k));
  EXPECT_GT(medianOf(errors, 2), 2 * others);
}

TEST(EpipolarErrors, AreTheSameForAnyNumberOfThreads) {
  const textured::Rig rig = fourViews();
  const std::vector<EpipolarError> one = epipolarErrors(rig.frame, {}, 1), three = epipolarErrors(rig.frame, {}, 3);
  ASSERT_EQ(one.size(), three.size());
  for (std::size_t k = 0; k < one.size(); ++k) {
    EXPECT_EQ(one[k].matches, three[k].matches);
    EXPECT_EQ(one[k].median, three[k].median);
  }
}

TEST(EpipolarErrors, WithoutTextureNothingMatches) {
  textured::Rig rig = fourViews();
  for (auto& image : rig.images) image.assign(image.size(), Rgb8{90, 90, 90});
  for (const EpipolarError& error : epipolarErrors(rig.frame)) {
    EXPECT_EQ(error.matches, 0u);
    EXPECT_TRUE(std::isnan(error.median));
  }
}

TEST(EpipolarErrors, RefuseWhatStereoRefuses) {
  const textured::Rig rig = fourViews();
  RigFrame frame = rig.frame;
  frame.views[0] = frame.views[1] = frame.views[2] = {};
  refusal::expectThrow([&] { epipolarErrors(frame); }, {"1 of 4 views"});
  StereoParameters parameters;
  parameters.levels = 0;
  refusal::expectThrow([&] { epipolarErrors(rig.frame, parameters); }, {"levels"});
}

}  // namespace
