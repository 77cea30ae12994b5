#pragma once

#include <Eigen/Geometry>

#include <cstddef>
#include <map>
#include <string>

namespace fuse_flow::io {

/** \brief Camera → world by the frame's number, and why those that are no pose are none. */
struct Trajectory {
  std::map<std::size_t, Eigen::Isometry3d> poses;
  std::map<std::size_t, std::string> invalid;
};

/** \brief Reads a .log of Redwood and Open3D: blocks of five lines, "i j k", then camera → world, 4×4; i is the frame's number. Throws InputError. */
Trajectory readTrajectoryLog(const std::string& path);

/** \brief Reads a PinholeCameraTrajectory of Open3D: a list of parameters, the first of frame 0, each with the extrinsic matrix, world → camera, 4×4, column by
 *  column. Throws InputError. */
Trajectory readTrajectoryJson(const std::string& path);

}  // namespace fuse_flow::io
