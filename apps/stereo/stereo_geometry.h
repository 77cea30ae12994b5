#pragma once

#include <fuse_flow/camera.h>
#include <fuse_flow/stereo/epipolar_errors.h>
#include <fuse_flow/stereo/parameters.h>
#include <fuse_flow/stereo/stereo_frame.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief What MultiViewStereo knows before it looks at any image. */
struct StereoSetup {
  std::vector<StereoGeometry> geometry;  ///< who is matched with whom, and from what depth to what depth
  std::vector<Camera> cameras;           ///< of the depth that is found, see StereoFrame::rig
};

/** \param has_color of each camera: those without are matched with none */
StereoSetup stereoSetup(const std::vector<Camera>& cameras, const std::vector<bool>& has_color,
                        const StereoParameters& parameters);

/** \brief What is wrong with how cameras stand, one line each, with what would be right.  \param of the cameras whose depth is estimated */
std::vector<std::string> stereoWarnings(const std::vector<Camera>& cameras, const std::vector<bool>& of,
                                        const std::vector<StereoGeometry>& geometry,
                                        const StereoParameters& parameters);

/** \brief One line if matches of some cameras lie beside their epipolar lines, on the median over the cameras that each is matched with; else
 *  nothing. */
std::string epipolarWarning(const std::vector<Camera>& cameras, const std::vector<EpipolarError>& errors);

}  // namespace fuse_flow::io
