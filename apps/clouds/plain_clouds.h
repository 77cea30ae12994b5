#pragma once

#include "clouds/livescan_file.h"
#include "methods/point_fused_normal.h"

#include <pcl/point_cloud.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Clouds of several scanners, without the images that they were measured in: PLY and PCD files, one for each scanner; folders, one for
 *  each scanner, with a file for each frame, whose name ends with the frame's number; or files of LiveScan3D, one for each sensor, whose frames
 *  are those of the same place in all. Only one thread may use an object. */
class PlainClouds {
 public:
  /** \brief Whether inputs are such clouds: .bin of LiveScan3D, .ply files, .pcd files that are not organised, or folders of them. Organised .pcd files are a
   *  recording, see openRecording(). Throws InputError for a file that cannot be read. */
  static bool are(const std::vector<std::string>& inputs);

  /** \brief Throws InputError where files and folders are mixed, and if there is no frame.
   *  \param poses a rig.json, whose poses move the points of the scanner with the name of the file or folder into the world; empty: they are there */
  PlainClouds(const std::vector<std::string>& inputs, const std::string& poses);

  /** \brief Numbers of the frames, ascending; of files 0. */
  std::vector<std::size_t> frames() const;
  const std::vector<std::string>& scanners() const { return names_; }
  /** \brief All that is read. */
  std::vector<std::string> inputs() const;
  bool haveNormals() const { return have_normals_; }
  /** \brief What was assumed or left out at opening, one line each. */
  const std::vector<std::string>& warnings() const { return warnings_; }

  /** \brief All points of a frame in the world, scanner after scanner; confidence 1, where a file has none. Throws InputError.
   *  \param scanners of each point the scanner's number */
  void read(std::size_t frame, pcl::PointCloud<PointFusedNormal>& points, std::vector<std::uint32_t>& scanners);

 private:
  void checkLiveScan();
  void placeScanners();
  void readPointsOf(const std::string& file, pcl::PointCloud<PointFusedNormal>& points) const;

  std::vector<std::string> inputs_;
  std::string poses_;
  std::vector<std::string> names_;
  std::vector<std::map<std::size_t, std::string>>
      files_;  ///< of each scanner, by frame; of LiveScan3D the same file again and again
  std::vector<std::unique_ptr<LiveScanFile>> livescan_;  ///< of each scanner; null: it is none of LiveScan3D's
  std::vector<std::string> warnings_;
  std::vector<Eigen::Isometry3d> T_world_scanner_;
  bool have_normals_{false};
};

}  // namespace fuse_flow::io
