#pragma once

#include "calibration/marker_detector.h"

#include <opencv2/core.hpp>

namespace fuse_flow::io {

/** \brief Moves the corners of a black square on white to where curves through its edges meet, to a tenth of a pixel, from a pixel or
 *  two away. OpenCV's own refinements take in the bits of a marker as well, or round to pixels.
 *  \param border width of what is black along the edges, as a share of the side. \return False if an edge is not there. */
bool fitEdges(const cv::Mat& grey, double border, DetectedMarker& marker);

}  // namespace fuse_flow::io
