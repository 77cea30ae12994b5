#pragma once

#include <fuse_flow/preprocessing.h>
#include <fuse_flow/rig_frame.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Finds the cameras none of whose depth is ever in range: more often than not their unit is wrong. */
class DepthInRange {
 public:
  explicit DepthInRange(const PreprocessingParameters& range) : range_(range) {}

  /** \brief Looks at a frame; cheap, since most cameras are found right in their first row. */
  void look(const RigFrame& frame);

  /** \brief A line for each camera that had images, but nothing in range in any of them. */
  std::vector<std::string> complaints() const;

 private:
  struct Seen {
    std::string name;
    bool images{false};
    bool in_range{false};
    /** \brief Of what is out of range, metres. */
    float nearest{0}, farthest{0};
    float scale{0};  ///< metres per unit; 0: the images are in metres
  };
  PreprocessingParameters range_;
  std::vector<Seen> cameras_;
};

}  // namespace fuse_flow::io
