#pragma once

#include <fuse_flow/stream/description.h>

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

namespace fuse_flow::stream {

/** \brief Writes a stream to a file, .ffs. One thread may use it at a time. */
class StreamWriter {
 public:
  /** \throws std::runtime_error naming the file, if it cannot be written */
  StreamWriter(const std::string& path, const Description& description);
  /** \brief From here on, another description holds. \throws std::runtime_error */
  void describe(const Description& description);
  /** \param message a whole frame \throws std::runtime_error, as for a full disk; what was written before plays */
  void write(const std::uint8_t* message, std::size_t size);
  void write(const Message& message);

 private:
  void record(std::uint32_t kind, const std::vector<Message::Piece>& pieces);

  std::string path_;
  std::ofstream file_;
};

/** \brief Reads a file that StreamWriter wrote. One thread may use it at a time. */
class StreamReader {
 public:
  /** \throws FormatError if it is no stream file, std::runtime_error if it cannot be read; both name it */
  explicit StreamReader(const std::string& path);
  /** \brief That of the first record, and then of the frame that was read last. */
  const Description& description() const { return description_; }
  std::size_t frames() const { return frames_.size(); }
  /** \brief When a frame was captured, or else encoded, nanoseconds since 1970. */
  std::int64_t time(std::size_t frame) const { return frames_[frame].time; }
  /** \brief The bytes of a frame. \throws std::runtime_error */
  void read(std::size_t frame, std::vector<std::uint8_t>& message);
  /** \brief The file ends in a record: it was cut off. What is before it is there. */
  bool cutOff() const { return cut_off_; }

 private:
  struct Entry {
    std::uint64_t offset;
    std::uint32_t size;
    std::int64_t time;
    std::size_t description;
  };
  std::string path_;
  std::ifstream file_;
  Description description_;
  std::vector<Description> descriptions_;
  std::vector<Entry> frames_;
  bool cut_off_{false};
};

}  // namespace fuse_flow::stream
