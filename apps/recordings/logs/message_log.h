#pragma once

#include "recordings/streams/frame_sets.h"

#include <fuse_flow/recordings/error.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief How the numbers of a message are laid out. */
enum class Wire {
  Ros1,  ///< packed, little endian
  Cdr    ///< aligned, as ROS 2 has it from DDS
};

/** \brief A topic of a log, and when its messages came. */
struct Topic {
  std::string name;  ///< "/camera/depth/image_raw"
  std::string type;  ///< "sensor_msgs/Image", also of ROS 2
  Wire wire{Wire::Ros1};
  std::vector<Nanoseconds> times;  ///< when each message was written, in the log's order
};

/** \brief The messages of a bag, whatever its format: any message of any topic. Only one thread may use an object. */
class MessageLog {
 public:
  virtual ~MessageLog() = default;

  /** \brief With a message at least. */
  const std::vector<Topic>& topics() const { return topics_; }
  const std::string& path() const { return path_; }
  /** \brief Losses at opening, a line each. */
  const std::vector<std::string>& warnings() const { return warnings_; }
  /** \brief The number of a topic. */
  std::optional<std::size_t> find(const std::string& name) const;

  /** \brief The bytes of a message. Fastest in the order of time. Throws InputError. */
  virtual void read(std::size_t topic, std::size_t message, std::string& bytes) = 0;
  /** \brief Its first bytes, or more, where they can be had for less. */
  virtual void readStart(std::size_t topic, std::size_t message, std::size_t count, std::string& bytes) {
    (void)count;
    read(topic, message, bytes);
  }

 protected:
  std::string path_;
  std::vector<Topic> topics_;
  std::vector<std::string> warnings_;
};

/** \brief A ROS 1 bag, chunks uncompressed or by LZ4 or bzip2. Throws InputError. */
std::unique_ptr<MessageLog> openRosBag(const std::string& path);

/** \brief An MCAP file, chunks uncompressed or by LZ4 or Zstandard, with messages of ROS 1 and ROS 2. It is gone through once, chunk by chunk, also when its
 *  recorder was killed before it wrote the summary. Throws InputError. */
std::unique_ptr<MessageLog> openMcap(const std::string& path);

/** \brief A ROS 2 bag in SQLite. Throws InputError. */
std::unique_ptr<MessageLog> openSqliteBag(const std::string& path);

/** \brief The messages of several logs, one behind the other. */
std::unique_ptr<MessageLog> joinLogs(const std::string& path, std::vector<std::unique_ptr<MessageLog>> parts);

}  // namespace fuse_flow::io
