#pragma once

#include "recordings/logs/mcap_writer.h"

#include <fuse_flow/recordings/recording.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Writes the frames of a rig as messages of ROS 2 into an MCAP file, which ROS 2, Foxglove and openRecording() read: of each camera
 *  /NAME/depth/image_raw/compressedDepth by RVL without loss, or /NAME/depth/image_raw of float depth, and /NAME/color/image_raw/compressed by
 *  JPEG; camera_info of both, and tf_static from world. Throws OutputError; InputError where the build lacks a library. */
class RigMessages {
 public:
  struct Options {
    std::string compression;  ///< of chunks, see McapWriter; its images are compressed already
    int color_quality{95};    ///< of JPEG, 1 … 100
  };

  /** \param cameras where they stand, and whether a camera has colour  \throws OutputError for two names that are one in ROS */
  RigMessages(const std::string& path, const std::vector<Camera>& cameras, const std::vector<bool>& has_color,
              const Options& options);
  ~RigMessages();
  RigMessages(const RigMessages&) = delete;
  RigMessages& operator=(const RigMessages&) = delete;

  /** \brief What of the cameras is not in such a file, a line each. */
  const std::vector<std::string>& warnings() const { return warnings_; }

  /** \brief A message, ready to be written. */
  struct Encoded {
    std::uint16_t channel{0};
    Nanoseconds time{0};
    std::string bytes;  ///< in CDR
  };
  /** \brief Compresses the images of one camera; any number of threads may do so. \param time of its headers */
  std::vector<Encoded> encode(std::size_t camera, Nanoseconds time, const LoadedView& images) const;
  /** \brief Writes what encode() gave, after the calibration. */
  void write(const std::vector<Encoded>& messages);
  /** \brief encode() and write() of all cameras. */
  void write(Nanoseconds time, const LoadedFrame& frame);
  /** \brief See McapWriter::bytes(). */
  std::uint64_t bytes() const { return writer_.bytes(); }
  /** \brief See McapWriter::flush(). */
  void flush() { writer_.flush(); }
  /** \brief See McapWriter::finish(). */
  void finish();

 private:
  struct Channels {
    std::string name;  ///< of the camera, in ROS
    std::uint16_t depth{0}, float_depth{0}, depth_info{0}, color{0}, color_info{0};
  };

  void writeCalibration(Nanoseconds time);

  std::vector<Camera> cameras_;
  Options options_;
  McapWriter writer_;
  std::vector<Channels> channels_;
  std::uint16_t tf_{0};
  bool calibrated_{false};
  std::vector<std::string> warnings_;
};

/** \brief A camera's name as names must be in ROS: letters, digits and underscores. */
std::string nameInRos(std::string name);

/** \brief Wilson's lossless compression of depth, as image_transport has it. */
std::string encodeRvl(const DepthImage& image);

}  // namespace fuse_flow::io
