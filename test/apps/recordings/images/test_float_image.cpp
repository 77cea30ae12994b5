#include "recordings/images/float_image.h"

#include "../io_fixture.h"
#include "float_files.h"

#include <cmath>

namespace {

using namespace io_test;

class FloatImages : public IoTest {
 protected:
  float value(int u, int v) const { return 1.5f + 0.25f * static_cast<float>(u) - 3 * static_cast<float>(v); }
  PixelValue values() const {
    return [this](int u, int v) { return value(u, v); };
  }
  void expectRead(const std::string& name, const std::string& bytes) const {
    io::FloatImage image;
    const std::string file = write(name, bytes);
    EXPECT_EQ(io::floatImageSize(file).width, 5) << name;
    EXPECT_EQ(io::floatImageSize(file).height, 3) << name;
    io::readFloatImage(file, image);
    ASSERT_EQ(image.width, 5) << name;
    ASSERT_EQ(image.height, 3) << name;
    for (int v = 0; v < 3; ++v)
      for (int u = 0; u < 5; ++u) EXPECT_EQ(image.at(u, v), value(u, v)) << name << ' ' << u << ' ' << v;
  }
  testing::AssertionResult refused(const std::string& name, const std::string& bytes,
                                   std::vector<std::string> words) const {
    const std::string file = write(name, bytes);
    words.push_back(file);
    io::FloatImage image;
    return refuses([&] { io::readFloatImage(file, image); }, words);
  }
};

TEST_F(FloatImages, TheTopRowComesFirstWhateverTheFileAndItsOrderOfBytes) {
  expectRead("a.pfm", pfm(5, 3, values()));
  expectRead("b.pfm", pfm(5, 3, values(), true));
  expectRead("c.PFM", "Pf 5 3 -0.003922\n" + pfm(5, 3, values()).substr(12));
  expectRead("a.npy", npy("<f4", "(3, 5)", floats(5, 3, values())));
  expectRead("b.npy", npy(">f4", "(3, 5)", floats(5, 3, values(), true)));
  expectRead("c.npy", npy("<f4", "(1, 3, 5)", floats(5, 3, values())));
  expectRead("d.npy", npy("<f4", "(3, 5, 1)", floats(5, 3, values())));
  std::string doubles;
  for (int v = 0; v < 3; ++v)
    for (int u = 0; u < 5; ++u) doubles += rawBytes(static_cast<double>(value(u, v)));
  expectRead("e.npy", npy("<f8", "(3, 5)", doubles));
  expectRead("a.geometric.bin", colmapMap(5, 3, values()));
}

TEST_F(FloatImages, HeadersOfVersion2AreRead) {
  const std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 5), }\n";
  expectRead("a.npy", std::string("\x93NUMPY\x02\x00", 8) + static_cast<char>(header.size()) + std::string(3, '\0') +
                          header + floats(5, 3, values()));
}

TEST_F(FloatImages, NumbersThatAreNoDepthStayAsTheyAre) {
  io::FloatImage image;
  io::readFloatImage(write("a.pfm", pfm(2, 1, [](int u, int) { return u == 0 ? NAN : -INFINITY; })), image);
  EXPECT_TRUE(std::isnan(image.at(0, 0)));
  EXPECT_EQ(image.at(1, 0), -INFINITY);
  io::readFloatImage(write("a.npy", npy("<f8", "(1, 2)", rawBytes(1e300) + rawBytes(-1e300))), image);
  EXPECT_EQ(image.at(0, 0), INFINITY);
  EXPECT_EQ(image.at(1, 0), -INFINITY);
}

TEST_F(FloatImages, WhatIsNoneIsRefusedInOneLineThatSaysWhatItMustBe) {
  const std::string whole = pfm(5, 3, values());
  EXPECT_TRUE(refused("short.pfm", whole.substr(0, whole.size() - 1), {"71 bytes", "5x3", "72"}));
  EXPECT_TRUE(refused("long.pfm", whole + "x", {"73 bytes", "72"}));
  EXPECT_TRUE(refused("color.pfm", "PF" + whole.substr(2), {"three channels", "Pf"}));
  EXPECT_TRUE(refused("png.pfm", "\x89PNG\r\n", {"no PFM"}));
  EXPECT_TRUE(refused("empty.pfm", "", {"no PFM"}));
  EXPECT_TRUE(refused("scale.pfm", "Pf\n5 3\n0\n" + whole.substr(12), {"scale 0"}));
  EXPECT_TRUE(refused("wide.pfm", "Pf\n70000 3\n-1\n", {"70000", "65535"}));
  EXPECT_TRUE(refused("zero.pfm", "Pf\n0 3\n-1\n", {"0 pixels"}));
  EXPECT_TRUE(refused("type.npy", npy("<u2", "(3, 5)", ""), {"u2", "float32"}));
  EXPECT_TRUE(refused("order.npy", npy("<f4", "(3, 5)", "", "True"), {"column by column"}));
  EXPECT_TRUE(refused("shape.npy", npy("<f4", "(2, 3, 5)", ""), {"2, 3, 5", "height x width"}));
  EXPECT_TRUE(refused("line.npy", npy("<f4", "(15,)", ""), {"15,"}));
  EXPECT_TRUE(refused("header.npy", npy("<f4", "(3, 5)", "").substr(0, 40), {"cut short"}));
  const std::string spaces(40000, ' ');
  EXPECT_TRUE(refused("long.npy",
                      std::string("\x93NUMPY\x01\x00\x60\xea", 10) +
                          "{'descr': '<f4', 'fortran_order': False, 'shape': (3," + spaces + "5)}" + spaces,
                      {"header of 60000 bytes"}));
  EXPECT_TRUE(refused("data.npy", npy("<f4", "(3, 5)", "1234"), {"132 bytes", "188"}));
  EXPECT_TRUE(refused("text.bin", "depth", {"no depth map of COLMAP"}));
  EXPECT_TRUE(refused("normals.bin", "5&3&3&", {"3 channels"}));
}

TEST_F(FloatImages, TheSizeIsCheckedBeforeMemoryIsTaken) {
  io::FloatImage image;
  const std::string file = write("a.pfm", "Pf\n60000 60000\n-1\n");
  EXPECT_TRUE(
      refuses([&] { io::readFloatImage(file, image, [](int, int) { throw io::InputError("size"); }); }, {"size"}));
  EXPECT_TRUE(image.empty());
}

}  // namespace
