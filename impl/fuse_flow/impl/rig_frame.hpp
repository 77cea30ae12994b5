#pragma once

#include <fuse_flow/rig_frame.h>

namespace fuse_flow {
namespace detail {

template <typename Pixel>
void checkImage(const Owner& owner, const char* what, const ImageView<Pixel>& image, const Intrinsics& expected) {
  if (!image) return;
  if (image.width != expected.width || image.height != expected.height)
    throwBadArgument(owner, ": ", what, " image is ", image.width, "x", image.height, ", its camera is ",
                     expected.width, "x", expected.height);
  if (image.row_stride < sizeof(Pixel) * static_cast<std::size_t>(image.width))
    throwBadArgument(owner, ": ", what, " row stride is ", image.row_stride, " bytes, less than a row");
}

inline void checkView(const Camera& camera, const DepthView& view) {
  const Owner owner{"fuse_flow::DepthView of camera '", camera.name, "'"};
  if (view.depth16 && view.depth32) throwBadArgument(owner, ": both depth16 and depth32 are set, must be one");
  checkImage(owner, "depth", view.depth16, camera.intrinsics);
  checkImage(owner, "depth", view.depth32, camera.intrinsics);
  checkImage(owner, "confidence", view.confidence, camera.intrinsics);
  checkImage(owner, "color", view.color, camera.color ? camera.color->intrinsics : camera.intrinsics);
}

}  // namespace detail

inline void checkRigFrame(const RigFrame& frame) {
  if (frame.cameras.empty()) detail::throwBadArgument("fuse_flow::RigFrame: has no camera");
  if (frame.cameras.size() != frame.views.size())
    detail::throwBadArgument("fuse_flow::RigFrame: has ", frame.cameras.size(), " cameras but ", frame.views.size(),
                             " views");
  for (std::size_t i = 0; i < frame.cameras.size(); ++i) {
    checkCamera(frame.cameras[i]);
    if (!frame.views[i].missing()) detail::checkView(frame.cameras[i], frame.views[i]);
  }
}

}  // namespace fuse_flow
