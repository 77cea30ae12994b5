#pragma once

#include "simulation/true_view.h"

#include <cstdint>
#include <vector>

namespace fuse_flow::simulation {

/** \brief Light of a camera's own lamp that comes to what a pixel sees by way of another surface (multipath): one bounce off
 *  matt surfaces, as phases of the lamp's modulation.
 *
 *  The light that falls on a place from all around is an integral, and smooth along a surface. It is estimated from 36 random
 *  directions for each pixel, in strata, together with those of the 7 × 7 pixels around it on the same surface: 1,764 in all.
 *  A few alone would leave noise that no sensor has. */
class IndirectLight {
 public:
  /** \brief Of what stands there in the middle of the exposure. \param period depth at which the phase begins again, metres
   *  \param seed of the directions */
  IndirectLight(const Exposure& exposure, const Intrinsics& K, const Eigen::Isometry3d& T_world_camera, float period,
                std::uint64_t seed, int threads);

  /** \brief Of the indirect light on what a pixel sees: in phase with the direct light, and a quarter of a period
   *  behind it. In shares of the light that the lamp sends to a place 1 m away, as a surface that swallows nothing would
   *  send it back. 0 where the pixel sees nothing. */
  struct Light {
    float in_phase{0}, behind{0};
  };
  Light at(int u, int v) const;

 private:
  /** \brief What a pixel sees, and what falls on it; phases counted from the lamp. */
  struct Receiver {
    Eigen::Vector3f position, normal;
    float distance{0};  ///< from the camera, metres; 0: it sees nothing
    std::uint32_t surface{0};
    float real{0}, imaginary{0};
  };

  Receiver receive(const Exposure& exposure, const PixelRays& rays, int u, int v, std::uint64_t seed) const;
  const Receiver& receiver(int u, int v) const {
    return receivers_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u)];
  }

  int width_, height_;
  float radians_per_metre_;  ///< of a path's length
  std::vector<Receiver> receivers_;
};

/** \brief Share of a lamp's light that a matt surface sends back to where the lamp stands, which lights what is 1 m away, and
 *  faces it, with 1. */
float returnedLight(const RayScene& scene, const SurfacePoint& surface, const Eigen::Vector3f& lamp);

}  // namespace fuse_flow::simulation
