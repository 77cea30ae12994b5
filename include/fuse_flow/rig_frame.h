#pragma once

#include <fuse_flow/camera.h>
#include <fuse_flow/depth_view.h>

#include <vector>

namespace fuse_flow {

/** \brief The views of one instant: views[i] is what cameras[i] measured. Keep one object and refill views from frame to frame: everything
 *  that depends only on the calibration is then computed once. Thread safety: many threads may read it while none writes. */
struct RigFrame {
  std::vector<Camera> cameras;   ///< the calibration of the rig
  std::vector<DepthView> views;  ///< as many as cameras, in their order
  /** \brief Time stamp; copied into the header of the fused cloud; microseconds, as in pcl::PCLHeader. */
  std::uint64_t stamp{0};
};

/** \brief Throws pcl::BadArgumentException, naming the camera and what is wrong, unless every present view fits its
 *  camera. */
inline void checkRigFrame(const RigFrame& frame);

}  // namespace fuse_flow

#include <fuse_flow/impl/rig_frame.hpp>
