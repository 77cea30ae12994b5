#pragma once

#include "viewer/frame_source.h"

#include <fuse_flow/stream/client.h>
#include <fuse_flow/stream/stream_file.h>

#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::viewing {

/** \brief Clouds that a server sends: the newest, whatever frame is asked for. */
class StreamedFrames : public FrameSource {
 public:
  /** \throws io::InputError if it is no link */
  StreamedFrames(const std::string& link, const stream::ClientOptions& options);

  std::string name() const override { return name_; }
  std::optional<std::size_t> frameCount() const override { return std::nullopt; }
  std::optional<double> framesPerSecond() const override { return std::nullopt; }
  std::vector<std::string> status() const override;
  /** \brief Waits until there is a newer cloud, for a second at most: then the last one is given again. \throws io::InputError if there has
   *  been none, saying why */
  void read(std::size_t frame, io::LoadedFrame& out) override;
  FinishedCloud finished() const override { return cloud_; }
  bool isFinished() const override { return true; }
  bool knowsTruth() const override { return false; }
  const simulation::RayScene& truth(std::size_t frame) override;

 private:
  std::string name_;
  stream::Client client_;
  stream::FrameDecoder decoder_;
  stream::ReceivedFrame received_;
  stream::StreamedCloud streamed_;
  FinishedCloud cloud_;
  std::vector<std::string> lines_;
  std::deque<std::pair<double, std::size_t>> arrivals_;  ///< seconds, bytes; of the last two seconds
};

/** \brief Clouds of a stream that was kept. */
class KeptFrames : public FrameSource {
 public:
  /** \throws io::InputError */
  explicit KeptFrames(const std::string& path);

  std::string name() const override { return path_; }
  std::optional<std::size_t> frameCount() const override { return reader_->frames(); }
  std::optional<double> framesPerSecond() const override;
  std::vector<std::string> inputs() const override { return {path_}; }
  void read(std::size_t frame, io::LoadedFrame& out) override;
  FinishedCloud finished() const override { return cloud_; }
  bool isFinished() const override { return true; }
  bool knowsTruth() const override { return false; }
  const simulation::RayScene& truth(std::size_t frame) override;
  /** \brief The file ends in a frame. */
  bool cutOff() const { return reader_->cutOff(); }

 private:
  std::string path_;
  std::unique_ptr<stream::StreamReader> reader_;
  stream::FrameDecoder decoder_;
  std::vector<std::uint8_t> message_;
  stream::StreamedCloud streamed_;
  FinishedCloud cloud_;
};

}  // namespace fuse_flow::viewing
