#include "viewer/live_frames.h"

#include <fuse_flow/recordings/error.h>

#include <chrono>
#include <utility>

namespace fuse_flow::viewing {

std::vector<std::string> LiveFrames::status() const {
  std::vector<std::string> lines;
  for (const io::CameraStatus& camera : rig_.status()) lines.push_back(io::describe(camera));
  return lines;
}

void LiveFrames::read(std::size_t, io::LoadedFrame& out) {
  if (auto newer = inlet_->slot_.waitAndTake(std::chrono::seconds(1))) {
    before_ = std::move(shown_);
    shown_ = std::move(*newer);
  }
  if (!shown_) throw io::InputError("the cameras have not delivered anything yet");
  out.rig = shown_->rig;
  out.images.assign(shown_->held.size(), {});
  out.damaged.clear();
  out.ended.clear();
}

const simulation::RayScene& LiveFrames::truth(std::size_t) {
  throw io::InputError("nobody knows the true surfaces of cameras that run");
}

}  // namespace fuse_flow::viewing
