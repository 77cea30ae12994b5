#pragma once

#include <string>
#include <vector>

namespace fuse_flow_fuzz {

/** \brief The files of a recording in a folder, in the order in which an input has them, see scratchFiles(). */
namespace bundles {

inline const std::vector<std::string> rig{"rig.json",
                                          "left/depth/000000.png",
                                          "right/depth/000000.tif",
                                          "left/color/000000.png",
                                          "right/color/000000.jpg",
                                          "left/confidence/000000.png",
                                          "left/timestamps.txt",
                                          "right/timestamps.txt",
                                          "left/depth/000001.png",
                                          "right/depth/000001.npy"};
inline const std::vector<std::string> seven_scenes{
    "frame-000000.pose.txt",  "frame-000000.depth.png", "K.txt",
    "frame-000000.color.jpg", "frame-000001.pose.txt",  "frame-000001.depth.png"};
inline const std::vector<std::string> tum{"depth.txt", "groundtruth.txt", "depth/1.png",
                                          "rgb.txt",   "rgb/1.png",       "camera.yaml"};
inline const std::vector<std::string> redwood{"camera_trajectory.json", "depth/000001.png", "trajectory.log",
                                              "color/000001.jpg", "intrinsics.json"};
inline const std::vector<std::string> mvsnet{"cams/00000000_cam.txt", "depth_est/00000000.pfm",
                                             "images/00000000.png",   "confidence/00000000.pfm",
                                             "cams/00000001_cam.txt", "depth_est/00000001.npy"};
inline const std::vector<std::string> colmap{"sparse/cameras.txt", "sparse/images.txt", "images/a.png",
                                             "stereo/depth_maps/a.png.geometric.bin",
                                             "stereo/depth_maps/b.png.photometric.bin"};
inline const std::vector<std::string> colmap_binary{"sparse/0/cameras.bin", "sparse/0/images.bin", "images/a.png",
                                                    "stereo/depth_maps/a.png.geometric.bin"};

}  // namespace bundles
}  // namespace fuse_flow_fuzz
