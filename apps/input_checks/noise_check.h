#pragma once

#include <fuse_flow/fusion/statistics.h>
#include <fuse_flow/rig_frame.h>

#include <cstddef>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Finds cameras whose own noise model (Camera::noise) is far from what their depth shows in each of their images: more often than not
 *  its numbers are not in metres. */
class NoiseCheck {
 public:
  /** \param statistics of the frame, fused; without noise scales, as of methods that measure none, nothing is seen */
  void look(const RigFrame& frame, const FrameStatistics& statistics);

  /** \brief A line for each such camera. */
  std::vector<std::string> complaints() const;

 private:
  struct Seen {
    std::string name;
    NoiseModel model;
    std::size_t images{0};
    std::size_t far_less{0};  ///< of those, with no more than the least share of the model that is believed
    std::size_t far_more{0};  ///< … with the largest
  };
  std::vector<Seen> cameras_;
};

}  // namespace fuse_flow::io
