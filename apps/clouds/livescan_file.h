#pragma once

#include "methods/point_fused_normal.h"

#include <pcl/point_cloud.h>

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief A recording of one sensor by LiveScan3D, recording_….bin: clouds in its world, one after the other. Each is two lines of text,
 *  "n_points= N" and "frame_timestamp= T", then N points of three 16-bit millimetres, N colours of four bytes (blue, green, red and one that is
 *  not used), and a line end. Little-endian. Only one thread may use an object. */
class LiveScanFile {
 public:
  /** \brief Whether a file begins as such a recording does. Throws InputError if it cannot be read. */
  static bool is(const std::string& path);

  /** \brief Finds its frames. One that is cut short at the end is left out. Throws InputError for a file that goes on with something else. */
  explicit LiveScanFile(const std::string& path);

  std::size_t frameCount() const { return frames_.size(); }
  bool isCutShort() const { return cut_short_; }
  /** \brief \param points their confidence is 1 \throws InputError */
  void read(std::size_t frame, pcl::PointCloud<PointFusedNormal>& points);

 private:
  struct Frame {
    std::uint64_t at{0};  ///< of its points
    std::size_t points{0};
  };

  std::string path_;
  std::ifstream file_;
  std::vector<Frame> frames_;
  bool cut_short_{false};
};

}  // namespace fuse_flow::io
