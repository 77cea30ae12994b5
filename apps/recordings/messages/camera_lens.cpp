#include "recordings/messages/camera_lens.h"

#include "recordings/calibrations/calibration.h"
#include "recordings/calibrations/lens_models.h"

#include <algorithm>

namespace fuse_flow::io {

Intrinsics lensOf(const std::string& owner, const CameraInfoMessage& info, bool rectified,
                  std::vector<std::string>& warnings) {
  constexpr std::uint32_t widest = 65535;
  if (info.width == 0 || info.height == 0 || info.width > widest || info.height > widest)
    throw InputError(owner + ": is of " + std::to_string(info.width) + "x" + std::to_string(info.height) +
                     " pixels; the camera was not calibrated");
  const bool by_projection = rectified && info.P[0] > 0;
  Intrinsics K = by_projection ? intrinsicsOf(owner, {info.P[0], info.P[1], info.P[2], info.P[4], info.P[5], info.P[6],
                                                      info.P[8], info.P[9], info.P[10]})
                               : intrinsicsOf(owner, std::vector<double>(info.K, info.K + 9));
  // ROS's calibration is of the whole sensor; the image may be a part of it, and coarser.
  const std::uint32_t binning_x = std::max(info.binning_x, 1u), binning_y = std::max(info.binning_y, 1u);
  const std::uint32_t width = (info.roi_width > 0 ? info.roi_width : info.width) / binning_x;
  const std::uint32_t height = (info.roi_height > 0 ? info.roi_height : info.height) / binning_y;
  if (width == 0 || height == 0 || width > widest || height > widest)
    throw InputError(owner + ": its region of the sensor and its binning leave " + std::to_string(width) + "x" +
                     std::to_string(height) + " pixels, must be those of the image");
  const auto bx = static_cast<float>(binning_x), by = static_cast<float>(binning_y);
  K.fx /= bx;
  K.fy /= by;
  K.cx = (K.cx - static_cast<float>(info.roi_x) + 0.5f) / bx - 0.5f;
  K.cy = (K.cy - static_cast<float>(info.roi_y) + 0.5f) / by - 0.5f;
  K.width = static_cast<int>(width);
  K.height = static_cast<int>(height);
  return rectified ? K : withDistortion(owner, K, info.distortion_model, info.D, warnings);
}

}  // namespace fuse_flow::io
