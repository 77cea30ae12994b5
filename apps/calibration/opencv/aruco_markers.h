#pragma once

#include "calibration/marker_detector.h"

#include <opencv2/core.hpp>

#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Finds ArUco markers by OpenCV, whose interface is another one from 4.7 on. */
class ArucoMarkers {
 public:
  /** \param dictionary of BoardKind::dictionaries() */
  explicit ArucoMarkers(const std::string& dictionary);
  ~ArucoMarkers();
  ArucoMarkers(const ArucoMarkers&) = delete;
  ArucoMarkers& operator=(const ArucoMarkers&) = delete;

  /** \brief The markers that can be identified: if two have the same number, neither of them. Corners to about a pixel. */
  std::vector<DetectedMarker> detect(const cv::Mat& grey);
  /** \brief Those with a margin of white around them, of two cells or so, corners to a tenth of a pixel. */
  std::vector<DetectedMarker> detectWithEdges(const cv::Mat& grey);

 private:
  struct Library;
  std::unique_ptr<Library> library_;
  double border_;  ///< width of a marker's border, as a share of its side
};

}  // namespace fuse_flow::io
