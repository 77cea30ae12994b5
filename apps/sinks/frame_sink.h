#pragma once

#include "methods/method.h"
#include "recordings/pool.h"

#include <fuse_flow/recordings/recording.h>

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief A frame that was fused, with what it was fused from. */
struct FusedFrame {
  std::size_t number{0};  ///< of the recording
  /** \brief When the last of its images came, by the host's clock since 1970; 0: they were read from files. */
  std::chrono::microseconds arrived{0};
  LoadedFrame input;
  std::vector<std::shared_ptr<const LoadedView>>
      live;  ///< what the views of input.rig point into, where that is not input.images
  Method::Cloud cloud;
  bool has_normals{false};      ///< see MethodOptions::normals
  bool has_camera_mask{false};  ///< see MethodOptions::camera_mask
  pcl::PointCloud<PointFusedNormal>
      with_normals;  ///< if it has one of them: the same points, see Method::withNormals()
  /** \brief If there are any, the points are in these bytes only: see Method::fuseEncoded(). */
  std::shared_ptr<const stream::EncodedFrame> encoded;
  FrameStatistics statistics;
};

/** \brief An output for fused frames: files, figures, or anything else that takes one frame after the other. One loop can feed several
 *  sinks. */
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  /** \brief One frame; they come in the order in which they were chosen. What a sink keeps stays as it is: the frame's memory is used again
   *  only when nobody holds it. \throws what ends the run */
  virtual void take(const std::shared_ptr<const FusedFrame>& frame) = 0;
  /** \brief After the last frame: what was noticed, a line each. */
  virtual std::vector<std::string> finish() { return {}; }
};

/** \brief Memory for frames. */
using FramePool = Pool<FusedFrame>;

}  // namespace fuse_flow::io
