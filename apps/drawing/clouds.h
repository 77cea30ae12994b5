#pragma once

#include <fuse_flow/recordings/image.h>

#include <Eigen/Core>

#include <string>
#include <vector>

namespace fuse_flow::drawing {

/** \brief Colours of each point, channels 0 … 255; as many as positions. */
struct ColoredPoints {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Rgb8> colors;
};

/** \brief How to look at a cloud; world frame, metres. */
struct Viewpoint {
  std::vector<double> from;  ///< where the viewer stands; empty: outside the bounding box
  std::vector<double> at;    ///< what the viewer looks at; empty: the middle of the first cloud
  std::vector<double> up{0, 0, 1};
  double zoom{1.0};
  float point_size{2.0f};  ///< pixels
  int width{1600};
  int height{800};
};

/** \brief Clouds side by side from one viewpoint. Throws io::InputError without a display. */
io::ColorImage drawClouds(const std::vector<ColoredPoints>& clouds, const Viewpoint& viewpoint);

/** \brief The colour of a distance to the true surface: blue at 0, green, yellow, and red from the limit on. */
Rgb8 errorColor(float distance, float limit);

}  // namespace fuse_flow::drawing
