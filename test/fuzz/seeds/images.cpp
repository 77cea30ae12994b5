#include "../scratch.h"
#include "../seeds.h"
#include "small_images.h"

#include "recordings/files/file_io.h"
#include "recordings/images/jpeg_encode.h"

#include "../../apps/recordings/images/float_files.h"
#include "../../apps/recordings/images/jpeg_file.h"
#include "../../apps/tools/support/png_file.h"

#include <tiffio.h>

#ifdef FUSE_FLOW_WITH_OPENEXR
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#endif

#include <cmath>

namespace fuse_flow_fuzz {
namespace {

std::vector<std::uint16_t> millimetres() {
  std::vector<std::uint16_t> pixels;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) pixels.push_back(static_cast<std::uint16_t>(1000 * metresAt(u, v)));
  return pixels;
}

fuse_flow::io::ColorImage colors(int width, int height) {
  fuse_flow::io::ColorImage image;
  image.resize(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      image.at(u, v) = {static_cast<std::uint8_t>(20 * u), static_cast<std::uint8_t>(30 * v),
                        static_cast<std::uint8_t>(u * v)};
  return image;
}

template <typename Number>
std::string tiff(std::uint16_t compression, bool tiles, bool is_float) {
  const std::string path = scratchFile("seed.tif", "");
  TIFF* const file = TIFFOpen(path.c_str(), "w");
  const std::uint32_t side = 16;  // of tiles, whose sides are multiples of 16
  TIFFSetField(file, TIFFTAG_IMAGEWIDTH, side);
  TIFFSetField(file, TIFFTAG_IMAGELENGTH, side);
  TIFFSetField(file, TIFFTAG_BITSPERSAMPLE, 8 * static_cast<int>(sizeof(Number)));
  TIFFSetField(file, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(file, TIFFTAG_SAMPLEFORMAT, is_float ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT);
  TIFFSetField(file, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(file, TIFFTAG_COMPRESSION, compression);
  if (tiles) {
    TIFFSetField(file, TIFFTAG_TILEWIDTH, side);
    TIFFSetField(file, TIFFTAG_TILELENGTH, side);
  } else {
    TIFFSetField(file, TIFFTAG_ROWSPERSTRIP, 4);
  }
  std::vector<Number> pixels;
  for (int k = 0; k < 256; ++k) pixels.push_back(static_cast<Number>(k));
  if (tiles)
    TIFFWriteTile(file, pixels.data(), 0, 0, 0, 0);
  else
    for (std::uint32_t v = 0; v < side; ++v) TIFFWriteScanline(file, pixels.data() + side * v, v, 0);
  TIFFClose(file);
  return fuse_flow::io::readFile(path);
}

#ifdef FUSE_FLOW_WITH_OPENEXR
std::string exr(Imf::Compression compression, Imf::PixelType type) {
  const std::string path = scratchFile("seed.exr", "");
  {
    Imf::Header header(kWidth, kHeight);
    header.compression() = compression;
    header.channels().insert("Z", Imf::Channel(type));
    std::vector<float> pixels;
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth; ++u) pixels.push_back(metresAt(u, v));
    const std::vector<std::uint16_t> halves(pixels.size(), 0x3c00);  // 1
    const bool is_half = type == Imf::HALF;
    char* const data = is_half ? reinterpret_cast<char*>(const_cast<std::uint16_t*>(halves.data()))
                               : reinterpret_cast<char*>(pixels.data());
    const std::size_t size = is_half ? 2 : 4;
    Imf::FrameBuffer buffer;
    buffer.insert("Z", Imf::Slice(type, data, size, size * kWidth));
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(kHeight);
  }
  return fuse_flow::io::readFile(path);
}
#endif

}  // namespace

void addImageSeeds(Seeds& seeds) {
  using namespace tool_test;
  seeds["png"] = {depthPng(kWidth, kHeight, millimetres()),
                  colorPng(kWidth, kHeight, 10, 20, 30),
                  samplesPng(kWidth, kHeight, 8, 0, std::string(kWidth * kHeight, '\x80')),
                  samplesPng(kWidth, kHeight, 8, 6, std::string(4 * kWidth * kHeight, '\x80')),
                  samplesPng(kWidth, kHeight, 1, 0, std::string(kHeight, '\x55')),
                  png(pngHeader(kWidth, kHeight, 4, 3) + pngChunk("PLTE", "abcdef") + pngChunk("tRNS", "a") +
                      pngChunk("IDAT", zlibStored(std::string(kHeight * (1 + kWidth / 2), '\0'))))};
  seeds["jpeg"] = {fuse_flow::io::encodeJpeg(colors(16, 8), 90), fuse_flow::io::encodeJpeg(colors(9, 17), 30),
                   io_test::jpeg(2, {{10, 20}}), io_test::jpeg(1, {{10, 20}, {128, 130}, {100, 90}})};
  seeds["pfm"] = {io_test::pfm(kWidth, kHeight, metresAt), io_test::pfm(kWidth, kHeight, metresAt, true)};
  seeds["npy"] = {io_test::npy("<f4", "(6, 8)", io_test::floats(kWidth, kHeight, metresAt)),
                  io_test::npy(">f4", "(1, 6, 8, 1)", io_test::floats(kWidth, kHeight, metresAt, true)),
                  io_test::npy("<f8", "(1, 2)", std::string(16, '\x40'))};
  seeds["colmap_depth"] = {io_test::colmapMap(kWidth, kHeight, metresAt)};
  for (const std::uint16_t compression :
       {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_PACKBITS}) {
    seeds["tiff"].push_back(tiff<std::uint16_t>(compression, false, false));
    seeds["tiff"].push_back(tiff<float>(compression, true, true));
  }
  seeds["tiff"].push_back(tiff<double>(COMPRESSION_NONE, false, true));
#ifdef FUSE_FLOW_WITH_OPENEXR
  for (const Imf::Compression compression :
       {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION, Imf::PXR24_COMPRESSION})
    for (const Imf::PixelType type : {Imf::FLOAT, Imf::HALF}) seeds["exr"].push_back(exr(compression, type));
#endif
}

}  // namespace fuse_flow_fuzz
