#include "recordings/messages/image_messages.h"

#include "recordings/files/cut_short.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

namespace fuse_flow::io {
namespace {

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

std::string lowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/** \brief An infrared image is grey, too, but no colour. */
bool namesInfrared(const std::string& topic) {
  const std::string name = lowerCase(topic);
  return contains(name, "infra") || contains(name, "/ir/") || contains(name, "/ir_") || contains(name, "_ir/");
}

/** \brief Where red, green and blue are among the bytes of a pixel. */
struct Layout {
  std::size_t pixel, red, green, blue;
};

const std::map<std::string, Layout>& layouts() {
  static const std::map<std::string, Layout> all{
      {"rgb8", {3, 0, 1, 2}},  {"bgr8", {3, 2, 1, 0}}, {"rgba8", {4, 0, 1, 2}}, {"bgra8", {4, 2, 1, 0}},
      {"mono8", {1, 0, 0, 0}}, {"8UC1", {1, 0, 0, 0}}, {"8UC3", {3, 2, 1, 0}},  {"8UC4", {4, 2, 1, 0}}};
  return all;
}

/** \brief Where the colours are in the square of the first four pixels: 'r', 'g' or 'b' each, row by row; empty: no Bayer pattern. */
std::string bayerPattern(const std::string& encoding) {
  constexpr const char* prefix = "bayer_";
  if (encoding.rfind(prefix, 0) != 0 || encoding.size() != 11 || encoding.back() != '8') return "";
  const std::string pattern = encoding.substr(6, 4);
  for (const char* known : {"rggb", "bggr", "gbrg", "grbg"})
    if (pattern == known) return pattern;
  return "";
}

/** \brief Where luminance is among the two bytes of a pixel; none: no such encoding. */
std::optional<std::size_t> lumaOffset(const std::string& encoding) {
  const std::string name = lowerCase(encoding);
  if (name == "yuv422" || name == "uyvy") return 1;
  if (name == "yuv422_yuy2" || name == "yuyv" || name == "yuy2") return 0;
  return std::nullopt;
}

/** \brief Throws unless the message has all the rows that it says it has, and then as the check does. */
void checkRows(const std::string& name, const ImageMessage& image, std::size_t bytes_per_pixel,
               const SizeCheck& check) {
  constexpr std::uint32_t widest = 1 << 16;
  if (image.width == 0 || image.height == 0 || image.width > widest || image.height > widest)
    throw InputError(name + ": is " + std::to_string(image.width) + "x" + std::to_string(image.height) + " pixels");
  const std::size_t row = bytes_per_pixel * image.width;
  if (image.step < row || image.data.size() < std::size_t{image.step} * (image.height - 1) + row)
    throw InputError(name + ": has " + std::to_string(image.data.size()) + " bytes and a step of " +
                     std::to_string(image.step) + ", which is too little for " + std::to_string(image.width) + "x" +
                     std::to_string(image.height) + " pixels of " + image.encoding);
  if (check) check(static_cast<int>(image.width), static_cast<int>(image.height));
}

const std::uint8_t* rowOf(const ImageMessage& image, int v) {
  return reinterpret_cast<const std::uint8_t*>(image.data.data()) +
         std::size_t{image.step} * static_cast<std::size_t>(v);
}

template <typename Number>
void copyDepth(const ImageMessage& image, Image<Number>& into) {
  into.resize(static_cast<int>(image.width), static_cast<int>(image.height));
  for (int v = 0; v < into.height; ++v) {
    std::memcpy(&into.at(0, v), rowOf(image, v), sizeof(Number) * image.width);
    if (!image.big_endian) continue;
    for (int u = 0; u < into.width; ++u) {
      auto* bytes = reinterpret_cast<std::uint8_t*>(&into.at(u, v));
      std::reverse(bytes, bytes + sizeof(Number));
    }
  }
}

std::uint8_t rounded(float value) { return static_cast<std::uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f)); }

/** \brief BT.601 of limited range, as USB cameras have it; two pixels share their chroma. */
void convertYuv422(const ImageMessage& image, std::size_t luma, ColorImage& into) {
  for (int v = 0; v < into.height; ++v) {
    const std::uint8_t* row = rowOf(image, v);
    for (int u = 0; u < into.width; ++u) {
      const std::uint8_t* pair = row + 4 * (static_cast<std::size_t>(u) / 2);
      const float y = 1.164384f * static_cast<float>(row[2 * static_cast<std::size_t>(u) + luma] - 16);
      const auto cb = static_cast<float>(pair[1 - luma] - 128), cr = static_cast<float>(pair[3 - luma] - 128);
      into.at(u, v) = {rounded(y + 1.596027f * cr), rounded(y - 0.391762f * cb - 0.812968f * cr),
                       rounded(y + 2.017232f * cb)};
    }
  }
}

/** \brief What a pixel did not measure is the mean of the neighbours that did. */
void convertBayer(const ImageMessage& image, const std::string& pattern, ColorImage& into) {
  const auto color_at = [&](int u, int v) { return pattern[static_cast<std::size_t>(2 * (v & 1) + (u & 1))]; };
  for (int v = 0; v < into.height; ++v)
    for (int u = 0; u < into.width; ++u) {
      int sums[3] = {}, counts[3] = {};
      const char own = color_at(u, v);
      for (int y = std::max(0, v - 1); y <= std::min(into.height - 1, v + 1); ++y)
        for (int x = std::max(0, u - 1); x <= std::min(into.width - 1, u + 1); ++x) {
          const char color = color_at(x, y);
          const bool here = x == u && y == v;
          if (color == own && !here) continue;
          const std::size_t channel = color == 'r' ? 0 : color == 'g' ? 1 : 2;
          sums[channel] += rowOf(image, y)[x];
          ++counts[channel];
        }
      const auto mean = [&](int c) {
        return static_cast<std::uint8_t>(counts[c] ? (sums[c] + counts[c] / 2) / counts[c] : 0);
      };
      into.at(u, v) = {mean(0), mean(1), mean(2)};
    }
}

/** \brief Depth by Wilson's run lengths and variable lengths: groups of three bits, the highest says that more follow, in words of 32 bits. */
void decodeRvl(const std::string& name, std::string_view data, DepthImage& into) {
  std::size_t word = 0;
  int nibbles_left = 0;
  std::uint32_t bits = 0;
  const auto damaged = [&] { return InputError(name + ": is damaged, must be whole depth by RVL"); };
  const auto number = [&] {
    std::uint32_t value = 0;
    for (int shift = 0;; shift += 3) {
      if (shift > 30) throw damaged();
      if (nibbles_left == 0) {
        if (data.size() - word < 4) throw damaged();
        std::memcpy(&bits, data.data() + word, 4);
        word += 4;
        nibbles_left = 8;
      }
      const std::uint32_t nibble = bits >> 28;
      bits <<= 4;
      --nibbles_left;
      value |= (nibble & 7u) << shift;
      if ((nibble & 8u) == 0) return value;
    }
  };
  std::size_t at = 0;
  std::uint32_t last = 0;
  while (at < into.data.size()) {
    const std::uint32_t zeros = number();
    if (zeros > into.data.size() - at) throw damaged();
    std::fill_n(into.data.begin() + static_cast<std::ptrdiff_t>(at), zeros, std::uint16_t{0});
    at += zeros;
    const std::uint32_t values = number();
    if (values > into.data.size() - at || (zeros == 0 && values == 0)) throw damaged();
    for (std::uint32_t k = 0; k < values; ++k) {
      const std::uint32_t zigzag = number();
      last += (zigzag >> 1) ^ (0u - (zigzag & 1u));
      into.data[at++] = static_cast<std::uint16_t>(last);
    }
  }
}

}  // namespace

ImageKind kindOf(const ImageMessage& image, const std::string& topic) {
  const std::string name = lowerCase(topic);
  for (const char* other : {"disparity", "confidence", "amplitude", "intensity", "variance"})
    if (contains(name, other)) return ImageKind::Neither;
  if (image.encoding == "32FC1") return ImageKind::Depth;
  if (image.encoding == "16UC1" || image.encoding == "mono16")
    return contains(name, "depth") ? ImageKind::Depth : ImageKind::Neither;
  if (namesInfrared(topic)) return ImageKind::Neither;
  const bool color =
      layouts().count(image.encoding) > 0 || !bayerPattern(image.encoding).empty() || lumaOffset(image.encoding);
  return color ? ImageKind::Color : ImageKind::Neither;
}

ImageKind kindOf(const CompressedImageMessage& image, const std::string& topic) {
  if (contains(image.format, "compressedDepth")) return ImageKind::Depth;
  if (contains(image.format, "16UC1") || contains(image.format, "mono16"))  // a PNG of plain "compressed"
    return contains(lowerCase(topic), "depth") ? ImageKind::Depth : ImageKind::Neither;
  if (namesInfrared(topic)) return ImageKind::Neither;
  const std::string format = lowerCase(image.format);
  const bool known = contains(format, "jpeg") || contains(format, "jpg") || contains(format, "png");
  return known ? ImageKind::Color : ImageKind::Neither;
}

void decodeDepth(const std::string& name, const ImageMessage& image, LoadedView& into, const SizeCheck& check) {
  if (image.encoding == "32FC1") {
    checkRows(name, image, sizeof(float), check);
    into.depth16.resize(0, 0);
    copyDepth(image, into.depth32);
    return;
  }
  if (image.encoding != "16UC1" && image.encoding != "mono16")
    throw InputError(name + ": is encoded as '" + cutShort(image.encoding) + "', depth must be 16UC1, mono16 or 32FC1");
  checkRows(name, image, sizeof(std::uint16_t), check);
  into.depth32.resize(0, 0);
  copyDepth(image, into.depth16);
}

void decodeDepth(const std::string& name, const CompressedImageMessage& image, LoadedView& into,
                 const SizeCheck& check) {
  into.depth32.resize(0, 0);
  if (!contains(image.format, "compressedDepth")) {
    decodeDepthPng(name, std::string(image.data), into.depth16, check);
    return;
  }
  // An enumeration, which nobody sets, and the two parameters of inverse depth.
  constexpr std::size_t config_size = 12;
  if (image.data.size() < config_size) throw InputError(name + ": has no data");
  float quant_a = 0, quant_b = 0;
  std::memcpy(&quant_a, image.data.data() + 4, 4);
  std::memcpy(&quant_b, image.data.data() + 8, 4);
  std::string_view data = image.data.substr(config_size);
  if (contains(image.format, "rvl")) {
    std::uint32_t size[2] = {};
    if (data.size() < sizeof size) throw InputError(name + ": has no data");
    std::memcpy(size, data.data(), sizeof size);
    constexpr std::uint32_t widest = 1 << 14;
    if (size[0] == 0 || size[1] == 0 || size[0] > widest || size[1] > widest)
      throw InputError(name + ": is " + std::to_string(size[0]) + "x" + std::to_string(size[1]) + " pixels");
    // Before the memory: of RVL a few bytes are any number of pixels without a measurement.
    if (check) check(static_cast<int>(size[0]), static_cast<int>(size[1]));
    into.depth16.resize(static_cast<int>(size[0]), static_cast<int>(size[1]));
    decodeRvl(name, data.substr(sizeof size), into.depth16);
  } else {
    decodeDepthPng(name, std::string(data), into.depth16, check);
  }
  if (!contains(image.format, "32FC1")) return;
  if (!std::isfinite(quant_a) || !std::isfinite(quant_b) || !(quant_a > 0))
    throw InputError(name + ": has no parameters of inverse depth");
  into.depth32.resize(into.depth16.width, into.depth16.height);
  for (std::size_t k = 0; k < into.depth32.data.size(); ++k) {
    const std::uint16_t raw = into.depth16.data[k];
    into.depth32.data[k] =
        raw == 0 ? std::numeric_limits<float>::quiet_NaN() : quant_a / (static_cast<float>(raw) - quant_b);
  }
  into.depth16.resize(0, 0);
}

void decodeColor(const std::string& name, const ImageMessage& image, ColorImage& into, const SizeCheck& check) {
  const auto layout = layouts().find(image.encoding);
  const std::string pattern = bayerPattern(image.encoding);
  const std::optional<std::size_t> luma = lumaOffset(image.encoding);
  if (layout == layouts().end() && pattern.empty() && !luma)
    throw InputError(name + ": is encoded as '" + cutShort(image.encoding) +
                     "', colour must be rgb8, bgr8, rgba8, bgra8, mono8, yuv422, yuv422_yuy2 or bayer_****8");
  checkRows(name, image, luma ? 2 : pattern.empty() ? layout->second.pixel : 1, check);
  if (luma && image.width % 2 == 1) throw InputError(name + ": is of an odd width, YUV 4:2:2 must be even");
  into.resize(static_cast<int>(image.width), static_cast<int>(image.height));
  if (luma) return convertYuv422(image, *luma, into);
  if (!pattern.empty()) return convertBayer(image, pattern, into);
  const Layout& l = layout->second;
  for (int v = 0; v < into.height; ++v) {
    const std::uint8_t* pixel = rowOf(image, v);
    for (int u = 0; u < into.width; ++u, pixel += l.pixel)
      into.at(u, v) = {pixel[l.red], pixel[l.green], pixel[l.blue]};
  }
}

void decodeColor(const std::string& name, const CompressedImageMessage& image, ColorImage& into,
                 const SizeCheck& check) {
  decodeColor(name, std::string(image.data), into, check);
}

}  // namespace fuse_flow::io
