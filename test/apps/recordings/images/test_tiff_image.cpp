#include "recordings/images/tiff_image.h"

#include "../io_fixture.h"

#include <fuse_flow/recordings/recording.h>

#include <cstdlib>

namespace {

using namespace io_test;

constexpr int kTiffWidth = 21, kTiffHeight = 18;

int tiffValue(int u, int v) { return u == v ? 0 : 300 + 5 * u + 70 * v; }

/** \brief Files that Pillow and tifffile wrote. */
class TiffImages : public IoTest {
 protected:
  static void SetUpTestSuite() {
    std::string pattern = (fs::temp_directory_path() / "fuse_flow_tiffs_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr) << pattern;
    files_ = pattern;
    const std::string script = std::string(FUSE_FLOW_TEST_SOURCE_DIR) + "/test/apps/recordings/images/write_tiffs.py";
    written_ = std::system(("/usr/bin/python3 '" + script + "' '" + pattern + "' > /dev/null 2>&1").c_str()) == 0;
  }
  static void TearDownTestSuite() { fs::remove_all(files_); }
  void SetUp() override {
    if (!written_) GTEST_SKIP() << "needs Debian's python3-pil and python3-tifffile";
    IoTest::SetUp();
  }
  void TearDown() override {
    if (written_) IoTest::TearDown();
  }
  static std::vector<std::string> filesThatBegin(const std::string& start) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(files_))
      if (entry.path().filename().string().rfind(start, 0) == 0) names.push_back(entry.path().string());
    return names;
  }

  static inline fs::path files_;
  static inline bool written_{false};
};

TEST_F(TiffImages, WholeNumbersStayAsTheyAre) {
  ASSERT_EQ(filesThatBegin("whole").size(), 6u);
  for (const std::string& file : filesThatBegin("whole")) {
    EXPECT_TRUE(io::isTiff(file));
    EXPECT_FALSE(io::tiffIsFloat(file));
    io::DepthImage whole;
    io::FloatImage floats;
    floats.resize(3, 3);  // of another image before
    io::readDepthTiff(file, whole, floats);
    EXPECT_TRUE(floats.empty());
    ASSERT_EQ(whole.width, kTiffWidth) << file;
    ASSERT_EQ(whole.height, kTiffHeight) << file;
    for (int v = 0; v < kTiffHeight; ++v)
      for (int u = 0; u < kTiffWidth; ++u) ASSERT_EQ(whole.at(u, v), tiffValue(u, v)) << file << ' ' << u << ' ' << v;
  }
}

TEST_F(TiffImages, NumbersInFloatStayAsTheyAre) {
  ASSERT_EQ(filesThatBegin("float").size(), 9u);
  for (const std::string& file : filesThatBegin("float")) {
    EXPECT_TRUE(io::tiffIsFloat(file));
    io::DepthImage whole;
    io::FloatImage floats;
    io::readDepthTiff(file, whole, floats);
    EXPECT_TRUE(whole.empty());
    ASSERT_EQ(floats.width, kTiffWidth) << file;
    ASSERT_EQ(floats.height, kTiffHeight) << file;
    for (int v = 0; v < kTiffHeight; ++v)
      for (int u = 0; u < kTiffWidth; ++u)
        ASSERT_EQ(floats.at(u, v), static_cast<float>(tiffValue(u, v)) / 1000) << file << ' ' << u << ' ' << v;
  }
}

TEST_F(TiffImages, WhatIsNoDepthIsRefused) {
  const std::vector<std::pair<std::string, std::string>> wrong = {{"pages", "has several images"},
                                                                  {"channels", "3 channels of 32-bit float"},
                                                                  {"bits", "8-bit whole"},
                                                                  {"sign", "16-bit other"},
                                                                  {"white", "0 is white"},
                                                                  {"turned", "orientation 6"},
                                                                  {"text", "is no TIFF, or damaged"},
                                                                  {"short", "damaged"},
                                                                  {"large", "70000x70000"}};
  for (const auto& [name, problem] : wrong) {
    const std::string file = (files_ / ("wrong_" + name + ".tif")).string();
    io::DepthImage whole;
    io::FloatImage floats;
    EXPECT_TRUE(refuses([&] { io::readDepthTiff(file, whole, floats); }, {file, problem}));
  }
  io::DepthImage whole;
  io::FloatImage floats;
  const auto check = [](int width, int height) { throw io::InputError(std::to_string(width * height)); };
  EXPECT_TRUE(refuses([&] { io::readDepthTiff((files_ / "whole.tif").string(), whole, floats, check); }, {"378"}));
  EXPECT_TRUE(refuses([&] { io::readDepthTiff(path("none.tif"), whole, floats); }, {path("none.tif")}));
}

/** \brief A change of any byte gives an image or one line. */
TEST_F(TiffImages, DamageIsNoCrash) {
  std::size_t refused = 0;
  for (const char* name : {"float.tiff", "whole_tiles.tif", "whole_tiff_lzw.tif"}) {
    std::ifstream in(files_ / name, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    for (std::size_t at = 0; at < bytes.size(); ++at) {
      if (at > 200 && at + 300 < bytes.size()) continue;  // pixels
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(~damaged[at]);
      const std::string file = write("a.tif", damaged);
      io::DepthImage whole;
      io::FloatImage floats;
      try {
        io::readDepthTiff(file, whole, floats, [](int width, int height) {
          if (width != kTiffWidth || height != kTiffHeight) throw io::InputError("size");
        });
      } catch (const io::InputError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 50u);
}

TEST_F(TiffImages, AreDepthOfARig) {
  write("rig.json", R"({"cameras": [{"name": "a", "width": 21, "height": 18, "fx": 10, "fy": 10, "cx": 10, "cy": 9,
      "depth_scale": 0.001, "T_world_camera": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]})");
  fs::create_directories(path("a/depth"));
  fs::copy_file(files_ / "whole.tif", path("a/depth/000000.tif"));
  fs::copy_file(files_ / "float.tiff", path("a/depth/000001.tiff"));
  const auto recording = io::openRecording({folder_.string()});
  EXPECT_TRUE(recording->warnings().empty());
  io::LoadedFrame frame;
  recording->read(0, frame);
  ASSERT_TRUE(frame.rig.views[0].depth16);
  EXPECT_FALSE(frame.rig.views[0].depth32);
  EXPECT_EQ(frame.rig.views[0].depth16.row(2)[1], 445);
  recording->read(1, frame);
  ASSERT_TRUE(frame.rig.views[0].depth32);
  EXPECT_FALSE(frame.rig.views[0].depth16);
  EXPECT_FLOAT_EQ(frame.rig.views[0].depth32.row(2)[1], 0.000445f);  // in millimetres, as depth_scale has it
  fs::remove(path("a/depth/000000.tif"));
  ASSERT_EQ(io::openRecording({folder_.string()})->warnings().size(), 2u);  // begins at frame 1
  EXPECT_NE(io::openRecording({folder_.string()})->warnings()[1].find("in float is multiplied by its depth_scale"),
            std::string::npos);
}

}  // namespace
