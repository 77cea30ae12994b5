#include "input_checks/empty_clouds.h"

#include "methods/why_empty.h"

namespace fuse_flow::io {

void EmptyClouds::look(std::size_t number, const RigFrame& frame, std::size_t points, bool whole) {
  ++frames_;
  if (points > 0) return;
  if (++empty_ > 1) return;
  first_ = "frame " + std::to_string(number);
  if (!whole || !knowsConfidence(method_)) return;
  MethodOptions options = options_;
  options.encoding = nullptr;
  first_ += ": " + whyEmpty(method_, options, frame, SettingNames::Options);
}

std::vector<std::string> EmptyClouds::complaints() const {
  if (empty_ == 0) return {};
  return {std::to_string(empty_) + " of " + std::to_string(frames_) + " clouds are empty, the first of " + first_};
}

}  // namespace fuse_flow::io
