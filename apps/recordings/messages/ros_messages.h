#pragma once

#include "recordings/messages/wire_reader.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace fuse_flow::io {

// The messages of ROS 1 and 2 that describe depth cameras. Every read…() throws InputError where a message is too short.

/** \brief std_msgs/Header. */
struct HeaderMessage {
  Nanoseconds stamp{0};
  std::string frame;  ///< name of the coordinate frame
};

/** \brief sensor_msgs/Image; data as long as the message's bytes stay. */
struct ImageMessage {
  HeaderMessage header;
  std::uint32_t height{0}, width{0};
  std::string encoding;
  bool big_endian{false};
  std::uint32_t step{0};  ///< bytes from row to row
  std::string_view data;
};

/** \brief sensor_msgs/CompressedImage; data as long as the message's bytes stay. */
struct CompressedImageMessage {
  HeaderMessage header;
  std::string format;
  std::string_view data;
};

/** \brief sensor_msgs/CameraInfo, as far as it is used. */
struct CameraInfoMessage {
  HeaderMessage header;
  std::uint32_t height{0}, width{0};
  std::string distortion_model;
  std::vector<double> D;
  double K[9]{};
  double P[12]{};
  std::uint32_t binning_x{0}, binning_y{0};
  std::uint32_t roi_x{0}, roi_y{0}, roi_height{0}, roi_width{0};
};

/** \brief geometry_msgs/TransformStamped. */
struct TransformMessage {
  HeaderMessage header;  ///< its frame is the parent
  std::string child;
  Eigen::Isometry3d T_parent_child = Eigen::Isometry3d::Identity();
};

HeaderMessage readHeader(WireReader& in);
ImageMessage readImage(WireReader& in);
CompressedImageMessage readCompressedImage(WireReader& in);
CameraInfoMessage readCameraInfo(WireReader& in);
/** \brief tf2_msgs/TFMessage and tf/tfMessage. */
std::vector<TransformMessage> readTransforms(WireReader& in);
/** \brief geometry_msgs/Transform. */
Eigen::Isometry3d readTransform(WireReader& in);

}  // namespace fuse_flow::io
