#include "recordings/images/png_check.h"

#include "recordings/files/checksum.h"

#include <fuse_flow/recordings/error.h>

#include <cstdint>

namespace fuse_flow::io {
namespace {

const std::string png_signature("\x89PNG\r\n\x1a\n", 8);

std::uint8_t byteAt(const std::string& bytes, std::size_t at) { return static_cast<std::uint8_t>(bytes[at]); }

std::uint32_t bigEndian(const std::string& bytes, std::size_t at) {
  return std::uint32_t{byteAt(bytes, at)} << 24 | std::uint32_t{byteAt(bytes, at + 1)} << 16 |
         std::uint32_t{byteAt(bytes, at + 2)} << 8 | std::uint32_t{byteAt(bytes, at + 3)};
}

}  // namespace

bool isPng(const std::string& bytes) { return bytes.compare(0, png_signature.size(), png_signature) == 0; }

PngHeader checkPng(const std::string& path, const std::string& bytes) {
  if (bytes.empty()) throw InputError(path + ": is empty, must be a PNG image");
  if (!isPng(bytes)) throw InputError(path + ": is not a PNG image");
  PngHeader header;
  // A chunk: length of the data, 4 bytes; type, 4 bytes; data; checksum over type and data, 4 bytes.
  for (std::size_t at = png_signature.size();;) {
    if (bytes.size() < at + 12 || bytes.size() - at - 12 < bigEndian(bytes, at))
      throw InputError(path + ": is cut short after " + std::to_string(bytes.size()) + " bytes, must be a whole PNG");
    const std::size_t length = bigEndian(bytes, at);
    const std::string type = bytes.substr(at + 4, 4);
    if (crc32(std::string_view(bytes).substr(at + 4, 4 + length)) != bigEndian(bytes, at + 8 + length))
      throw InputError(path + ": is damaged: wrong checksum in the chunk at byte " + std::to_string(at));
    if (at == png_signature.size()) {
      if (type != "IHDR" || length != 13) throw InputError(path + ": is damaged: no PNG header");
      header.width = static_cast<int>(bigEndian(bytes, at + 8));
      header.height = static_cast<int>(bigEndian(bytes, at + 12));
      header.bits = byteAt(bytes, at + 16);
      header.color_type = byteAt(bytes, at + 17);
    }
    if (type == "IEND") break;
    at += 12 + length;
  }
  if (header.width <= 0 || header.height <= 0 || header.width > 65535 || header.height > 65535)
    throw InputError(path + ": is " + std::to_string(header.width) + "x" + std::to_string(header.height) +
                     " pixels, sides must be in [1, 65535]");
  return header;
}

namespace {

/** \brief Where the next marker of a JPEG begins: 255 and what it marks. In image data 255 is followed by 0 where it is a value,
 *  and restart markers lie in between; before a marker it may stand several times. */
std::size_t nextMarker(const std::string& bytes, std::size_t at) {
  for (; (at = bytes.find('\xff', at)) != std::string::npos && at + 1 < bytes.size(); ++at) {
    const std::uint8_t marker = byteAt(bytes, at + 1);
    const bool is_restart = marker >= 0xd0 && marker <= 0xd7;
    if (marker != 0 && marker != 0xff && !is_restart) return at;
  }
  return bytes.size();
}

/** \brief Goes from segment to segment: those that hold a small picture hold its end, too. */
bool hasEndOfJpeg(const std::string& bytes) {
  constexpr std::uint8_t end_of_image = 0xd9;
  for (std::size_t at = nextMarker(bytes, 2); at + 1 < bytes.size();) {
    if (byteAt(bytes, at + 1) == end_of_image) return true;
    if (bytes.size() < at + 4) return false;
    const std::size_t length = std::size_t{byteAt(bytes, at + 2)} << 8 | byteAt(bytes, at + 3);
    at = nextMarker(bytes, at + 2 + length);
  }
  return false;
}

}  // namespace

void checkJpeg(const std::string& path, const std::string& bytes) {
  if (bytes.empty()) throw InputError(path + ": is empty, must be a PNG or JPEG image");
  if (bytes.compare(0, 3, "\xff\xd8\xff") != 0) throw InputError(path + ": is neither a PNG nor a JPEG image");
  if (!hasEndOfJpeg(bytes))
    throw InputError(path + ": is cut short after " + std::to_string(bytes.size()) + " bytes, must be a whole JPEG");
}

}  // namespace fuse_flow::io
