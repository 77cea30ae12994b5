#pragma once

#include "viewer/fusing/point_attributes.h"

#include <fuse_flow/depth_view.h>

#include <string>
#include <vector>

namespace fuse_flow::viewing {

/** \brief What the colour of a point shows. */
enum class ColorBy { Rgb, Confidence, Views, Camera, TruthDistance, Normal };

/** \brief "rgb", "confidence", "views", "camera", "truth", "normal", in the order of ColorBy. */
const std::vector<std::string>& colorByNames();

constexpr float kTruthLimit = 0.02f;  ///< distance from which on TruthDistance is red, metres

/** \brief What some colourings need beyond the cloud; as many as points, or empty if not needed. */
struct PointAttributes {
  bool confidence_known{true};  ///< false: the method has no confidence, even if the points have the field
  bool views_known{true};
  std::vector<Origin> origins;
  std::vector<Eigen::Vector3f> normals;
  std::vector<float> truth_distances;  ///< metres
};

/** \brief The colour of each point. A point is grey if its attribute is not known. */
std::vector<Rgb8> colorsOf(const Cloud& cloud, ColorBy what, const PointAttributes& attributes);

/** \brief The colour that camera number k has, in the cloud, as a frustum, and in the strip of images. */
Rgb8 cameraColor(std::size_t k);

/** \brief What a colour means: a scale from low to high with a title. */
struct Legend {
  std::string title;  ///< empty: rgb, which needs no explanation
  double low{0};
  double high{1};
  std::vector<Rgb8> colors;         ///< from low to high
  std::vector<std::string> labels;  ///< of each colour, if they are categories; else empty
};

/** \param camera_names of the categories of ColorBy::Camera */
Legend legendOf(ColorBy what, const std::vector<std::string>& camera_names);

}  // namespace fuse_flow::viewing
