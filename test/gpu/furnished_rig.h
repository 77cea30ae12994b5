#pragma once

/** \file
 *  \brief Cameras around a room with random spheres in it, a scene that determines poses. */

#include "random_rig.h"

#include <fuse_flow/rig_frame.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace furnished_rig {

using random_rig::Random;
using Poses = std::vector<Eigen::Isometry3d>;

struct Options {
  int cameras{4};
  int width{160}, height{120};
  bool integers{true};  ///< depth16, else depth32
  bool color{true};
  bool distortion{false};
  bool color_camera{false};  ///< of its own
  bool plane_only{false};    ///< cameras side by side before one wall
  double noise{0.002};       ///< standard deviation of depth, metres
};

/** \brief A frame with the memory behind it. */
class FurnishedRig {
 public:
  fuse_flow::RigFrame rig;

  FurnishedRig(Random& random, const Options& options) : options_(options) {
    for (int k = 0; k < 4; ++k)
      spheres_.push_back(
          {random.uniform(-1.0, 1.0), random.uniform(-0.8, 0.8), random.uniform(0.2, 1.6), random.uniform(0.2, 0.5)});
    const double turn = random.uniform(0.0, 6.28);
    for (int i = 0; i < options.cameras; ++i) addCamera(random, i, turn);
    measure(random);
  }
  FurnishedRig(const FurnishedRig&) = delete;

  /** \brief Another instant: new noise. */
  void measure(Random& random) {
    rig.views.assign(rig.cameras.size(), {});
    images_.assign(rig.cameras.size(), {});
    for (std::size_t i = 0; i < rig.cameras.size(); ++i) render(random, i);
  }

  /** \brief Every other camera a model of its own, each of another shape. */
  void giveNoise() {
    for (std::size_t i = 0; i < rig.cameras.size(); i += 2) {
      const auto k = static_cast<float>(i + 1);
      rig.cameras[i].noise = fuse_flow::NoiseModel{0.002f / k, 0.0003f * k, 0.0004f * k};
    }
  }

  Poses poses() const {
    Poses result;
    for (const fuse_flow::Camera& camera : rig.cameras) result.push_back(camera.T_world_camera);
    return result;
  }
  /** \brief All cameras but the first up to so far off, metres and radians. */
  Poses disturbed(Random& random, double metres = 0.02, double radians = 0.0175) const {
    Poses result = poses();
    for (std::size_t i = 1; i < result.size(); ++i) {
      result[i].pretranslate(metres * direction(random));
      result[i].rotate(Eigen::AngleAxisd(radians, direction(random)));
    }
    return result;
  }

 private:
  struct Images {
    std::vector<std::uint16_t> depth16;
    std::vector<float> depth32;
    std::vector<fuse_flow::Rgb8> color;
  };

  static Eigen::Vector3d direction(Random& random) {
    return Eigen::Vector3d(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0) + 1e-3)
        .normalized();
  }

  void addCamera(Random& random, int i, double turn) {
    fuse_flow::Camera camera;
    camera.name = "camera " + std::to_string(i);
    fuse_flow::Intrinsics& K = camera.intrinsics;
    K.width = options_.width;
    K.height = options_.height;
    K.fx = K.fy = random.uniform(0.8f, 1.0f) * static_cast<float>(K.width);
    K.cx = 0.5f * static_cast<float>(K.width - 1);
    K.cy = 0.5f * static_cast<float>(K.height - 1);
    if (options_.distortion) {
      K.distortion.k1 = random.uniform(-0.1f, 0.1f);
      K.distortion.p1 = random.uniform(-0.01f, 0.01f);
      camera.multipath.modulation_frequency = 200e6f;
      camera.depth_correction = {2, 2, {}, {}};
      for (int k = 0; k < 4; ++k) {
        camera.depth_correction.relative.push_back(random.uniform(-1e-3f, 1e-3f));
        camera.depth_correction.per_metre.push_back(random.uniform(-1e-3f, 1e-3f));
      }
    }
    if (options_.color_camera) {
      camera.color.emplace();
      camera.color->intrinsics = K;
      camera.color->intrinsics.width += 20;
      camera.color->intrinsics.cx += 10;
      camera.color->T_depth_color.translation().x() = 0.03;
    }
    const double angle = turn + 0.55 * i;
    const Eigen::Vector3d eye =
        options_.plane_only ? Eigen::Vector3d(0.25 * i, 0.1 * (i % 2), 1.4)
                            : Eigen::Vector3d(2.3 * std::cos(angle), 2.0 * std::sin(angle), random.uniform(1.1, 1.9));
    const Eigen::Vector3d target = options_.plane_only
                                       ? Eigen::Vector3d(0.3, 2.4, 1.5)
                                       : Eigen::Vector3d(-0.4 * std::cos(angle), -0.4 * std::sin(angle), 0.9);
    const Eigen::Vector3d forward = (target - eye).normalized();
    const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
    camera.T_world_camera.linear() << right, forward.cross(right), forward;
    camera.T_world_camera.translation() = eye;
    rig.cameras.push_back(camera);
  }

  /** \brief Distance along a ray to the nearest surface, of 6 × 5 × 3 m and the spheres, or of one wall. */
  double cast(const double (&o)[3], const double (&d)[3]) const {
    if (options_.plane_only) return d[1] > 0 ? (2.4 - o[1]) / d[1] : 0;
    const double low[3] = {-3, -2.5, 0}, high[3] = {3, 2.5, 3};
    double nearest = 1e9;
    for (int axis = 0; axis < 3; ++axis)
      if (d[axis] != 0) nearest = std::min(nearest, ((d[axis] > 0 ? high : low)[axis] - o[axis]) / d[axis]);
    for (const auto& s : spheres_) {
      const double x = o[0] - s[0], y = o[1] - s[1], z = o[2] - s[2];
      const double a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2], b = d[0] * x + d[1] * y + d[2] * z;
      const double discriminant = b * b - a * (x * x + y * y + z * z - s[3] * s[3]);
      if (discriminant > 0 && -b > std::sqrt(discriminant))
        nearest = std::min(nearest, (-b - std::sqrt(discriminant)) / a);
    }
    return nearest;
  }

  void render(Random& random, std::size_t i) {
    const fuse_flow::Camera& camera = rig.cameras[i];
    const fuse_flow::Intrinsics& K = camera.intrinsics;
    Images& images = images_[i];
    const Eigen::Isometry3d& T = camera.T_world_camera;
    const double o[3] = {T(0, 3), T(1, 3), T(2, 3)};
    const int color_width = camera.color ? camera.color->intrinsics.width : K.width;
    for (int v = 0; v < K.height; ++v)
      for (int u = 0; u < K.width; ++u) {
        const fuse_flow::Ray ray = fuse_flow::unproject(K, {static_cast<float>(u), static_cast<float>(v)});
        const double x = static_cast<double>(ray.x), y = static_cast<double>(ray.y);
        double d[3];
        for (int k = 0; k < 3; ++k) d[k] = T(k, 0) * x + T(k, 1) * y + T(k, 2);
        const double z = cast(o, d);
        const double noise = random.uniform(-1.0, 1.0) + random.uniform(-1.0, 1.0) + random.uniform(-1.0, 1.0);
        const double measured = random.oneIn(60) ? 0 : z + options_.noise * noise;
        if (options_.integers) {
          images.depth16.push_back(static_cast<std::uint16_t>(1000 * measured + 0.5));
        } else {
          images.depth32.push_back(random.oneIn(200) ? std::nanf("") : static_cast<float>(measured));
        }
        const auto channel = [&](int k, double often) {
          return static_cast<std::uint8_t>(127.5 + 100 * std::sin(often * (o[k] + z * d[k])));
        };
        images.color.push_back({channel(0, 7), channel(1, 5), channel(2, 6)});
        if (u + 1 == K.width)
          images.color.insert(images.color.end(), static_cast<std::size_t>(color_width - K.width), {});
      }
    fuse_flow::DepthView& view = rig.views[i];
    if (options_.integers) {
      view.depth16 = {images.depth16.data(), K.width, K.height};
    } else {
      view.depth32 = {images.depth32.data(), K.width, K.height};
    }
    if (options_.color) view.color = {images.color.data(), color_width, K.height};
  }

  Options options_;
  std::vector<std::array<double, 4>> spheres_;
  std::vector<Images> images_;
};

}  // namespace furnished_rig
