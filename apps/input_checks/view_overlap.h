#pragma once

#include <fuse_flow/recordings/recording.h>
#include <fuse_flow/sensors/preprocessing.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Of one camera's points, as far as a grid of pixels tells. */
struct CameraOverlap {
  std::size_t points{0};
  std::size_t seen{0};    ///< of those: fall onto depth in another camera's image, and are not hidden from it
  std::size_t agreed{0};  ///< of those: that camera measured the same depth, to 5 cm and 2 per cent
};

/** \brief How far the views of one instant are of one place. \param frame with images and the cameras' poses
 *  \param range what counts as measured  \returns one for each camera */
std::vector<CameraOverlap> viewOverlap(const RigFrame& frame, const PreprocessingParameters& range);

/** \brief Says which cameras see nothing that another sees, or contradict the others: most often by poses that are in another frame,
 *  inverted, or of other axes. Looks at the first frames in which two cameras or more have depth. */
class OverlapCheck {
 public:
  explicit OverlapCheck(const PreprocessingParameters& range) : range_(range) {}
  void look(const RigFrame& frame);
  std::vector<std::string> complaints() const { return complaints_; }

 private:
  PreprocessingParameters range_;
  bool done_{false};
  std::vector<std::string> complaints_;
};

}  // namespace fuse_flow::io
