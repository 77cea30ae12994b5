#include "recordings/images/exr_image.h"

#include "../io_fixture.h"
#include "float_files.h"

#include <fuse_flow/recordings/recording.h>

#include <cmath>
#include <cstdlib>

#ifdef FUSE_FLOW_WITH_OPENEXR

namespace {

using namespace io_test;

float exrValue(int u, int v) { return u == v ? 0 : 0.5f + 0.25f * static_cast<float>(u) + 2 * static_cast<float>(v); }

/** \brief An OpenEXR file as its specification says, not compressed. */
struct ExrFile {
  struct Channel {
    std::string name;
    PixelValue value;
    bool is_half{false};
  };
  std::vector<Channel> channels{{"Z", exrValue}};  // in the order of their names
  int left{0}, top{0}, width{7}, height{5};        // of the pixels
  int picture_left{0}, picture_top{0}, picture_width{7}, picture_height{5};

  /** \brief Of a number that half holds exactly; from 65520 on, infinity. */
  static std::uint16_t half(float value) {
    if (value == 0) return 0;
    if (value >= 65520) return 0x7c00;
    int exponent = 0;
    const float mantissa = std::frexp(value, &exponent);  // 0.5 to 1
    return static_cast<std::uint16_t>((exponent + 14) << 10 | (static_cast<int>(mantissa * 2048) & 1023));
  }
  static std::string attribute(const std::string& name, const std::string& type, const std::string& data) {
    return name + '\0' + type + '\0' + rawBytes(static_cast<std::int32_t>(data.size())) + data;
  }
  static std::string box(int left, int top, int width, int height) {
    std::string bytes;
    for (const std::int32_t number : {left, top, left + width - 1, top + height - 1}) bytes += rawBytes(number);
    return bytes;
  }
  std::string bytes() const {
    std::string list;
    for (const Channel& channel : channels)
      list += channel.name + '\0' + rawBytes(std::int32_t{channel.is_half ? 1 : 2}) + std::string(4, '\0') +
              rawBytes(std::int32_t{1}) + rawBytes(std::int32_t{1});
    std::string file = rawBytes(std::int32_t{20000630}) + rawBytes(std::int32_t{2});
    file += attribute("channels", "chlist", list + '\0');
    file += attribute("compression", "compression", std::string(1, '\0'));
    file += attribute("dataWindow", "box2i", box(left, top, width, height));
    file += attribute("displayWindow", "box2i", box(picture_left, picture_top, picture_width, picture_height));
    file += attribute("lineOrder", "lineOrder", std::string(1, '\0'));
    file += attribute("pixelAspectRatio", "float", rawBytes(1.0f));
    file += attribute("screenWindowCenter", "v2f", rawBytes(0.0f) + rawBytes(0.0f));
    file += attribute("screenWindowWidth", "float", rawBytes(1.0f)) + '\0';
    std::string rows;
    const std::size_t begin = file.size() + 8 * static_cast<std::size_t>(height);
    for (int v = 0; v < height; ++v) {
      file += rawBytes(static_cast<std::uint64_t>(begin + rows.size()));
      std::string row;
      for (const Channel& channel : channels)
        for (int u = 0; u < width; ++u)
          row += channel.is_half ? rawBytes(half(channel.value(u, v))) : rawBytes(channel.value(u, v));
      rows += rawBytes(std::int32_t{top + v}) + rawBytes(static_cast<std::int32_t>(row.size())) + row;
    }
    return file + rows;
  }
};

class ExrImages : public IoTest {
 protected:
  io::FloatImage read(const ExrFile& file) const {
    io::FloatImage image;
    io::readExr(write("a.exr", file.bytes()), image);
    return image;
  }
  static void expectValues(const io::FloatImage& image, const std::string& what) {
    ASSERT_EQ(image.width, 7) << what;
    ASSERT_EQ(image.height, 5) << what;
    for (int v = 0; v < 5; ++v)
      for (int u = 0; u < 7; ++u) ASSERT_EQ(image.at(u, v), exrValue(u, v)) << what << ' ' << u << ' ' << v;
  }
  testing::AssertionResult refused(const ExrFile& file, const std::vector<std::string>& words) const {
    return refuses([&] { read(file); }, words);
  }
};

float wrongDepth(int, int) { return 77; }

TEST_F(ExrImages, TheChannelOfDepthIsFound) {
  using Channels = std::vector<ExrFile::Channel>;
  const std::vector<Channels> sets{
      {{"Z", exrValue}},
      {{"Z", exrValue, true}},
      {{"V", exrValue}},
      {{"Y", exrValue, true}},
      {{"distance", exrValue}},
      {{"B", wrongDepth}, {"G", wrongDepth}, {"R", wrongDepth}, {"Z", exrValue}},
      {{"A", wrongDepth}, {"B", exrValue}, {"G", exrValue}, {"R", exrValue}},
      {{"A", wrongDepth}, {"V", exrValue}},
      {{"ViewLayer.Combined.R", wrongDepth}, {"ViewLayer.Depth.Z", exrValue}, {"ViewLayer.Normal.Z", wrongDepth}}};
  for (const Channels& channels : sets) {
    ExrFile file;
    file.channels = channels;
    expectValues(read(file), channels[0].name);
    EXPECT_EQ(io::exrSize(path("a.exr")).width, 7);
    EXPECT_EQ(io::exrSize(path("a.exr")).height, 5);
  }
}

TEST_F(ExrImages, WhereNothingWasMeasuredThereIsInfinity) {
  ExrFile file;
  for (const bool is_half : {false, true}) {
    file.channels = {
        {"Z", [](int u, int) { return u == 0   ? 1e10f
                                      : u == 1 ? INFINITY
                                      : u == 2 ? 65504.0f
                                               : 3.0f; }, is_half}};
    const io::FloatImage image = read(file);
    EXPECT_EQ(image.at(0, 0), INFINITY);
    EXPECT_EQ(image.at(1, 0), INFINITY);
    EXPECT_EQ(image.at(2, 0), is_half ? INFINITY : 65504.0f);
    EXPECT_EQ(image.at(3, 0), 3.0f);
  }
}

TEST_F(ExrImages, PixelsOutsideTheDataWindowHaveNoDepth) {
  ExrFile file;
  file.picture_left = -10, file.picture_top = 20, file.picture_width = 12, file.picture_height = 9;
  file.left = -8, file.top = 23;
  const io::FloatImage image = read(file);
  ASSERT_EQ(image.width, 12);
  ASSERT_EQ(image.height, 9);
  for (int v = 0; v < 9; ++v)
    for (int u = 0; u < 12; ++u) {
      const bool inside = u >= 2 && u < 9 && v >= 3 && v < 8;
      ASSERT_EQ(image.at(u, v), inside ? exrValue(u - 2, v - 3) : 0) << u << ' ' << v;
    }
}

TEST_F(ExrImages, WhatIsNoDepthIsRefused) {
  ExrFile file;
  file.channels = {{"A", exrValue}, {"U", exrValue}};
  EXPECT_TRUE(refused(file, {path("a.exr"), "channels A, U", "Z, V, Y or R"}));
  file.channels = {{"B", wrongDepth}, {"G", exrValue}, {"R", exrValue}};
  EXPECT_TRUE(refused(file, {path("a.exr"), "is a picture in colour"}));
  file = ExrFile();
  file.left = 1;
  EXPECT_TRUE(refused(file, {path("a.exr"), "outside its display window"}));
  file = ExrFile();
  file.picture_width = 70000;
  EXPECT_TRUE(refused(file, {path("a.exr"), "70000x5"}));
  const std::string whole = ExrFile().bytes();
  for (const std::string& bytes :
       {std::string(), std::string("depth"), whole.substr(0, 100), whole.substr(0, whole.size() - 9)}) {
    io::FloatImage image;
    const std::string name = write("short.exr", bytes);
    EXPECT_TRUE(refuses([&] { io::readExr(name, image); }, {name, "is no OpenEXR image, or damaged or cut short"}));
  }
  io::FloatImage image;
  const auto check = [](int width, int height) { throw io::InputError(std::to_string(width * height)); };
  EXPECT_TRUE(refuses([&] { io::readExr(write("b.exr", whole), image, check); }, {"35"}));
  EXPECT_TRUE(image.empty());
}

TEST_F(ExrImages, FilesOfFfmpegAreRead) {
  if (std::system("ffmpeg -v quiet -h encoder=exr 2> /dev/null | grep -q grayf32") != 0)
    GTEST_SKIP() << "needs ffmpeg 5, which writes images of one channel";
  const std::string raw = write("raw", floats(7, 5, exrValue));
  for (const char* options : {"-compression none", "-compression rle", "-compression zip1", "-compression zip16",
                              "-compression zip16 -format half"}) {
    const std::string file = path("ffmpeg.exr");
    if (std::system(("ffmpeg -v quiet -y -f rawvideo -pix_fmt grayf32le -s 7x5 -i '" + raw + "' " + options + " '" +
                     file + "' > /dev/null 2>&1")
                        .c_str()) != 0)
      GTEST_SKIP() << "needs ffmpeg";
    io::FloatImage image;
    io::readExr(file, image);
    expectValues(image, options);
  }
}

TEST_F(ExrImages, AreDepthOfARig) {
  write("rig.json", R"({"cameras": [{"name": "a", "width": 7, "height": 5, "fx": 10, "fy": 10, "cx": 3, "cy": 2,
      "depth_scale": 1, "T_world_camera": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]})");
  write("a/depth/Image0001.exr", ExrFile().bytes());
  ExrFile certain;
  certain.channels = {{"V", [](int, int) { return 0.5f; }}};
  write("a/confidence/0001.exr", certain.bytes());
  io::LoadedFrame frame;
  io::openRecording({folder_.string()})->read(1, frame);
  ASSERT_TRUE(frame.rig.views[0].depth32);
  EXPECT_EQ(frame.rig.views[0].depth32.row(2)[1], 4.75f);
  ASSERT_TRUE(frame.rig.views[0].confidence);
  EXPECT_EQ(frame.rig.views[0].confidence.row(0)[0], 0.5f);
}

}  // namespace

#endif  // FUSE_FLOW_WITH_OPENEXR
