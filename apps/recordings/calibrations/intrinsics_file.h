#pragma once

#include <fuse_flow/math/pinhole.h>

#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Reads the intrinsics of one camera from a file, whose format is recognised by its name and content:
 *  - ROS camera_info or OpenCV YAML: camera_matrix or K, distortion_coefficients or D, image_width and image_height
 *  - JSON as Open3D writes it: width, height, intrinsic_matrix column by column, alone or the same for each frame of a trajectory; or with fx, fy, cx, cy as rig.json has them
 *  - text of a 3×3 or 4×4 matrix, row by row, or of the four numbers fx fy cx cy
 *  - COLMAP's cameras.txt, whose pixel centres lie at halves: they are moved to ours, at integers
 *
 *  Width and height are 0 where the file does not say them.
 *  \param width of the images, pixels: chooses among the cameras of a cameras.txt; 0: not known  \param height of the images
 *  \param warnings gets those of withDistortion(); null: they are lost
 *  Throws InputError, naming the path and what is wrong, for any other file and for lenses that Intrinsics cannot express. */
Intrinsics readIntrinsicsFile(const std::string& path, int width = 0, int height = 0,
                              std::vector<std::string>* warnings = nullptr);

/** \brief What Open3D calls its PinholeCameraTrajectory. */
constexpr const char* kOpen3dTrajectory = "camera_trajectory.json";

/** \brief Intrinsics, and the file that has them. */
struct FoundIntrinsics {
  Intrinsics intrinsics;
  std::string path;
  std::vector<std::string> warnings;  ///< see withDistortion()
};

/** \brief Intrinsics that lie beside images: those of the folder's .json, .yaml, .yml and usual .txt files (camera-intrinsics.txt,
 *  intrinsics.txt, K.txt, cameras.txt, …). Of several, those of the images' size count, and among these the ones named depth.
 *  Without such a file those of camera_trajectory.json. None: no file has any. Throws InputError for a file that has wrong ones, and where several files contradict each other.
 *  \param width of the images, pixels  \param height of the images */
std::optional<FoundIntrinsics> findIntrinsics(const std::string& folder, int width, int height);

}  // namespace fuse_flow::io
