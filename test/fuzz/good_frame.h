#pragma once

#include "fuzz_target.h"

#include <fuse_flow/recordings/recording.h>

#include <pcl/exceptions.h>

namespace fuse_flow_fuzz {

/** \brief What a reader accepts must be what FuseFlow accepts: its messages name no file. */
inline void requireGoodFrame(const fuse_flow::io::LoadedFrame& frame) {
  try {
    fuse_flow::checkRigFrame(frame.rig);
  } catch (const pcl::PCLException& error) {
    throw Finding(std::string("a frame was read that cannot be fused: ") + error.what());
  }
}

/** \brief Opens a recording, and reads its first frames. \param options with what the kind needs; one thread reads, so that runs are the same */
inline void readRecording(const std::vector<std::string>& inputs, fuse_flow::io::RecordingOptions options = {}) {
  using namespace fuse_flow;
  options.threads = 1;
  accepts<io::InputError>([&] {
    const auto recording = io::openRecording(inputs, options);
    std::size_t left = 3;  // frames
    for (const std::size_t number : recording->frames()) {
      if (left-- == 0) break;
      io::LoadedFrame frame;
      if (accepts<io::InputError>([&] { recording->read(number, frame); })) requireGoodFrame(frame);
    }
  });
}

}  // namespace fuse_flow_fuzz
