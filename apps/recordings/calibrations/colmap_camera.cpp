#include "recordings/calibrations/colmap_camera.h"

#include "recordings/calibrations/calibration.h"
#include "recordings/files/cut_short.h"

#include <fuse_flow/recordings/error.h>

#include <map>

namespace fuse_flow::io {

Intrinsics colmapIntrinsics(const std::string& path, const std::string& model, double width, double height,
                            const std::vector<double>& p) {
  struct Layout {
    std::size_t focal_lengths, distortion;
  };
  static const std::map<std::string, Layout> known = {{"SIMPLE_PINHOLE", {1, 0}}, {"PINHOLE", {2, 0}},
                                                      {"SIMPLE_RADIAL", {1, 1}},  {"RADIAL", {1, 2}},
                                                      {"OPENCV", {2, 4}},         {"FULL_OPENCV", {2, 8}}};
  const auto layout = known.find(model);
  if (layout == known.end())
    throw InputError(path + ": the camera model is " + cutShort(model) +
                     ", must be SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV or FULL_OPENCV");
  const auto [focal_lengths, distortion] = layout->second;
  const std::size_t wanted = focal_lengths + 2 + distortion;
  if (p.size() != wanted)
    throw InputError(path + ": the camera of model " + model + " has " + std::to_string(p.size()) +
                     " parameters, must be " + std::to_string(wanted));
  Intrinsics K;
  K.width = imageSide(path, "width", width);
  K.height = imageSide(path, "height", height);
  K.fx = static_cast<float>(p[0]);
  K.fy = static_cast<float>(p[focal_lengths - 1]);
  // COLMAP's first pixel reaches from 0 to 1, ours from -0.5 to 0.5.
  K.cx = static_cast<float>(p[focal_lengths] - 0.5);
  K.cy = static_cast<float>(p[focal_lengths + 1] - 0.5);
  std::vector<double> d(p.end() - static_cast<std::ptrdiff_t>(distortion), p.end());
  if (!d.empty() && d.size() < 4) d.resize(4, 0.0);  // k1, k2 alone
  K.distortion = distortionOf(path, d);
  return K;
}

ColmapModel colmapModel(const std::string& path, int number) {
  static const std::vector<ColmapModel> models = {{"SIMPLE_PINHOLE", 3},
                                                  {"PINHOLE", 4},
                                                  {"SIMPLE_RADIAL", 4},
                                                  {"RADIAL", 5},
                                                  {"OPENCV", 8},
                                                  {"OPENCV_FISHEYE", 8},
                                                  {"FULL_OPENCV", 12},
                                                  {"FOV", 5},
                                                  {"SIMPLE_RADIAL_FISHEYE", 4},
                                                  {"RADIAL_FISHEYE", 5},
                                                  {"THIN_PRISM_FISHEYE", 12}};
  if (number < 0 || static_cast<std::size_t>(number) >= models.size())
    throw InputError(path + ": has a camera model of number " + std::to_string(number) + ", must be 0 to " +
                     std::to_string(models.size() - 1));
  return models[static_cast<std::size_t>(number)];
}

}  // namespace fuse_flow::io
