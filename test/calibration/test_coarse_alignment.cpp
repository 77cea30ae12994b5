#include "../rigs.h"

#include <fuse_flow/calibration/coarse_alignment.h>
#include <fuse_flow/impl/calibration/coarse/rig_placement.hpp>
#include <fuse_flow/impl/calibration/coarse/view_agreement.hpp>

#include <pcl/exceptions.h>

namespace {

using Eigen::Vector3d;
using fuse_flow::CoarseAlignment;
using fuse_flow::CoarseAlignmentParameters;
using fuse_flow::CoarseAlignmentResult;
using fuse_flow::Placement;
using scenes::Scene;
using scenes::Surface;

/** \brief A box along the axes, from outside. */
Surface box(const Vector3d& low, const Vector3d& high) {
  return [=](const Vector3d& origin, const Vector3d& direction) {
    double enter = 0, leave = std::numeric_limits<double>::max();
    for (int k = 0; k < 3; ++k) {
      const double a = (low[k] - origin[k]) / direction[k], b = (high[k] - origin[k]) / direction[k];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return enter < leave ? enter : 0.0;
  };
}

/** \brief Floor, ceiling and walls, from inside; y is down. */
std::vector<Surface> emptyRoom() {
  return {scenes::plane({0, 1, 0}, 1.1),  scenes::plane({0, 1, 0}, -1.3), scenes::plane({1, 0, 0}, 2.3),
          scenes::plane({1, 0, 0}, -1.9), scenes::plane({0, 0, 1}, 1.6),  scenes::plane({0, 0, 1}, -1.8)};
}

/** \brief No two of its things alike. */
Surface furnishedRoom() {
  std::vector<Surface> surfaces = emptyRoom();
  surfaces.push_back(box({-0.6, 0.4, -0.3}, {0.3, 1.1, 0.2}));
  surfaces.push_back(box({0.5, 0.75, 0.5}, {0.8, 1.1, 1.1}));
  surfaces.push_back(box({1.6, -0.4, -0.9}, {2.3, 1.1, -0.2}));
  surfaces.push_back(box({-1.9, 0.6, 0.7}, {-1.2, 1.1, 1.6}));
  surfaces.push_back(box({-1.3, 0.2, -1.8}, {-0.2, 1.1, -1.4}));
  surfaces.push_back(scenes::sphere({-0.1, 0.2, 0.0}, 0.2));
  surfaces.push_back(scenes::sphere({0.9, 0.9, -0.6}, 0.2));
  return scenes::nearest(surfaces);
}

/** \brief From places around the middle of the room, degrees apart, in no particular height. */
std::vector<fuse_flow::Camera> around(const std::vector<double>& degrees) {
  std::vector<fuse_flow::Camera> cameras;
  for (const double angle : degrees) {
    const double a = angle * M_PI / 180;
    const Vector3d eye(1.5 * std::cos(a), -0.35 + 0.002 * angle, 1.4 * std::sin(a));
    cameras.push_back(scenes::lookAt(eye, {0.1, 0.5, 0.05}, 160, 120, 130));
    cameras.back().name = "camera at " + std::to_string(angle);
  }
  return cameras;
}

/** \brief What the cameras see, with nothing said about where they are. */
Scene unposed(const std::vector<fuse_flow::Camera>& cameras, const Surface& surface) {
  Scene scene = scenes::makeScene(cameras, surface);
  scenes::addNoise(scene, 0.002f);
  for (fuse_flow::Camera& camera : scene.rig.cameras) camera.T_world_camera.setIdentity();
  return scene;
}

/** \brief The same after half a turn about its middle, but for how bright it is. */
Surface halfTurnedRoom() {
  std::vector<Surface> surfaces{scenes::plane({0, 1, 0}, 1.1),          scenes::plane({0, 1, 0}, -1.3),
                                scenes::plane({1, 0, 0}, 2.1),          scenes::plane({1, 0, 0}, -2.1),
                                scenes::plane({0, 0, 1}, 1.7),          scenes::plane({0, 0, 1}, -1.7),
                                box({-0.5, 0.4, -0.3}, {0.5, 1.1, 0.3})};
  for (const double side : {-1.0, 1.0}) {
    const Vector3d seat(side * 0.9, 0.85, side * 0.7), shelf(side * 1.8, 0.3, side * 0.4);
    surfaces.push_back(box(seat - Vector3d(0.2, 0.25, 0.3), seat + Vector3d(0.2, 0.25, 0.3)));
    surfaces.push_back(box(shelf - Vector3d(0.3, 0.8, 0.35), shelf + Vector3d(0.3, 0.8, 0.35)));
    surfaces.push_back(scenes::sphere({side * 0.3, 0.25, side * 0.1}, 0.15));
  }
  return scenes::nearest(surfaces);
}

CoarseAlignmentResult align(const Scene& scene, unsigned int threads = 2,
                            const CoarseAlignmentParameters& parameters = {}) {
  CoarseAlignment alignment;
  alignment.setParameters(parameters);
  alignment.setNumberOfThreads(threads);
  alignment.addFrame(scene.rig);
  return alignment.estimate();
}

/** \brief Grey levels that no shift or turn of the floor repeats. */
double floorPaint(const Vector3d& x) {
  return 120 + 30 * std::sin(3.1 * x.x() + 1.7 * x.z()) + 25 * std::sin(5.3 * x.z() - 2.2 * x.x()) +
         20 * std::sin(7.7 * x.x() + 3.9 * x.z()) + 12 * std::sin(11 * x.z() - 6.1 * x.x());
}

/** \brief Relative to camera 0, well within what ExtrinsicEstimation brings to the end. */
void expectPose(const CoarseAlignmentResult& result, const std::vector<fuse_flow::Camera>& truth, std::size_t i) {
  const Eigen::Isometry3d expected = truth[0].T_world_camera.inverse() * truth[i].T_world_camera;
  const Eigen::Isometry3d error = expected.inverse() * result.T_world_camera[i];
  EXPECT_EQ(result.placements[i], Placement::Placed) << "camera " << i;
  EXPECT_EQ(result.groups[i], 0u) << "camera " << i;
  EXPECT_LT(error.translation().norm(), 0.06) << "camera " << i;
  EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), 0.07) << "camera " << i;
}

TEST(CoarseAlignment, FindsThePosesOfCamerasOfWhichNothingIsKnown) {
  if (scenes::kSanitized) GTEST_SKIP() << "the code of ColourKeepsCamerasFromBeingPlacedHalfATurnAway";
  const auto cameras = around({10, 45, 85, 120});
  const CoarseAlignmentResult result = align(unposed(cameras, furnishedRoom()));
  for (std::size_t i = 0; i < cameras.size(); ++i) expectPose(result, cameras, i);
  EXPECT_TRUE(result.complete());
}

TEST(CoarseAlignment, NeighboursOverlapAndTheOverlapsSayHowMuch) {
  if (scenes::kSanitized) GTEST_SKIP() << "the code of ColourKeepsCamerasFromBeingPlacedHalfATurnAway";
  const auto cameras = around({10, 40, 70});
  const CoarseAlignmentResult result = align(unposed(cameras, furnishedRoom()));
  ASSERT_EQ(result.overlaps.size(), 3u);
  for (const fuse_flow::CoarseOverlap& overlap : result.overlaps) {
    EXPECT_LT(overlap.first, overlap.second);
    EXPECT_GT(overlap.agreement.confirmed, 10 * overlap.agreement.contradicted);
  }
  EXPECT_GT(result.overlaps[0].agreement.confirmed, result.overlaps[1].agreement.confirmed);  // 30° apart, not 60°
}

TEST(CoarseAlignment, PosesThatTheCamerasHaveMakeNoDifference) {
  if (scenes::kSanitized) GTEST_SKIP() << "the code of ColourKeepsCamerasFromBeingPlacedHalfATurnAway";
  const auto cameras = around({10, 55, 115});
  Scene scene = unposed(cameras, furnishedRoom());
  const CoarseAlignmentResult without = align(scene);
  scene.rig.cameras[1].T_world_camera.translation() = Vector3d(5, 6, 7);
  const CoarseAlignmentResult with = align(scene);
  for (std::size_t i = 0; i < cameras.size(); ++i)
    EXPECT_EQ(without.T_world_camera[i].matrix(), with.T_world_camera[i].matrix());
}

TEST(CoarseAlignment, FarDepthCountsAsAnyOtherOnceMultipathInterferenceIsTakenAway) {
  const auto cameras = around({10, 45});
  Scene late = unposed(cameras, furnishedRoom()), right = unposed(cameras, furnishedRoom());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    late.rig.cameras[i].multipath.modulation_frequency = 200e6f;
    fuse_flow::host::ViewGeometry geometry;
    geometry.assign(late.rig.cameras[i]);
    fuse_flow::host::DepthMap depth;
    fuse_flow::host::makeDepthMap({}, geometry, late.rig.views[i], depth);
    for (int v = 0; v < depth.height(); ++v) std::copy_n(depth.row(v), depth.width(), &right.depth[i].at(0, v));
  }
  const CoarseAlignmentResult found = align(late), expected = align(right);
  ASSERT_EQ(expected.placements[1], Placement::Placed);
  EXPECT_EQ(found.placements, expected.placements);
  EXPECT_EQ(found.T_world_camera[1].matrix(), expected.T_world_camera[1].matrix());
  EXPECT_NE(found.T_world_camera[1].matrix(), align(unposed(cameras, furnishedRoom())).T_world_camera[1].matrix());
}

TEST(CoarseAlignmentThreads, AnyNumberOfThemFindsTheSame) {
  Scene scene = scenes::makeScene(around({10, 55, 115}), furnishedRoom());
  scenes::addNoise(scene, 0.002f);
  scenes::paintWorld(scene, floorPaint);
  for (fuse_flow::Camera& camera : scene.rig.cameras) camera.T_world_camera.setIdentity();
  CoarseAlignmentParameters parameters;
  if (scenes::kSanitized) {  // all of its code, of fewer poses
    parameters.samples = 200;
    parameters.hypotheses = 3;
    parameters.cell_size = 0.25f;
  }
  const CoarseAlignmentResult one = align(scene, 1, parameters);
  ASSERT_GE(std::count(one.placements.begin(), one.placements.end(), Placement::Placed), 2);
  for (const unsigned int threads : scenes::kSanitized ? std::vector{3u} : std::vector{2u, 5u}) {
    const CoarseAlignmentResult many = align(scene, threads, parameters);
    EXPECT_EQ(one.placements, many.placements);
    ASSERT_EQ(one.T_world_camera.size(), many.T_world_camera.size());
    for (std::size_t i = 0; i < one.T_world_camera.size(); ++i)
      EXPECT_EQ(one.T_world_camera[i].matrix(), many.T_world_camera[i].matrix());
  }
}

TEST(CoarseAlignment, AMissingViewIsSaidAndTheOthersArePlaced) {
  const auto cameras = around({10, 30, 55});
  Scene scene = unposed(cameras, furnishedRoom());
  scene.rig.views[1] = {};
  const CoarseAlignmentResult result = align(scene);
  EXPECT_EQ(result.placements[1], Placement::Missing);
  EXPECT_EQ(result.groups[1], 1u);
  expectPose(result, cameras, 2);
  EXPECT_FALSE(result.complete());
}

TEST(CoarseAlignment, ACameraThatSharesNothingWithTheOthersIsLeftOut) {
  if (scenes::kSanitized) GTEST_SKIP() << "the code of ColourKeepsCamerasFromBeingPlacedHalfATurnAway";
  const auto cameras = around({10, 55, 115});
  Scene scene = unposed(cameras, furnishedRoom());
  // It hangs elsewhere, before a ball.
  const auto elsewhere = scenes::lookAt({0, 0, -2}, {0, 0, 0}, 160, 120, 130);
  scene.depth[1] = scenes::render(elsewhere, scenes::sphere({0, 0, 0}, 0.7));
  scene.attach();
  const CoarseAlignmentResult result = align(scene);
  EXPECT_NE(result.placements[1], Placement::Placed);
  EXPECT_EQ(result.groups[1], 1u);
  EXPECT_EQ(result.T_world_camera[1].matrix(), Eigen::Isometry3d::Identity().matrix());
}

TEST(CoarseAlignment, OneWallAloneIsAmbiguous) {
  const auto cameras = scenes::cameraRow(2, 160, 120, 130);
  const CoarseAlignmentResult result = align(unposed(cameras, scenes::plane({0, 0, 1}, 1.5)));
  EXPECT_EQ(result.placements[0], Placement::Ambiguous);
  EXPECT_EQ(result.placements[1], Placement::Ambiguous);
  EXPECT_FALSE(result.complete());
}

TEST(CoarseAlignment, ColourKeepsCamerasFromBeingPlacedHalfATurnAway) {
  const auto cameras = around({10, 45, 85, 120});
  Scene scene = scenes::makeScene(cameras, halfTurnedRoom());
  scenes::addNoise(scene, 0.002f);
  // No wall differs from the one opposite by more than exposures may.
  scenes::paintWorld(scene, [](const Vector3d& x) { return 128 + 6 * x.x() - 4 * x.z(); });
  for (fuse_flow::Camera& camera : scene.rig.cameras) camera.T_world_camera.setIdentity();
  const CoarseAlignmentResult result = align(scene);
  expectPose(result, cameras, 1);
  for (std::size_t i = 2; i < cameras.size(); ++i)
    if (result.groups[i] == 0) expectPose(result, cameras, i);  // or it is said to be open
}

TEST(CoarseAlignment, OfARoomThatLooksAlikeAfterHalfATurnNotAllIsToldWithoutColour) {
  if (scenes::kSanitized) GTEST_SKIP() << "the code of ColourKeepsCamerasFromBeingPlacedHalfATurnAway";
  EXPECT_FALSE(align(unposed(around({10, 45, 85, 120}), halfTurnedRoom())).complete());
}

/** \brief Cameras that see nothing but a floor. */
Scene floorOnly(const std::vector<fuse_flow::Camera>& cameras) {
  Scene scene = scenes::makeScene(cameras, scenes::plane({0, 1, 0}, 1.1));
  scenes::addNoise(scene, 0.002f);
  return scene;
}

std::vector<fuse_flow::Camera> overFloor() {
  return {scenes::lookAt({0, -0.3, 0}, {0.3, 1.1, 0.9}, 160, 120, 130),
          scenes::lookAt({1.1, -0.2, 0.2}, {0.4, 1.1, 1.0}, 160, 120, 130),
          scenes::lookAt({0.9, -0.4, 1.9}, {0.2, 1.1, 0.8}, 160, 120, 130)};
}

TEST(CoarseAlignment, WhatIsPaintedOnABareFloorTellsWhereCamerasAre) {
  const auto cameras = overFloor();
  Scene scene = floorOnly(cameras);
  scenes::paintWorld(scene, floorPaint);
  for (auto& pixel : scene.color[1].data)  // of a shorter exposure
    pixel.r = pixel.g = pixel.b = static_cast<std::uint8_t>(pixel.r - 20);
  for (fuse_flow::Camera& camera : scene.rig.cameras) camera.T_world_camera.setIdentity();
  const CoarseAlignmentResult result = align(scene);
  for (std::size_t i = 0; i < cameras.size(); ++i) expectPose(result, cameras, i);
}

TEST(CoarseAlignment, ABareFloorWithoutPaintIsAmbiguous) {
  if (scenes::kSanitized) GTEST_SKIP() << "the code of WhatIsPaintedOnABareFloorTellsWhereCamerasAre";
  Scene scene = floorOnly(overFloor());
  scenes::paintWorld(scene, [](const Vector3d&) { return 120; });
  for (fuse_flow::Camera& camera : scene.rig.cameras) camera.T_world_camera.setIdentity();
  for (const Placement placement : align(scene).placements) EXPECT_EQ(placement, Placement::Ambiguous);
}

// Each tile fits on every other one.
TEST(CoarseAlignment, ABareFloorOfTilesThatRepeatIsAmbiguous) {
  if (scenes::kSanitized) GTEST_SKIP() << "the code of WhatIsPaintedOnABareFloorTellsWhereCamerasAre";
  Scene scene = floorOnly(overFloor());
  scenes::paintWorld(scene, [](const Vector3d& x) {
    return (static_cast<int>(std::floor(x.x() / 0.3)) + static_cast<int>(std::floor(x.z() / 0.3))) % 2 == 0 ? 60 : 190;
  });
  for (fuse_flow::Camera& camera : scene.rig.cameras) camera.T_world_camera.setIdentity();
  for (const Placement placement : align(scene).placements) EXPECT_NE(placement, Placement::Placed);
}

/** \brief What two cameras over a painted floor make of each other where they stand, from so many copies of one instant. */
fuse_flow::ViewAgreement agreementOfInstants(int instants, double (*grey)(const Vector3d&)) {
  const auto cameras = overFloor();
  Scene scene = scenes::makeScene({cameras[0], cameras[1]}, scenes::plane({0, 1, 0}, 1.1));
  scenes::paintWorld(scene, grey);
  for (auto& pixel : scene.color[1].data)  // of a shorter exposure
    pixel.r = pixel.g = pixel.b = static_cast<std::uint8_t>(pixel.r - 20);
  fuse_flow::ExtrinsicParameters p;
  p.reduction = 1;
  fuse_flow::host::AlignmentSystem system(1);
  for (int k = 0; k < instants; ++k) system.add(scene.rig, p);
  const CoarseAlignmentParameters parameters;
  system.sample({cameras[0].T_world_camera, cameras[1].T_world_camera}, parameters.samples);
  fuse_flow::host::ViewComparison comparison(system, parameters);
  comparison.setColorNoise(2);
  return comparison.compare(0, 1, cameras[0].T_world_camera.inverse() * cameras[1].T_world_camera);
}

TEST(CoarseAlignment, PaintThatAgreesIsEvidenceWhateverTheExposureAndHoweverManyInstants) {
  const fuse_flow::ViewAgreement one = agreementOfInstants(1, floorPaint), four = agreementOfInstants(4, floorPaint);
  // All but wholly the same, and r counts as 0.99 at most: artanh(0.99) = 2.6467.
  EXPECT_NEAR(one.color_evidence, 2.6467 * std::sqrt(one.confirmed), 0.05 * one.color_evidence);
  EXPECT_EQ(one.unlike, 0);
  EXPECT_NEAR(four.color_evidence, one.color_evidence, 1e-6);
  EXPECT_NEAR(four.score(), one.score(), 1e-6);
  const fuse_flow::ViewAgreement twelve = agreementOfInstants(12, floorPaint);  // of which some are enough
  EXPECT_NEAR(twelve.confirmed, one.confirmed, 1e-6);
  EXPECT_NEAR(twelve.color_evidence, one.color_evidence, 1e-6);
  EXPECT_NEAR(twelve.score(), one.score(), 1e-6);
  const fuse_flow::ViewAgreement plain = agreementOfInstants(1, [](const Vector3d&) { return 120.0; });
  EXPECT_EQ(plain.color_evidence, 0);
  EXPECT_NEAR(one.score() - plain.score(), 3 * one.color_evidence, 1e-6);
}

// Of poses that paint proposes the best may stand anywhere behind those of shape.
TEST(HypothesisTable, NoiseOfColourIsThatOfPosesThatScoreAtLeastHalfOfTheHighest) {
  fuse_flow::host::HypothesisTable table(2);
  EXPECT_EQ(table.colorNoise(), std::numeric_limits<double>::infinity());  // nothing is known
  const auto hypothesis = [](double score, double spread) {
    fuse_flow::host::PoseHypothesis h;
    h.score = score;
    h.color_spread = spread;
    return h;
  };
  table(0, 1) = {hypothesis(40, 9), hypothesis(100, 3), hypothesis(51, 4), hypothesis(49, 1.5)};
  EXPECT_EQ(table.colorNoise(), 3);
  table(0, 1) = {hypothesis(19, 1.5), hypothesis(21, 2.5),
                 hypothesis(22, 0)};  // too little to be plausible; without colour
  EXPECT_EQ(table.colorNoise(), 2.5);
  table(0, 1) = {hypothesis(60, 0.4)};
  EXPECT_EQ(table.colorNoise(), 1.2);  // no less, however alike
}

fuse_flow::host::PlacedGroup groupOf(const std::vector<std::size_t>& members, double score, double shift = 0) {
  fuse_flow::host::PlacedGroup group;
  group.members = members;
  group.score = score;
  group.poses.assign(4, Eigen::Isometry3d::Identity());
  for (std::size_t i = 0; i < 4; ++i)  // in a world of its own
    group.poses[i] = Eigen::Translation3d(score, 0, 0) * Eigen::AngleAxisd(score, Vector3d::UnitY()) *
                     Eigen::Translation3d(static_cast<double>(i) * (1 + shift), 0, 0);
  return group;
}

TEST(PlacedGroups, ThatAreTheSameWhereverTheyLieStandOnce) {
  using fuse_flow::host::sameGroup;
  EXPECT_TRUE(sameGroup(groupOf({0, 1, 2}, 7), groupOf({2, 0, 1}, 9), 0.1, 0.1));
  EXPECT_FALSE(sameGroup(groupOf({0, 1, 2}, 7), groupOf({0, 1, 3}, 7), 0.1, 0.1));
  EXPECT_FALSE(sameGroup(groupOf({0, 1, 2}, 7), groupOf({0, 1}, 7), 0.1, 0.1));
  EXPECT_FALSE(sameGroup(groupOf({0, 1, 2}, 7), groupOf({0, 1, 2}, 7, 0.06), 0.1, 0.1));  // camera 2 by 0.12
  const auto kept = fuse_flow::host::withoutDuplicates(
      {groupOf({0, 1, 2}, 7), groupOf({}, 0), groupOf({2, 1, 0}, 9), groupOf({0, 1}, 8), groupOf({1, 0}, 2)}, 0.1, 0.1);
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_EQ(kept[0].score, 9);
  EXPECT_EQ(kept[1].score, 8);
}

// More of two bare floors lies on each other at wrong poses than at the right one, which only paint proposes: shape alone ends
// metres off.
TEST(CoarseAlignment, PaintFindsTwoCamerasThatShapeWouldLayOnEachOther) {
  const std::vector<fuse_flow::Camera> cameras{overFloor()[0],
                                               scenes::lookAt({2.2, -0.2, 0.2}, {1.5, 1.1, 1.0}, 160, 120, 130)};
  Scene scene = floorOnly(cameras);
  scenes::paintWorld(scene, floorPaint);
  for (fuse_flow::Camera& camera : scene.rig.cameras) camera.T_world_camera.setIdentity();
  expectPose(align(scene), cameras, 1);
}

// Beyond its border nothing is known of grey levels, which says nothing against a pose.
TEST(CoarseAlignment, AColourImageThatShowsLessThanTheDepthImageContradictsNothing) {
  const auto cameras = overFloor();
  Scene scene = scenes::makeScene({cameras[0], cameras[1]}, scenes::plane({0, 1, 0}, 1.1));
  scenes::paintWorld(scene, floorPaint);
  const auto compare = [&] {
    fuse_flow::ExtrinsicParameters p;
    p.reduction = 1;
    fuse_flow::host::AlignmentSystem system(1);
    system.add(scene.rig, p);
    const CoarseAlignmentParameters parameters;
    system.sample({cameras[0].T_world_camera, cameras[1].T_world_camera}, parameters.samples);
    return fuse_flow::host::ViewComparison(system, parameters)
        .compare(0, 1, cameras[0].T_world_camera.inverse() * cameras[1].T_world_camera);
  };
  const fuse_flow::ViewAgreement whole = compare();
  for (std::size_t i = 0; i < 2; ++i) {  // the same camera, of which only the left three quarters are kept
    fuse_flow::Camera& camera = scene.rig.cameras[i];
    camera.color.emplace();
    camera.color->intrinsics = camera.intrinsics;
    camera.color->intrinsics.width = 120;
    scene.rig.views[i].color.width = 120;
  }
  const fuse_flow::ViewAgreement part = compare();
  EXPECT_EQ(part.unlike, 0);
  EXPECT_EQ(part.confirmed, whole.confirmed);
  EXPECT_GT(part.color_evidence, 0.4 * whole.color_evidence);  // √ of the points that both have colour for
  EXPECT_LT(part.color_evidence, 0.95 * whole.color_evidence);
  EXPECT_LT(part.color_spread, 1.1 * whole.color_spread);  // no dark border
}

// Two views a quarter turn apart share little more than the floor, along which false counterparts pull.
TEST(CoarseAlignment, RefiningAPoseNeverMakesTwoViewsAgreeLess) {
  const auto cameras = around({10, 100});
  Scene scene = unposed(cameras, furnishedRoom());
  scenes::addNoise(scene, 0.006f);
  fuse_flow::ExtrinsicParameters p;
  p.reduction = 1;
  fuse_flow::host::AlignmentSystem system(1);
  system.add(scene.rig, p);
  const std::vector<Eigen::Isometry3d> poses(2, Eigen::Isometry3d::Identity());
  system.sample(poses, 600);
  const CoarseAlignmentParameters parameters;
  const fuse_flow::host::ViewComparison comparison(system, parameters);
  Eigen::Isometry3d T = cameras[0].T_world_camera.inverse() * cameras[1].T_world_camera;
  for (const double off : {0.0, 0.02, 0.04}) {
    T.translation().x() += off;
    const Eigen::Isometry3d refined = comparison.refine(1, T, {0}, poses, {0.06f, 0.05f, 0.04f, 0.03f});
    EXPECT_GE(comparison.compare(0, 1, refined).score(), comparison.compare(0, 1, T).score()) << off;
  }
}

TEST(CoarseAlignment, OneCameraIsARigOfItsOwn) {
  const CoarseAlignmentResult result = align(unposed(around({10}), furnishedRoom()));
  EXPECT_TRUE(result.complete());
  EXPECT_EQ(result.T_world_camera[0].matrix(), Eigen::Isometry3d::Identity().matrix());
}

TEST(CoarseAlignment, WithoutAFrameThereIsNothingToEstimate) {
  CoarseAlignment alignment;
  EXPECT_THROW(alignment.estimate(), pcl::PCLException);
  alignment.addFrame(unposed(around({10}), furnishedRoom()).rig);
  alignment.clear();
  EXPECT_THROW(alignment.estimate(), pcl::PCLException);
}

TEST(CoarseAlignment, FramesOfDifferentRigsAreRefused) {
  CoarseAlignment alignment;
  alignment.addFrame(unposed(around({10, 55}), furnishedRoom()).rig);
  EXPECT_THROW(alignment.addFrame(unposed(around({10}), furnishedRoom()).rig), pcl::BadArgumentException);
}

TEST(CoarseAlignment, AParameterOutOfRangeIsNamed) {
  CoarseAlignment alignment;
  CoarseAlignmentParameters p;
  p.max_ambiguity = 1.5f;
  try {
    alignment.setParameters(p);
    FAIL() << "nothing was thrown";
  } catch (const pcl::BadArgumentException& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("CoarseAlignment"), std::string::npos) << message;
    EXPECT_NE(message.find("max_ambiguity"), std::string::npos) << message;
    EXPECT_NE(message.find("1.5"), std::string::npos) << message;
  }
}

}  // namespace
