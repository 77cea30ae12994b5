#pragma once

#include <fuse_flow/camera.h>

#include <string>

namespace fuse_flow::io {

/** \brief How an Azure Kinect or an Orbbec Femto was set, as its recorder calls it: "NFOV_UNBINNED", "720P". */
struct AzureKinectModes {
  std::string depth;
  std::string color;  ///< empty: it recorded no colour
};

/** \brief The camera that the calibration of an Azure Kinect or an Orbbec Femto describes, in the mode that was recorded. The calibration
 *  holds each lens in parts of its whole sensor; a mode is a scale and a crop of it. The colour camera's pose is the calibration's. Throws InputError,
 *  beginning with owner, for what is no such calibration, and for an unknown mode.
 *  \param json the text of calibration.json  \returns millimetres as depth_scale */
Camera azureKinectCamera(const std::string& owner, const std::string& json, const AzureKinectModes& modes);

}  // namespace fuse_flow::io
