#pragma once

#include <fuse_flow/recordings/recording.h>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace io_test {

using namespace fuse_flow;

/** \brief A camera in an empty room: a box with a colour for each of its six walls, from (−1.5, −2, 0) to
 *  (2.5, 1.8, 2.6) in the world. Nothing about camera or room is symmetric, so that what is inverted, mirrored or in
 *  another order puts points beside the walls. */
struct RoomView {
  int width{64};
  int height{48};
  double fx{24}, fy{20}, cx{29}, cy{25.5};
  Eigen::Isometry3d T_world_camera{Eigen::Isometry3d::Identity()};

  /** \brief Along the optical axis, metres. */
  double depth(int u, int v) const;
  /** \brief In the camera's frame. */
  Eigen::Vector3d point(int u, int v) const;
  Rgb8 color(int u, int v) const;

  /** \brief A 16-bit PNG. */
  std::string depthPng(double metres_per_unit = 0.001) const;
  std::string colorPng() const;
  /** \brief Sixteen numbers in four lines. */
  std::string poseText() const;
};

/** \brief At (0.5, 0.3, 1.2), looking along the world's x at the wall 2 m away, its rows level:
 *      0  0  1  0.5
 *     −1  0  0  0.3
 *      0 −1  0  1.2
 *  As a quaternion x, y, z, w: −0.5, 0.5, −0.5, 0.5. */
RoomView levelView();

/** \brief Looking down into a corner; \param step moves it by 10 cm. */
RoomView cornerView(int step = 0);

/** \brief Whether the view's points lie on the walls of the room in the world, to 2 mm, with the colours of the walls
 *  if it has colour; at least 9 of 10 pixels must have one. \param walls that must be seen at least */
testing::AssertionResult showsRoom(const io::LoadedFrame& frame, std::size_t view, std::size_t walls = 3);

}  // namespace io_test
