#include "../../fuzz_target.h"
#include "../../image_limits.h"
#include "../../scratch.h"

#include "recordings/files/checksum.h"
#include "recordings/images/image_io.h"

#include <fuse_flow/recordings/image.h>

namespace {

using namespace fuse_flow;
using fuse_flow_fuzz::accepts;

std::uint32_t bigEndian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<std::uint8_t>(bytes[at + k]);
  return value;
}

/** \brief With the checksums that its chunks should have: without, hardly a mutation came past them. */
std::string withChecksums(std::string bytes) {
  for (std::size_t at = 8; at + 12 <= bytes.size();) {
    const std::size_t length = bigEndian(bytes, at);
    if (length > bytes.size() - at - 12) break;
    const std::uint32_t crc = io::crc32(std::string_view(bytes).substr(at + 4, 4 + length));
    for (std::size_t k = 0; k < 4; ++k) bytes[at + 8 + length + k] = static_cast<char>(crc >> (24 - 8 * k));
    at += 12 + length;
  }
  return bytes;
}

void readPng(const std::string& bytes) {
  accepts<io::InputError>([&] {
    io::DepthImage image;
    io::decodeDepthPng("depth.png", bytes, image, fuse_flow_fuzz::allowImage);
  });
  accepts<io::InputError>([&] {
    io::ColorImage image;
    io::decodeColor("color.png", bytes, image, fuse_flow_fuzz::allowImage);
  });
  accepts<io::InputError>([&] {
    io::FloatImage image;
    io::readConfidencePng(fuse_flow_fuzz::scratchFile("confidence.png", bytes), image, {}, fuse_flow_fuzz::allowImage);
  });
}

}  // namespace

/** \brief A 16-bit depth image, colour, or confidence. libpng takes some 200 KiB, most of it for its buffers and zlib's window. */
FUSE_FLOW_FUZZ_TARGET(png, 1 << 19, 16, 1000) {
  const std::string bytes(input);
  readPng(bytes);
  readPng(withChecksums(bytes));
}
