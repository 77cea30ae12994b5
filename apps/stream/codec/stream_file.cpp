#include "stream/codec/frame_layout.h"

#include <fuse_flow/stream/stream_file.h>

#include <cstring>
#include <limits>
#include <stdexcept>

namespace fuse_flow::stream {

namespace {

constexpr char kMagic[8] = {'F', 'F', 'S', '1', 0, 0, 0, 0};
enum Kind : std::uint32_t { kDescription = 1, kFrame = 2 };
constexpr std::uint32_t kMostDescription = 16u << 20;  // bytes

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error(path + ": " + what);
}

}  // namespace

StreamWriter::StreamWriter(const std::string& path, const Description& description)
    : path_(path), file_(path, std::ios::binary) {
  if (!file_) fail(path_, "cannot be written");
  file_.write(kMagic, sizeof(kMagic));
  describe(description);
}

void StreamWriter::describe(const Description& description) {
  const std::string json = toJson(description);
  record(kDescription, {{reinterpret_cast<const std::uint8_t*>(json.data()), json.size()}});
}

void StreamWriter::write(const std::uint8_t* message, std::size_t size) { record(kFrame, {{message, size}}); }

void StreamWriter::write(const Message& message) { record(kFrame, message.pieces); }

void StreamWriter::record(std::uint32_t kind, const std::vector<Message::Piece>& pieces) {
  std::size_t sum = 0;
  for (const Message::Piece& piece : pieces) sum += piece.size;
  if (sum > std::numeric_limits<std::uint32_t>::max()) fail(path_, "a frame of more than 4 GB cannot be written");
  const std::uint32_t header[2] = {static_cast<std::uint32_t>(sum), kind};
  file_.write(reinterpret_cast<const char*>(header), sizeof(header));
  for (const Message::Piece& piece : pieces)
    file_.write(reinterpret_cast<const char*>(piece.data), static_cast<std::streamsize>(piece.size));
  file_.flush();
  if (!file_) fail(path_, "cannot be written to its end; what is in it plays");
}

StreamReader::StreamReader(const std::string& path) : path_(path), file_(path, std::ios::binary) {
  if (!file_) fail(path_, "cannot be read");
  file_.seekg(0, std::ios::end);
  const auto size = static_cast<std::uint64_t>(file_.tellg());
  file_.seekg(0);
  char magic[sizeof(kMagic)] = {};
  file_.read(magic, sizeof(magic));
  if (!file_ || std::memcmp(magic, kMagic, sizeof(magic)) != 0)
    throw FormatError(path_ + ": no stream file: it does not begin with FFS1");
  std::uint64_t at = sizeof(kMagic);
  while (at < size) {
    std::uint32_t header[2];
    if (size - at < sizeof(header)) {
      cut_off_ = true;
      break;
    }
    file_.seekg(static_cast<std::streamoff>(at));
    file_.read(reinterpret_cast<char*>(header), sizeof(header));
    if (!file_) fail(path_, "cannot be read");
    at += sizeof(header);
    if (size - at < header[0]) {
      cut_off_ = true;
      break;
    }
    if (header[1] == kDescription) {
      if (header[0] > kMostDescription) throw FormatError(path_ + ": damaged: a description of more than 16 MB");
      std::string json(header[0], '\0');
      file_.read(json.data(), static_cast<std::streamsize>(json.size()));
      try {
        descriptions_.push_back(descriptionFromJson(json));
      } catch (const FormatError& error) {
        throw FormatError(path_ + ": " + error.what());
      }
    } else if (header[1] == kFrame) {
      if (descriptions_.empty()) throw FormatError(path_ + ": damaged: a frame comes before the description");
      std::uint8_t begin[kHeaderBytes] = {};
      if (header[0] < sizeof(begin)) throw FormatError(path_ + ": damaged: a frame is shorter than its header");
      file_.read(reinterpret_cast<char*>(begin), sizeof(begin));
      std::int64_t captured, encoded;
      std::memcpy(&captured, begin + 16, sizeof(captured));
      std::memcpy(&encoded, begin + 24, sizeof(encoded));
      frames_.push_back({at, header[0], captured != 0 ? captured : encoded, descriptions_.size() - 1});
    } else {
      throw FormatError(path_ + ": damaged, or of a later version: a record of kind " + std::to_string(header[1]));
    }
    if (!file_) fail(path_, "cannot be read");
    at += header[0];
  }
  if (descriptions_.empty()) throw FormatError(path_ + ": no stream file: it has no description");
  description_ = descriptions_.front();
}

void StreamReader::read(std::size_t frame, std::vector<std::uint8_t>& message) {
  const Entry& entry = frames_.at(frame);
  message.resize(entry.size);
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(entry.offset));
  file_.read(reinterpret_cast<char*>(message.data()), static_cast<std::streamsize>(message.size()));
  if (!file_) fail(path_, "frame " + std::to_string(frame) + " cannot be read");
  description_ = descriptions_[entry.description];
}

}  // namespace fuse_flow::stream
