#pragma once

#include <fuse_flow/camera.h>
#include <fuse_flow/recordings/recording.h>

#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief One entry of rig.json. */
struct RigCamera {
  Camera camera;  ///< with its name, which is that of its folder
  /** \brief Value of one step of its confidence images, where 1 is certain. Absent: the largest value of the file's type is 1. */
  std::optional<float> confidence_scale{};
  /** \brief Whether rig.json has its depth_scale, which a camera without depth does not need. */
  bool has_depth_scale{true};
  /** \brief What its depth images hold. */
  DepthMeaning depth{};
  /** \brief What is wrong with its T_world_camera, where readRigJson() was told not to ask for poses; empty: nothing. */
  std::string pose_error{};
};

/** \brief The content of rig.json. */
struct RigDescription {
  std::vector<RigCamera> cameras;  ///< in the file's order
  /** \brief Rate at which all cameras took their frames, Hz; 0.001 to 10^6. */
  std::optional<double> frames_per_second;
  /** \brief Warnings for unknown keys, one line each. */
  std::vector<std::string> warnings{};
};

/** \brief Reads a rig's calibration; doc/reference/formats.md describes the file. Throws InputError, naming file, camera, key,
 *  value and what is expected.
 *  \param with_poses false: for those that do not use the poses; a camera whose pose is missing, or is none, is at the origin, and has a
 *  RigCamera::pose_error */
RigDescription readRigJson(const std::string& path, bool with_poses = true);

/** \brief Writes a rig.json. Reading it gives the same numbers. Throws OutputError. */
void writeRigJson(const std::string& path, const RigDescription& rig);

}  // namespace fuse_flow::io
