#pragma once

#include <fuse_flow/camera.h>

#include <array>
#include <cstddef>
#include <vector>

namespace fuse_flow::io {

/** \brief A known point of a flat marker or board, and where an image shows it. */
struct MarkerPoint {
  /** \brief Where it is on the marker, seen from its front: x to the right, y down; metres from an origin of the marker's own. */
  Eigen::Vector2d place{0, 0};
  Pixel pixel;  ///< of the colour image
};

/** \brief A flat marker, or a board of many points, in one camera's image. */
struct MarkerSighting {
  std::size_t camera{0};  ///< which of the rig's
  std::size_t frame{0};   ///< the instant; at another one the marker may be elsewhere
  int id{0};              ///< which marker; of a board there is one only
  /** \brief What the image shows of it: four or more, not all on one line. Two cameras need not see the same ones. */
  std::vector<MarkerPoint> points;
  float depth{0};                  ///< measured at depth_at, along the colour camera's axis, metres; 0: not measured
  Eigen::Vector2d depth_at{0, 0};  ///< as MarkerPoint::place
};

/** \brief Where the cameras of a rig stand by the markers that they see. */
struct MarkerRig {
  /** \brief Of the depth cameras; the first one's is as it was given, and so is that of a camera that is not placed. */
  std::vector<Eigen::Isometry3d> T_world_camera;
  std::vector<bool> placed;  ///< camera by camera; whether markers connect it with the first
  std::size_t markers{0};    ///< that two or more placed cameras saw, each counted once an instant
  std::size_t unusable{0};   ///< sightings whose points give no pose: too few, or on one line
  double residual{0};        ///< root mean square distance of corners from where they should be, pixels
  /** \brief Median of depth as measured over depth as the markers' size says; 0: unknown. Apart from 1, the size is wrong. */
  double depth_ratio{0};
};

/** \brief The corners of a square, its middle the origin. \param side metres  \param corners lower left, lower right, upper right,
 *  upper left; pixels */
std::vector<MarkerPoint> squarePoints(double side, const std::array<Pixel, 4>& corners);

/** \brief Poses of a rig from flat markers of known size. Every marker alone gives two poses, mirrored about the line of
 *  sight, the better of which is sometimes the wrong one; so cameras are placed along the sightings that leave least doubt, and
 *  then all points decide about all poses together. */
MarkerRig placeByMarkers(const std::vector<Camera>& cameras, const std::vector<MarkerSighting>& sightings);

}  // namespace fuse_flow::io
