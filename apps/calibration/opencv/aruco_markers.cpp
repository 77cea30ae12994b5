#include "calibration/opencv/aruco_markers.h"

#include "calibration/opencv/square_edges.h"

#include <fuse_flow/recordings/error.h>

#include <opencv2/core/version.hpp>

#define FUSE_FLOW_ARUCO_IN_OBJDETECT (CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 7))
#if FUSE_FLOW_ARUCO_IN_OBJDETECT
#include <opencv2/objdetect/aruco_detector.hpp>
#else
#include <opencv2/aruco.hpp>
#endif

#include <algorithm>

namespace fuse_flow::io {
namespace {

int dictionaryNumber(const std::string& name) {
  static constexpr std::pair<const char*, int> numbers[] = {{"DICT_4X4_50", cv::aruco::DICT_4X4_50},
                                                            {"DICT_4X4_100", cv::aruco::DICT_4X4_100},
                                                            {"DICT_4X4_250", cv::aruco::DICT_4X4_250},
                                                            {"DICT_4X4_1000", cv::aruco::DICT_4X4_1000},
                                                            {"DICT_5X5_50", cv::aruco::DICT_5X5_50},
                                                            {"DICT_5X5_100", cv::aruco::DICT_5X5_100},
                                                            {"DICT_5X5_250", cv::aruco::DICT_5X5_250},
                                                            {"DICT_5X5_1000", cv::aruco::DICT_5X5_1000},
                                                            {"DICT_6X6_50", cv::aruco::DICT_6X6_50},
                                                            {"DICT_6X6_100", cv::aruco::DICT_6X6_100},
                                                            {"DICT_6X6_250", cv::aruco::DICT_6X6_250},
                                                            {"DICT_6X6_1000", cv::aruco::DICT_6X6_1000},
                                                            {"DICT_7X7_50", cv::aruco::DICT_7X7_50},
                                                            {"DICT_7X7_100", cv::aruco::DICT_7X7_100},
                                                            {"DICT_7X7_250", cv::aruco::DICT_7X7_250},
                                                            {"DICT_7X7_1000", cv::aruco::DICT_7X7_1000},
                                                            {"DICT_ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL}};
  for (const auto& [known, number] : numbers)
    if (known == name) return number;
  throw InputError("marker family '" + name + "' is not known");
}

/** \brief Across a marker, without its border: of "DICT_4X4_50" 4. */
int bitsOf(const std::string& dictionary) { return dictionary == "DICT_ARUCO_ORIGINAL" ? 5 : dictionary.at(5) - '0'; }

}  // namespace

#if FUSE_FLOW_ARUCO_IN_OBJDETECT

struct ArucoMarkers::Library {
  explicit Library(int dictionary) : detector(cv::aruco::getPredefinedDictionary(dictionary), parameters()) {}
  static cv::aruco::DetectorParameters parameters() {
    cv::aruco::DetectorParameters p;
    p.cornerRefinementMethod = cv::aruco::CORNER_REFINE_CONTOUR;
    return p;
  }
  void detect(const cv::Mat& grey, std::vector<std::vector<cv::Point2f>>& corners, std::vector<int>& ids) const {
    detector.detectMarkers(grey, corners, ids);
  }
  cv::aruco::ArucoDetector detector;
};

#else

struct ArucoMarkers::Library {
  explicit Library(int number)
      : dictionary(cv::aruco::getPredefinedDictionary(number)), parameters(cv::aruco::DetectorParameters::create()) {
    parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_CONTOUR;
  }
  void detect(const cv::Mat& grey, std::vector<std::vector<cv::Point2f>>& corners, std::vector<int>& ids) const {
    cv::aruco::detectMarkers(grey, dictionary, corners, ids, parameters);
  }
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  cv::Ptr<cv::aruco::DetectorParameters> parameters;
};

#endif

ArucoMarkers::ArucoMarkers(const std::string& dictionary)
    : library_(std::make_unique<Library>(dictionaryNumber(dictionary))), border_(1.0 / (2 + bitsOf(dictionary))) {}
ArucoMarkers::~ArucoMarkers() = default;

std::vector<DetectedMarker> ArucoMarkers::detectWithEdges(const cv::Mat& grey) {
  std::vector<DetectedMarker> found = detect(grey);
  const auto blurred = [&](DetectedMarker& marker) { return !fitEdges(grey, border_, marker); };
  found.erase(std::remove_if(found.begin(), found.end(), blurred), found.end());
  return found;
}

std::vector<DetectedMarker> ArucoMarkers::detect(const cv::Mat& grey) {
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  library_->detect(grey, corners, ids);
  std::vector<DetectedMarker> found;
  for (std::size_t k = 0; k < ids.size(); ++k) {
    if (std::count(ids.begin(), ids.end(), ids[k]) > 1) continue;
    DetectedMarker marker;
    marker.id = ids[k];
    // OpenCV begins at the upper left and goes on clockwise; its pixels have their centres at integers, as ours.
    for (std::size_t c = 0; c < 4; ++c) marker.corners[c] = {corners[k][3 - c].x, corners[k][3 - c].y};
    found.push_back(marker);
  }
  return found;
}

}  // namespace fuse_flow::io
