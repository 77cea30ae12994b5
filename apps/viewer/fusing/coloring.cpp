#include "viewer/fusing/coloring.h"

#include "drawing/clouds.h"

#include <pcl/common/colors.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace fuse_flow::viewing {
namespace {

constexpr Rgb8 kUnknown{128, 128, 128};

Rgb8 from(const pcl::RGB& color) { return {color.r, color.g, color.b}; }

/** \brief Dark blue at 0 to yellow at 1. */
Rgb8 viridis(float share) {
  const float place = std::clamp(share, 0.0f, 1.0f) * static_cast<float>(pcl::ViridisLUT::size() - 1);
  return from(pcl::ViridisLUT::at(static_cast<std::size_t>(std::lround(place))));
}

/** \brief One camera red, two yellow, three or more green and blue: what only one camera saw should strike the eye. */
Rgb8 viewsColor(std::uint32_t views) {
  constexpr Rgb8 scale[] = {kUnknown, {214, 69, 65}, {235, 190, 60}, {64, 170, 105}, {60, 120, 216}};
  return scale[std::min<std::size_t>(views, std::size(scale) - 1)];
}

/** \brief As a normal map: each axis from −1 … 1 to 0 … 255. */
Rgb8 normalColor(const Eigen::Vector3f& n) {
  if (n.squaredNorm() < 0.5f) return kUnknown;
  const auto channel = [](float x) {
    return static_cast<std::uint8_t>(std::lround(127.5f * (1 + std::clamp(x, -1.0f, 1.0f))));
  };
  return {channel(n.x()), channel(n.y()), channel(n.z())};
}

Rgb8 truthColor(float distance) {
  return std::isfinite(distance) ? drawing::errorColor(distance, kTruthLimit) : drawing::errorColor(1, kTruthLimit);
}

}  // namespace

const std::vector<std::string>& colorByNames() {
  static const std::vector<std::string> names{"rgb", "confidence", "views", "camera", "truth", "normal"};
  return names;
}

Rgb8 cameraColor(std::size_t k) { return from(pcl::GlasbeyLUT::at((k + 2) % pcl::GlasbeyLUT::size())); }

std::vector<Rgb8> colorsOf(const Cloud& cloud, ColorBy what, const PointAttributes& attributes) {
  std::vector<Rgb8> colors(cloud.size(), kUnknown);
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    const PointFused& p = cloud[k];
    switch (what) {
      case ColorBy::Rgb:
        colors[k] = {p.r, p.g, p.b};
        break;
      case ColorBy::Confidence:
        if (attributes.confidence_known) colors[k] = viridis(p.confidence);
        break;
      case ColorBy::Views:
        if (attributes.views_known) colors[k] = viewsColor(p.view_count);
        break;
      case ColorBy::Camera:
        if (k < attributes.origins.size() && attributes.origins[k].camera != Origin::kNone)
          colors[k] = cameraColor(attributes.origins[k].camera);
        break;
      case ColorBy::TruthDistance:
        if (k < attributes.truth_distances.size()) colors[k] = truthColor(attributes.truth_distances[k]);
        break;
      case ColorBy::Normal:
        if (k < attributes.normals.size()) colors[k] = normalColor(attributes.normals[k]);
        break;
    }
  }
  return colors;
}

Legend legendOf(ColorBy what, const std::vector<std::string>& camera_names) {
  Legend legend;
  constexpr int kSteps = 64;
  const auto scale = [&](auto color) {
    for (int k = 0; k < kSteps; ++k) legend.colors.push_back(color(static_cast<float>(k) / (kSteps - 1)));
  };
  switch (what) {
    case ColorBy::Rgb:
    case ColorBy::Normal:
      break;
    case ColorBy::Confidence:
      legend.title = "confidence";
      scale(viridis);
      break;
    case ColorBy::TruthDistance:
      legend.title = "mm off truth";
      legend.high = 1000.0 * static_cast<double>(kTruthLimit);
      scale([](float share) { return truthColor(share * kTruthLimit); });
      break;
    case ColorBy::Views:
      legend.title = "cameras";
      for (std::uint32_t n = 1; n <= 4; ++n) {
        legend.colors.push_back(viewsColor(n));
        legend.labels.push_back(n < 4 ? std::to_string(n) : "4 or more");
      }
      break;
    case ColorBy::Camera:
      legend.title = "camera";
      for (std::size_t k = 0; k < camera_names.size(); ++k) {
        legend.colors.push_back(cameraColor(k));
        legend.labels.push_back(camera_names[k]);
      }
      break;
  }
  return legend;
}

}  // namespace fuse_flow::viewing
