#pragma once

#include <fuse_flow/rig_frame.h>
#include <fuse_flow/sensors/depth_out_of_range.h>
#include <fuse_flow/sensors/preprocessing.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Finds cameras whose depth is nearly all out of range, in each of their images: more often than not their unit is wrong. */
class DepthInRange {
 public:
  explicit DepthInRange(const PreprocessingParameters& range) : range_(range) {}

  /** \brief Looks at a frame; at a camera only until one of its images is right. */
  void look(const RigFrame& frame);

  /** \brief A line for each camera that had images, but none that is right. */
  std::vector<std::string> complaints() const;

 private:
  struct Seen {
    std::string name;
    bool images{false};
    bool right{false};
    DepthOutOfRange depth;  ///< of all images so far
    float scale{0};         ///< metres per unit; 0: the images are in metres
  };
  PreprocessingParameters range_;
  std::vector<Seen> cameras_;
};

}  // namespace fuse_flow::io
