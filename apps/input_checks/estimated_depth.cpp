#include "input_checks/estimated_depth.h"

namespace fuse_flow::io {

std::vector<std::string> estimatedDepthAdvice(const std::string& kind, const std::string& method,
                                              const FuseFlowParameters& parameters) {
  const bool estimated = kind == "mvsnet" || kind == "colmap";
  if (!estimated || method != "fuse_flow" || parameters.agreement.min_views > 0) return {};
  return {"the depth of this recording was estimated from photographs, and is fused as a depth camera's; --depth-source "
          "network drops what too few views agree on"};
}

}  // namespace fuse_flow::io
