#pragma once

#include <fuse_flow/precompiled.h>
#include <fuse_flow/rig_frame.h>
#include <fuse_flow/stereo/parameters.h>

#include <cstddef>
#include <vector>

namespace fuse_flow {

/** \brief How far matches between two views are from where the calibration says that they must be. */
struct EpipolarError {
  std::size_t view{0};     ///< number of a camera
  std::size_t source{0};   ///< number of the camera that it is matched with
  std::size_t matches{0};  ///< points that look like one place in the other image and like no other
  /** \brief Median distance of the matches from their epipolar lines, pixels of the full image. Up to about 1.5 for a pair, and 1 for all pairs
   *  of a camera, where the calibration is right, since there are few matches; over 2: intrinsics, lens or poses are off, and depth suffers; NaN
   *  without matches. */
  float median{0};
};

/** \brief Tries a calibration on the images of one instant, before any depth is computed: points with texture are looked for in other views, along
 *  their epipolar lines and up to 12 pixels beside them. With right intrinsics and poses they lie on the lines. A wrong scale or the shape of the scene does
 *  not show. Of each view and the views that MultiViewStereo matches it with, one result. Takes about a twentieth of the time of the depth.
 *  Many threads may call it at once. \param frame as for MultiViewStereo::estimate()  \param parameters as there; checked
 *  \param threads to use; 0: one per core
 *  \throws pcl::BadArgumentException as MultiViewStereo::estimate() and setParameters() */
FUSE_FLOW_INLINE std::vector<EpipolarError> epipolarErrors(const RigFrame& frame,
                                                           const StereoParameters& parameters = {},
                                                           unsigned int threads = 0);

}  // namespace fuse_flow

#ifndef FUSE_FLOW_DECLARATIONS_ONLY
#include <fuse_flow/impl/stereo/epipolar_errors.hpp>
#endif
