#include "recordings/logs/mcap_writer.h"

#include "recordings/files/checksum.h"
#include "recordings/logs/decompress.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace fuse_flow::io {
namespace {

const std::string mcap_magic("\x89MCAP0\r\n", 8);

void putNumber(std::string& to, std::uint64_t value, int bytes) {
  for (int k = 0; k < bytes; ++k) to += static_cast<char>(value >> (8 * k) & 0xff);
}
void putText(std::string& to, std::string_view text) {
  putNumber(to, text.size(), 4);
  to += text;
}
std::string recordOf(int opcode, std::string_view content) {
  std::string record(1, static_cast<char>(opcode));
  putNumber(record, content.size(), 8);
  record += content;
  return record;
}

}  // namespace

McapWriter::McapWriter(const std::string& path, std::string compression)
    : path_(path), compression_(std::move(compression)) {
  if (!compression_.empty()) compress(path, compression_, "");  // throws now rather than after a second
  file_.open(path, std::ios::binary | std::ios::trunc);
  if (!file_) throw OutputError(path + ": cannot be written: " + std::strerror(errno));
  std::string header;
  putText(header, "ros2");
  putText(header, "fuse_flow");
  put(mcap_magic + recordOf(0x01, header));
}

void McapWriter::put(const std::string& bytes) {
  errno = 0;
  file_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file_.flush();
  if (!file_)
    throw OutputError(path_ + ": cannot be written after " + std::to_string(at_) +
                      " bytes: " + (errno != 0 ? std::strerror(errno) : "the disk does not take more") +
                      (chunks_.empty() ? "; nothing of it can be read" : "; it plays up to there"));
  at_ += bytes.size();
}

std::string McapWriter::schemaRecord(std::uint16_t id, const Schema& schema) {
  std::string content;
  putNumber(content, id, 2);
  putText(content, schema.name);
  putText(content, "ros2msg");
  putText(content, schema.definition);
  return recordOf(0x03, content);
}

std::string McapWriter::channelRecord(std::uint16_t id, const Channel& channel) {
  std::string content;
  putNumber(content, id, 2);
  putNumber(content, channel.schema, 2);
  putText(content, channel.topic);
  putText(content, "cdr");
  putText(content, "");  // no metadata
  return recordOf(0x04, content);
}

std::uint16_t McapWriter::addChannel(const std::string& topic, const std::string& type, const std::string& definition) {
  auto known = std::find_if(schemas_.begin(), schemas_.end(), [&](const Schema& s) { return s.name == type; });
  if (known == schemas_.end()) {
    schemas_.push_back({type, definition});
    known = schemas_.end() - 1;
    records_ += schemaRecord(static_cast<std::uint16_t>(schemas_.size()), *known);
  }
  channels_.push_back({static_cast<std::uint16_t>(known - schemas_.begin() + 1), topic});
  const auto id = static_cast<std::uint16_t>(channels_.size());
  records_ += channelRecord(id, channels_.back());
  return id;
}

void McapWriter::write(std::uint16_t channel, Nanoseconds time, std::string_view bytes) {
  constexpr std::size_t chunk_size = 4 << 20;  // less than half a second of eight cameras
  const auto stamp = static_cast<std::uint64_t>(std::max<Nanoseconds>(0, time));
  std::string& index = index_[channel];
  putNumber(index, stamp, 8);
  putNumber(index, records_.size(), 8);
  std::string head;
  putNumber(head, channel, 2);
  putNumber(head, channels_[channel - 1].messages++, 4);
  putNumber(head, stamp, 8);
  putNumber(head, stamp, 8);
  records_ += static_cast<char>(0x05);
  putNumber(records_, head.size() + bytes.size(), 8);
  records_ += head;
  records_ += bytes;
  chunk_start_ = std::min(chunk_start_, stamp);
  chunk_end_ = std::max(chunk_end_, stamp);
  if (records_.size() >= chunk_size) endChunk();
}

void McapWriter::endChunk() {
  if (index_.empty()) return;
  const std::string compressed = compression_.empty() ? "" : compress(path_, compression_, records_);
  const std::string& stored = compression_.empty() ? records_ : compressed;
  ChunkIndex chunk;
  chunk.start = chunk_start_;
  chunk.end = chunk_end_;
  chunk.offset = at_;
  chunk.stored = stored.size();
  chunk.size = records_.size();
  std::string content;
  putNumber(content, chunk.start, 8);
  putNumber(content, chunk.end, 8);
  putNumber(content, records_.size(), 8);
  putNumber(content, crc32(records_), 4);
  putText(content, compression_);
  putNumber(content, stored.size(), 8);
  std::string head(1, static_cast<char>(0x06));
  putNumber(head, content.size() + stored.size(), 8);
  head += content;
  put(head);
  put(stored);
  chunk.length = head.size() + stored.size();
  std::string bytes;  // the indices
  for (const auto& [channel, index] : index_) {
    chunk.index_offsets[channel] = at_ + bytes.size();
    std::string entry;
    putNumber(entry, channel, 2);
    putText(entry, index);
    bytes += recordOf(0x07, entry);
  }
  chunk.index_length = bytes.size();
  put(bytes);
  chunks_.push_back(std::move(chunk));
  start_ = std::min(start_, chunk_start_);
  end_ = std::max(end_, chunk_end_);
  records_.clear();
  index_.clear();
  chunk_start_ = ~std::uint64_t{0};
  chunk_end_ = 0;
}

void McapWriter::finish() {
  endChunk();
  std::string data_end;
  putNumber(data_end, 0, 4);  // no checksum of all
  put(recordOf(0x0f, data_end));
  const std::uint64_t summary = at_;
  std::string bytes;
  for (std::size_t k = 0; k < schemas_.size(); ++k)
    bytes += schemaRecord(static_cast<std::uint16_t>(k + 1), schemas_[k]);
  for (std::size_t k = 0; k < channels_.size(); ++k)
    bytes += channelRecord(static_cast<std::uint16_t>(k + 1), channels_[k]);
  std::uint64_t messages = 0;
  std::string counts;
  for (std::size_t k = 0; k < channels_.size(); ++k) {
    messages += channels_[k].messages;
    putNumber(counts, k + 1, 2);
    putNumber(counts, channels_[k].messages, 8);
  }
  std::string statistics;
  putNumber(statistics, messages, 8);
  putNumber(statistics, schemas_.size(), 2);
  putNumber(statistics, channels_.size(), 4);
  putNumber(statistics, 0, 4);  // attachments
  putNumber(statistics, 0, 4);  // metadata
  putNumber(statistics, chunks_.size(), 4);
  putNumber(statistics, chunks_.empty() ? 0 : start_, 8);
  putNumber(statistics, end_, 8);
  putText(statistics, counts);
  bytes += recordOf(0x0b, statistics);
  for (const ChunkIndex& chunk : chunks_) {
    std::string content, offsets;
    for (const auto& [channel, offset] : chunk.index_offsets) {
      putNumber(offsets, channel, 2);
      putNumber(offsets, offset, 8);
    }
    for (const std::uint64_t value : {chunk.start, chunk.end, chunk.offset, chunk.length}) putNumber(content, value, 8);
    putText(content, offsets);
    putNumber(content, chunk.index_length, 8);
    putText(content, compression_);
    putNumber(content, chunk.stored, 8);
    putNumber(content, chunk.size, 8);
    bytes += recordOf(0x08, content);
  }
  std::string footer;
  putNumber(footer, summary, 8);
  putNumber(footer, 0, 8);  // no offsets of the summary's parts
  putNumber(footer, 0, 4);  // nor its checksum
  put(bytes + recordOf(0x02, footer) + mcap_magic);
  file_.close();
  if (!file_) throw OutputError(path_ + ": cannot be written to its end");
}

}  // namespace fuse_flow::io
