#pragma once

#include "recordings/logs/mcap_writer.h"

#include <fuse_flow/camera.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Points as arrays; null: they have no such field. */
struct CloudArrays {
  std::size_t points{0};
  const float* positions{nullptr};          ///< x, y, z of each, metres
  const std::uint8_t* colors{nullptr};      ///< r, g, b of each
  const std::uint8_t* confidence{nullptr};  ///< 255 is 1
  const std::uint8_t* view_counts{nullptr};
  const float* normals{nullptr};  ///< x, y, z of each
};

/** \brief Writes clouds as messages of ROS 2 into an MCAP file, which ROS 2 and Foxglove play: /points, a sensor_msgs/msg/PointCloud2 a frame, with
 *  the fields that PCL's types and this project's have, and /tf_static from the frame of the clouds to each camera. Only one thread may use an
 *  object. Throws OutputError; InputError where the build lacks a library. */
class CloudMessages {
 public:
  /** \param compression see McapWriter */
  CloudMessages(const std::string& path, const std::string& compression);

  /** \brief From the next cloud on, this holds. Cameras whose names are one in ROS are numbered. \param frame name of the coordinate frame */
  void describe(const std::string& frame, const std::vector<Camera>& cameras);
  void write(Nanoseconds time, const CloudArrays& cloud);
  /** \brief See McapWriter::bytes(). */
  std::uint64_t bytes() const { return writer_.bytes(); }
  /** \brief See McapWriter::finish(). */
  void finish() { writer_.finish(); }

 private:
  void writeTransforms(Nanoseconds time);

  McapWriter writer_;
  std::uint16_t points_{0}, tf_{0};
  std::string frame_{"world"};
  std::vector<Camera> cameras_;
  bool described_{false};  ///< the transforms are written
};

}  // namespace fuse_flow::io
