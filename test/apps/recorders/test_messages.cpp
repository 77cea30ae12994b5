#include "recordings/messages/camera_lens.h"
#include "recordings/messages/frame_tree.h"
#include "recordings/messages/image_messages.h"

#include "../recordings/io_fixture.h"

#include <algorithm>
#include <cmath>

namespace {

using namespace io_test;

io::ImageMessage image(std::uint32_t width, std::uint32_t height, const std::string& encoding, std::string_view data) {
  io::ImageMessage message;
  message.width = width;
  message.height = height;
  message.encoding = encoding;
  message.step = static_cast<std::uint32_t>(data.size() / height);
  message.data = data;
  return message;
}

TEST(ImageMessages, BayerPatternsOfOneColourGiveThatColour) {
  // Red 200, green 100, blue 50 everywhere, sampled in each of the four orders.
  for (const std::string pattern : {"rggb", "bggr", "gbrg", "grbg"}) {
    std::string data;
    for (int v = 0; v < 6; ++v)
      for (int u = 0; u < 8; ++u) {
        const char color = pattern[static_cast<std::size_t>(2 * (v % 2) + u % 2)];
        data += static_cast<char>(color == 'r' ? 200 : color == 'g' ? 100 : 50);
      }
    io::ColorImage rgb;
    io::decodeColor("image", image(8, 6, "bayer_" + pattern + "8", data), rgb);
    for (const Rgb8& pixel : rgb.data) {
      EXPECT_EQ(pixel.r, 200);
      EXPECT_EQ(pixel.g, 100);
      EXPECT_EQ(pixel.b, 50);
    }
  }
}

TEST(ImageMessages, YuvIsBt601OfLimitedRange) {
  // Y, Cb, Cr of pure red, rounded: 81, 90, 240; of white 235, 128, 128.
  const std::string uyvy{90,
                         81,
                         static_cast<char>(240),
                         81,
                         static_cast<char>(128),
                         static_cast<char>(235),
                         static_cast<char>(128),
                         static_cast<char>(235)};
  const std::string yuyv{81,
                         90,
                         81,
                         static_cast<char>(240),
                         static_cast<char>(235),
                         static_cast<char>(128),
                         static_cast<char>(235),
                         static_cast<char>(128)};
  for (const auto& [encoding, data] :
       {std::pair<std::string, std::string>{"yuv422", uyvy}, {"yuv422_yuy2", yuyv}, {"YUYV", yuyv}}) {
    io::ColorImage rgb;
    io::decodeColor("image", image(4, 1, encoding, data), rgb);
    EXPECT_NEAR(rgb.at(0, 0).r, 255, 2) << encoding;
    EXPECT_NEAR(rgb.at(1, 0).g, 0, 2);
    EXPECT_NEAR(rgb.at(1, 0).b, 0, 2);
    EXPECT_NEAR(rgb.at(3, 0).g, 255, 1);
  }
}

TEST(ImageMessages, WhatTheyAreIsInEncodingAndName) {
  const auto kind = [](const std::string& encoding, const std::string& topic) {
    return io::kindOf(image(1, 1, encoding, "0123"), topic);
  };
  EXPECT_EQ(kind("16UC1", "/camera/depth/image_rect_raw"), io::ImageKind::Depth);
  EXPECT_EQ(kind("mono16", "/device_0/sensor_0/Depth_0/image/data"), io::ImageKind::Depth);
  EXPECT_EQ(kind("mono16", "/ir/image_raw"), io::ImageKind::Neither);
  EXPECT_EQ(kind("32FC1", "/zed/depth"), io::ImageKind::Depth);
  EXPECT_EQ(kind("32FC1", "/stereo/disparity"), io::ImageKind::Neither);
  EXPECT_EQ(kind("32FC1", "/zed/confidence/confidence_map"), io::ImageKind::Neither);
  EXPECT_EQ(kind("mono8", "/camera/infra1/image_rect_raw"), io::ImageKind::Neither);
  EXPECT_EQ(kind("mono8", "/camera/image_raw"), io::ImageKind::Color);
  EXPECT_EQ(kind("bayer_rggb8", "/camera/image_raw"), io::ImageKind::Color);
  EXPECT_EQ(kind("bayer_rggb16", "/camera/image_raw"), io::ImageKind::Neither);
  EXPECT_EQ(kind("nv21", "/camera/image_raw"), io::ImageKind::Neither);
}

TEST(ImageMessages, TooFewBytesAndUnknownEncodingsAreRefused) {
  io::LoadedView view;
  io::ColorImage rgb;
  EXPECT_TRUE(refuses([&] { io::decodeDepth("image", image(4, 4, "16UC1", std::string(31, 'x')), view); },
                      {"image: has 31 bytes"}));
  EXPECT_TRUE(
      refuses([&] { io::decodeDepth("image", image(4, 4, "rgb8", std::string(48, 'x')), view); }, {"'rgb8'", "16UC1"}));
  EXPECT_TRUE(
      refuses([&] { io::decodeColor("image", image(4, 4, "nv21", std::string(48, 'x')), rgb); }, {"'nv21'", "rgb8"}));
  EXPECT_TRUE(refuses([&] { io::decodeColor("image", image(0, 4, "rgb8", ""), rgb); }, {"0x4"}));
  io::CompressedImageMessage compressed;
  compressed.format = "16UC1; compressedDepth rvl";
  const std::string rvl = std::string(12, '\0') + std::string("\4\0\0\0\4\0\0\0", 8) + "\x01\x02";
  compressed.data = rvl;
  EXPECT_TRUE(refuses([&] { io::decodeDepth("image", compressed, view); }, {"image: is damaged"}));
  compressed.format = "jpeg";
  compressed.data = "no JPEG";
  EXPECT_TRUE(refuses([&] { io::decodeColor("image", compressed, rgb); }, {"image"}));
}

io::CameraInfoMessage info(const std::string& model, std::vector<double> D) {
  io::CameraInfoMessage message;
  message.width = 640;
  message.height = 480;
  message.distortion_model = model;
  message.D = std::move(D);
  const double K[9] = {400, 0, 320, 0, 410, 240, 0, 0, 1};
  const double P[12] = {390, 0, 321, 0, 0, 395, 241, 0, 0, 0, 1, 0};
  std::copy(K, K + 9, message.K);
  std::copy(P, P + 12, message.P);
  return message;
}

TEST(CameraLens, ARectifiedImageHasTheProjectionsPinhole) {
  std::vector<std::string> warnings;
  const Intrinsics K = io::lensOf("topic", info("plumb_bob", {0.1, 0, 0, 0, 0}), true, warnings);
  EXPECT_FLOAT_EQ(K.fx, 390);
  EXPECT_FLOAT_EQ(K.cy, 241);
  EXPECT_TRUE(isIdeal(K.distortion));
  io::CameraInfoMessage no_projection = info("plumb_bob", {0.1, 0, 0, 0, 0});
  std::fill(no_projection.P, no_projection.P + 12, 0.0);
  EXPECT_FLOAT_EQ(io::lensOf("topic", no_projection, true, warnings).fx, 400);
}

TEST(CameraLens, BinningAndRegionOfInterest) {
  io::CameraInfoMessage message = info("", {});
  message.binning_x = message.binning_y = 2;
  message.roi_x = 40;
  message.roi_width = 560;
  message.roi_height = 480;
  std::vector<std::string> warnings;
  const Intrinsics K = io::lensOf("topic", message, false, warnings);
  EXPECT_EQ(K.width, 280);
  EXPECT_EQ(K.height, 240);
  EXPECT_FLOAT_EQ(K.fx, 200);
  EXPECT_FLOAT_EQ(K.cx, (320 - 40 + 0.5f) / 2 - 0.5f);
}

/** \brief The pixel of a ray by Kannala and Brandt's formula. */
Pixel fisheye(const std::vector<double>& k, double x, double y) {
  const double r = std::hypot(x, y), theta = std::atan(r), t2 = theta * theta;
  const double s = r == 0 ? 1 : theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) / r;
  return {static_cast<float>(400 * x * s + 320), static_cast<float>(410 * y * s + 240)};
}

TEST(CameraLens, AFisheyeIsTheNearestBrownConradyLens) {
  const std::vector<double> k{0.02, -0.01, 0.003, -0.0005};
  std::vector<std::string> warnings;
  const Intrinsics K = io::lensOf("topic", info("equidistant", k), false, warnings);
  for (double x = -0.8; x <= 0.8; x += 0.4)
    for (double y = -0.6; y <= 0.6; y += 0.3) {
      const Pixel should = fisheye(k, x, y);
      if (should.u < 0 || should.v < 0 || should.u > 639 || should.v > 479) continue;
      const Pixel is = project(K, {static_cast<float>(x), static_cast<float>(y), 1});
      EXPECT_NEAR(is.u, should.u, 0.05) << x << " " << y;
      EXPECT_NEAR(is.v, should.v, 0.05) << x << " " << y;
    }
}

TEST(CameraLens, WhatNoLensIsLikeIsRefused) {
  std::vector<std::string> warnings;
  EXPECT_TRUE(
      refuses([&] { io::lensOf("topic", info("cat_eye", {1}), false, warnings); }, {"topic", "cat_eye", "plumb_bob"}));
  EXPECT_TRUE(refuses([&] { io::lensOf("topic", info("equidistant", {1}), false, warnings); },
                      {"1 distortion coefficients", "4"}));
  EXPECT_TRUE(refuses(
      [&] {
        io::lensOf("topic", info("Inverse Brown Conrady", {5, -30, 1, 1, 80}), false, warnings);
      },
      {"within half a pixel", "rectified"}));
  io::CameraInfoMessage empty = info("plumb_bob", {});
  empty.width = 0;
  EXPECT_TRUE(refuses([&] { io::lensOf("topic", empty, false, warnings); }, {"0x480"}));
  std::fill(empty.K, empty.K + 9, 0.0);
  empty.width = 640;
  EXPECT_TRUE(refuses([&] { io::lensOf("topic", empty, false, warnings); }, {"topic"}));
}

io::TransformMessage transform(const std::string& parent, const std::string& child, double x) {
  io::TransformMessage message;
  message.header.frame = parent;
  message.child = child;
  message.T_parent_child.translation().x() = x;
  return message;
}

TEST(FrameTree, WaysUpAndAcross) {
  io::FrameTree tree;
  EXPECT_FALSE(tree.add(transform("world", "robot", 1)));
  EXPECT_FALSE(tree.add(transform("robot", "left", 10)));
  EXPECT_FALSE(tree.add(transform("robot", "right", 20)));
  EXPECT_FALSE(tree.add(transform("elsewhere", "other", 0)));
  EXPECT_EQ(tree.root("left"), "world");
  EXPECT_EQ(tree.toRoot("left").translation().x(), 11);
  EXPECT_EQ(tree.between("left", "right")->translation().x(), 10);
  EXPECT_FALSE(tree.between("left", "other"));
  EXPECT_EQ(tree.root("nobody"), "nobody");
  EXPECT_TRUE(tree.add(transform("world", "robot", 1.01)));  // it moves
  EXPECT_FALSE(tree.add(transform("world", "robot", 1)));
  EXPECT_EQ(tree.toRoot("left").translation().x(), 11);
}

TEST(FrameTree, ALoopHasNoTopAndIsNotTaken) {
  io::FrameTree tree;
  tree.add(transform("a", "b", 1));
  tree.add(transform("b", "c", 1));
  tree.add(transform("c", "a", 1));
  EXPECT_EQ(tree.root("c"), "a");
  tree.add(transform("x", "x", 1));
  EXPECT_EQ(tree.root("x"), "x");
}

}  // namespace
