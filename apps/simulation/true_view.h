#pragma once

#include "simulation/exposure.h"

#include <fuse_flow/camera.h>
#include <fuse_flow/recordings/image.h>

#include <cmath>

namespace fuse_flow::simulation {

/** \brief A pinhole camera in a scene, for casting rays through its pixels. */
class PixelRays {
 public:
  PixelRays(const Intrinsics& K, const Eigen::Isometry3d& T_world_camera)
      : K_(K), R_(T_world_camera.linear().cast<float>()), origin_(T_world_camera.translation().cast<float>()) {}

  const Eigen::Vector3f& origin() const { return origin_; }
  /** \brief Of the image. */
  int rows() const { return K_.height; }
  /** \brief Through a position in the image, world frame, of depth 1 along the optical axis: lengths along it are
   *  depths. */
  Eigen::Vector3f direction(float u, float v) const {
    return R_ * Eigen::Vector3f((u - K_.cx) / K_.fx, (v - K_.cy) / K_.fy, 1.0f);
  }
  /** \brief A point of the camera's own frame. */
  Eigen::Vector3f toWorld(const Eigen::Vector3f& p_C) const { return R_ * p_C + origin_; }
  /** \brief Whether a point of the world falls into the image. */
  bool reach(const Eigen::Vector3f& p_W) const {
    const Eigen::Vector3f p = R_.transpose() * (p_W - origin_);
    const float u = K_.fx * p.x() + K_.cx * p.z(), v = K_.fy * p.y() + K_.cy * p.z();
    return p.z() > 0 && u > 0 && v > 0 && u < static_cast<float>(K_.width) * p.z() &&
           v < static_cast<float>(K_.height) * p.z();
  }

 private:
  Intrinsics K_;
  Eigen::Matrix3f R_;
  Eigen::Vector3f origin_;
};

/** \brief What a perfect sensor would see; the depth image's size, depth 0 where there is nothing. Where something moves while a pixel
 *  is exposed: the surface that it saw the longest, at its mean depth; of two the nearer one. */
struct TrueView {
  /** \brief Along the optical axis, metres. */
  io::FloatImage depth;
  /** \brief Cosine between the ray and the surface normal. */
  io::FloatImage cosine;
  /** \brief The material's infrared reflectance. */
  io::FloatImage infrared;
  /** \brief 0 where a second eye (projector or imager) at an offset cannot see the surface, else 1. */
  io::FloatImage seen_twice;
  /** \brief Share of the exposure in which the pixel saw this surface; (0, 1]. */
  io::FloatImage steadiness;
};

/** \brief \param second_eye in the camera's frame, metres; zero: seen_twice is 1 everywhere. */
TrueView renderTrueView(const Exposure& exposure, const Intrinsics& K, const Eigen::Isometry3d& T_world_camera,
                        const Eigen::Vector3f& second_eye, int threads);

/** \brief White noise of unit variance, smoothed by a Gaussian of sigma pixels and scaled to unit variance again: how
 *  errors of a matching window go together. */
io::FloatImage correlatedNoise(int width, int height, float sigma, std::uint64_t seed, int threads);

}  // namespace fuse_flow::simulation
