#pragma once

#include <string>

namespace fuse_flow::stream::foxglove {

/** \brief A type of message, as Foxglove knows it. */
struct Schema {
  std::string name;         ///< "foxglove.PointCloud"
  std::string descriptors;  ///< what it consists of: a FileDescriptorSet of Protocol Buffers, in Base64
};

const Schema& pointCloudSchema();
const Schema& transformsSchema();
const Schema& calibrationSchema();
const Schema& imageSchema();

}  // namespace fuse_flow::stream::foxglove
