#include "recordings/images/tiff_image.h"

#include "recordings/files/file_io.h"
#include "recordings/images/plausible_size.h"

#include <fuse_flow/recordings/error.h>

#include <tiffio.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <vector>

namespace fuse_flow::io {
namespace {

/** \brief A file's bytes, as libtiff reads them. */
struct TiffBytes {
  const std::string& bytes;
  std::uint64_t at{0};
};

TiffBytes& bytesOf(thandle_t handle) { return *static_cast<TiffBytes*>(handle); }

tmsize_t readBytes(thandle_t handle, void* to, tmsize_t size) {
  TiffBytes& file = bytesOf(handle);
  const std::uint64_t left = file.at < file.bytes.size() ? file.bytes.size() - file.at : 0;
  const std::uint64_t count = std::min<std::uint64_t>(left, size < 0 ? 0 : static_cast<std::uint64_t>(size));
  if (count > 0) std::memcpy(to, file.bytes.data() + file.at, count);
  file.at += count;
  return static_cast<tmsize_t>(count);
}
tmsize_t writeNothing(thandle_t, void*, tmsize_t) { return 0; }
toff_t seekBytes(thandle_t handle, toff_t offset, int whence) {
  TiffBytes& file = bytesOf(handle);
  file.at = whence == SEEK_SET ? offset : whence == SEEK_CUR ? file.at + offset : file.bytes.size() + offset;
  return file.at;
}
int closeNothing(thandle_t) { return 0; }
toff_t sizeOfBytes(thandle_t handle) { return bytesOf(handle).bytes.size(); }

using TiffHandle = std::unique_ptr<TIFF, decltype(&TIFFClose)>;

/** \brief libtiff prints what it finds wrong, unless told otherwise: since 4.5 for one file, before for the process. */
TIFF* openQuietly(TiffBytes& file) {
  // M: not mapped.
#if TIFFLIB_VERSION >= 20221213
  TIFFOpenOptions* const options = TIFFOpenOptionsAlloc();
  const auto silent = [](TIFF*, void*, const char*, const char*, va_list) { return 1; };
  TIFFOpenOptionsSetErrorHandlerExtR(options, silent, nullptr);
  TIFFOpenOptionsSetWarningHandlerExtR(options, silent, nullptr);
  TIFF* const tiff = TIFFClientOpenExt("", "rM", &file, readBytes, writeNothing, seekBytes, closeNothing, sizeOfBytes,
                                       nullptr, nullptr, options);
  TIFFOpenOptionsFree(options);
  return tiff;
#else
  static const bool silenced = (TIFFSetErrorHandler(nullptr), TIFFSetWarningHandler(nullptr), true);
  static_cast<void>(silenced);
  return TIFFClientOpen("", "rM", &file, readBytes, writeNothing, seekBytes, closeNothing, sizeOfBytes, nullptr,
                        nullptr);
#endif
}

/** \brief What a depth image may be. */
struct TiffHeader {
  std::uint32_t width{0};
  std::uint32_t height{0};
  std::uint16_t bits{0};
  bool is_float{false};
  bool bottom_first{false};
};

std::uint16_t tagOf(TIFF* tiff, ttag_t tag) {
  std::uint16_t value = 0;
  TIFFGetFieldDefaulted(tiff, tag, &value);
  return value;
}

TiffHeader headerOf(const std::string& path, TIFF* tiff) {
  TiffHeader header;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &header.width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &header.height);
  const auto is_side = [](std::uint32_t pixels) { return pixels >= 1 && pixels <= 65535; };
  if (!is_side(header.width) || !is_side(header.height))
    throw InputError(path + ": says that it is " + std::to_string(header.width) + "x" + std::to_string(header.height) +
                     " pixels, each side must be 1 to 65535");
  header.bits = tagOf(tiff, TIFFTAG_BITSPERSAMPLE);
  const std::uint16_t channels = tagOf(tiff, TIFFTAG_SAMPLESPERPIXEL), format = tagOf(tiff, TIFFTAG_SAMPLEFORMAT);
  header.is_float = format == SAMPLEFORMAT_IEEEFP;
  const bool whole = format == SAMPLEFORMAT_UINT || format == SAMPLEFORMAT_VOID;
  const bool known = header.is_float ? header.bits == 32 || header.bits == 64 : whole && header.bits == 16;
  if (channels != 1 || !known)
    throw InputError(path + ": is a TIFF of " + std::to_string(channels) + " channels of " +
                     std::to_string(header.bits) + "-bit " +
                     (header.is_float ? "float"
                      : whole         ? "whole"
                                      : "other") +
                     " numbers, depth must be one channel of 16-bit whole numbers or of 32-bit float");
  if (tagOf(tiff, TIFFTAG_PHOTOMETRIC) == PHOTOMETRIC_MINISWHITE)
    throw InputError(path + ": is a TIFF where 0 is white, which is no depth");
  const std::uint16_t orientation = tagOf(tiff, TIFFTAG_ORIENTATION);
  if (orientation != ORIENTATION_TOPLEFT && orientation != ORIENTATION_BOTLEFT)
    throw InputError(path + ": has its columns or rows exchanged (orientation " + std::to_string(orientation) +
                     "), must begin at the top left");
  header.bottom_first = orientation == ORIENTATION_BOTLEFT;
  if (TIFFLastDirectory(tiff) == 0) throw InputError(path + ": has several images, must have one");
  return header;
}

/** \brief All rows, as they are in the file. */
std::vector<std::uint8_t> pixelsOf(const std::string& path, TIFF* tiff, const TiffHeader& header) {
  const auto broken = [&path] { return InputError(path + ": is damaged or cut short"); };
  const std::size_t sample = header.bits / 8U, row = sample * header.width;
  std::vector<std::uint8_t> pixels(row * header.height);
  if (TIFFIsTiled(tiff) == 0) {
    if (TIFFScanlineSize64(tiff) != row) throw broken();
    for (std::uint32_t v = 0; v < header.height; ++v)
      if (TIFFReadScanline(tiff, pixels.data() + row * v, v, 0) != 1) throw broken();
    return pixels;
  }
  std::uint32_t width = 0, height = 0;  // of a tile
  TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &width);
  TIFFGetField(tiff, TIFFTAG_TILELENGTH, &height);
  constexpr std::uint32_t largest = 65536;
  if (width < 1 || height < 1 || width > largest || height > largest ||
      std::uint64_t{width} * height > 4 * (std::uint64_t{header.width} * header.height + largest) ||
      TIFFTileSize64(tiff) != std::uint64_t{width} * height * sample)
    throw broken();
  std::vector<std::uint8_t> tile(std::size_t{width} * height * sample);
  for (std::uint32_t v = 0; v < header.height; v += height)
    for (std::uint32_t u = 0; u < header.width; u += width) {
      if (TIFFReadTile(tiff, tile.data(), u, v, 0, 0) < 0) throw broken();
      const std::size_t columns = std::min(width, header.width - u), rows = std::min(height, header.height - v);
      for (std::size_t j = 0; j < rows; ++j)
        std::copy_n(tile.data() + j * width * sample, columns * sample, pixels.data() + (v + j) * row + u * sample);
    }
  return pixels;
}

float inFloat(float number) { return number; }
/** \brief A cast would be undefined for what float cannot hold. */
float inFloat(double number) {
  constexpr double most = std::numeric_limits<float>::max();
  if (number > most) return std::numeric_limits<float>::infinity();
  if (number < -most) return -std::numeric_limits<float>::infinity();
  return static_cast<float>(number);
}
std::uint16_t inFloat(std::uint16_t number) { return number; }

template <typename Sample, typename Pixel>
void copyTiff(const std::vector<std::uint8_t>& pixels, const TiffHeader& header, Image<Pixel>& image) {
  image.resize(static_cast<int>(header.width), static_cast<int>(header.height));
  for (int v = 0; v < image.height; ++v) {
    const int place = header.bottom_first ? image.height - 1 - v : v;
    const std::uint8_t* from = pixels.data() + sizeof(Sample) * header.width * static_cast<std::size_t>(place);
    for (int u = 0; u < image.width; ++u, from += sizeof(Sample)) {
      Sample number;
      std::memcpy(&number, from, sizeof number);
      image.at(u, v) = inFloat(number);
    }
  }
}

TiffHandle openTiff(const std::string& path, TiffBytes& file) {
  TiffHandle tiff(openQuietly(file), &TIFFClose);
  if (!tiff) throw InputError(path + ": is no TIFF, or damaged");
  return tiff;
}

}  // namespace

bool isTiff(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  return extension == ".tif" || extension == ".tiff" || extension == ".TIF" || extension == ".TIFF";
}

bool tiffIsFloat(const std::string& path) {
  const std::string bytes = readFile(path);
  TiffBytes file{bytes};
  const TiffHandle tiff = openTiff(path, file);
  return headerOf(path, tiff.get()).is_float;
}

void readDepthTiff(const std::string& path, DepthImage& depth16, FloatImage& depth32, const SizeCheck& check) {
  const std::string bytes = readFile(path);
  TiffBytes file{bytes};
  const TiffHandle tiff = openTiff(path, file);
  const TiffHeader header = headerOf(path, tiff.get());
  if (check) check(static_cast<int>(header.width), static_cast<int>(header.height));
  checkPlausible(path, static_cast<int>(header.width), static_cast<int>(header.height), bytes.size(), kMostOfAnyByte);
  const std::vector<std::uint8_t> pixels = pixelsOf(path, tiff.get(), header);
  depth16.resize(0, 0);
  depth32.resize(0, 0);
  if (!header.is_float)
    copyTiff<std::uint16_t>(pixels, header, depth16);
  else if (header.bits == 32)
    copyTiff<float>(pixels, header, depth32);
  else
    copyTiff<double>(pixels, header, depth32);
}

}  // namespace fuse_flow::io
