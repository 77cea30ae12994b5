#include "../refusal.h"
#include "textured_rig.h"

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <thread>

namespace {

using namespace fuse_flow;
using textured::Errors;
using textured::errorsOf;
using textured::Rig;

StereoFrame estimate(const Rig& rig, const StereoParameters& parameters = {}, unsigned int threads = 0) {
  MultiViewStereo<> stereo;
  stereo.setParameters(parameters);
  stereo.setNumberOfThreads(threads);
  StereoFrame found;
  stereo.estimate(rig.frame, found);
  return found;
}

Rig wallAndBall(int cameras = 4, int width = 128) {
  Rig rig = textured::onArc(cameras, width);
  rig.render(textured::wallAndBall(), textured::noise(0.06));
  return rig;
}

/** \brief What a wrong sign, a wrong row or a transposed rotation misses by far: at 2 m a pixel of the widest baseline, 0.8 m, is some 50 mm of depth. */
void expectFound(const Errors& errors, double unit = 1) {
  EXPECT_GT(errors.found, 0.6);
  EXPECT_LT(errors.median, 0.012 * unit);
  EXPECT_LT(errors.bad, 0.02);
}

bool sameBytes(const StereoFrame& a, const StereoFrame& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() && (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0);
  };
  for (std::size_t k = 0; k < a.views.size(); ++k)
    if (!same(a.views[k].depth, b.views[k].depth) || !same(a.views[k].confidence, b.views[k].confidence) ||
        !same(a.views[k].normals, b.views[k].normals))
      return false;
  return a.views.size() == b.views.size();
}

TEST(MultiViewStereo, FindsAWallAndABall) { expectFound(errorsOf(wallAndBall(), estimate(wallAndBall()))); }

// At 2.4 m a pixel of them is a seventh of the depth, and what they find is good to a quarter of that: two views that say the same are
// farther apart than a hundredth, and what is noise is no edge.
TEST(MultiViewStereo, CamerasBesideEachOtherAreSureOfWhatTheyFind) {
  Rig rig = textured::onArc(2, 160);
  rig.frame.cameras[1] = rig.frame.cameras[0];
  rig.frame.cameras[1].T_world_camera.translate(Eigen::Vector3d(0.12, 0, 0));
  rig.render(textured::wallAndBall(), textured::noise(0.06));
  const StereoFrame found = estimate(rig);
  const double disparity =
      0.12 * static_cast<double>(rig.frame.cameras[0].intrinsics.fx);  // of a metre of depth, pixels
  double right = 0, sure = 0, sure_and_wrong = 0;
  for (std::size_t k = 0; k < 2; ++k)
    for (std::size_t i = 0; i < rig.depth[k].size(); ++i) {
      const double error = disparity * std::abs(1 / static_cast<double>(found.views[k].depth[i]) -
                                                1 / static_cast<double>(rig.depth[k][i]));
      right += error < 0.5 ? 1 : 0;
      if (!(found.views[k].confidence[i] > 0.5f)) continue;
      sure += 1;
      sure_and_wrong += error > 1 ? 1 : 0;
    }
  EXPECT_GT(sure, 0.6 * right);
  EXPECT_LT(sure_and_wrong, 0.03 * sure);
}

// What lies beyond the range is found at its end, by all views alike: by itself the range ends where the images move by two pixels.
TEST(MultiViewStereo, WhatLiesBeyondTheRangeIsNotSure) {
  Rig rig = textured::onArc(2, 160);
  StereoParameters to_before_it;
  to_before_it.max_depth = 1.6f;
  for (const auto& [baseline, parameters] : {std::pair<double, StereoParameters>{0.02, {}}, {0.06, to_before_it}}) {
    rig.frame.cameras[1] = rig.frame.cameras[0];
    rig.frame.cameras[1].T_world_camera.translate(Eigen::Vector3d(baseline, 0, 0));
    rig.render(scenes::plane(Eigen::Vector3d(0, 0, 1), 2.6), textured::noise(0.06));
    const StereoFrame found = estimate(rig, parameters);
    double pixels = 0, sure = 0;
    for (const StereoView& view : found.views)
      for (const float confidence : view.confidence) {
        pixels += 1;
        sure += confidence > 0.5f ? 1 : 0;
      }
    EXPECT_LT(found.views[0].geometry.max_depth, 2) << "the wall is farther";
    EXPECT_GT(found.views[0].depth[80 * 60 + 80], 0) << "it was looked for";
    EXPECT_LT(sure, 0.02 * pixels) << baseline;
  }
}

// Each place is seen by one other view at most: that this one agrees must do, though every view has two sources.
TEST(MultiViewStereo, CamerasThatLookOutwardAreSureWhereTwoOverlap) {
  constexpr int cameras = 8, width = 256;
  Rig rig = textured::onArc(cameras, width);
  for (int k = 0; k < cameras; ++k) {
    Camera& camera = rig.frame.cameras[static_cast<std::size_t>(k)];
    camera.intrinsics.fx = camera.intrinsics.fy = 160;  // 77 degrees: neighbours share 32, second neighbours nothing
    const double angle = k * M_PI / 4;
    const Eigen::Vector3d forward(std::cos(angle), 0, std::sin(angle)), down(0, 1, 0);
    camera.T_world_camera.linear() << down.cross(forward), down, forward;
    camera.T_world_camera.translation() = 0.3 * forward;
  }
  const auto from_inside_a_ball = [](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    const double a = direction.squaredNorm(), b = direction.dot(origin), c = origin.squaredNorm() - 1.5 * 1.5;
    return (std::sqrt(b * b - a * c) - b) / a;
  };
  rig.render(from_inside_a_ball, textured::noise(0.06));
  StereoParameters parameters;
  parameters.min_depth = 0.5f;
  parameters.max_depth = 4;
  const StereoFrame found = estimate(rig, parameters);
  double shared = 0, sure = 0, right = 0, elsewhere = 0, sure_elsewhere = 0;
  for (std::size_t k = 0; k < cameras; ++k) {
    EXPECT_EQ(found.views[k].geometry.sources.size(), 2u);
    for (int v = 30; v < width * 3 / 4 - 30; ++v)
      for (int u = 0; u < width; ++u) {
        const std::size_t place = static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u);
        const double degrees = std::atan(std::abs(u - 0.5 * (width - 1)) / 160) * 180 / M_PI;
        const bool is_sure = found.views[k].confidence[place] > 0.5f;
        if (degrees < 4) {
          elsewhere += 1;
          sure_elsewhere += is_sure ? 1 : 0;
        }
        if (!(degrees > 18 && degrees < 36)) continue;
        const auto truth = static_cast<double>(rig.depth[k][place]);
        shared += 1;
        sure += is_sure ? 1 : 0;
        right += is_sure && std::abs(static_cast<double>(found.views[k].depth[place]) - truth) < 0.05 * truth ? 1 : 0;
      }
  }
  EXPECT_GT(sure, 0.6 * shared);
  EXPECT_GT(right, 0.95 * sure);
  EXPECT_LT(sure_elsewhere, 0.02 * elsewhere);
}

// Two other views see the place, and one of them shows something else: then one that agrees is not enough.
TEST(MultiViewStereo, OneThatAgreesIsNotEnoughWhereTwoCouldSeeThePlace) {
  Rig rig = wallAndBall(3);
  std::uint32_t random = 1;
  for (Rgb8& pixel : rig.images[2]) {
    random = random * 1664525u + 1013904223u;
    pixel.r = pixel.g = pixel.b = static_cast<std::uint8_t>(random >> 24);
  }
  rig.point();
  const StereoFrame found = estimate(rig);
  for (std::size_t k = 0; k < 2; ++k) {
    const Intrinsics& K = rig.frame.cameras[k].intrinsics;
    double pixels = 0, sure = 0, unsure = 0;
    for (int v = K.height / 4; v < 3 * K.height / 4; ++v)
      for (int u = K.width / 4; u < 3 * K.width / 4; ++u) {
        const float confidence =
            found.views[k].confidence[static_cast<std::size_t>(v) * static_cast<std::size_t>(K.width) +
                                      static_cast<std::size_t>(u)];
        pixels += 1;
        sure += confidence > 0.5f ? 1 : 0;
        unsure += confidence > 0.25f ? 1 : 0;
      }
    EXPECT_LT(sure, 0.2 * pixels) << k << ": where the depth of the third agrees by chance, too";
    EXPECT_GT(unsure, 0.3 * pixels) << k << ": the other one does agree";
  }
}

TEST(MultiViewStereo, WhereASurfaceGrewOverItsEdgeItIsDoubtful) {
  // A board before a wall. Beside it the wall is seen, and windows that show the board's edge find the board.
  Rig rig = textured::onArc(4, 160);
  const scenes::Surface wall = scenes::plane(Eigen::Vector3d(0, 0, 1), 2.6);
  const scenes::Surface board = scenes::plane(Eigen::Vector3d(0, 0, 1), 1.6);
  rig.render(
      [&](const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
        const double z = board(from, direction);
        const Eigen::Vector3d p = from + z * direction;
        return std::abs(p.x()) < 0.25 && std::abs(p.y()) < 0.25 ? z : wall(from, direction);
      },
      textured::noise(0.06));
  const StereoFrame found = estimate(rig);
  StereoParameters parameters;
  parameters.edge_step = 0;
  const StereoFrame without = estimate(rig, parameters);
  std::size_t grown = 0, grown_without = 0, on_board = 0, on_board_without = 0, wall_without = 0, wall_and_doubted = 0;
  for (std::size_t k = 0; k < found.views.size(); ++k)
    for (std::size_t i = 0; i < found.views[k].depth.size(); ++i) {
      const float z = found.views[k].depth[i], truth = rig.depth[k][i];
      const float before = without.views[k].confidence[i], now = found.views[k].confidence[i];
      EXPECT_EQ(z, without.views[k].depth[i]) << "only confidence changes";
      EXPECT_TRUE(now == before || now == 0.5f * before);
      if (!(before > 0.5f)) continue;
      const bool sure = now > 0.5f;
      if (truth > 2 && z < 1.8f) {
        ++grown_without;
        grown += sure ? 1 : 0;
      } else if (truth > 2) {
        ++wall_without;
        wall_and_doubted += sure ? 0 : 1;
      } else {
        ++on_board_without;
        on_board += sure ? 1 : 0;
      }
    }
  EXPECT_GT(grown_without, 20u) << "nothing grew: this tests nothing";
  EXPECT_LT(4 * grown, grown_without);
  EXPECT_GT(on_board, on_board_without * 3 / 4) << "all but its edges";
  EXPECT_LT(wall_and_doubted, wall_without / 10) << "what lies behind has no edge there";
}

TEST(MultiViewStereo, WhatLooksAsItsSurfaceIsNotDoubtedBesideItsEdge) {
  // A bright bar of ten pixels, most of them within half a window of an edge, before a dark wall.
  Rig rig = textured::onArc(4, 160);
  const scenes::Surface wall = scenes::plane(Eigen::Vector3d(0, 0, 1), 2.6);
  const scenes::Surface bar = scenes::plane(Eigen::Vector3d(0, 0, 1), 1.6);
  const textured::Texture pattern = textured::noise(0.05);
  const double half = 5 * 1.6 / static_cast<double>(rig.frame.cameras[0].intrinsics.fx);
  rig.render(
      [&](const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
        const double z = bar(from, direction);
        return std::abs((from + z * direction).x()) < half ? z : wall(from, direction);
      },
      [&](const Eigen::Vector3d& p) { return 0.4 * pattern(p) + (p.z() < 2 ? 140 : 0); });
  StereoParameters parameters;
  parameters.repetition_reach = 0;  // here it is about edges
  const StereoFrame found = estimate(rig, parameters);
  std::size_t right = 0, sure = 0, grown = 0, grown_and_sure = 0;
  for (std::size_t k = 0; k < found.views.size(); ++k)
    for (std::size_t i = 0; i < found.views[k].depth.size(); ++i) {
      const float z = found.views[k].depth[i], truth = rig.depth[k][i];
      if (!(found.views[k].confidence[i] > 0.3f && z > 1.4f && z < 1.8f))
        continue;  // of the bar; 0.3: doubted ones, too
      (truth < 2 ? right : grown) += 1;
      (truth < 2 ? sure : grown_and_sure) += found.views[k].confidence[i] > 0.5f ? 1 : 0;
    }
  EXPECT_GT(right, 1000u);
  EXPECT_GT(sure, right * 9 / 10);
  EXPECT_LT(2 * grown_and_sure, grown);
}

/** \brief Stripes, or a chessboard without sharp edges, on a wall: each period looks as the next. */
textured::Texture repeating(double period, bool in_both_directions) {
  return [=](const Eigen::Vector3d& p) {
    const double along = std::sin(2 * M_PI * p.x() / period), across = std::sin(2 * M_PI * p.y() / period);
    return 128 + 90 * along * (in_both_directions ? across : 1);
  };
}

struct Sureness {
  double right{0},
      wrong{0};  ///< shares of the pixels with a confidence over a half, and within 5 % of the depth or not
};

Sureness surenessOf(const Rig& rig, const StereoFrame& found) {
  Sureness result;
  double pixels = 0;
  for (std::size_t k = 0; k < found.views.size(); ++k)
    for (std::size_t i = 0; i < found.views[k].depth.size(); ++i) {
      pixels += 1;
      if (!(found.views[k].confidence[i] > 0.5f)) continue;
      const float truth = rig.depth[k][i];
      (std::abs(found.views[k].depth[i] - truth) < 0.05f * truth ? result.right : result.wrong) += 1;
    }
  result.right /= pixels;
  result.wrong /= pixels;
  return result;
}

TEST(MultiViewStereo, APatternThatRepeatsItselfIsDoubtful) {
  // At 2.4 m a period of 0.1 m is 6 pixels: between neighbours, 8 degrees apart, a third of a metre of depth looks the same.
  for (const bool both : {false, true}) {
    Rig rig = textured::onArc(4, 160);
    rig.render(scenes::plane(Eigen::Vector3d(0, 0, 1), 2.4), repeating(0.1, both));
    StereoParameters parameters;
    parameters.repetition_reach = 0;
    const StereoFrame without = estimate(rig, parameters), found = estimate(rig);
    const double fooled = surenessOf(rig, without).wrong;
    EXPECT_GT(fooled, 0.1) << "nothing is fooled: this tests nothing";
    EXPECT_LT(surenessOf(rig, found).wrong, 0.3 * fooled);
    for (std::size_t k = 0; k < found.views.size(); ++k)
      for (std::size_t i = 0; i < found.views[k].depth.size(); ++i) {
        EXPECT_EQ(found.views[k].depth[i], without.views[k].depth[i]) << "only confidence changes";
        const float before = without.views[k].confidence[i], now = found.views[k].confidence[i];
        EXPECT_TRUE(now == before || now == 0.5f * before);
      }
  }
}

TEST(MultiViewStereo, ARepetitionThatIsFartherThanTheReachIsNotLookedFor) {
  // A period of 18 pixels between neighbours, whose baseline is half of the widest.
  Rig rig = textured::onArc(4, 160);
  rig.render(scenes::plane(Eigen::Vector3d(0, 0, 1), 2.4), repeating(0.3, true));
  StereoParameters parameters;
  const auto doubted = [&](int reach) {
    parameters.repetition_reach = reach;
    return surenessOf(rig, estimate(rig, parameters)).right;
  };
  const double all = doubted(0);
  EXPECT_GT(doubted(8), 0.95 * all);
  EXPECT_LT(doubted(48), 0.3 * all);
}

TEST(MultiViewStereo, WhatDoesNotRepeatItselfIsNotDoubted) {
  StereoParameters parameters;
  parameters.repetition_reach = 0;
  const Rig random = wallAndBall(4, 160);
  EXPECT_GT(surenessOf(random, estimate(random)).right, 0.97 * surenessOf(random, estimate(random, parameters)).right);
  // One smooth hill of brightness for each image: no texture, but no repetition.
  Rig smooth = textured::onArc(4, 160);
  smooth.render(scenes::plane(Eigen::Vector3d(0, 0, 1), 2.4), repeating(4, true));
  EXPECT_GT(surenessOf(smooth, estimate(smooth)).right, 0.97 * surenessOf(smooth, estimate(smooth, parameters)).right);
}

TEST(MultiViewStereo, NormalsAreThoseOfTheSurfaceAndFaceTheCamera) {
  Rig rig = textured::onArc(4);
  const Eigen::Vector3d normal = Eigen::Vector3d(0.5, -0.2, 1).normalized();
  rig.render(scenes::plane(normal, 2), textured::noise(0.06));
  const StereoFrame found = estimate(rig);
  std::vector<double> angles;
  for (const StereoView& view : found.views)
    for (std::size_t k = 0; k < view.depth.size(); ++k) {
      if (!(view.confidence[k] > 0.5f)) continue;
      const Vec3& n = view.normals[k];
      EXPECT_NEAR(squaredNorm(n), 1, 1e-4);
      const double cosine = -normal.dot(Eigen::Vector3d(n.x, n.y, n.z));
      EXPECT_GT(cosine, 0);
      angles.push_back(std::acos(std::min(cosine, 1.0)) * 180 / M_PI);
    }
  ASSERT_GT(angles.size(), 10000u);
  std::nth_element(angles.begin(), angles.begin() + 5000, angles.end());
  std::sort(angles.begin(), angles.end());
  EXPECT_LT(angles[angles.size() / 2], 8);
}

TEST(MultiViewStereo, TheSameBytesForAnyNumberOfThreadsAndOnEveryRun) {
  const Rig rig = wallAndBall(3, 64);
  const StereoFrame once = estimate(rig, {}, 1);
  EXPECT_TRUE(sameBytes(once, estimate(rig, {}, 2)));
  EXPECT_TRUE(sameBytes(once, estimate(rig, {}, 3)));
  // Nothing is kept from another frame.
  Rig other = textured::onArc(3, 64);
  other.render(scenes::plane(Eigen::Vector3d(0, 0, 1), 1.7), textured::noise(0.05));
  MultiViewStereo<> stereo;
  StereoFrame found;
  stereo.estimate(other.frame, found);
  stereo.estimate(rig.frame, found);
  EXPECT_TRUE(sameBytes(once, found));
}

TEST(MultiViewStereo, TheSeedMattersToBytesAlone) {
  const Rig rig = wallAndBall();
  StereoParameters parameters;
  parameters.seed = 7;
  const StereoFrame found = estimate(rig, parameters);
  EXPECT_FALSE(sameBytes(estimate(rig), found));
  expectFound(errorsOf(rig, found));
}

TEST(MultiViewStereo, ARigidMotionOfTheWorldDoesNotMatter) {
  Rig rig = wallAndBall();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.rotate(Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, 3).normalized()));
  T.pretranslate(Eigen::Vector3d(3000, -500, 20));  // where floats have steps of a quarter of a millimetre
  for (Camera& camera : rig.frame.cameras) camera.T_world_camera = T * camera.T_world_camera;
  expectFound(errorsOf(rig, estimate(rig)));
}

TEST(MultiViewStereo, TheUnitOfLengthDoesNotMatter) {
  Rig rig = wallAndBall();
  for (Camera& camera : rig.frame.cameras) camera.T_world_camera.translation() *= 100;
  expectFound(errorsOf(rig, estimate(rig), 100), 100);
}

TEST(MultiViewStereo, TheOrderOfCamerasDoesNotMatter) {
  Rig rig = wallAndBall();
  std::reverse(rig.frame.cameras.begin(), rig.frame.cameras.end());
  std::reverse(rig.images.begin(), rig.images.end());
  std::reverse(rig.depth.begin(), rig.depth.end());
  rig.point();
  expectFound(errorsOf(rig, estimate(rig)));
}

TEST(MultiViewStereo, ExposureOfTheCamerasDoesNotMatter) {
  Rig rig = wallAndBall();
  for (std::size_t k = 0; k < rig.images.size(); ++k)
    for (Rgb8& pixel : rig.images[k]) {
      const double gain = 0.6 + 0.2 * static_cast<double>(k);
      pixel.r = pixel.g = pixel.b =
          static_cast<std::uint8_t>(std::min(255.0, gain * pixel.r + 5.0 * static_cast<double>(k)));
    }
  expectFound(errorsOf(rig, estimate(rig)));
}

TEST(MultiViewStereo, LensesMayDistort) {
  Rig rig = textured::onArc(4);
  for (std::size_t k = 0; k < rig.frame.cameras.size(); ++k) {
    Distortion& d = rig.frame.cameras[k].intrinsics.distortion;
    d.k1 = k % 2 == 0 ? -0.25f : 0.1f;
    d.k2 = 0.05f;
    d.p1 = 0.002f;
  }
  rig.render(textured::wallAndBall(), textured::noise(0.06));
  expectFound(errorsOf(rig, estimate(rig)));
}

TEST(MultiViewStereo, AColourCameraOfItsOwnIsWhereItStands) {
  Rig rig = textured::onArc(4);
  for (Camera& camera : rig.frame.cameras) {
    camera.color.emplace();
    camera.color->intrinsics = camera.intrinsics;
    camera.color->intrinsics.fx *= 1.1f;
    camera.color->intrinsics.fy *= 1.1f;
    camera.color->T_depth_color.translation() = Eigen::Vector3d(0.03, 0.01, 0);
    camera.color->T_depth_color.rotate(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY()));
    camera.intrinsics.width = 16;  // of depth, which there is none of
    camera.intrinsics.height = 12;
  }
  rig.render(textured::wallAndBall(), textured::noise(0.06));
  const StereoFrame found = estimate(rig);
  expectFound(errorsOf(rig, found));
  EXPECT_FALSE(found.rig.cameras[0].color.has_value());
  const Eigen::Isometry3d expected = rig.frame.cameras[1].T_world_camera * rig.frame.cameras[1].color->T_depth_color;
  EXPECT_TRUE(found.rig.cameras[1].T_world_camera.isApprox(expected));
}

TEST(MultiViewStereo, RowsMayHavePadding) {
  Rig rig = wallAndBall(3, 64);
  const StereoFrame packed = estimate(rig);
  std::vector<std::vector<Rgb8>> wide;
  for (std::size_t k = 0; k < rig.images.size(); ++k) {
    wide.emplace_back(70 * 48, Rgb8{255, 0, 255});
    for (std::size_t v = 0; v < 48; ++v)
      std::copy_n(rig.images[k].begin() + static_cast<std::ptrdiff_t>(64 * v), 64,
                  wide[k].begin() + static_cast<std::ptrdiff_t>(70 * v));
    rig.frame.views[k].color = {wide[k].data(), 64, 48, 70 * sizeof(Rgb8)};
  }
  EXPECT_TRUE(sameBytes(packed, estimate(rig)));
}

TEST(MultiViewStereo, WhatIsFoundIsFused) {
  const Rig rig = wallAndBall();
  StereoFrame found = estimate(rig);
  FuseFlow<PointFused> fusion;
  fusion.setParameters(FuseFlowParameters::estimatedDepth());
  pcl::PointCloud<PointFused> cloud;
  fusion.fuse(found.rig, cloud);
  ASSERT_GT(cloud.size(), 3000u);
  std::vector<double> distances;
  const Eigen::Vector3d ball(0.1, -0.05, 1.9), wall(0.2, 0.1, 1);
  for (const PointFused& p : cloud) {
    const Eigen::Vector3d q = p.getVector3fMap().cast<double>();
    distances.push_back(std::min(std::abs((q - ball).norm() - 0.35), std::abs(wall.dot(q) - 2.4) / wall.norm()));
  }
  std::sort(distances.begin(), distances.end());
  EXPECT_LT(distances[distances.size() / 2], 0.006);
  EXPECT_LT(distances[distances.size() * 95 / 100], 0.04);
}

TEST(MultiViewStereo, ResultsCarryTheNoiseOfSuchDepth) {
  const Rig rig = wallAndBall(3, 64);
  const StereoFrame found = estimate(rig);
  for (std::size_t k = 0; k < 3; ++k) {
    const Camera& camera = found.rig.cameras[k];
    ASSERT_TRUE(camera.noise.has_value());
    EXPECT_TRUE(*camera.noise ==
                NoiseModel::stereo(camera.intrinsics.fx, found.views[k].geometry.baseline, kStereoDisparityDeviation));
  }
  // From the first to the last of three cameras, 16° apart on a circle of 2 m.
  EXPECT_NEAR(found.views[0].geometry.baseline, 2 * 2 * std::sin(8 * M_PI / 180), 0.01);
}

TEST(MultiViewStereo, TwoViewsAreEnough) {
  Rig rig = wallAndBall(2);
  const StereoFrame found = estimate(rig);
  const Errors errors = errorsOf(rig, found);
  EXPECT_GT(errors.found, 0.4);
  EXPECT_LT(errors.median, 0.02);
  EXPECT_TRUE(found.views[0].geometry.parallel_baselines);  // there is only one
}

TEST(MultiViewStereo, SaysWithWhomAViewIsMatched) {
  const StereoFrame found = estimate(wallAndBall(4, 64));
  const StereoGeometry& first = found.views[0].geometry;
  EXPECT_EQ(first.sources.size(), 3u);
  EXPECT_NEAR(first.min_angle, 11.7, 0.3);  // 8° along the arc, and 8.5° up
  EXPECT_NEAR(first.max_angle, 25.4, 0.5);
  EXPECT_FALSE(first.parallel_baselines);
  EXPECT_LT(first.min_depth, 1.2f);
  EXPECT_GT(first.max_depth, 4.0f);
  Rig level = textured::onArc(4, 64);
  for (Camera& camera : level.frame.cameras) {
    camera.T_world_camera.translation().y() = 0;
    const Eigen::Vector3d forward = (Eigen::Vector3d(0, 0, 2) - camera.T_world_camera.translation()).normalized();
    const Eigen::Vector3d right = Eigen::Vector3d::UnitY().cross(forward).normalized();
    camera.T_world_camera.linear() << right, forward.cross(right), forward;
  }
  level.render(textured::wallAndBall(), textured::noise(0.06));
  for (const StereoView& view : estimate(level).views) EXPECT_TRUE(view.geometry.parallel_baselines);
}

TEST(MultiViewStereo, ViewsThatDoNotOverlapHaveNoDepth) {
  Rig rig = wallAndBall(3, 64);
  rig.frame.cameras[2].T_world_camera.rotate(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY()));
  const StereoFrame found = estimate(rig);
  EXPECT_TRUE(found.views[2].geometry.sources.empty());
  EXPECT_TRUE(found.rig.views[2].missing());
  EXPECT_FALSE(found.rig.views[0].missing());
}

TEST(MultiViewStereo, AViewWithoutAnImageIsMissing) {
  Rig rig = wallAndBall(4);
  rig.frame.views[1] = {};
  const StereoFrame found = estimate(rig);
  EXPECT_TRUE(found.rig.views[1].missing());
  for (const StereoView& view : found.views)
    for (const std::size_t source : view.geometry.sources) EXPECT_NE(source, 1u);
  rig.depth[1].assign(rig.depth[1].size(), 0);
  const Errors errors = errorsOf(rig, found);
  EXPECT_GT(errors.found, 0.5);
  EXPECT_LT(errors.median, 0.012);
}

TEST(MultiViewStereo, BlackAndWhiteImagesMatchNothing) {
  for (const std::uint8_t level : {std::uint8_t{0}, std::uint8_t{255}}) {
    Rig rig = wallAndBall(3, 64);
    for (auto& image : rig.images) image.assign(image.size(), Rgb8{level, level, level});
    const StereoFrame found = estimate(rig);
    for (const StereoView& view : found.views) EXPECT_EQ(view.agreeing, 0u);
  }
  // One camera whose lens is covered takes nothing from the others.
  Rig rig = wallAndBall(4);
  rig.images[0].assign(rig.images[0].size(), Rgb8{});
  const StereoFrame found = estimate(rig);
  EXPECT_EQ(found.views[0].agreeing, 0u);
  rig.depth[0].assign(rig.depth[0].size(), 0);
  EXPECT_GT(errorsOf(rig, found).found, 0.5);
  EXPECT_LT(errorsOf(rig, found).bad, 0.03);
}

TEST(MultiViewStereo, ARangeThatIsGivenIsKept) {
  const Rig rig = wallAndBall(3, 64);
  StereoParameters parameters;
  parameters.min_depth = 1.4f;
  parameters.max_depth = 2.1f;
  const StereoFrame found = estimate(rig, parameters);
  for (const StereoView& view : found.views)
    for (const float z : view.depth) EXPECT_TRUE(z == 0 || (z > 1.39f && z < 2.11f)) << z;
}

TEST(MultiViewStereo, RefusesWhatContradictsItself) {
  MultiViewStereo<> stereo;
  StereoFrame found;
  Rig rig = wallAndBall(3, 64);
  RigFrame frame = rig.frame;
  frame.views.pop_back();
  refusal::expectThrow([&] { stereo.estimate(frame, found); }, {"MultiViewStereo", "3 cameras", "2 views"});
  frame = rig.frame;
  frame.views[0] = frame.views[1] = {};
  refusal::expectThrow([&] { stereo.estimate(frame, found); }, {"MultiViewStereo", "1 of 3 views", "two or more"});
  frame = rig.frame;
  frame.views[2].color.width = 63;
  refusal::expectThrow([&] { stereo.estimate(frame, found); }, {"arc 2", "63x48", "64x48"});
  const auto refuses = [&](const char* name, auto StereoParameters::*member, auto value) {
    StereoParameters parameters;
    parameters.*member = value;
    refusal::expectThrow([&] { stereo.setParameters(parameters); }, {"MultiViewStereo", name});
  };
  refuses("max_sources", &StereoParameters::max_sources, 0);
  refuses("max_sources", &StereoParameters::max_sources, kMaxStereoSources + 1);
  refuses("best_sources", &StereoParameters::best_sources, 0);
  refuses("levels", &StereoParameters::levels, 0);
  refuses("sweep_step", &StereoParameters::sweep_step, 0.0f);
  refuses("max_planes", &StereoParameters::max_planes, 1);
  refuses("coarse_passes", &StereoParameters::coarse_passes, 0);
  refuses("fine_passes", &StereoParameters::fine_passes, -1);
  refuses("window_spacing", &StereoParameters::window_spacing, 9);
  refuses("level_sigma", &StereoParameters::level_sigma, NAN);
  refuses("min_variance", &StereoParameters::min_variance, 0.0f);
  refuses("geometric_weight", &StereoParameters::geometric_weight, -1.0f);
  refuses("min_incidence", &StereoParameters::min_incidence, 1.0f);
  refuses("edge_step", &StereoParameters::edge_step, -0.01f);
  refuses("edge_step", &StereoParameters::edge_step, 1.0f);
  refuses("repetition_reach", &StereoParameters::repetition_reach, -1);
  refuses("repetition_reach", &StereoParameters::repetition_reach, 257);
  StereoParameters parameters;
  parameters.min_depth = 2;
  parameters.max_depth = 1;
  refusal::expectThrow([&] { stereo.setParameters(parameters); }, {"max_depth", "min_depth"});
}

TEST(MultiViewStereo, AnImageSmallerThanAWindowIsNoError) {
  Rig rig = textured::onArc(3, 8);
  rig.render(textured::wallAndBall(), textured::noise(0.06));
  const StereoFrame found = estimate(rig);
  EXPECT_EQ(found.views[0].depth.size(), 48u);
}

}  // namespace
