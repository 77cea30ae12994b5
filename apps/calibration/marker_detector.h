#pragma once

#include <fuse_flow/math/pinhole.h>
#include <fuse_flow/recordings/image.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief A square marker in an image. */
struct DetectedMarker {
  int id{0};  ///< its number in its family
  /** \brief Of its black square, as it is read: lower left, lower right, upper right, upper left; pixels. */
  std::array<Pixel, 4> corners{};
};

/** \brief Finds AprilTags, by the library of that name. */
class MarkerDetector {
 public:
  /** \param family "tag36h11" and so on; see families(). Throws OptionError, beginning with --board, if this build has no
   *  library for it, and InputError for another name. */
  explicit MarkerDetector(const std::string& family);
  ~MarkerDetector();
  MarkerDetector(const MarkerDetector&) = delete;
  MarkerDetector& operator=(const MarkerDetector&) = delete;

  /** \brief The markers that can be identified: if two have the same number, neither of them. */
  std::vector<DetectedMarker> detect(const ColorImage& image);

  static std::vector<std::string> families() { return {"tag36h11", "tag25h9", "tag16h5", "tagStandard41h12"}; }
  /** \brief Whether this build has the library. */
  static bool available();

 private:
  struct Library;
  std::unique_ptr<Library> library_;
};

}  // namespace fuse_flow::io
