#pragma once

#include <fuse_flow/distributed/byte_planes.h>
#include <fuse_flow/distributed/codec.h>
#include <fuse_flow/distributed/message.h>
#include <fuse_flow/impl/host/parallel.hpp>

#include <algorithm>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief Consecutive bytes of a message that are of one kind. */
struct MessagePart {
  std::size_t bytes;
  ByteKind kind{ByteKind::Any};
  std::uint32_t record{1};  ///< words of a record, for ByteKind::Words
};
using MessageParts = std::vector<MessagePart>;

/** \brief Messages that a Codec has made shorter, and back. A coded message is a table of its segments, and then these; each is coded apart, so
 *  that many threads take part. Only one thread at a time uses an object; memory is kept. */
class CodedMessage {
 public:
  /** \brief Whether a message is one. No other begins so. */
  static bool isOne(const Message& message) {
    std::uint32_t magic = 0;
    if (message.size() >= sizeof magic) std::memcpy(&magic, message.data(), sizeof magic);
    return magic == kMagic;
  }

  /** \brief Codec::format() of one; 0 if it is too short. */
  static std::uint32_t formatOf(const Message& message) {
    std::uint32_t format = 0;
    if (message.size() >= 2 * sizeof format) std::memcpy(&format, message.data() + sizeof format, sizeof format);
    return format;
  }

  /** \param plain what to code  \param parts what its bytes are, in their order; what they do not reach is of any kind
   *  \param coded receives the message  \param threads as in host::parallelFor() */
  void code(const Codec& codec, const Message& plain, const MessageParts& parts, int threads, Message& coded) {
    segments_.clear();
    std::size_t begin = 0;
    for (const MessagePart& part : parts) begin = addSegments(begin, part, plain.size());
    addSegments(begin, {plain.size() - begin}, plain.size());
    pieces_.resize(segments_.size());
    host::parallelFor(threads, segments_.size(), [&](std::size_t s, int) {
      const Segment& segment = segments_[s];
      thread_local Message ordered;
      ordered.resize(segment.bytes);
      planesOf(segment.header).order(plain.data() + segment.begin, segment.bytes, ordered.data());
      pieces_[s].clear();
      codec.compress(ordered.data(), segment.bytes, pieces_[s]);
    });
    MessageWriter out(coded);
    out.put(kMagic);
    out.put(codec.format());
    out.put(static_cast<std::uint32_t>(segments_.size()));
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      segments_[s].header.coded = static_cast<std::uint32_t>(pieces_[s].size());
      out.put(segments_[s].header);
    }
    for (const Message& piece : pieces_) out.put(piece.data(), piece.size());
  }

  /** \brief The inverse. \param from the rank that sent it  \param limit no honest message is longer  \throws RankError for what cannot be */
  void decode(const Codec* codec, const Message& coded, int from, std::size_t limit, int threads, Message& plain) {
    MessageReader in(coded, from);
    in.get<std::uint32_t>();
    const auto format = in.get<std::uint32_t>();
    if (codec == nullptr || format != codec->format())
      throw RankError(
          from, "compresses what it sends, and this rank does not, or by another format: all must have the same codec");
    const auto count = in.get<std::uint32_t>();
    const char* table = in.take(count, sizeof(Header));
    segments_.clear();
    std::size_t bytes = 0;
    for (std::uint32_t s = 0; s < count; ++s) {
      Segment segment{bytes, 0, {}, nullptr};
      std::memcpy(&segment.header, table + s * sizeof(Header), sizeof(Header));
      segment.bytes = segment.header.bytes;
      if (segment.bytes > kSegment || segment.header.record == 0 || segment.header.record > kSegment)
        in.fail("a segment that cannot be");
      if (segment.bytes > limit - bytes) in.fail("more than the frame has");
      segment.coded = in.take(segment.header.coded, 1);
      bytes += segment.bytes;
      segments_.push_back(segment);
    }
    in.finish();
    plain.resize(bytes);
    wrong_.assign(segments_.size(), 0);
    host::parallelFor(threads, segments_.size(), [&](std::size_t s, int) {
      const Segment& segment = segments_[s];
      thread_local Message ordered;
      ordered.resize(segment.bytes);
      wrong_[s] = codec->decompress(segment.coded, segment.header.coded, ordered.data(), segment.bytes) ? 0 : 1;
      if (!wrong_[s]) planesOf(segment.header).restore(ordered.data(), segment.bytes, plain.data() + segment.begin);
    });
    if (std::find(wrong_.begin(), wrong_.end(), 1) != wrong_.end())
      throw RankError(from, "sent a segment that cannot be decompressed");
  }

 private:
  static constexpr std::uint32_t kMagic = 0x4f434646;  // "FFCO"
  /** \brief Bytes of a segment at most: of the size of a second cache, with what is made of it. */
  static constexpr std::size_t kSegment = std::size_t{1} << 18;

  struct Header {
    std::uint32_t bytes, coded, record;
    ByteKind kind;
    std::uint8_t unused[3];
  };
  struct Segment {
    std::size_t begin, bytes;
    Header header;
    const char* coded;
  };

  static BytePlanes planesOf(const Header& header) { return {header.kind, header.record}; }

  std::size_t addSegments(std::size_t begin, const MessagePart& part, std::size_t limit) {
    const std::size_t end = begin + std::min(part.bytes, limit - begin);
    // Whole records: floats and colours of a segment then begin where they began.
    const std::size_t unit = part.kind == ByteKind::Words    ? part.record * sizeof(std::uint32_t)
                             : part.kind == ByteKind::Colors ? 3
                                                             : 1;
    const std::size_t most = std::max(kSegment / unit, std::size_t{1}) * unit;
    for (std::size_t bytes; begin < end; begin += bytes) {
      bytes = std::min(most, end - begin);
      segments_.push_back({begin, bytes, {static_cast<std::uint32_t>(bytes), 0, part.record, part.kind, {}}, nullptr});
    }
    return end;
  }

  std::vector<Segment> segments_;
  std::vector<Message> pieces_;
  std::vector<char> wrong_;
};

}  // namespace distributed
}  // namespace fuse_flow
