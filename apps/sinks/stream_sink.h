#pragma once

#include "sinks/frame_sink.h"

#include <fuse_flow/stream/server.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Of a frame that is encoded now. */
stream::FrameTimes timesOf(const FusedFrame& frame);

/** \brief Sends the cloud of each frame to the clients of a server. */
class StreamSink : public FrameSink {
 public:
  /** \param description its cameras are those of the first frame  \param images whether the cameras' colour images go with the clouds */
  StreamSink(std::shared_ptr<stream::Server> server, stream::Description description, bool images);

  /** \brief Cameras that have moved are told to the clients, once a second at most. */
  void take(const std::shared_ptr<const FusedFrame>& frame) override;
  std::vector<std::string> finish() override;

 private:
  void describe(const std::vector<Camera>& cameras);
  void publishImages(const std::shared_ptr<const FusedFrame>& frame, const stream::FrameTimes& times);

  std::shared_ptr<stream::Server> server_;
  stream::Description description_;
  bool images_;
  bool described_{false};
  std::chrono::steady_clock::time_point described_at_;
};

}  // namespace fuse_flow::io
