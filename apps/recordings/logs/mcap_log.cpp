#include "recordings/files/checksum.h"
#include "recordings/files/file_io.h"
#include "recordings/logs/decompress.h"
#include "recordings/logs/message_log.h"
#include "recordings/messages/byte_cursor.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <list>
#include <map>
#include <optional>

namespace fuse_flow::io {
namespace {

/** \brief The kinds of records that matter; the names are the format's. */
enum Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kDataEnd = 0x0f
};

constexpr std::uint64_t kMagicSize = 8;
constexpr std::uint64_t kRecordHead = 9;             // an opcode and a length
constexpr std::size_t kMessageHead = 22;             // channel, sequence and two times, before its data
constexpr std::uint64_t kMostOfAChunk = 1ull << 31;  // bytes; recorders write some megabytes

/** \brief Where a chunk's records are. */
struct Chunk {
  std::uint64_t offset{0};  ///< of its records, as they are stored
  std::uint64_t stored{0};  ///< bytes
  std::uint64_t size{0};    ///< bytes when they are decompressed
  std::uint32_t crc{0};     ///< of them decompressed; 0: not known
  std::string compression;
  std::optional<bool>
      whole;  ///< whether crc is that of what is stored, of a chunk that is not compressed; absent: not looked at yet
};

class McapLog : public MessageLog {
 public:
  explicit McapLog(const std::string& path) : file_(path, std::ios::binary) {
    path_ = path;
    size_ = fileSize(path);
    if (!file_) throw InputError(path + ": cannot be opened");
    std::string magic(kMagicSize, '\0');
    if (size_ < kMagicSize || !readAt(0, kMagicSize, magic) || magic != std::string("\x89MCAP0\r\n", kMagicSize))
      throw InputError(path + ": is not an MCAP file");
    scan();
    for (Stream& stream : streams_) {
      std::stable_sort(stream.places.begin(), stream.places.end(),
                       [](const Place& a, const Place& b) { return a.time < b.time; });
      Topic topic{stream.name, stream.type, stream.wire, {}};
      for (const Place& place : stream.places) topic.times.push_back(place.time);
      topics_.push_back(std::move(topic));
    }
  }

  void read(std::size_t topic, std::size_t message, std::string& bytes) override {
    fetch(topic, message, std::string::npos, bytes);
  }
  void readStart(std::size_t topic, std::size_t message, std::size_t count, std::string& bytes) override {
    fetch(topic, message, count, bytes);
  }

 private:
  static constexpr std::uint32_t kNoChunk = ~0u;

  /** \brief Where a message's record is: in its chunk, or, outside of chunks, in the file. */
  struct Place {
    Nanoseconds time;
    std::uint32_t chunk;
    std::uint64_t offset;
  };
  /** \brief The messages of a topic: those of all channels that have its name. */
  struct Stream {
    std::string name, type;
    Wire wire;
    std::vector<Place> places;
  };

  bool readAt(std::uint64_t offset, std::uint64_t count, std::string& bytes) {
    bytes.resize(count);
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(offset));
    file_.read(bytes.data(), static_cast<std::streamsize>(count));
    return static_cast<std::uint64_t>(file_.gcount()) == count;
  }

  /** \brief Goes from record to record, up to the end of the data or of the file. */
  void scan() {
    std::uint64_t at = kMagicSize;
    std::string head;
    bool ended = false;
    while (!ended && at + kRecordHead <= size_ && readAt(at, kRecordHead, head)) {
      ByteCursor cursor(path_, head);
      const std::uint8_t opcode = cursor.u8();
      const std::uint64_t length = cursor.u64(), content = at + kRecordHead;
      if (length > size_ - content) break;
      ended = opcode == kDataEnd || opcode == kFooter;
      if (!ended) take(opcode, content, length);
      at = content + length;
    }
    indexLastChunk();
    if (!ended)
      warnings_.push_back(path_ + ": was not closed, or is cut short; what is before byte " + std::to_string(at) +
                          " is used");
  }

  void take(std::uint8_t opcode, std::uint64_t content, std::uint64_t length) {
    if (opcode == kMessageIndex) {
      takeIndex(content, length);
      return;
    }
    indexLastChunk();
    if (opcode == kChunk) {
      takeChunk(content, length);
    } else if (opcode == kMessage) {
      std::string head;
      if (length < kMessageHead) throw InputError(path_ + ": has a message of " + std::to_string(length) + " bytes");
      readAt(content, kMessageHead, head);
      ByteCursor cursor(path_, head);
      const std::uint16_t channel = cursor.u16();
      cursor.u32();
      add(channel, cursor.time(), kNoChunk, content - kRecordHead);
    } else if (opcode == kSchema || opcode == kChannel) {
      std::string record;
      readAt(content, std::min<std::uint64_t>(length, kMostTextBytes), record);
      ByteCursor cursor(path_, record);
      define(opcode, cursor);
    }
  }

  void takeChunk(std::uint64_t content, std::uint64_t length) {
    constexpr std::uint64_t fixed = 8 + 8 + 8 + 4 + 4, longest_name = 64;
    std::string head;
    readAt(content, std::min<std::uint64_t>(length, fixed + longest_name), head);
    ByteCursor cursor(path_, head);
    Chunk chunk;
    cursor.u64();  // its first and last time
    cursor.u64();
    chunk.size = cursor.u64();
    chunk.crc = cursor.u32();
    chunk.compression = cursor.text();
    chunk.stored = cursor.u64();
    chunk.offset = content + cursor.position();
    if (chunk.offset > content + length || chunk.stored > content + length - chunk.offset ||
        std::max(chunk.size, chunk.stored) > kMostOfAChunk)
      throw InputError(path_ + ": has a damaged chunk at byte " + std::to_string(content));
    chunks_.push_back(std::move(chunk));
    indexed_ = false;
    waiting_.clear();
  }

  /** \brief The times of one channel's messages in the chunk before, and where they are in it. */
  void takeIndex(std::uint64_t content, std::uint64_t length) {
    if (chunks_.empty()) return;
    if (length > kMostTextBytes) throw InputError(path_ + ": has a damaged index at byte " + std::to_string(content));
    std::string record;
    readAt(content, length, record);
    ByteCursor cursor(path_, record);
    const std::uint16_t channel = cursor.u16();
    const std::uint32_t bytes = cursor.u32();
    for (std::uint32_t k = 0; k < bytes / 16; ++k) {
      const Nanoseconds time = cursor.time();
      waiting_.push_back({channel, {time, static_cast<std::uint32_t>(chunks_.size() - 1), cursor.u64()}});
    }
  }

  /** \brief All of its index has been seen. Where that does not say what a channel is, or is not there, the chunk itself is gone through. */
  void indexLastChunk() {
    if (indexed_) return;
    indexed_ = true;
    const auto unknown = [this](const auto& entry) { return channels_.count(entry.first) == 0; };
    if (!waiting_.empty() && std::none_of(waiting_.begin(), waiting_.end(), unknown)) {
      for (const auto& [channel, place] : waiting_) add(channel, place.time, place.chunk, place.offset);
      waiting_.clear();
      return;
    }
    waiting_.clear();
    const auto number = static_cast<std::uint32_t>(chunks_.size() - 1);
    try {
      goThrough(number);
    } catch (const InputError& error) {
      warnings_.push_back(std::string(error.what()) + "; its messages are left out");
    }
  }

  void goThrough(std::uint32_t number) {
    const std::string& records = decompressed(number);
    std::size_t at = 0;
    while (at + kRecordHead <= records.size()) {
      ByteCursor head(path_, std::string_view(records).substr(at, kRecordHead));
      const std::uint8_t opcode = head.u8();
      const std::uint64_t length = head.u64();
      if (length > records.size() - at - kRecordHead) throw damaged(number);
      ByteCursor cursor(path_, std::string_view(records).substr(at + kRecordHead, length));
      if (opcode == kMessage) {
        const std::uint16_t channel = cursor.u16();
        cursor.u32();
        add(channel, cursor.time(), number, at);
      } else {
        define(opcode, cursor);
      }
      at += kRecordHead + length;
    }
  }

  /** \brief A schema or a channel; others are passed over. */
  void define(std::uint8_t opcode, ByteCursor& cursor) {
    if (opcode == kSchema) {
      const std::uint16_t id = cursor.u16();
      std::string name = cursor.text();
      if (const std::size_t message = name.find("/msg/"); message != std::string::npos) name.erase(message, 4);
      schemas_[id] = name;
    } else if (opcode == kChannel) {
      const std::uint16_t id = cursor.u16();
      if (channels_.count(id) > 0) return;  // it is repeated in every chunk
      const std::uint16_t schema = cursor.u16();
      const std::string name = cursor.text();
      const std::string encoding = cursor.text();
      const bool known = encoding == "cdr" || encoding == "ros1";
      const Wire wire = encoding == "cdr" ? Wire::Cdr : Wire::Ros1;
      // What cannot be read is there with its encoding as type, so that messages can say so.
      const std::string type = known ? schemas_[schema] : schemas_[schema] + " in " + encoding;
      const auto same = std::find_if(streams_.begin(), streams_.end(), [&](const Stream& s) {
        return s.name == name && s.type == type && s.wire == wire;
      });
      channels_[id] = static_cast<std::size_t>(same - streams_.begin());
      if (same == streams_.end()) streams_.push_back({name, type, wire, {}});
    }
  }

  void add(std::uint16_t channel, Nanoseconds time, std::uint32_t chunk, std::uint64_t offset) {
    const auto found = channels_.find(channel);
    if (found == channels_.end()) return;  // what no channel describes has no meaning
    streams_[found->second].places.push_back({time, chunk, offset});
  }

  void fetch(std::size_t topic, std::size_t message, std::size_t count, std::string& bytes) {
    const Place& place = streams_.at(topic).places.at(message);
    constexpr std::size_t before_data = kRecordHead + kMessageHead;
    const bool in_chunk = place.chunk != kNoChunk;
    if (in_chunk && !chunks_[place.chunk].compression.empty()) {
      const std::string& records = decompressed(place.chunk);
      if (place.offset > records.size() || records.size() - place.offset < before_data) throw damaged(place.chunk);
      ByteCursor head(path_, std::string_view(records).substr(place.offset, before_data));
      const std::size_t length = lengthOf(head);
      if (length > records.size() - place.offset - before_data) throw damaged(place.chunk);
      bytes.assign(records, place.offset + before_data, std::min(length, count));
      return;
    }
    // Of a chunk that is not compressed no more is read than is asked for, but for its checksum, once.
    if (in_chunk && count == std::string::npos) requireWhole(place.chunk);
    const std::uint64_t offset = (in_chunk ? chunks_[place.chunk].offset : 0) + place.offset;
    const std::string what = path_ + ": the message at byte " + std::to_string(offset);
    std::string record;
    if (!readAt(offset, before_data, record)) throw InputError(what + " cannot be read");
    ByteCursor head(path_, record);
    const std::size_t length = lengthOf(head);
    if (length > size_ - std::min(size_, offset + before_data) ||
        !readAt(offset + before_data, std::min(length, count), bytes))
      throw InputError(what + " is damaged or cut short");
  }

  /** \brief Throws unless a chunk that is not compressed has the checksum that the file says. */
  void requireWhole(std::uint32_t number) {
    Chunk& chunk = chunks_[number];
    if (!chunk.whole) {
      constexpr std::uint64_t most = 1 << 20;  // bytes at a time
      std::uint32_t crc = 0;
      std::string part;
      bool read = true;
      for (std::uint64_t at = 0; chunk.crc != 0 && read && at < chunk.stored; at += part.size()) {
        read = readAt(chunk.offset + at, std::min(most, chunk.stored - at), part);
        crc = crc32(part, crc);
      }
      chunk.whole = chunk.crc == 0 || (read && crc == chunk.crc);
    }
    if (!*chunk.whole) throw damaged(number);
  }

  /** \brief Bytes of a message's data. */
  std::size_t lengthOf(ByteCursor& head) const {
    const std::uint8_t opcode = head.u8();
    const std::uint64_t length = head.u64();
    if (opcode != kMessage || length < kMessageHead)
      throw InputError(path_ + ": has an index that points to no message");
    return length - kMessageHead;
  }

  InputError damaged(std::uint32_t chunk) const {
    return InputError(path_ + ": the chunk at byte " + std::to_string(chunks_[chunk].offset) + " is damaged");
  }

  /** \brief The records of a chunk; the latest ones are kept. */
  const std::string& decompressed(std::uint32_t number) {
    constexpr std::size_t most = 4;  // those that messages of one time are in
    const auto known =
        std::find_if(kept_.begin(), kept_.end(), [&](const auto& entry) { return entry.first == number; });
    if (known != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, known);
      return kept_.front().second;
    }
    const Chunk& chunk = chunks_[number];
    std::string stored;
    if (!readAt(chunk.offset, chunk.stored, stored)) throw damaged(number);
    std::string records;
    if (kept_.size() >= most) {
      records = std::move(kept_.back().second);
      kept_.pop_back();
    }
    if (chunk.compression.empty())
      records = std::move(stored);
    else
      decompress(path_ + ": the chunk at byte " + std::to_string(chunk.offset), chunk.compression, stored, chunk.size,
                 records);
    if (chunk.crc != 0 && crc32(records) != chunk.crc) throw damaged(number);
    kept_.emplace_front(number, std::move(records));
    return kept_.front().second;
  }

  std::ifstream file_;
  std::uint64_t size_{0};
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, std::size_t> channels_;  // to streams_
  std::vector<Stream> streams_;                    // as topics_
  std::vector<Chunk> chunks_;
  std::vector<std::pair<std::uint16_t, Place>> waiting_;  // from the index of the last chunk, by channel
  bool indexed_{true};                                    // the last chunk
  std::list<std::pair<std::uint32_t, std::string>> kept_;
};

}  // namespace

std::unique_ptr<MessageLog> openMcap(const std::string& path) { return std::make_unique<McapLog>(path); }

}  // namespace fuse_flow::io
