#include "stream/codec/frame_layout.h"

#include "stream/codec/layers.h"
#include "stream/codec/morton.h"

#include <fuse_flow/stream/streamed_cloud.h>

#include <zlib.h>

#include <cmath>
#include <cstring>
#include <string>

namespace fuse_flow::stream {

namespace {

/** \brief Numbers into bytes; little-endian, as all machines that CUDA and PCL run on. */
class Bytes {
 public:
  template <typename T>
  void put(const T& value) {
    const std::size_t end = bytes.size();
    bytes.resize(end + sizeof(T));
    std::memcpy(bytes.data() + end, &value, sizeof(T));
  }
  std::vector<std::uint8_t> bytes;
};

/** \brief Back. What is read was checked to be there. */
class Cursor {
 public:
  explicit Cursor(const std::uint8_t* data) : data_(data) {}
  template <typename T>
  void get(T& value) {
    std::memcpy(&value, data_, sizeof(T));
    data_ += sizeof(T);
  }
  template <typename T>
  T get() {
    T value;
    get(value);
    return value;
  }

 private:
  const std::uint8_t* data_;
};

std::uint32_t checksum(const std::uint8_t* data, std::size_t size) {
  return static_cast<std::uint32_t>(crc32_z(0, data, size));
}

void require(bool holds, const char* what) {
  if (!holds) throw FormatError(std::string("a frame of points: ") + what);
}

}  // namespace

std::vector<std::uint8_t> writeHeader(const FrameHeader& header) {
  std::size_t size = kHeaderBytes + kChecksumBytes;
  for (const ChunkHeader& chunk : header.chunks) size += kHeaderOfChunkBytes + 4 * chunk.layers;
  Bytes to;
  to.bytes.reserve(size);
  for (const char letter : {'F', 'F', 'C', '1'}) to.put(letter);
  to.put(static_cast<std::uint32_t>(size));
  to.put(header.times.number);
  to.put(header.times.captured);
  to.put(header.times.encoded);
  for (const double coordinate : header.origin) to.put(coordinate);
  to.put(header.step);
  to.put(header.fields);
  for (const int value : {header.chroma_step, header.layers, header.mask_bytes, 0})
    to.put(static_cast<std::uint8_t>(value));
  to.put(header.points_of_frame);
  to.put(header.points);
  to.put(static_cast<std::uint32_t>(header.chunks.size()));
  for (const ChunkHeader& chunk : header.chunks) {
    to.put(chunk.number);
    to.put(chunk.points);
    to.put(chunk.layers);
    for (const std::uint32_t coordinate : chunk.least) to.put(coordinate);
    for (const std::uint32_t coordinate : chunk.greatest) to.put(coordinate);
    for (std::uint32_t layer = 0; layer < chunk.layers; ++layer) to.put(chunk.bytes[layer]);
  }
  to.put(checksum(to.bytes.data(), to.bytes.size()));
  return std::move(to.bytes);
}

void readHeader(const std::uint8_t* data, std::size_t size, std::uint32_t most_points, FrameHeader& header) {
  require(size >= kHeaderBytes + kChecksumBytes, "it is shorter than a header");
  require(std::memcmp(data, "FFC1", 4) == 0, "it does not begin with FFC1");
  Cursor from(data + 4);
  header.size = from.get<std::uint32_t>();
  require(header.size >= kHeaderBytes + kChecksumBytes && header.size <= size, "its header is longer than it");
  std::uint32_t written;
  std::memcpy(&written, data + header.size - kChecksumBytes, kChecksumBytes);
  require(written == checksum(data, header.size - kChecksumBytes), "its header is damaged");
  from.get(header.times.number);
  from.get(header.times.captured);
  from.get(header.times.encoded);
  for (double& coordinate : header.origin) {
    from.get(coordinate);
    require(std::isfinite(coordinate), "its origin is not finite");
  }
  from.get(header.step);
  require(std::isfinite(header.step) && header.step > 0, "its step is not above 0");
  from.get(header.fields);
  require((header.fields & ~kAllFields) == 0, "it has fields that this version does not know");
  header.chroma_step = from.get<std::uint8_t>();
  header.layers = from.get<std::uint8_t>();
  header.mask_bytes = from.get<std::uint8_t>();
  require(from.get<std::uint8_t>() == 0, "it is of a later version");
  require(header.chroma_step <= kMostChromaStep, "its chroma step is above 64");
  require(header.layers >= 1 && header.layers <= kMostLayers, "it has not 1 to 8 layers");
  require(header.mask_bytes <= 8 && (header.mask_bytes > 0) == ((header.fields & kCameras) != 0),
          "its camera masks have no size");
  from.get(header.points_of_frame);
  from.get(header.points);
  const auto chunks = from.get<std::uint32_t>();
  require(header.points <= most_points, "it has more points than are taken");
  require(header.points <= header.points_of_frame, "it has more points than its frame");
  const std::size_t end = header.size - kChecksumBytes;
  require(chunks <= (end - kHeaderBytes) / (kHeaderOfChunkBytes + 4),
          "it has more chunks than its header has room for");
  header.chunks.resize(chunks);
  std::size_t at = kHeaderBytes, in_layers = 0;
  std::uint64_t points = 0, points_of_chunks = 0;
  for (std::size_t k = 0; k < chunks; ++k) {
    ChunkHeader& chunk = header.chunks[k];
    require(end - at >= kHeaderOfChunkBytes, "its list of chunks ends early");
    from.get(chunk.number);
    from.get(chunk.points);
    from.get(chunk.layers);
    at += kHeaderOfChunkBytes;
    require(k == 0 || chunk.number > header.chunks[k - 1].number, "its chunks are not in their order");
    require(chunk.points >= 1 && chunk.points <= kMostChunkPoints, "a chunk has not 1 to 65536 points");
    require(chunk.layers >= 1 && chunk.layers <= static_cast<std::uint32_t>(header.layers),
            "a chunk has more layers than the frame");
    require((end - at) / 4 >= chunk.layers, "its list of chunks ends early");
    for (std::uint32_t& coordinate : chunk.least) from.get(coordinate);
    for (std::uint32_t& coordinate : chunk.greatest) from.get(coordinate);
    for (std::size_t axis = 0; axis < 3; ++axis)
      require(chunk.least[axis] <= chunk.greatest[axis] && chunk.greatest[axis] >> kCoordinateBits == 0,
              "the box of a chunk is none");
    for (std::uint32_t layer = 0; layer < chunk.layers; ++layer) {
      from.get(chunk.bytes[layer]);
      in_layers += chunk.bytes[layer];
      const bool empty = Layer(static_cast<int>(layer), header.layers).points(chunk.points) == 0;
      require(empty == (chunk.bytes[layer] == 0), "a layer has points and no bytes, or bytes and no points");
    }
    at += 4 * chunk.layers;
    points += pointsUpTo(chunk.points, static_cast<int>(chunk.layers), header.layers);
    points_of_chunks += chunk.points;
  }
  require(at == end, "its header is longer than its list of chunks");
  require(points == header.points, "its chunks have not as many points as it says");
  require(points_of_chunks <= header.points_of_frame, "its chunks have more points than its frame");
  require(in_layers == size - header.size, "its layers do not fill it");
}

}  // namespace fuse_flow::stream
