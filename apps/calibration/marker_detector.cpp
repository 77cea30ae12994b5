#include "calibration/marker_detector.h"

#include "calibration/grey.h"

#include <fuse_flow/recordings/error.h>

#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagStandard41h12.h>

#include <algorithm>

namespace fuse_flow::io {
namespace {

using Family = std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)>;
using Detections = std::unique_ptr<zarray_t, void (*)(zarray_t*)>;

Family makeFamily(const std::string& name) {
  if (name == "tag36h11") return {tag36h11_create(), tag36h11_destroy};
  if (name == "tag25h9") return {tag25h9_create(), tag25h9_destroy};
  if (name == "tag16h5") return {tag16h5_create(), tag16h5_destroy};
  if (name == "tagStandard41h12") return {tagStandard41h12_create(), tagStandard41h12_destroy};
  throw InputError("marker family '" + name + "' is not known");
}

}  // namespace

struct MarkerDetector::Library {
  explicit Library(const std::string& name)
      : family(makeFamily(name)), detector(apriltag_detector_create(), apriltag_detector_destroy) {
    apriltag_detector_add_family_bits(detector.get(), family.get(), 1);
    detector->quad_decimate = 1;  // half the image would cost half of the precision
    detector->nthreads = 1;
  }
  Family family;
  std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)> detector;  // gone before the family it holds
};

MarkerDetector::MarkerDetector(const std::string& family) : library_(std::make_unique<Library>(family)) {}
MarkerDetector::~MarkerDetector() = default;

std::vector<DetectedMarker> MarkerDetector::detect(const ColorImage& image) {
  std::vector<DetectedMarker> found;
  if (image.empty()) return found;
  std::vector<std::uint8_t> grey = toGrey(image);
  image_u8_t view{image.width, image.height, image.width, grey.data()};
  const Detections all(apriltag_detector_detect(library_->detector.get(), &view), apriltag_detections_destroy);
  std::vector<int> ids;
  for (int k = 0; k < zarray_size(all.get()); ++k) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(all.get(), k, &detection);
    DetectedMarker marker;
    marker.id = detection->id;
    for (std::size_t c = 0; c < 4; ++c)  // the library's pixels have their corners at integers, ours their centres
      marker.corners[c] = {static_cast<float>(detection->p[c][0] - 0.5), static_cast<float>(detection->p[c][1] - 0.5)};
    ids.push_back(marker.id);
    found.push_back(marker);
  }
  const auto twice = [&](const DetectedMarker& m) { return std::count(ids.begin(), ids.end(), m.id) > 1; };
  found.erase(std::remove_if(found.begin(), found.end(), twice), found.end());
  return found;
}

bool MarkerDetector::available() { return true; }

}  // namespace fuse_flow::io
