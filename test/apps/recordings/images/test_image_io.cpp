#include "recordings/images/image_io.h"

#include "../../tools/support/png_file.h"
#include "../io_fixture.h"
#include "jpeg_file.h"

#include <numeric>
#include <utility>

namespace {

using namespace io_test;
using tool_test::png;
using tool_test::pngChunk;
using tool_test::pngHeader;
using tool_test::samplesPng;
using tool_test::zlibStored;

class ImageIo : public IoTest {};

std::string bytesOf(const std::vector<int>& values) { return std::string(values.begin(), values.end()); }

std::vector<int> channels(const Rgb8& c) { return {c.r, c.g, c.b}; }

/** \brief 3×2 pixels, each with a value of its own; the most and the least significant byte differ. */
const std::vector<std::uint16_t> kDepths{0, 1, 255, 256, 12345, 65535};

TEST_F(ImageIo, DepthComesBackAsWritten) {
  io::DepthImage image, back;
  image.resize(3, 2);
  image.data = kDepths;
  io::writeDepthPng(path("a.png"), image);
  io::readDepthPng(path("a.png"), back);
  EXPECT_EQ(std::make_pair(back.width, back.height), std::make_pair(3, 2));
  EXPECT_EQ(back.data, kDepths);
}

TEST_F(ImageIo, DepthOfAnotherProgramIsReadTopRowFirst) {
  io::DepthImage image;
  io::readDepthPng(write("a.png", tool_test::depthPng(3, 2, kDepths)), image);
  EXPECT_EQ(std::make_pair(image.width, image.height), std::make_pair(3, 2));
  EXPECT_EQ(image.data, kDepths);
  EXPECT_EQ(image.at(1, 0), 1);
  EXPECT_EQ(image.at(0, 1), 256);
  EXPECT_EQ(image.view().row(1)[2], 65535);
}

TEST_F(ImageIo, AColorThatThePngDeclaresTransparentIsDepthLikeAnyOther) {
  std::string samples;
  for (const std::uint16_t value : kDepths) samples += {static_cast<char>(value >> 8), static_cast<char>(value & 0xff)};
  const std::string rows = '\0' + samples.substr(0, 6) + '\0' + samples.substr(6);
  io::DepthImage image;
  io::readDepthPng(write("a.png", png(pngHeader(3, 2, 16, 0) + pngChunk("tRNS", bytesOf({0, 255})) +
                                      pngChunk("IDAT", zlibStored(rows)))),
                   image);
  EXPECT_EQ(image.data, kDepths);
}

TEST_F(ImageIo, AnInterlacedPngIsReadLikeAnyOther) {
  const std::string header = bytesOf({0, 0, 0, 3, 0, 0, 0, 2, 16, 0, 0, 0, 1});
  const auto row = [](const std::vector<std::uint16_t>& values) {
    std::string samples(1, '\0');
    for (const std::uint16_t value : values)
      samples += {static_cast<char>(value >> 8), static_cast<char>(value & 0xff)};
    return samples;
  };
  // Of the seven passes of a 3x2 image, those that are not empty: pixel 0, pixel 2, pixel 1, the second row.
  const std::string rows = row({kDepths[0]}) + row({kDepths[2]}) + row({kDepths[1]}) + row({256, 12345, 65535});
  io::DepthImage image;
  io::readDepthPng(write("a.png", png(pngChunk("IHDR", header) + pngChunk("IDAT", zlibStored(rows)))), image);
  EXPECT_EQ(image.data, kDepths);
}

TEST_F(ImageIo, DepthInAnyOtherKindOfPngIsRefused) {
  const auto samples = [](int count) { return std::string(static_cast<std::size_t>(count), '\1'); };
  const std::vector<std::pair<std::string, std::string>> kinds = {
      {"8-bit grey PNG", samplesPng(2, 2, 8, 0, samples(4))},
      {"8-bit RGB", samplesPng(2, 2, 8, 2, samples(12))},
      {"16-bit RGB", samplesPng(2, 2, 16, 2, samples(24))},
      {"16-bit grey and alpha", samplesPng(2, 2, 16, 4, samples(16))},
      {"8-bit RGB and alpha", samplesPng(2, 2, 8, 6, samples(16))}};
  for (const auto& [kind, bytes] : kinds) {
    const std::string file = write("a.png", bytes);
    io::DepthImage image;
    EXPECT_TRUE(refuses([&] { io::readDepthPng(file, image); }, {file, kind, "must be 16-bit grey"}));
  }
}

TEST_F(ImageIo, ColorComesBackAsWritten) {
  io::ColorImage image, back;
  image.resize(2, 2);
  image.data = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {1, 2, 3}};
  io::writeColorPng(path("a.png"), image);
  io::readColor(path("a.png"), back);
  ASSERT_EQ(std::make_pair(back.width, back.height), std::make_pair(2, 2));
  for (int v = 0; v < 2; ++v)
    for (int u = 0; u < 2; ++u) EXPECT_EQ(channels(back.at(u, v)), channels(image.at(u, v))) << u << ' ' << v;
}

TEST_F(ImageIo, EveryKindOfEightBitPngIsReadAsColor) {
  using Pixels = std::vector<std::vector<int>>;
  struct Kind {
    std::string name;
    std::string bytes;
    Pixels pixels;  // of an image of 2×1
  };
  const std::string palette = pngChunk("PLTE", bytesOf({9, 8, 7, 20, 30, 40}));
  const std::vector<Kind> kinds = {
      {"RGB", samplesPng(2, 1, 8, 2, bytesOf({1, 2, 3, 4, 5, 6})), {{1, 2, 3}, {4, 5, 6}}},
      {"RGB and alpha", samplesPng(2, 1, 8, 6, bytesOf({1, 2, 3, 0, 4, 5, 6, 128})), {{1, 2, 3}, {4, 5, 6}}},
      {"grey", samplesPng(2, 1, 8, 0, bytesOf({7, 200})), {{7, 7, 7}, {200, 200, 200}}},
      {"grey and alpha", samplesPng(2, 1, 8, 4, bytesOf({7, 0, 200, 255})), {{7, 7, 7}, {200, 200, 200}}},
      {"1-bit grey", samplesPng(2, 1, 1, 0, bytesOf({0x40})), {{0, 0, 0}, {255, 255, 255}}},
      {"palette",
       png(pngHeader(2, 1, 8, 3) + palette + pngChunk("IDAT", zlibStored(bytesOf({0, 1, 0})))),
       {{20, 30, 40}, {9, 8, 7}}},
      {"palette with transparency",
       png(pngHeader(2, 1, 8, 3) + palette + pngChunk("tRNS", bytesOf({0})) +
           pngChunk("IDAT", zlibStored(bytesOf({0, 1, 0})))),
       {{20, 30, 40}, {9, 8, 7}}}};
  for (const Kind& kind : kinds) {
    io::ColorImage image;
    io::readColor(write("a.png", kind.bytes), image);
    ASSERT_EQ(std::make_pair(image.width, image.height), std::make_pair(2, 1)) << kind.name;
    EXPECT_EQ(channels(image.at(0, 0)), kind.pixels[0]) << kind.name;
    EXPECT_EQ(channels(image.at(1, 0)), kind.pixels[1]) << kind.name;
  }
}

TEST_F(ImageIo, ColorOfSixteenBitsIsRefused) {
  const std::string file = write("a.png", samplesPng(1, 1, 16, 2, std::string(6, '\1')));
  io::ColorImage image;
  EXPECT_TRUE(refuses([&] { io::readColor(file, image); }, {file, "16-bit RGB", "8-bit"}));
}

TEST_F(ImageIo, AJpegIsReadTopRowFirstWhateverItsName) {
  // Y, Cb, Cr of red above, of blue below, by the formula of JFIF.
  const std::string bytes = jpeg(2, {{76, 76, 29, 29}, {85, 85, 255, 255}, {255, 255, 107, 107}});
  io::ColorImage image;
  io::readColor(write("a.png", bytes), image);
  ASSERT_EQ(std::make_pair(image.width, image.height), std::make_pair(16, 16));
  const auto isNear = [](const Rgb8& c, int r, int g, int b) {
    return std::abs(c.r - r) <= 3 && std::abs(c.g - g) <= 3 && std::abs(c.b - b) <= 3;
  };
  for (int u = 0; u < 16; ++u) {
    EXPECT_TRUE(isNear(image.at(u, 0), 254, 0, 0)) << testing::PrintToString(channels(image.at(u, 0)));
    EXPECT_TRUE(isNear(image.at(u, 15), 0, 0, 254)) << testing::PrintToString(channels(image.at(u, 15)));
  }
}

TEST_F(ImageIo, AGreyJpegIsSpreadOverTheChannels) {
  io::ColorImage image;
  io::readColor(write("a.jpg", jpeg(2, {{10, 100, 200, 255}})), image);
  EXPECT_EQ(channels(image.at(0, 0)), (std::vector<int>{10, 10, 10}));
  EXPECT_EQ(channels(image.at(15, 0)), (std::vector<int>{100, 100, 100}));
  EXPECT_EQ(channels(image.at(0, 15)), (std::vector<int>{200, 200, 200}));
  EXPECT_EQ(channels(image.at(15, 15)), (std::vector<int>{255, 255, 255}));
}

TEST_F(ImageIo, AJpegForPrintersIsRefused) {
  const std::string file = write("a.jpg", jpeg(1, {{10}, {20}, {30}, {40}}));
  io::ColorImage image;
  EXPECT_TRUE(refuses([&] { io::readColor(file, image); }, {file, "of 4 channels", "grey or RGB"}));
}

TEST_F(ImageIo, ZeroBytesAfterAJpegAreNoDamage) {
  io::ColorImage image;
  io::readColor(write("a.jpg", jpeg(1, {{77}}) + std::string(512, '\0')), image);
  EXPECT_EQ(channels(image.at(3, 3)), (std::vector<int>{77, 77, 77}));
}

TEST_F(ImageIo, ConfidenceRunsFromZeroToOne) {
  io::FloatImage image;
  io::readConfidencePng(write("8.png", samplesPng(3, 1, 8, 0, bytesOf({0, 51, 255}))), image);
  EXPECT_EQ(image.data.size(), 3u);
  EXPECT_EQ(image.at(0, 0), 0.0f);
  EXPECT_FLOAT_EQ(image.at(1, 0), 0.2f);
  EXPECT_EQ(image.at(2, 0), 1.0f);
  io::readConfidencePng(write("16.png", tool_test::depthPng(3, 1, {0, 13107, 65535})), image);
  EXPECT_EQ(image.at(0, 0), 0.0f);
  EXPECT_FLOAT_EQ(image.at(1, 0), 0.2f);
  EXPECT_EQ(image.at(2, 0), 1.0f);
}

TEST_F(ImageIo, ConfidenceInColorIsRefused) {
  const std::string file = write("a.png", samplesPng(1, 1, 8, 2, "abc"));
  io::FloatImage image;
  EXPECT_TRUE(refuses([&] { io::readConfidencePng(file, image); }, {file, "8-bit RGB", "grey"}));
}

TEST_F(ImageIo, ASmallerImageReplacesALargerOne) {
  io::DepthImage image;
  io::readDepthPng(write("large.png", tool_test::depthPng(3, 2, kDepths)), image);
  io::readDepthPng(write("small.png", tool_test::depthPng(1, 1, {42})), image);
  EXPECT_EQ(std::make_pair(image.width, image.height), std::make_pair(1, 1));
  EXPECT_EQ(image.data, (std::vector<std::uint16_t>{42}));
}

TEST_F(ImageIo, APngCutShortAnywhereIsRefused) {
  const std::string whole = tool_test::depthPng(3, 2, kDepths);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::string file = write("a.png", whole.substr(0, size));
    io::DepthImage image;
    EXPECT_TRUE(refuses([&] { io::readDepthPng(file, image); }, {file})) << "after " << size << " bytes";
  }
}

TEST_F(ImageIo, APngWithAnyByteChangedIsRefused) {
  const std::string whole = tool_test::depthPng(3, 2, kDepths);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    const std::string file = write("a.png", damaged);
    io::DepthImage image;
    EXPECT_TRUE(refuses([&] { io::readDepthPng(file, image); }, {file})) << "byte " << at;
  }
}

TEST_F(ImageIo, BytesBehindTheEndOfAJpegAreNoDamage) {
  for (const std::string& behind : {std::string("\n"), std::string("x"), "\xff\xd8" + std::string(100, 'x'),
                                    std::string("a trailer of the camera's maker\0", 32)}) {
    io::ColorImage image;
    io::readColor(write("a.jpg", jpeg(1, {{77}}) + behind), image);
    EXPECT_EQ(channels(image.at(7, 7)), (std::vector<int>{77, 77, 77})) << behind;
  }
}

/** \brief A camera's small picture within the picture has an end of its own. */
TEST_F(ImageIo, AJpegCutShortBehindThePictureWithinItIsRefused) {
  const std::string whole = jpeg(1, {{77}}), small = jpeg(1, {{33}});
  const std::string length{static_cast<char>((small.size() + 2) >> 8), static_cast<char>((small.size() + 2) & 0xff)};
  const std::string both = whole.substr(0, 2) + "\xff\xe1" + length + small + whole.substr(2);
  io::ColorImage image;
  io::readColor(write("a.jpg", both), image);
  EXPECT_EQ(channels(image.at(0, 0)), (std::vector<int>{77, 77, 77}));
  const std::string file = write("a.jpg", both.substr(0, 6 + small.size()));
  EXPECT_TRUE(refuses([&] { io::readColor(file, image); }, {file, "cut short"}));
}

TEST_F(ImageIo, AJpegCutShortAnywhereIsRefused) {
  const std::string whole = jpeg(2, {{76, 76, 29, 29}, {85, 85, 255, 255}, {255, 255, 107, 107}});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::string file = write("a.jpg", whole.substr(0, size));
    io::ColorImage image;
    EXPECT_TRUE(refuses([&] { io::readColor(file, image); }, {file})) << "after " << size << " bytes";
  }
}

TEST_F(ImageIo, AJpegThatLacksItsMiddleIsRefused) {
  const std::string whole = jpeg(8, {std::vector<std::uint8_t>(64, 90)});
  const std::string file = write("a.jpg", whole.substr(0, whole.size() - 12) + "\xff\xd9");
  io::ColorImage image;
  EXPECT_TRUE(refuses([&] { io::readColor(file, image); }, {file}));
}

TEST_F(ImageIo, AJpegWithAnyByteChangedIsReadOrRefused) {
  const std::string whole = jpeg(2, {{76, 76, 29, 29}, {85, 85, 255, 255}, {255, 255, 107, 107}});
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x24);
    const std::string file = write("a.jpg", damaged);
    try {
      io::ColorImage image;
      io::readColor(file, image);
      EXPECT_EQ(image.data.size(), static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
    } catch (const io::InputError& error) {
      EXPECT_NE(std::string(error.what()).find(file), std::string::npos) << "byte " << at << ": " << error.what();
    }
  }
}

/** \brief The size is looked at before memory is taken for it, and before the data, which are wrong here. */
TEST_F(ImageIo, TheSizeThatAFileClaimsIsToldBeforeItIsDecoded) {
  const auto check = [](int width, int height) {
    throw io::InputError("claims " + std::to_string(width) + "x" + std::to_string(height));
  };
  std::string large = jpeg(2, {{76, 76, 29, 29}, {85, 85, 255, 255}, {255, 255, 107, 107}});
  const std::size_t frame = large.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  large.replace(frame + 5, 4, "\x4e\x20\x4e\x21");  // height, width
  io::ColorImage color;
  io::DepthImage depth;
  io::FloatImage confidence;
  const std::string jpg = write("a.jpg", large);
  EXPECT_TRUE(refuses([&] { io::readColor(jpg, color, check); }, {"claims 20001x20000"}));
  const std::string bytes = tool_test::pngChunk("IDAT", "nothing");
  const std::string rgb = write("b.png", tool_test::png(tool_test::pngHeader(20001, 20000, 8, 2) + bytes));
  EXPECT_TRUE(refuses([&] { io::readColor(rgb, color, check); }, {"claims 20001x20000"}));
  const std::string grey = write("c.png", tool_test::png(tool_test::pngHeader(20001, 20000, 16, 0) + bytes));
  EXPECT_TRUE(refuses([&] { io::readDepthPng(grey, depth, check); }, {"claims 20001x20000"}));
  EXPECT_TRUE(refuses([&] { io::readConfidencePng(grey, confidence, {}, check); }, {"claims 20001x20000"}));
  EXPECT_TRUE(color.empty() && depth.empty() && confidence.empty());
}

/** \brief A decoder skips a marker that has no length, where another reader of headers takes what follows for one. */
TEST_F(ImageIo, TheSizeOfAJpegIsTheOneThatIsDecoded) {
  std::string bytes = jpeg(2, {{76, 76, 29, 29}, {85, 85, 255, 255}, {255, 255, 107, 107}});
  const std::string decoy = std::string("\xff\x01\x00\x04", 4);
  bytes.insert(2, decoy);
  int told_width = 0, told_height = 0;
  io::ColorImage image;
  try {
    io::readColor(write("a.jpg", bytes), image, [&](int width, int height) {
      told_width = width;
      told_height = height;
    });
  } catch (const io::InputError&) {
    return;
  }
  EXPECT_EQ(told_width, image.width);
  EXPECT_EQ(told_height, image.height);
}

TEST_F(ImageIo, AFileThatIsNotThereOrAFolderIsNamed) {
  io::DepthImage depth;
  io::ColorImage color;
  EXPECT_TRUE(refuses([&] { io::readDepthPng(path("no.png"), depth); }, {path("no.png"), "not found"}));
  EXPECT_TRUE(refuses([&] { io::readColor(path("no.jpg"), color); }, {path("no.jpg"), "not found"}));
  EXPECT_TRUE(refuses([&] { io::readDepthPng(folder_.string(), depth); }, {folder_.string(), "is a folder"}));
}

TEST_F(ImageIo, AnEmptyImageOrAFolderThatIsNotThereCannotBeWritten) {
  EXPECT_TRUE(refuses<io::OutputError>([&] { io::writeDepthPng(path("a.png"), {}); }, {path("a.png"), "no image"}));
  io::ColorImage image;
  image.resize(1, 1);
  EXPECT_TRUE(refuses<io::OutputError>([&] { io::writeColorPng(path("no/a.png"), image); }, {path("no/a.png")}));
  EXPECT_TRUE(fs::is_empty(folder_));
}

}  // namespace
