#pragma once

#include "recordings/messages/cloud_messages.h"

#include <fuse_flow/stream/description.h>
#include <fuse_flow/stream/streamed_cloud.h>

#include <string>

namespace fuse_flow::io {

/** \brief Writes clouds that were received as an MCAP file, which ROS 2 and Foxglove play. Throws as CloudMessages. */
class CloudMcapWriter {
 public:
  /** \param compression "lz4", "zstd" or "", see McapWriter */
  explicit CloudMcapWriter(const std::string& path, const std::string& compression = "zstd")
      : messages_(path, compression) {}

  /** \brief From the next cloud on, this holds. */
  void describe(const stream::Description& description);
  /** \brief At the time when it was captured, else encoded. */
  void write(const stream::StreamedCloud& cloud);
  std::uint64_t bytes() const { return messages_.bytes(); }
  /** \brief The end of the file. Without it, it is one of a program that was killed: it plays up to the last four megabytes. */
  void finish() { messages_.finish(); }

 private:
  CloudMessages messages_;
};

}  // namespace fuse_flow::io
