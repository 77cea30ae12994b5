#include "../scenes.h"

#include <fuse_flow/filters/depth_backprojection.h>
#include <fuse_flow/quality/reprojection_quality.h>

// Cameras whose lenses bend: a barrel, which pulls the image's corners in, and the rational model of a depth camera.

namespace {

using Eigen::Vector2d;
using fuse_flow::Camera;
using fuse_flow::FuseFlowParameters;
using fuse_flow::Intrinsics;
using scenes::Cloud;
using scenes::Scene;
using scenes::Vector3d;

constexpr double kMicrometre = 1e-6;

Intrinsics barrelLens() {
  Intrinsics K{160, 120, 150, 150, 80.3f, 59.1f, {}};
  K.distortion = {-0.28f, 0.07f, 4e-4f, -3e-4f, 0, 0, 0, 0};
  return K;
}

/** \brief That of an Azure Kinect's narrow mode, at a quarter of its size. */
Intrinsics rationalLens() {
  Intrinsics K{160, 144, 126.1f, 126.1f, 80.2f, 82.6f, {}};
  K.distortion = {5.2025f, 3.7001f, 1.02e-5f, -6.9e-5f, 0.2024f, 5.5320f, 5.4433f, 1.0286f};
  return K;
}

/** \brief By how much the radial terms stretch a ray of radius r. */
double stretch(const fuse_flow::Distortion& lens, double r) {
  const auto k = [](float coefficient) { return static_cast<double>(coefficient); };
  const double r2 = r * r, r4 = r2 * r2, r6 = r4 * r2;
  return (1 + k(lens.k1) * r2 + k(lens.k2) * r4 + k(lens.k3) * r6) /
         (1 + k(lens.k4) * r2 + k(lens.k5) * r4 + k(lens.k6) * r6);
}

/** \brief What p1 and p2 add to a ray. */
Vector2d tangential(const fuse_flow::Distortion& lens, const Vector2d& p) {
  const auto p1 = static_cast<double>(lens.p1), p2 = static_cast<double>(lens.p2);
  const double r2 = p.squaredNorm(), xy = p.x() * p.y();
  return {2 * p1 * xy + p2 * (r2 + 2 * p.x() * p.x()), p1 * (r2 + 2 * p.y() * p.y()) + 2 * p2 * xy};
}

/** \brief Where a camera sees a ray, pixels. */
Vector2d pixelOf(const Intrinsics& K, const Vector2d& ray) {
  const Vector2d bent = stretch(K.distortion, ray.norm()) * ray + tangential(K.distortion, ray);
  return {static_cast<double>(K.fx) * bent.x() + static_cast<double>(K.cx),
          static_cast<double>(K.fy) * bent.y() + static_cast<double>(K.cy)};
}

/** \brief The ray of a pixel: its radius by bisection, with the tangential terms, which are small, at the ray found before. */
Vector2d rayOf(const Intrinsics& K, int u, int v) {
  const Vector2d bent((u - static_cast<double>(K.cx)) / static_cast<double>(K.fx),
                      (v - static_cast<double>(K.cy)) / static_cast<double>(K.fy));
  Vector2d ray = bent;
  for (int repetition = 0; repetition < 3; ++repetition) {
    const Vector2d radial = bent - tangential(K.distortion, ray);
    double low = 0, high = 2;
    for (int k = 0; k < 40; ++k) {
      const double middle = 0.5 * (low + high);
      (middle * stretch(K.distortion, middle) < radial.norm() ? low : high) = middle;
    }
    ray = radial.normalized() * low;
  }
  return ray;
}

const Vector3d kWallNormal = Vector3d(0.2, -0.1, 1).normalized();
constexpr double kWallOffset = 1.5;

double offTheWall(const Vector3d& p) { return std::abs(kWallNormal.dot(p) - kWallOffset); }

template <typename P>
Vector3d position(const P& point) {
  return point.getVector3fMap().template cast<double>();
}

/** \brief Depth along a ray of the camera, metres, and where that is in the world. */
struct Seen {
  double depth;
  Vector3d position;
};

/** \brief What every pixel of a camera sees of the wall. */
std::vector<Seen> look(const Camera& camera) {
  const scenes::Surface wall = scenes::plane(kWallNormal, kWallOffset);
  std::vector<Seen> pixels;
  for (int v = 0; v < camera.intrinsics.height; ++v)
    for (int u = 0; u < camera.intrinsics.width; ++u) {
      const Vector3d eye = camera.T_world_camera.translation();
      const Vector3d direction = camera.T_world_camera.linear() * rayOf(camera.intrinsics, u, v).homogeneous();
      const double depth = wall(eye, direction);
      pixels.push_back({depth, eye + depth * direction});
    }
  return pixels;
}

/** \brief Two cameras, each with a lens of its own, on an inclined wall. */
class DistortedRig : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    cameras_ = {scenes::lookAt({-0.2, 0.03, 0}, {0, 0, 1.5}), scenes::lookAt({0.25, -0.06, 0}, {0, 0, 1.5})};
    cameras_[0].intrinsics = barrelLens();
    cameras_[1].intrinsics = rationalLens();
    seen_ = {look(cameras_[0]), look(cameras_[1])};
  }
  static void TearDownTestSuite() {
    cameras_.clear();
    seen_.clear();
  }

  DistortedRig() {
    scene_.rig.cameras = cameras_;
    for (std::size_t camera = 0; camera < 2; ++camera) {
      const Intrinsics& K = cameras_[camera].intrinsics;
      scene_.depth.push_back(scenes::uniform(K.width, K.height, 0));
      for (std::size_t k = 0; k < seen_[camera].size(); ++k)
        scene_.depth[camera].data[k] = static_cast<float>(seen_[camera][k].depth);
    }
    scene_.attach();
    every_pixel_.use_spatial_hash = every_pixel_.use_distance_consistency = every_pixel_.use_measurement_confidence =
        false;
    every_pixel_.smoothing.passes = 0;
    only_consistency_.use_measurement_confidence = false;  // ω is V
    only_consistency_.half_weight_noise = 0;
    only_consistency_.smoothing.passes = 0;
    only_consistency_.aggregation.min_cell_size =
        only_consistency_.aggregation.cell_size;  // many cells of both cameras
  }

  /** \brief The same images, as if the lenses were ideal. */
  fuse_flow::RigFrame withoutDistortion() const {
    fuse_flow::RigFrame rig = scene_.rig;
    for (Camera& camera : rig.cameras) camera.intrinsics.distortion = {};
    return rig;
  }

  /** \brief What one camera measured. */
  Cloud backProjected(const fuse_flow::RigFrame& rig, std::size_t camera) const {
    fuse_flow::DepthBackprojection<fuse_flow::PointFused> filter;
    filter.setCamera(rig.cameras[camera]);
    filter.setView(rig.views[camera]);
    Cloud cloud;
    filter.filter(cloud);
    return cloud;
  }

  static inline std::vector<Camera> cameras_;
  static inline std::vector<std::vector<Seen>> seen_;  ///< camera by camera, pixel by pixel
  Scene scene_;
  FuseFlowParameters every_pixel_, only_consistency_;
};

TEST_F(DistortedRig, BackprojectionPutsEveryPixelWhereItsRayMeetsTheWall) {
  for (std::size_t camera = 0; camera < 2; ++camera) {
    const Cloud cloud = backProjected(scene_.rig, camera);
    ASSERT_EQ(cloud.size(), seen_[camera].size());
    for (std::size_t k = 0; k < cloud.size(); ++k)
      ASSERT_LT((position(cloud[k]) - seen_[camera][k].position).norm(), 3 * kMicrometre) << camera << ", " << k;
    const Cloud bent = backProjected(withoutDistortion(), camera);
    EXPECT_GT((position(bent[0]) - seen_[camera][0].position).norm(), 0.1);  // in the corner
  }
}

TEST_F(DistortedRig, FusionPointByPointPutsEveryPixelWhereItsRayMeetsTheWall) {
  const Cloud cloud = scenes::fuse(scene_.rig, every_pixel_);
  ASSERT_EQ(cloud.size(), seen_[0].size() + seen_[1].size());
  std::size_t next = 0;
  for (const std::vector<Seen>& pixels : seen_)
    for (const Seen& seen : pixels)
      ASSERT_LT((position(cloud[next++]) - seen.position).norm(), 3 * kMicrometre) << next;
}

TEST_F(DistortedRig, FusedPointsLieOnTheWallAndTheCamerasAgreeAboutThem) {
  double sum_V = 0;
  std::size_t of_both = 0;
  const Cloud cloud = scenes::fuse(scene_.rig, only_consistency_);
  for (const auto& point : cloud) {
    ASSERT_LT(offTheWall(position(point)), 3 * kMicrometre);
    // Where the rational lens stretches pixels to 34 mm, half of one is 7 mm in depth: V > exp(−(7/20)²).
    ASSERT_GT(point.confidence, 0.88f);
    sum_V += static_cast<double>(point.confidence);
    of_both += point.view_count == 2 ? 1 : 0;
  }
  EXPECT_GT(sum_V / static_cast<double>(cloud.size()), 0.99);
  EXPECT_GT(of_both, cloud.size() / 3);
}

TEST_F(DistortedRig, FusedPointsWouldLieBesideTheWallAndTheCamerasDisagreeIfTheLensesWereTakenForIdeal) {
  double sum_V = 0;
  std::size_t off = 0;
  const Cloud cloud = scenes::fuse(withoutDistortion(), only_consistency_);
  for (const auto& point : cloud) {
    sum_V += static_cast<double>(point.confidence);
    off += offTheWall(position(point)) > 0.002 ? 1 : 0;
  }
  EXPECT_LT(sum_V / static_cast<double>(cloud.size()), 0.97);
  EXPECT_GT(off, cloud.size() / 2);
}

TEST_F(DistortedRig, TheQualityMeasureFindsEachPointOfACameraInItsOwnPixel) {
  for (std::size_t camera = 0; camera < 2; ++camera) {
    Cloud cloud;
    for (const Seen& seen : seen_[camera]) {
      cloud.emplace_back();
      cloud.back().getVector3fMap() = seen.position.cast<float>();
    }
    fuse_flow::RigFrame alone = scene_.rig;
    alone.views[1 - camera] = {};
    const fuse_flow::ReprojectionQuality quality = reprojectionQuality(cloud, alone);
    EXPECT_EQ(quality.seen_points, cloud.size());
    EXPECT_LT(quality.error, kMicrometre);
    EXPECT_EQ(quality.covered_pixels, quality.pixels);
    alone.cameras[camera].intrinsics.distortion = {};
    EXPECT_GT(reprojectionQuality(cloud, alone).error, 0.001);
  }
}

TEST_F(DistortedRig, TheQualityMeasureFindsThatTheCamerasAgreeToWithinHalfAPixelOfTheWall) {
  for (std::size_t camera = 0; camera < 2; ++camera) {
    const Cloud cloud = backProjected(scene_.rig, camera);
    const fuse_flow::ReprojectionQuality quality = reprojectionQuality(cloud, scene_.rig);
    EXPECT_GT(quality.multi_view_points, cloud.size() / 2);
    EXPECT_LT(quality.multi_view_error, 0.001);  // on average a quarter of a pixel
    EXPECT_EQ(quality.violating_points, 0u);
    const Cloud bent = backProjected(withoutDistortion(), camera);
    EXPECT_GT(reprojectionQuality(bent, withoutDistortion()).multi_view_error, 0.003);
  }
}

TEST_F(DistortedRig, WhatIsFarOutsideTheFieldOfViewIsNotFoldedBackIntoTheImage) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 20, 15, 40), {1.0f});
  scene.rig.cameras[0].intrinsics.distortion.k1 = -0.25f;  // r − r³/4 is 0 at r = 2: beside the camera is in the middle
  pcl::PointCloud<pcl::PointXYZ> cloud;
  cloud.push_back({2, 0, 1});
  cloud.push_back({1, 0, 0.5f});
  cloud.push_back({0, 0, 1});
  const fuse_flow::ReprojectionQuality quality = reprojectionQuality(cloud, scene.rig);
  EXPECT_EQ(quality.seen_points, 1u);
  EXPECT_EQ(quality.violating_points, 0u);
}

TEST_F(DistortedRig, AColourCameraSeesThroughItsOwnLens) {
  // Columns in red and rows in green, so that a colour says which pixel it comes from.
  Camera& camera = scene_.rig.cameras[1];
  camera.color.emplace();
  camera.color->intrinsics = barrelLens();
  camera.color->T_depth_color.translation() << 0.05, -0.02, 0.01;
  std::vector<fuse_flow::Rgb8> image;
  for (int v = 0; v < 120; ++v)
    for (int u = 0; u < 160; ++u) image.push_back({static_cast<std::uint8_t>(u), static_cast<std::uint8_t>(v), 0});
  scene_.rig.views[1].color = {image.data(), 160, 120};
  const Eigen::Isometry3d T_color_world = (camera.T_world_camera * camera.color->T_depth_color).inverse();
  const Cloud filtered = backProjected(scene_.rig, 1), fused = scenes::fuse(scene_.rig, every_pixel_);
  const std::size_t first = seen_[0].size();  // of the second camera
  std::size_t inside = 0;
  for (std::size_t k = 0; k < filtered.size(); ++k) {
    const Vector2d pixel = pixelOf(barrelLens(), (T_color_world * seen_[1][k].position).hnormalized());
    if (pixel.x() < 0 || pixel.x() > 159 || pixel.y() < 0 || pixel.y() > 119) continue;
    ++inside;
    for (const auto& point : {filtered[k], fused[first + k]}) {
      ASSERT_NEAR(point.r, pixel.x(), 0.501) << k;
      ASSERT_NEAR(point.g, pixel.y(), 0.501) << k;
    }
  }
  EXPECT_GT(inside, 5000u);
}

}  // namespace
