#pragma once

#include <fuse_flow/stream/encoded_frame.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fuse_flow::stream {

constexpr std::size_t kHeaderBytes = 84;         ///< before the list of chunks
constexpr std::size_t kHeaderOfChunkBytes = 36;  ///< and 4 for each of its layers
constexpr std::size_t kChecksumBytes = 4;
constexpr int kMostLayers = 8;
constexpr int kMostChromaStep = 64;
constexpr std::uint32_t kMostChunkPoints = 65536;
constexpr std::uint32_t kAllFields = kColor | kConfidence | kViewCount | kNormal | kCameras;

/** \brief What a frame of such points has. */
inline std::uint32_t fieldsOf(const CloudView& cloud, const EncodingOptions& options) {
  return (cloud.color >= 0 ? kColor : 0u) | (cloud.confidence >= 0 && options.confidence ? kConfidence : 0u) |
         (cloud.view_count >= 0 && options.view_count ? kViewCount : 0u) |
         (cloud.normal >= 0 && options.normals ? kNormal : 0u) |
         (cloud.camera_mask >= 0 && options.camera_masks ? kCameras : 0u);
}

/** \brief What stands of a chunk in a header. */
struct ChunkHeader {
  std::uint32_t number{0};
  std::uint32_t points{0};
  std::uint32_t layers{0};
  std::array<std::uint32_t, 3> least{}, greatest{};
  std::array<std::uint32_t, kMostLayers> bytes{};
};

/** \brief The header of a message, as numbers. */
struct FrameHeader {
  FrameTimes times;
  std::array<double, 3> origin{};
  double step{0};
  std::uint32_t fields{0};
  int chroma_step{0}, layers{1}, mask_bytes{0};
  std::uint32_t points_of_frame{0}, points{0};
  std::vector<ChunkHeader> chunks;
  std::size_t size{0};  ///< bytes, when it was read
};

std::vector<std::uint8_t> writeHeader(const FrameHeader& header);
/** \brief Checks all that can be checked before the layers are unpacked: that their sizes fill the message, too. \throws FormatError */
void readHeader(const std::uint8_t* data, std::size_t size, std::uint32_t most_points, FrameHeader& header);

}  // namespace fuse_flow::stream
