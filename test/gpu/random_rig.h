#pragma once

/** \file
 *  \brief Rigs, images and parameters drawn at random, the same from the same seed everywhere. */

#include <fuse_flow/fuse_flow.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace random_rig {

class Random {
 public:
  explicit Random(unsigned int seed) : engine_(seed) {}
  /** \brief The first numbers are those of a fuzzer's input, two bytes each; then as from the seed 1. \param bytes must stay */
  explicit Random(std::string_view bytes) : engine_(1), bytes_(bytes) {}
  double uniform(double low, double high) { return low + (high - low) * (next() >> 8) * 0x1p-24; }
  float uniform(float low, float high) {
    return static_cast<float>(uniform(static_cast<double>(low), static_cast<double>(high)));
  }
  int below(int n) { return static_cast<int>(next() % static_cast<unsigned int>(n)); }
  bool oneIn(int n) { return below(n) == 0; }

 private:
  std::uint32_t next() {
    if (bytes_.size() < 2) return static_cast<std::uint32_t>(engine_());
    const auto low = static_cast<std::uint8_t>(bytes_[0]), high = static_cast<std::uint8_t>(bytes_[1]);
    bytes_.remove_prefix(2);
    return (std::uint32_t{high} << 24 | std::uint32_t{low} << 16) + std::uint32_t{low} * 257u + high;
  }

  std::mt19937 engine_;
  std::string_view bytes_;
};

/** \brief A frame with the memory behind it; filled again and again. */
class RandomFrame {
 public:
  fuse_flow::RigFrame rig;

  /** \brief Up to max_cameras in front of a rough wall; scale: metres from camera to wall. */
  void draw(Random& random, int max_cameras = 6, int max_side = 40, double scale = 1.5) {
    const int n = 1 + random.below(max_cameras);
    rig.cameras.assign(static_cast<std::size_t>(n), {});
    rig.views.assign(static_cast<std::size_t>(n), {});
    images_.assign(static_cast<std::size_t>(n), {});
    rig.stamp = static_cast<std::uint64_t>(random.below(1 << 30));
    for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
      drawCamera(random, rig.cameras[i], max_side, scale);
      rig.cameras[i].name = "camera " + std::to_string(i);
      drawImages(random, i, scale);
    }
  }

  /** \brief Of every view that is there and has none. */
  void giveConfidence(Random& random) {
    for (std::size_t i = 0; i < rig.views.size(); ++i)
      if (fuse_flow::DepthView& view = rig.views[i]; !view.missing() && !view.confidence)
        drawConfidence(random, view.width(), view.height(), images_[i], view);
  }

 private:
  struct Images {
    std::vector<std::uint16_t> depth16;
    std::vector<float> depth32, confidence;
    std::vector<fuse_flow::Rgb8> color;
  };

  static void drawCamera(Random& random, fuse_flow::Camera& camera, int max_side, double scale) {
    fuse_flow::Intrinsics& K = camera.intrinsics;
    if (random.oneIn(10)) camera.depth_scale = random.oneIn(2) ? 1.0f : 1e-5f;  // not that of its images
    K.width = 1 + random.below(max_side);
    K.height = 1 + random.below(max_side);
    K.fx = random.uniform(0.8f, 1.6f) * static_cast<float>(max_side);
    K.fy = random.uniform(0.8f, 1.6f) * static_cast<float>(max_side);
    K.cx = random.uniform(0.4f, 0.6f) * static_cast<float>(K.width);
    K.cy = random.uniform(0.4f, 0.6f) * static_cast<float>(K.height);
    if (random.oneIn(3)) {
      K.distortion.k1 = random.uniform(-0.1f, 0.1f);
      K.distortion.k2 = random.uniform(-0.02f, 0.02f);
      K.distortion.p1 = random.uniform(-0.01f, 0.01f);
    }
    if (random.oneIn(5)) {
      camera.color.emplace();
      camera.color->intrinsics = K;
      camera.color->intrinsics.width = 1 + random.below(max_side);
      camera.color->intrinsics.height = 1 + random.below(max_side);
      camera.color->T_depth_color.translation().x() = random.uniform(-0.05, 0.05);
    }
    if (random.oneIn(4)) drawCorrection(random, camera.depth_correction, scale);
    if (random.oneIn(4)) camera.multipath = {random.uniform(20e6f, 300e6f), random.uniform(0.1f, 1.0f)};
    if (random.oneIn(3))
      camera.noise = fuse_flow::NoiseModel{random.uniform(0.0002f, 0.005f), random.uniform(0.0f, 0.003f),
                                           random.uniform(0.0002f, 0.005f)};
    camera.T_world_camera.linear() = (Eigen::AngleAxisd(random.uniform(-0.2, 0.2), Eigen::Vector3d::UnitX()) *
                                      Eigen::AngleAxisd(random.uniform(-0.2, 0.2), Eigen::Vector3d::UnitY()))
                                         .toRotationMatrix();
    camera.T_world_camera.translation() << random.uniform(-0.3, 0.3) * scale, random.uniform(-0.3, 0.3) * scale,
        random.uniform(-0.15, 0.15) * scale;
  }

  static void drawCorrection(Random& random, fuse_flow::DepthCorrection& correction, double scale) {
    correction = {2 + random.below(4), 2 + random.below(4), {}, {}};
    const float most = 0.02f, per_metre = std::min(0.4f, most / static_cast<float>(scale));
    for (int k = 0; k < correction.columns * correction.rows; ++k) {
      correction.relative.push_back(random.uniform(-most, most));
      correction.per_metre.push_back(random.uniform(-per_metre, per_metre));
    }
  }

  void drawImages(Random& random, std::size_t i, double scale) {
    if (random.oneIn(12)) return;  // a missing camera
    const fuse_flow::Camera& camera = rig.cameras[i];
    const int w = camera.intrinsics.width, h = camera.intrinsics.height;
    Images& images = images_[i];
    const bool integers = !random.oneIn(4) && scale > 0.05 && scale < 30;
    const double along_u = random.uniform(-0.2, 0.2) * scale, along_v = random.uniform(-0.2, 0.2) * scale;
    for (int v = 0; v < h; ++v)
      for (int u = 0; u < w; ++u) {
        double z = scale + along_u * u / w + along_v * v / h + random.uniform(-0.003, 0.003) * scale;
        if (random.oneIn(30)) z = 0;
        if (random.oneIn(40)) z *= random.uniform(0.5, 1.5);
        if (integers) {
          images.depth16.push_back(static_cast<std::uint16_t>(z * 1000));
        } else {
          images.depth32.push_back(random.oneIn(200) ? std::nanf("") : static_cast<float>(z));
        }
      }
    fuse_flow::DepthView& view = rig.views[i];
    if (integers) {
      view.depth16 = {images.depth16.data(), w, h};
    } else {
      view.depth32 = {images.depth32.data(), w, h};
    }
    if (!random.oneIn(6)) drawColor(random, camera, images, view);
    if (random.oneIn(4)) drawConfidence(random, w, h, images, view);
  }

  static void drawColor(Random& random, const fuse_flow::Camera& camera, Images& images, fuse_flow::DepthView& view) {
    const fuse_flow::Intrinsics& K = camera.color ? camera.color->intrinsics : camera.intrinsics;
    for (int k = 0; k < K.width * K.height; ++k)
      images.color.push_back({static_cast<std::uint8_t>(random.below(256)),
                              static_cast<std::uint8_t>(random.below(256)),
                              static_cast<std::uint8_t>(random.below(256))});
    view.color = {images.color.data(), K.width, K.height};
  }

  static void drawConfidence(Random& random, int w, int h, Images& images, fuse_flow::DepthView& view) {
    for (int k = 0; k < w * h; ++k)
      images.confidence.push_back(random.oneIn(50) ? std::nanf("") : random.uniform(-0.1f, 1.2f));
    view.confidence = {images.confidence.data(), w, h};
  }

  std::vector<Images> images_;
};

/** \brief Every switch of the ablation, every form, and numbers from all of their useful ranges. \param cameras of the rig, which other views
 *  are asked of */
inline fuse_flow::FuseFlowParameters parameters(Random& random, double scale = 1.5, int cameras = 1) {
  using namespace fuse_flow;
  FuseFlowParameters p = random.oneIn(2) ? FuseFlowParameters() : FuseFlowParameters::published();
  p.use_measurement_confidence = !random.oneIn(5);
  p.use_distance_consistency = !random.oneIn(5);
  p.use_spatial_hash = !random.oneIn(5);
  if (random.oneIn(3)) p.preprocessing.fill_neighbours = 3 + random.below(6);
  if (random.oneIn(4)) {
    p.preprocessing.min_range = static_cast<float>(0.9 * scale);
    p.preprocessing.max_range = static_cast<float>(1.2 * scale);
  }
  if (random.oneIn(6)) {
    p.preprocessing.bilateral = true;
    p.preprocessing.bilateral_sigma_s = random.uniform(0.7f, 6.0f);
    p.preprocessing.bilateral_sigma_r = random.uniform(0.01f, 0.2f) * static_cast<float>(scale);
  }
  p.smoothing.passes = random.below(kMaxSmoothingPasses + 1);
  p.smoothing.tolerance = random.uniform(1.0f, 4.0f);
  p.smoothing.shrink = random.uniform(0.4f, 1.0f);
  p.smoothing.wide_above = random.uniform(0.2f, 3.0f);
  p.smoothing.twicing = random.below(3) > 0;
  p.smoothing.twicing_above = random.below(3) > 0 ? random.uniform(0.02f, 1.0f) : 0.0f;
  p.adapt_noise = !random.oneIn(3);
  p.half_weight_noise = random.oneIn(3) ? 0.0f : random.uniform(0.002f, 0.1f);
  p.gate_noise = random.oneIn(3) ? 0.0f : random.uniform(0.002f, 0.05f);
  p.max_noise =
      random.oneIn(2) ? 0.0f : random.uniform(0.5f, 3.0f) * axialNoise(p.confidence.noise, static_cast<float>(scale));
  p.min_support = random.below(9);
  p.min_confidence = random.oneIn(2) ? 0.0f : random.uniform(0.0f, 1.0f);
  p.confidence.form = random.oneIn(2) ? ConfidenceForm::Published : ConfidenceForm::SlopeCompensated;
  p.confidence.threshold = random.oneIn(3) ? random.uniform(0.0f, 0.7f) : p.confidence.threshold;
  p.agreement.min_views = random.oneIn(2) ? 0 : random.below(std::min(cameras, 4));
  p.agreement.pixels = random.uniform(0.3f, 4.0f);
  p.agreement.relative = random.uniform(0.003f, 0.1f);
  p.consistency.weigh_contradictions = random.oneIn(2);
  p.consistency.occlusion = random.oneIn(2) ? OcclusionForm::Published : OcclusionForm::OcclusionAware;
  p.consistency.distance = random.oneIn(2) ? DistanceForm::Euclidean : DistanceForm::AlongRay;
  p.consistency.min_facing = random.oneIn(4) ? -1.0f : random.uniform(-1.0f, 0.5f);
  p.consistency.silhouette_radius = random.below(5);
  p.consistency.max_views = 2 + random.below(6);
  p.consistency.max_candidates = p.consistency.max_views - 1 + random.below(4);
  p.consistency.sigma_per_noise = random.oneIn(2) ? 0.0f : random.uniform(0.5f, 20.0f);
  p.aggregation.cell_size = random.uniform(0.02f, 0.09f) * static_cast<float>(scale);
  p.aggregation.min_cell_size = p.aggregation.cell_size / random.uniform(1.0f, 20.0f);
  p.aggregation.points_per_cell = random.uniform(0.5f, 5.0f);
  p.aggregation.representatives = static_cast<Representatives>(random.below(3));
  p.aggregation.consistency_at = static_cast<ConsistencyAt>(random.below(2));
  p.aggregation.min_weight = random.oneIn(2) ? 0.0f : random.uniform(0.0f, 0.3f);
  p.aggregation.weak_weight = random.oneIn(3) ? 0.0f : random.uniform(0.0f, 0.8f);
  p.aggregation.confirmation_reach = random.oneIn(3) ? 0.0f : random.uniform(0.002f, 0.05f) * static_cast<float>(scale);
  p.aggregation.reach_per_noise = random.oneIn(3) ? 0.0f : random.uniform(0.0f, 20.0f);
  if (random.oneIn(5)) {
    const auto half = static_cast<float>(0.3 * scale);
    p.crop_box = Eigen::AlignedBox3f(Eigen::Vector3f(-half, -half, 0), Eigen::Vector3f(half, half, 4 * half));
  }
  return p;
}

}  // namespace random_rig
