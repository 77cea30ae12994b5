#include "input_checks/estimated_depth.h"

#include <algorithm>

namespace fuse_flow::io {

std::vector<std::string> estimatedDepthAdvice(const std::string& kind, const std::string& method,
                                              const FuseFlowParameters& parameters) {
  const bool stereo = kind == "stereo", estimated = stereo || kind == "mvsnet" || kind == "colmap";
  if (!estimated || method != "fuse_flow" || parameters.agreement.min_views > 0) return {};
  return {"depth of this recording is estimated from photographs, and is fused as a depth camera's; --depth-source " +
          std::string(stereo ? "stereo" : "network") + " drops what too few views agree on"};
}

void AgreementCheck::look(const RigFrame& frame, const FrameStatistics& statistics) {
  if (min_views_ == 0) return;
  ++frames_;
  measured_ += statistics.measured_points;
  kept_ += statistics.gated_points;
  const auto there =
      std::count_if(frame.views.begin(), frame.views.end(), [](const DepthView& v) { return !v.missing(); });
  frames_of_few_ += there <= min_views_ ? 1 : 0;
}

std::vector<std::string> AgreementCheck::complaints() const {
  std::vector<std::string> lines;
  const std::string option = "--min-agreeing-views " + std::to_string(min_views_);
  if (frames_of_few_ > 0)
    lines.push_back("in " + std::to_string(frames_of_few_) + " of " + std::to_string(frames_) +
                    " frames too few cameras have depth for " + option);
  if (!cropped_ && frames_of_few_ < frames_ && measured_ > 0 && kept_ < measured_ / 10)
    lines.push_back(std::to_string(kept_) + " of " + std::to_string(measured_) + " measurements are left: " + option +
                    " drops what fewer other views measure, too; do depth and poses fit (one unit, poses not inverted, "
                    "rows not upside down, depth along the axis and not along the ray)?");
  return lines;
}

}  // namespace fuse_flow::io
