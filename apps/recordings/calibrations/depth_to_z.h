#pragma once

#include <fuse_flow/recordings/recording.h>

#include <vector>

namespace fuse_flow::io {

/** \brief Makes z of a camera's depth images, whatever they mean. Many threads may use one object. */
class DepthToZ {
 public:
  DepthToZ(const Camera& camera, const DepthMeaning& meaning);

  /** \brief Depth becomes z in metres, in depth32; nothing changes if it is z, or missing. \param view of these images, which must be of the
   *  camera's size */
  void convert(LoadedView& images, DepthView& view) const;

 private:
  DepthMeaning meaning_;
  float depth_scale_;
  std::vector<float> z_per_distance_;  ///< of each pixel; empty: 1
};

}  // namespace fuse_flow::io
