#pragma once

#include <fuse_flow/camera.h>
#include <fuse_flow/stream/streamed_cloud.h>

#include <string>
#include <vector>

namespace fuse_flow::stream {

/** \brief What is known of a stream beside its frames. */
struct Description {
  std::string name;             ///< for people
  std::string frame{"world"};   ///< the name of the coordinate frame
  double step{0.001};           ///< metres, see EncodingOptions::step
  std::vector<Camera> cameras;  ///< name, intrinsics, T_world_camera
};

/** \brief As the text message of doc/reference/stream_format.md, UTF-8. */
std::string toJson(const Description& description);
/** \brief Unknown keys are ignored. \throws FormatError */
Description descriptionFromJson(const std::string& json);

}  // namespace fuse_flow::stream
