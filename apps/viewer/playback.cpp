#include "viewer/playback.h"

#include <algorithm>
#include <cmath>

namespace fuse_flow::viewing {

void Playback::advance(double seconds) {
  if (!playing_) return;
  position_ += seconds * frames_per_second_ * speed_;
  if (!frames_ || position_ < last() + 1) return;
  if (loop_) {
    position_ = std::fmod(position_, last() + 1);
  } else {
    position_ = last();
    playing_ = false;
  }
}

void Playback::play() {
  if (!loop_ && frames_ && frame() + 1 == *frames_) position_ = 0;  // as every player does at the end
  playing_ = true;
}

void Playback::step(long frames) {
  playing_ = false;
  double target = std::floor(position_) + static_cast<double>(frames);
  if (frames_ && loop_) {
    const double count = last() + 1;
    target -= count * std::floor(target / count);
  }
  seek(static_cast<std::size_t>(std::max(0.0, target)));
}

void Playback::seek(std::size_t frame) {
  position_ = static_cast<double>(frame);
  if (frames_) position_ = std::min(position_, last());
}

void Playback::seekEnd() {
  if (frames_) position_ = last();
}

void Playback::setSpeed(double speed) { speed_ = std::clamp(speed, kSlowest, kFastest); }

std::size_t Playback::frame() const { return static_cast<std::size_t>(position_); }

}  // namespace fuse_flow::viewing
