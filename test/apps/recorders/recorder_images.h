#pragma once

/** \file
 *  \brief The images that the recorders of these tests saw: those of write_bags.py and write_mcap.mjs. */

#include <fuse_flow/recordings/recording.h>

#include <gtest/gtest.h>

#include <cmath>

namespace recorder_test {

constexpr int kDepthWidth = 64, kDepthHeight = 48;
constexpr int kColorWidth = 80, kColorHeight = 60;

/** \brief Units of camera c's depth image k. */
inline std::uint16_t depthAt(int c, int k, int u, int v) {
  return static_cast<std::uint16_t>(u == v ? 0 : 500 + 100 * c + 11 * k + 3 * u + 7 * v);
}

inline fuse_flow::Rgb8 colorAt(int c, int k, int u, int v) {
  return {static_cast<std::uint8_t>(4 * u), static_cast<std::uint8_t>(5 * v),
          static_cast<std::uint8_t>(40 + 20 * k + c)};
}

inline void expectDepth(const fuse_flow::io::DepthImage& image, int c, int k) {
  ASSERT_EQ(image.width, kDepthWidth);
  ASSERT_EQ(image.height, kDepthHeight);
  int wrong = 0;
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) wrong += image.at(u, v) == depthAt(c, k, u, v) ? 0 : 1;
  EXPECT_EQ(wrong, 0) << "of camera " << c << ", image " << k;
}

/** \param relative error that its encoding makes */
inline void expectFloatDepth(const fuse_flow::io::FloatImage& image, int c, int k, double relative) {
  ASSERT_EQ(image.width, kDepthWidth);
  ASSERT_EQ(image.height, kDepthHeight);
  int wrong = 0;
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      const double metres = depthAt(c, k, u, v) * 0.001, z = image.at(u, v);
      wrong += (metres == 0 ? std::isnan(z) : std::abs(z - metres) <= relative * metres) ? 0 : 1;
    }
  EXPECT_EQ(wrong, 0);
}

inline void expectColor(const fuse_flow::io::ColorImage& image, int c, int k) {
  ASSERT_EQ(image.width, kColorWidth);
  ASSERT_EQ(image.height, kColorHeight);
  int wrong = 0;
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      const fuse_flow::Rgb8 is = image.at(u, v), should = colorAt(c, k, u, v);
      wrong += is.r == should.r && is.g == should.g && is.b == should.b ? 0 : 1;
    }
  EXPECT_EQ(wrong, 0) << "of camera " << c << ", image " << k;
}

}  // namespace recorder_test
