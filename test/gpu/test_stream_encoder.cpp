#include "stream/gpu/device_frame_encoder.h"

#include <fuse_flow/gpu/device_cloud.h>
#include <fuse_flow/point_types.h>
#include <fuse_flow/stream/streamed_cloud.h>

#include <gtest/gtest.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

// Every frame of the device decodes to what the CPU's does, chunk by chunk and layer by layer.

namespace {

using namespace fuse_flow;
using Bytes = std::vector<std::uint8_t>;

double unit(std::mt19937& random) { return static_cast<double>(random()) / 4294967296.0; }

/** \brief A point on a wavy sheet of 3 × 2 m, with whatever fields it has. */
template <typename PointT>
PointT pointOnSheet(std::mt19937& random) {
  PointT point;
  const double u = 3 * unit(random), v = 2 * unit(random);
  point.x = static_cast<float>(u - 1.7);
  point.y = static_cast<float>(v);
  point.z = static_cast<float>(1 + 0.2 * std::sin(4 * u) * std::cos(3 * v) + 0.004 * unit(random));
  if constexpr (point::has_color<PointT>) {
    const std::uint32_t r = static_cast<std::uint32_t>(128 + 90 * std::sin(7 * u)) + random() % 5,
                        g = static_cast<std::uint32_t>(128 + 90 * std::sin(5 * v)) + random() % 5;
    point.rgba = 0xff000000u | r << 16 | g << 8 | random() % 256;
  }
  if constexpr (point::has_confidence<PointT>) point.confidence = static_cast<float>(1.1 * unit(random) - 0.05);
  if constexpr (point::has_view_count<PointT>) point.view_count = random() % 50 == 0 ? 300 : 1 + random() % 4;
  if constexpr (point::has_normal<PointT>) {
    point.normal_x = static_cast<float>(unit(random) - 0.5);
    point.normal_y = static_cast<float>(unit(random) - 0.5);
    point.normal_z =
        random() % 9 == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(unit(random) - 0.3);
  }
  if constexpr (point::has_camera_mask<PointT>) {
    point.camera_mask[0] = 1u << random() % 20;
    point.camera_mask[1] = random() % 100 == 0 ? 1u << 9 : 0;
  }
  return point;
}

template <typename PointT>
pcl::PointCloud<PointT> sheet(std::size_t points, unsigned int seed = 1) {
  std::mt19937 random(seed);
  pcl::PointCloud<PointT> cloud;
  for (std::size_t k = 0; k < points; ++k) cloud.push_back(pointOnSheet<PointT>(random));
  return cloud;
}

/** \brief From the device's memory. */
template <typename PointT>
std::shared_ptr<const stream::EncodedFrame> encoded(const pcl::PointCloud<PointT>& cloud,
                                                    stream::DeviceFrameEncoder& encoder) {
  gpu::DeviceCloud<PointT> on_device;
  on_device.upload(cloud);
  return encoder.encode(stream::viewOf(on_device.data(), on_device.size()), {7, 1000, 2000});
}

Bytes bytesOf(const std::shared_ptr<const stream::EncodedFrame>& frame) { return stream::messageOf(frame).joined(); }

stream::StreamedCloud decoded(const std::shared_ptr<const stream::EncodedFrame>& frame, int layers) {
  stream::Selection all = stream::select(*frame, {});
  for (std::uint8_t& of_chunk : all.layers) of_chunk = static_cast<std::uint8_t>(layers);
  all.points = 0;
  for (const stream::EncodedChunk& chunk : frame->chunks)
    for (int layer = 0; layer < layers; ++layer) all.points += chunk.layer_points[static_cast<std::size_t>(layer)];
  const Bytes bytes = stream::messageOf(frame, all).joined();
  stream::FrameDecoder decoder(1);
  stream::StreamedCloud cloud;
  decoder.decode(bytes.data(), bytes.size(), cloud);
  return cloud;
}

void expectSame(const stream::StreamedCloud& a, const stream::StreamedCloud& b, const std::string& what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  EXPECT_EQ(a.points_of_frame, b.points_of_frame) << what;
  EXPECT_TRUE(a.positions == b.positions) << what;
  EXPECT_TRUE(a.colors == b.colors) << what;
  EXPECT_TRUE(a.confidence == b.confidence) << what;
  EXPECT_TRUE(a.view_counts == b.view_counts) << what;
  EXPECT_TRUE(a.normals == b.normals) << what;
  EXPECT_TRUE(a.camera_masks == b.camera_masks) << what;
}

/** \brief Compares with the CPU's frame. */
template <typename PointT>
void expectAsOnTheCpu(const pcl::PointCloud<PointT>& cloud, const stream::EncodingOptions& options,
                      const std::string& what) {
  stream::FrameEncoder on_cpu(options);
  stream::DeviceFrameEncoder on_device(options);
  const auto expected = on_cpu.encode(cloud, {7, 1000, 2000});
  const auto frame = encoded(cloud, on_device);
  ASSERT_EQ(frame->points, expected->points) << what;
  EXPECT_EQ(frame->left_out, expected->left_out) << what;
  EXPECT_EQ(frame->origin, expected->origin) << what;
  EXPECT_EQ(frame->fields, expected->fields) << what;
  EXPECT_EQ(frame->chroma_step, expected->chroma_step) << what;
  EXPECT_EQ(frame->mask_bytes, expected->mask_bytes) << what;
  EXPECT_EQ(frame->times.number, 7u);
  EXPECT_EQ(frame->times.captured, 1000);
  EXPECT_EQ(frame->times.encoded, 2000);
  ASSERT_EQ(frame->chunks.size(), expected->chunks.size()) << what;
  for (std::size_t k = 0; k < frame->chunks.size(); ++k) {
    EXPECT_EQ(frame->chunks[k].points, expected->chunks[k].points) << what;
    EXPECT_EQ(frame->chunks[k].least, expected->chunks[k].least) << what;
    EXPECT_EQ(frame->chunks[k].greatest, expected->chunks[k].greatest) << what;
    EXPECT_EQ(frame->chunks[k].layer_points, expected->chunks[k].layer_points) << what;
  }
  for (int layers = 1; layers <= options.layers; ++layers)
    expectSame(decoded(frame, layers), decoded(expected, layers), what + ", layers " + std::to_string(layers));
}

template <typename PointT>
void expectSizesAsOnTheCpu(const std::string& type) {
  stream::EncodingOptions options;
  options.camera_masks = true;
  options.threads = 1;
  for (const std::size_t points : {0, 1, 2, 31, 32768, 32769, 100000})
    expectAsOnTheCpu(sheet<PointT>(points), options, type + ", " + std::to_string(points) + " points");
}

TEST(GpuStreamEncoder, CloudsOfAnySizeDecodeAsTheCpusDo) {
  expectSizesAsOnTheCpu<PointFused>("PointFused");
  expectSizesAsOnTheCpu<PointFusedCameras>("PointFusedCameras");
  expectSizesAsOnTheCpu<pcl::PointXYZ>("PointXYZ");
  expectSizesAsOnTheCpu<pcl::PointXYZRGB>("PointXYZRGB");
  expectSizesAsOnTheCpu<pcl::PointXYZRGBNormal>("PointXYZRGBNormal");
}

TEST(GpuStreamEncoder, LayersAndChunksOfAnySizeDecodeAsTheCpusDo) {
  const auto large = sheet<PointFusedCameras>(70001), small = sheet<PointFusedCameras>(1003);
  stream::EncodingOptions options;
  options.threads = 1;
  for (int layers = 1; layers <= 8; ++layers)
    for (const int chunk : {64, 1000, 32768, 65536}) {
      const auto& cloud = chunk < 32768 ? small : large;
      options.layers = layers;
      options.chunk_points = chunk;
      options.camera_masks = layers % 2 == 0;
      expectAsOnTheCpu(cloud, options, std::to_string(layers) + " layers, chunks of " + std::to_string(chunk));
    }
}

TEST(GpuStreamEncoder, StepsOfPositionsAndOfChromaDecodeAsTheCpusDo) {
  const auto cloud = sheet<PointFused>(20000);
  stream::EncodingOptions options;
  options.threads = 1;
  for (const double step : {0.00001, 0.0005, 0.003, 0.1})
    for (const int chroma : {0, 1, 7, 64}) {
      options.step = step;
      options.chroma_step = chroma;
      options.confidence = chroma != 7;
      expectAsOnTheCpu(cloud, options, "step " + std::to_string(step) + ", chroma step " + std::to_string(chroma));
    }
}

TEST(GpuStreamEncoder, PointsInOnePlaceComeInTheOrderOfTheirFields) {
  auto cloud = sheet<PointFusedCameras>(5000);
  std::mt19937 random(2);
  for (int k = 0; k < 3000; ++k) {
    auto point = pointOnSheet<PointFusedCameras>(random);
    const auto& at = cloud[static_cast<std::size_t>(k % 7)];
    point.x = at.x, point.y = at.y, point.z = at.z;
    if (k % 3 == 0) point.rgba = at.rgba;
    cloud.push_back(k % 5 == 0 ? at : point);
  }
  stream::EncodingOptions options;
  options.camera_masks = true;
  options.threads = 1;
  expectAsOnTheCpu(cloud, options, "many in seven places");
  stream::DeviceFrameEncoder encoder(options);
  const Bytes expected = bytesOf(encoded(cloud, encoder));
  for (int k = 0; k < 3; ++k) {
    std::shuffle(cloud.points.begin(), cloud.points.end(), random);
    EXPECT_TRUE(bytesOf(encoded(cloud, encoder)) == expected);
  }
  for (int k = 0; k < 6000; ++k) cloud.push_back(cloud[3]);  // so many that the CPU has to
  expectAsOnTheCpu(cloud, options, "thousands in one place");
}

TEST(GpuStreamEncoder, WhatIsNowhereOrFarAwayIsLeftOut) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
  stream::EncodingOptions options;
  options.threads = 1;
  auto cloud = sheet<PointFused>(3000);
  for (const float x : {nan, infinite, -infinite}) {
    cloud.push_back(cloud[1]);
    cloud.back().x = x;
    cloud.push_back(cloud[2]);
    cloud.back().z = x;
  }
  expectAsOnTheCpu(cloud, options, "nowhere");
  cloud.push_back(cloud[5]);
  cloud.back().y = 5000;
  expectAsOnTheCpu(cloud, options, "five kilometres away");
  auto distant = sheet<PointFused>(3000);
  for (auto& point : distant) point.x += 1e20f;
  expectAsOnTheCpu(distant, options, "all far away");
  pcl::PointCloud<PointFused> none;
  for (int k = 0; k < 5; ++k) {
    none.push_back(cloud[0]);
    none.back().y = nan;
  }
  expectAsOnTheCpu(none, options, "all nowhere");
}

TEST(GpuStreamEncoder, PointsThatAreFarApartDecodeAsTheCpusDo) {
  // A kilometre at a step of 1 mm is 2^20 steps: differences of codes beyond 32 bits, and more raw bits than a block of Zstandard may hold.
  pcl::PointCloud<pcl::PointXYZ> cloud;
  std::mt19937 random(5);
  for (int k = 0; k < 60000; ++k)
    cloud.push_back({static_cast<float>(1000 * unit(random)), static_cast<float>(1000 * unit(random) - 500),
                     static_cast<float>(-1000 * unit(random))});
  stream::EncodingOptions options;
  options.threads = 1;
  expectAsOnTheCpu(cloud, options, "a cubic kilometre");
  options.layers = 1;
  options.chunk_points = 65536;
  expectAsOnTheCpu(cloud, options, "a cubic kilometre in one layer");
}

TEST(GpuStreamEncoder, AnEncoderThatHasEncodedBeforeGivesTheSameBytes) {
  const auto cloud = sheet<PointFused>(50000);
  stream::DeviceFrameEncoder fresh({}), used({});
  const Bytes expected = bytesOf(encoded(cloud, fresh));
  encoded(sheet<PointFused>(80000, 9), used);
  encoded(sheet<pcl::PointXYZ>(300), used);
  encoded(pcl::PointCloud<PointFused>(), used);
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(bytesOf(encoded(cloud, used)) == expected);
}

TEST(GpuStreamEncoder, TakesAsManyBytesAsTheCpuDoes) {
  const auto cloud = sheet<PointFused>(200000);
  stream::FrameEncoder on_cpu;
  stream::DeviceFrameEncoder on_device({});
  const double expected = static_cast<double>(on_cpu.encode(cloud, {})->bytes());
  EXPECT_NEAR(static_cast<double>(encoded(cloud, on_device)->bytes()) / expected, 1, 0.02);
}

}  // namespace
