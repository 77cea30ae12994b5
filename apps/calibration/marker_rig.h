#pragma once

#include <fuse_flow/camera.h>

#include <array>
#include <cstddef>
#include <vector>

namespace fuse_flow::io {

/** \brief A square marker in one camera's image. */
struct MarkerSighting {
  std::size_t camera{0};  ///< which of the rig's
  std::size_t frame{0};   ///< the instant; at another one the marker may be elsewhere
  int id{0};              ///< which marker
  /** \brief As the marker is read: lower left, lower right, upper right, upper left; pixels of the colour image. */
  std::array<Pixel, 4> corners{};
  float depth{0};  ///< measured at its middle, along the colour camera's axis, metres; 0: not measured
};

/** \brief Where the cameras of a rig stand by the markers that they see. */
struct MarkerRig {
  /** \brief Of the depth cameras; the first one's is as it was given, and so is that of a camera that is not placed. */
  std::vector<Eigen::Isometry3d> T_world_camera;
  std::vector<bool> placed;  ///< camera by camera; whether markers connect it with the first
  std::size_t markers{0};    ///< that two or more placed cameras saw, each counted once an instant
  double residual{0};        ///< root mean square distance of corners from where they should be, pixels
  /** \brief Median of depth as measured over depth as the markers' size says; 0: unknown. Apart from 1, the size is wrong. */
  double depth_ratio{0};
};

/** \brief Poses of a rig from square markers of one size. Every marker alone gives two poses, mirrored about the line of
 *  sight, the better of which is sometimes the wrong one; so cameras are placed along the sightings that leave least doubt, and
 *  then all corners decide about all poses together. \param side of the markers, metres */
MarkerRig placeByMarkers(const std::vector<Camera>& cameras, const std::vector<MarkerSighting>& sightings, double side);

}  // namespace fuse_flow::io
