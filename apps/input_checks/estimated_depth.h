#pragma once

#include <fuse_flow/fusion/parameters.h>

#include <fuse_flow/fusion/statistics.h>
#include <fuse_flow/rig_frame.h>

#include <cstddef>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief One line where depth that was estimated from photographs is fused as if a camera had measured it; else nothing.
 *  \param kind of the recording, see Recording::kind(); "stereo" if depth of its views was estimated here  \param method that fuses it, see makeMethod() */
std::vector<std::string> estimatedDepthAdvice(const std::string& kind, const std::string& method,
                                              const FuseFlowParameters& parameters);

/** \brief Finds out whether agreement of views (AgreementParameters) drops nearly all: then depth and poses do not fit. */
class AgreementCheck {
 public:
  /** \param method that fuses, see makeMethod(); of others than ours nothing is looked at */
  AgreementCheck(const std::string& method, const FuseFlowParameters& parameters)
      : min_views_(method == "fuse_flow" ? parameters.agreement.min_views : 0), cropped_(parameters.crop_box) {}

  /** \param statistics of the frame, fused */
  void look(const RigFrame& frame, const FrameStatistics& statistics);

  /** \brief A line for each thing that is wrong. */
  std::vector<std::string> complaints() const;

 private:
  int min_views_;
  bool cropped_;  ///< then much may be dropped for another reason
  std::size_t frames_{0};
  std::size_t measured_{0}, kept_{0};  ///< measurements
  std::size_t frames_of_few_{0};       ///< in which too few cameras have depth
};

}  // namespace fuse_flow::io
