#include "png_file.h"

#include <algorithm>

namespace tool_test {
namespace {

std::string bigEndian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xff);
  return bytes;
}

std::uint32_t crc32(const std::string& bytes) {
  std::uint32_t c = 0xffffffffu;
  for (const char byte : bytes) {
    c ^= static_cast<std::uint8_t>(byte);
    for (int k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320u ^ (c >> 1) : c >> 1;
  }
  return ~c;
}

std::uint32_t adler32(const std::string& bytes) {
  std::uint32_t a = 1, b = 0;
  for (const char byte : bytes) {
    a = (a + static_cast<std::uint8_t>(byte)) % 65521;
    b = (b + a) % 65521;
  }
  return b << 16 | a;
}

}  // namespace

std::string pngChunk(const std::string& type, const std::string& data) {
  return bigEndian(static_cast<std::uint32_t>(data.size())) + type + data + bigEndian(crc32(type + data));
}

std::string pngHeader(int width, int height, int bits, int color_type) {
  std::string data = bigEndian(static_cast<std::uint32_t>(width)) + bigEndian(static_cast<std::uint32_t>(height));
  data += {static_cast<char>(bits), static_cast<char>(color_type), 0, 0, 0};
  return pngChunk("IHDR", data);
}

std::string zlibStored(const std::string& data) {
  std::string stream = "\x78\x01";
  std::size_t at = 0;
  do {
    const std::size_t size = std::min<std::size_t>(65535, data.size() - at);
    const bool last = at + size == data.size();
    const auto low = static_cast<char>(size & 0xff), high = static_cast<char>(size >> 8);
    stream += {static_cast<char>(last), low, high, static_cast<char>(~low), static_cast<char>(~high)};
    stream.append(data, at, size);
    at += size;
  } while (at < data.size());
  return stream + bigEndian(adler32(data));
}

std::string png(const std::string& chunks) {
  return std::string("\x89PNG\r\n\x1a\n", 8) + chunks + pngChunk("IEND", "");
}

std::string samplesPng(int width, int height, int bits, int color_type, const std::string& samples) {
  const std::size_t row = samples.size() / static_cast<std::size_t>(height);
  std::string rows;
  for (std::size_t at = 0; at < samples.size(); at += row) {
    rows += '\0';  // no filter
    rows.append(samples, at, row);
  }
  return png(pngHeader(width, height, bits, color_type) + pngChunk("IDAT", zlibStored(rows)));
}

std::string depthPng(int width, int height, const std::vector<std::uint16_t>& pixels) {
  std::string samples;
  for (const std::uint16_t value : pixels) samples += {static_cast<char>(value >> 8), static_cast<char>(value & 0xff)};
  return samplesPng(width, height, 16, 0, samples);
}

std::string colorPng(int width, int height, std::uint8_t r, std::uint8_t g, std::uint8_t b) {
  std::string samples;
  for (int i = 0; i < width * height; ++i)
    samples += {static_cast<char>(r), static_cast<char>(g), static_cast<char>(b)};
  return samplesPng(width, height, 8, 2, samples);
}

}  // namespace tool_test
