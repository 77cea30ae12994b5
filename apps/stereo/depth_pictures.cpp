#include "stereo/depth_pictures.h"

#include <pcl/common/colors.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace fuse_flow::io {
namespace {

Rgb8 viridis(float share) {
  const float place = std::clamp(share, 0.0f, 1.0f) * static_cast<float>(pcl::ViridisLUT::size() - 1);
  const pcl::RGB color = pcl::ViridisLUT::at(static_cast<std::size_t>(std::lround(place)));
  return {color.r, color.g, color.b};
}

/** \brief The value below which a share of them lies. */
float quantile(std::vector<float>& values, double share) {
  const auto place = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[static_cast<std::size_t>(place)];
}

template <typename Color>
ColorImage pictureOf(const FloatImage& image, const Color& color) {
  ColorImage picture;
  picture.resize(image.width, image.height);
  std::transform(image.data.begin(), image.data.end(), picture.data.begin(), color);
  return picture;
}

}  // namespace

PictureRange pictureRange(const LoadedFrame& frame, const std::vector<bool>& of) {
  std::vector<float> agreed, all;
  for (std::size_t k = 0; k < of.size(); ++k) {
    if (!of[k] || frame.rig.views[k].missing()) continue;
    const LoadedView& view = frame.images[k];
    for (std::size_t i = 0; i < view.depth32.data.size(); ++i) {
      if (!(view.depth32.data[i] > 0)) continue;
      all.push_back(view.depth32.data[i]);
      if (view.confidence.data[i] > 0) agreed.push_back(view.depth32.data[i]);
    }
  }
  std::vector<float>& depths = agreed.empty() ? all : agreed;
  if (depths.empty()) return {};
  return {quantile(depths, 0.01), quantile(depths, 0.99)};
}

ColorImage depthPicture(const FloatImage& depth, const PictureRange& range) {
  const bool one = !(range.farthest > range.nearest);
  const float from = one ? 0 : 1 / range.farthest, to = one ? 1 : 1 / range.nearest;
  return pictureOf(depth, [&](float z) { return z > 0 ? viridis((1 / z - from) / (to - from)) : Rgb8{}; });
}

ColorImage confidencePicture(const FloatImage& confidence) {
  return pictureOf(confidence, [](float c) {
    const auto level = static_cast<std::uint8_t>(std::lround(255 * std::clamp(c, 0.0f, 1.0f)));
    return Rgb8{level, level, level};
  });
}

}  // namespace fuse_flow::io
