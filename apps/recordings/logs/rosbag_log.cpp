#include "recordings/files/cut_short.h"
#include "recordings/files/file_io.h"
#include "recordings/logs/decompress.h"
#include "recordings/logs/message_log.h"
#include "recordings/messages/byte_cursor.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <list>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace fuse_flow::io {
namespace {

/** \brief The kinds of records that matter, as their field "op" has them; the names are the format's. */
enum BagOp : char { kBagMessage = 0x02, kBagHeader = 0x03, kBagIndex = 0x04, kBagChunk = 0x05, kBagConnection = 0x07 };

/** \brief The fields of a record's header, each "name=value". */
class BagFields {
 public:
  BagFields(const std::string& path, std::string_view header) : path_(path) {
    ByteCursor cursor(path_, header);
    while (cursor.position() < header.size()) {
      const std::string field = cursor.text();
      if (const std::size_t sign = field.find('='); sign != std::string::npos)
        values_[field.substr(0, sign)] = field.substr(sign + 1);
    }
  }
  std::string text(const char* name) const {
    const auto found = values_.find(name);
    return found == values_.end() ? "" : found->second;
  }
  template <typename Number>
  Number number(const char* name) const {
    const std::string value = text(name);
    Number number = 0;
    if (value.size() != sizeof number) throw InputError(path_ + ": is damaged: a record has no " + name);
    std::memcpy(&number, value.data(), sizeof number);
    return number;
  }
  char op() const { return number<char>("op"); }

 private:
  const std::string& path_;
  std::map<std::string, std::string> values_;
};

/** \brief Where a chunk's records are. */
struct BagChunk {
  std::uint64_t offset{0};
  std::uint32_t stored{0};  ///< bytes
  std::uint32_t size{0};    ///< bytes when they are decompressed
  std::string compression;
};

/** \brief Read here and not by librosbag-storage, which goes to places, and takes memory by lengths, that it reads from the file. */
class RosBagLog : public MessageLog {
 public:
  explicit RosBagLog(const std::string& path) : size_(fileSize(path)), file_(path, std::ios::binary) {
    path_ = path;
    const std::string magic = "#ROSBAG V2.0\n";
    if (size_ < magic.size() || readAt(0, magic.size()) != magic)
      throw InputError(path + ": is no bag of ROS 1, in its format 2.0");
    for (std::uint64_t at = magic.size(); at < size_;) at = takeRecord(at);
    if (chunks_.size() != chunk_count_)
      throw InputError(path + ": has " + std::to_string(chunks_.size()) + " chunks of messages, its header says " +
                       std::to_string(chunk_count_) + ": it is damaged or cut short");
    for (const auto& [connection, place] : places_) addPlace(connection, place);
    places_.clear();
    const auto earlier = [](const Place& a, const Place& b) { return a.time < b.time; };
    for (Stream& stream : streams_) std::stable_sort(stream.places.begin(), stream.places.end(), earlier);
    std::stable_sort(streams_.begin(), streams_.end(),
                     [](const Stream& a, const Stream& b) { return a.places.front().time < b.places.front().time; });
    for (const Stream& stream : streams_) {
      Topic topic{stream.name, stream.type, Wire::Ros1, {}};
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
  /** \brief Of a message's record in its chunk. */
  struct Place {
    Nanoseconds time;
    std::uint32_t chunk, offset;
  };
  /** \brief The messages of all connections that have a topic's name. */
  struct Stream {
    std::string name, type;
    std::vector<Place> places;
  };
  struct Connection {
    std::string topic, type;
  };

  InputError damaged(std::uint64_t at) const {
    return InputError(path_ + ": has a damaged record at byte " + std::to_string(at));
  }

  std::string readAt(std::uint64_t at, std::uint64_t count) {
    if (at > size_ || count > size_ - at) throw damaged(at);
    std::string bytes(count, '\0');
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(at));
    if (!file_.read(bytes.data(), static_cast<std::streamsize>(count))) throw damaged(at);
    return bytes;
  }
  static std::uint32_t asNumber(std::string_view bytes) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }

  /** \brief A record outside of chunks. \returns where the next one begins */
  std::uint64_t takeRecord(std::uint64_t at) {
    const std::uint32_t header_size = asNumber(readAt(at, 4));
    const std::string header = readAt(at + 4, header_size);
    const BagFields fields(path_, header);
    const std::uint64_t data = at + 8 + header_size;
    const std::uint32_t size = asNumber(readAt(data - 4, 4));
    switch (fields.op()) {
      case kBagHeader:
        if (fields.number<std::uint64_t>("index_pos") == 0)
          throw InputError(path_ +
                           ": was not closed when it was recorded, and has no index; `rosbag reindex` makes one");
        if (!fields.text("encryptor").empty())
          throw InputError(path_ + ": is encrypted by '" + cutShort(fields.text("encryptor")) +
                           "', must be recorded or written again without");
        chunk_count_ = fields.number<std::uint32_t>("chunk_count");
        break;
      case kBagChunk:
        if (size > size_ - data) throw damaged(at);
        chunks_.push_back({data, size, fields.number<std::uint32_t>("size"), fields.text("compression")});
        break;
      case kBagIndex:
        takeIndex(at, fields, readAt(data, size));
        break;
      case kBagConnection: {
        const std::string connection = readAt(data, size);
        connections_[fields.number<std::uint32_t>("conn")] = {fields.text("topic"),
                                                              BagFields(path_, connection).text("type")};
        break;
      }
      default:
        break;
    }
    if (size > size_ - data) throw damaged(at);
    return data + size;
  }

  /** \brief The times of one connection's messages in the chunk before, and where they are in it. */
  void takeIndex(std::uint64_t at, const BagFields& fields, const std::string& entries) {
    const auto connection = fields.number<std::uint32_t>("conn");
    if (chunks_.empty() || fields.number<std::uint32_t>("ver") != 1) throw damaged(at);
    ByteCursor cursor(path_, entries);
    for (std::uint32_t left = fields.number<std::uint32_t>("count"); left > 0; --left) {
      const Nanoseconds seconds = cursor.u32();
      const Nanoseconds time = seconds * 1'000'000'000 + cursor.u32();
      places_.push_back({connection, {time, static_cast<std::uint32_t>(chunks_.size() - 1), cursor.u32()}});
    }
  }

  void addPlace(std::uint32_t connection, const Place& place) {
    const auto found = connections_.find(connection);
    if (found == connections_.end()) throw InputError(path_ + ": is damaged: it has messages of no topic");
    const auto [number, added] = numbers_.emplace(found->second.topic, streams_.size());
    if (added) streams_.push_back({found->second.topic, found->second.type, {}});
    streams_[number->second].places.push_back(place);
  }

  void fetch(std::size_t topic, std::size_t message, std::size_t count, std::string& bytes) {
    const Place& place = streams_.at(topic).places.at(message);
    const BagChunk& chunk = chunks_[place.chunk];
    for (std::uint64_t at = place.offset;;) {
      const std::uint32_t header_size = asNumber(recordsAt(chunk, at, 4));
      const std::string header = recordsAt(chunk, at + 4, header_size);
      const char op = BagFields(path_, header).op();
      const std::uint64_t data = at + 8 + header_size;
      const std::uint32_t size = asNumber(recordsAt(chunk, data - 4, 4));
      if (op == kBagMessage) {
        if (size > chunk.size - std::min<std::uint64_t>(chunk.size, data)) throw damaged(chunk.offset);
        bytes = recordsAt(chunk, data, std::min<std::size_t>(size, count));
        return;
      }
      if (op != kBagConnection) throw damaged(chunk.offset);  // which may be before its first message
      at = data + size;
    }
  }

  /** \brief A part of a chunk's records. Of one that is not compressed no more is read than that. */
  std::string recordsAt(const BagChunk& chunk, std::uint64_t at, std::uint64_t count) {
    const bool plain = chunk.compression == "none";
    const std::uint64_t size = plain ? chunk.stored : chunk.size;
    if (at > size || count > size - at) throw damaged(chunk.offset);
    return plain ? readAt(chunk.offset + at, count) : decompressed(chunk).substr(at, count);
  }

  /** \brief The records of a chunk; the latest ones are kept. */
  const std::string& decompressed(const BagChunk& chunk) {
    constexpr std::size_t most = 4;  // those that messages of one time are in
    const auto known =
        std::find_if(kept_.begin(), kept_.end(), [&](const auto& entry) { return entry.first == chunk.offset; });
    if (known != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, known);
      return kept_.front().second;
    }
    const std::string what = path_ + ": the chunk at byte " + std::to_string(chunk.offset);
    std::string records;
    decompress(what, chunk.compression, readAt(chunk.offset, chunk.stored), chunk.size, records);
    if (kept_.size() >= most) kept_.pop_back();
    kept_.emplace_front(chunk.offset, std::move(records));
    return kept_.front().second;
  }

  std::uint64_t size_;
  std::ifstream file_;
  std::uint32_t chunk_count_{0};  ///< as the header says
  std::vector<BagChunk> chunks_;
  std::map<std::uint32_t, Connection> connections_;
  std::vector<std::pair<std::uint32_t, Place>> places_;  // by connection, until all of these are known
  std::map<std::string, std::size_t> numbers_;           // of streams_, by their names
  std::vector<Stream> streams_;                          // as topics_
  std::list<std::pair<std::uint64_t, std::string>> kept_;
};

}  // namespace

std::unique_ptr<MessageLog> openRosBag(const std::string& path) { return std::make_unique<RosBagLog>(path); }

}  // namespace fuse_flow::io
