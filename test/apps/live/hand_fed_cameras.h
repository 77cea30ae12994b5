#pragma once

#include "live/camera_source.h"
#include "numbered_rig.h"

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace live_test {

/** \brief Cameras that deliver when a test says so: images of a NumberedRig, whatever they are called. */
class HandFedCameras : public io::CameraSource {
 public:
  explicit HandFedCameras(std::vector<std::string> names, ClockModel clocks = ClockModel::Shared, bool posed = true)
      : clocks_(clocks), posed_(posed) {
    const NumberedRig rig(names.size(), 1);
    cameras_ = rig.cameras();
    for (std::size_t k = 0; k < names.size(); ++k) cameras_[k].name = names[k];
  }
  const std::vector<Camera>& cameras() const override { return cameras_; }
  bool hasPoses() const override { return posed_; }
  /** \brief One that is called "rgb" has none. */
  bool hasDepth(std::size_t camera) const override { return cameras_[camera].name != "rgb"; }
  /** \brief One that is called "webcam" does not know them. */
  bool hasIntrinsics(std::size_t camera) const override { return cameras_[camera].name != "webcam"; }
  ClockModel clocks() const override { return clocks_; }
  void start(const Receiver& receiver) override { receiver_ = receiver; }
  void stop() override { receiver_ = {}; }
  bool running() const override { return runs; }
  std::string failure() const override { return why; }

  void deliver(std::size_t camera, std::uint64_t stamp, std::size_t frame = 0, std::chrono::microseconds age = {}) {
    receiver_.view({camera, stamp, std::make_shared<io::LoadedView>(NumberedRig::imagesOf(camera, frame)), age});
  }
  void notice(const std::string& line) { receiver_.notice(line); }

  std::atomic<bool> runs{true};
  std::string why;

 private:
  ClockModel clocks_;
  bool posed_;
  std::vector<Camera> cameras_;
  Receiver receiver_;
};

}  // namespace live_test
