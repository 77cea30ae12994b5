// In place of marker_detector.cpp where libapriltag is not there.

#include "calibration/marker_detector.h"

#include <fuse_flow/recordings/error.h>

namespace fuse_flow::io {

struct MarkerDetector::Library {};

MarkerDetector::MarkerDetector(const std::string&) {
  throw OptionError("--board: this build cannot find markers; install libapriltag-dev and build again");
}

MarkerDetector::~MarkerDetector() = default;

std::vector<DetectedMarker> MarkerDetector::detect(const ColorImage&) { return {}; }

bool MarkerDetector::available() { return false; }

}  // namespace fuse_flow::io
