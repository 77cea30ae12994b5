#pragma once

#include "recordings/streams/frame_sets.h"

#include <cstdint>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace fuse_flow::io {

/** \brief Writes an MCAP file of ROS 2's messages: in chunks, each with its index, and at the end a summary. A program that is killed leaves a
 *  file that plays up to the last chunk. Only one thread may use an object. Throws OutputError. */
class McapWriter {
 public:
  /** \param compression of chunks: "lz4", "zstd" or ""  \throws InputError for one that the build has no library for */
  McapWriter(const std::string& path, std::string compression);

  /** \brief \param type "sensor_msgs/msg/Image" \param definition of the type, as ROS 2 has it  \returns the channel's number */
  std::uint16_t addChannel(const std::string& topic, const std::string& type, const std::string& definition);
  /** \brief \param bytes in CDR */
  void write(std::uint16_t channel, Nanoseconds time, std::string_view bytes);
  /** \brief Ends the chunk: what was written so far can be read, even if the program is killed. */
  void flush() { endChunk(); }
  /** \brief The summary, and the end. Without it, the file is one of a program that was killed. */
  void finish();
  /** \brief Bytes that are written. */
  std::uint64_t bytes() const { return at_; }

 private:
  struct Schema {
    std::string name, definition;
  };
  struct Channel {
    std::uint16_t schema;
    std::string topic;
    std::uint64_t messages{0};
  };
  struct ChunkIndex {
    std::uint64_t start{0}, end{0};  ///< times
    std::uint64_t offset{0}, length{0};
    std::map<std::uint16_t, std::uint64_t> index_offsets;
    std::uint64_t index_length{0}, stored{0}, size{0};
  };

  void put(const std::string& bytes);
  void endChunk();
  static std::string schemaRecord(std::uint16_t id, const Schema& schema);
  static std::string channelRecord(std::uint16_t id, const Channel& channel);

  std::string path_;
  std::string compression_;
  std::ofstream file_;
  std::uint64_t at_{0};
  std::vector<Schema> schemas_;    // from 1 on
  std::vector<Channel> channels_;  // from 1 on
  std::vector<ChunkIndex> chunks_;
  std::uint64_t start_{~std::uint64_t{0}}, end_{0};
  // Of the chunk that grows:
  std::string records_;
  std::uint64_t chunk_start_{~std::uint64_t{0}}, chunk_end_{0};
  std::map<std::uint16_t, std::string> index_;
};

}  // namespace fuse_flow::io
