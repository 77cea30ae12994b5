#include "clouds_to_stream.h"

#include <fuse_flow/stream/encoded_frame.h>
#include <fuse_flow/stream/streamed_cloud.h>

#include <gtest/gtest.h>
#include <pcl/point_types.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>

namespace {

using namespace fuse_flow;
using fuse_flow::test::wall;
using Bytes = std::vector<std::uint8_t>;

template <typename Cloud>
Bytes encoded(const Cloud& cloud, const stream::EncodingOptions& options = {}) {
  stream::FrameEncoder encoder(options);
  return stream::messageOf(encoder.encode(cloud, {7, 1000, 2000})).joined();
}

stream::StreamedCloud decoded(const Bytes& bytes, int threads = 1) {
  stream::FrameDecoder decoder(threads);
  stream::StreamedCloud cloud;
  decoder.decode(bytes.data(), bytes.size(), cloud);
  return cloud;
}

std::string refusal(const Bytes& bytes) {
  try {
    decoded(bytes);
  } catch (const stream::FormatError& error) {
    return error.what();
  }
  return "";
}

using Steps = std::array<long, 3>;
Steps stepsOf(const float* p, double step) {
  return {std::lround(p[0] / step), std::lround(p[1] / step), std::lround(p[2] / step)};
}

TEST(StreamedFrame, EveryPointComesBackWithinHalfAStepAndItsColourExactly) {
  for (const double step : {0.0005, 0.001, 0.003}) {
    auto cloud = wall();
    stream::EncodingOptions options;
    options.step = step;
    options.camera_masks = true;
    // Which point is which is told by its colour and mask alone: each gets its own.
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      cloud[i].r = static_cast<std::uint8_t>(i);
      cloud[i].g = static_cast<std::uint8_t>(i >> 8);
      cloud[i].b = static_cast<std::uint8_t>(i >> 16);
    }
    const stream::StreamedCloud out = decoded(encoded(cloud, options), 2);
    ASSERT_EQ(out.size(), cloud.size());
    ASSERT_EQ(out.points_of_frame, cloud.size());
    EXPECT_EQ(out.times.number, 7u);
    EXPECT_EQ(out.times.captured, 1000);
    EXPECT_EQ(out.times.encoded, 2000);
    std::vector<bool> seen(cloud.size());
    for (std::size_t k = 0; k < out.size(); ++k) {
      const std::size_t i = out.colors[3 * k] | static_cast<std::size_t>(out.colors[3 * k + 1]) << 8 |
                            static_cast<std::size_t>(out.colors[3 * k + 2]) << 16;
      ASSERT_LT(i, cloud.size());
      ASSERT_FALSE(seen[i]);
      seen[i] = true;
      const auto& point = cloud[i];
      for (std::size_t axis = 0; axis < 3; ++axis)
        ASSERT_NEAR(out.positions[3 * k + axis], point.data[axis], 0.5 * step + 3e-7);
      ASSERT_NEAR(out.confidence[k] / 255.0, point.confidence, 0.5 / 255 + 1e-6);
      ASSERT_EQ(out.view_counts[k], point.view_count);
      ASSERT_EQ(out.camera_masks[k], point.camera_mask[0] | static_cast<std::uint64_t>(point.camera_mask[1]) << 32);
    }
  }
}

TEST(StreamedFrame, TheOrderOfThePointsAndThreadsDoNotMatter) {
  auto cloud = wall();
  // Some points at the same place, with different colours.
  for (std::size_t i = 0; i < 2000; ++i) {
    auto point = cloud[i % 10];
    point.r = static_cast<std::uint8_t>(i % 251);
    point.confidence = static_cast<float>(i % 17) / 17;
    cloud.push_back(point);
  }
  stream::EncodingOptions options;
  options.threads = 1;
  options.camera_masks = true;
  const Bytes expected = encoded(cloud, options);
  std::mt19937 random(3);
  for (const int threads : {1, 2, 5}) {
    std::shuffle(cloud.points.begin(), cloud.points.end(), random);
    options.threads = threads;
    EXPECT_EQ(encoded(cloud, options), expected) << threads << " threads";
  }
  EXPECT_EQ(decoded(expected, 1).positions, decoded(expected, 3).positions);
}

TEST(StreamedFrame, AnEncoderThatHasEncodedBeforeGivesTheSameBytes) {
  const auto cloud = wall();
  stream::FrameEncoder encoder;
  encoder.encode(wall(2), {});
  encoder.encode(pcl::PointCloud<pcl::PointXYZ>(), {});
  EXPECT_EQ(stream::messageOf(encoder.encode(cloud, {7, 1000, 2000})).joined(), encoded(cloud));
}

TEST(StreamedFrame, SmallClouds) {
  for (std::size_t points = 0; points < 40; ++points)
    for (const int layers : {1, 2, 5, 8}) {
      pcl::PointCloud<pcl::PointXYZRGB> cloud;
      std::multiset<Steps> expected;
      for (std::size_t i = 0; i < points; ++i) {
        pcl::PointXYZRGB point(static_cast<std::uint8_t>(i), 2, 3);
        point.x = static_cast<float>(i % 5) * 0.5f;
        point.y = -static_cast<float>(i % 3);
        point.z = static_cast<float>(i) * 0.01f;
        cloud.push_back(point);
        expected.insert(stepsOf(point.data, 0.001));
      }
      stream::EncodingOptions options;
      options.layers = layers;
      const stream::StreamedCloud out = decoded(encoded(cloud, options));
      std::multiset<Steps> found;
      for (std::size_t k = 0; k < out.size(); ++k) found.insert(stepsOf(&out.positions[3 * k], 0.001));
      EXPECT_EQ(found, expected) << points << " points, " << layers << " layers";
    }
}

TEST(StreamedFrame, PointsThatAreFarApartComeBack) {
  // A kilometre at a step of 1 mm is 2^20 steps: differences of codes beyond 32 bits.
  pcl::PointCloud<pcl::PointXYZ> cloud;
  std::mt19937 random(5);
  for (int i = 0; i < 3000; ++i) {
    const auto metres = [&] { return static_cast<float>(random() % 1000000) * 0.001f; };
    cloud.push_back({metres(), metres() - 500, -metres()});
  }
  const stream::StreamedCloud out = decoded(encoded(cloud));
  ASSERT_EQ(out.size(), cloud.size());
  std::multiset<Steps> expected, found;
  for (const auto& point : cloud) expected.insert(stepsOf(point.data, 0.001));
  for (std::size_t k = 0; k < out.size(); ++k) found.insert(stepsOf(&out.positions[3 * k], 0.001));
  EXPECT_EQ(found, expected);
}

TEST(StreamedFrame, APointHasTheSameErrorInEachFrame) {
  // The lattice is that of the world: what else is in a frame does not move its points.
  pcl::PointCloud<pcl::PointXYZ> alone, with_others;
  alone.push_back({1.23456f, 2.34567f, 0.12345f});
  with_others.push_back(alone[0]);
  with_others.push_back({-3.21098f, -7.77777f, -0.00012f});
  const auto one = decoded(encoded(alone)), two = decoded(encoded(with_others));
  bool found = false;
  for (std::size_t k = 0; k < 2; ++k)
    found = found || std::equal(one.positions.begin(), one.positions.end(),
                                two.positions.begin() + 3 * static_cast<std::ptrdiff_t>(k),
                                [](float a, float b) { return std::abs(a - b) < 1e-6f; });
  EXPECT_TRUE(found);
}

TEST(StreamedFrame, WhatIsNowhereOrFarAwayIsLeftOutAndCounted) {
  auto cloud = wall();
  const std::size_t all = cloud.size();
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
  for (const float x : {nan, infinite, -infinite, 1e30f, -5000.0f}) {
    auto point = cloud[0];
    point.x = x;
    cloud.push_back(point);
    point = cloud[0];
    point.z = x;
    cloud.push_back(point);
  }
  stream::FrameEncoder encoder;
  const auto frame = encoder.encode(cloud, {});
  EXPECT_EQ(frame->points, all);
  EXPECT_EQ(frame->left_out, 10u);
  EXPECT_EQ(frame->too_far, 4u);  // 1e30 m and −5 km
  EXPECT_EQ(decoded(stream::messageOf(frame).joined()).size(), all);
}

TEST(StreamedFrame, NormalsComeBackWithinADegree) {
  pcl::PointCloud<pcl::PointXYZRGBNormal> cloud;
  for (int i = 0; i < 20000; ++i) {  // a spiral around the sphere
    const double z = 1 - 2 * (i + 0.5) / 20000, r = std::sqrt(1 - z * z), angle = 2.399963 * i;
    pcl::PointXYZRGBNormal point;
    point.x = point.normal_x = static_cast<float>(r * std::cos(angle));
    point.y = point.normal_y = static_cast<float>(r * std::sin(angle));
    point.z = point.normal_z = static_cast<float>(z);
    cloud.push_back(point);
  }
  pcl::PointXYZRGBNormal none;
  none.x = 5;
  none.normal_x = std::numeric_limits<float>::quiet_NaN();
  cloud.push_back(none);
  const auto out = decoded(encoded(cloud));
  std::size_t without = 0;
  for (std::size_t k = 0; k < out.size(); ++k) {
    const float *p = &out.positions[3 * k], *n = &out.normals[3 * k];
    if (p[0] > 4) {
      ++without;
      EXPECT_EQ(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 0);
      continue;
    }
    EXPECT_NEAR(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1, 1e-5);
    const double length = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);  // 1, but for the step
    ASSERT_GT((p[0] * n[0] + p[1] * n[1] + p[2] * n[2]) / length, std::cos(0.0175)) << k;
  }
  EXPECT_EQ(without, 1u);
}

TEST(StreamedFrame, LessChromaIsLessBytesAndABoundedError) {
  const auto cloud = wall();
  std::size_t before = encoded(cloud).size();
  for (const int step : {2, 4, 16}) {
    auto colours = cloud;
    for (std::size_t i = 0; i < colours.size(); ++i) {
      colours[i].r = static_cast<std::uint8_t>(i * 7);
      colours[i].g = static_cast<std::uint8_t>(i * 13);
      colours[i].b = static_cast<std::uint8_t>(i * 29);
    }
    stream::EncodingOptions options;
    options.chroma_step = step;
    const std::size_t size = encoded(cloud, options).size();
    EXPECT_LT(size, before) << step;
    before = size;
    const auto out = decoded(encoded(colours, options));
    std::map<Steps, const PointFusedCameras*> at;
    for (const auto& point : colours) at[stepsOf(point.data, 0.001)] = &point;
    for (std::size_t k = 0; k < out.size(); ++k) {
      const auto found = at.find(stepsOf(&out.positions[3 * k], 0.001));
      ASSERT_NE(found, at.end());
      const std::uint8_t* color = &out.colors[3 * k];
      // Blue and red are off by half a step and the rounding of y, green by as much and its own rounding.
      ASSERT_NEAR(color[0], found->second->r, 0.5 * step + 1);
      ASSERT_NEAR(color[1], found->second->g, 0.5 * step + 3);
      ASSERT_NEAR(color[2], found->second->b, 0.5 * step + 1);
    }
  }
}

TEST(StreamedFrame, TheFieldsOfItsPointTypeAreThereAndNoOthers) {
  pcl::PointCloud<pcl::PointXYZ> plain;
  plain.push_back({1, 2, 3});
  const auto out = decoded(encoded(plain));
  EXPECT_TRUE(out.colors.empty() && out.confidence.empty() && out.view_counts.empty() && out.normals.empty() &&
              out.camera_masks.empty());
  pcl::PointCloud<PointFused> back;
  stream::toPointCloud(out, back);
  ASSERT_EQ(back.size(), 1u);
  EXPECT_FLOAT_EQ(back[0].z, 3);
  EXPECT_EQ(back.header.stamp, 1u);  // microseconds

  const auto all = wall();
  stream::EncodingOptions options;
  options.confidence = false;
  const auto less = decoded(encoded(all, options));
  EXPECT_TRUE(less.confidence.empty() && less.camera_masks.empty());
  EXPECT_EQ(less.view_counts.size(), all.size());
}

TEST(StreamedFrame, AsManyBitsAsTheEntropyOfAFlatGridAsksFor) {
  // 100,000 points anywhere in a slab of 4000 × 2500 × 7 steps: log2 of how many points it has room for each, and 1.44 bits less what their
  // order would cost, 10.9. That the slab is flat the code does not know: no more than 3.5 for that, and for whole bits.
  auto cloud = wall();
  for (auto& point : cloud) point.r = point.g = point.b = 100;
  stream::EncodingOptions options;
  options.confidence = options.view_count = false;
  EXPECT_LT(8.0 * static_cast<double>(encoded(cloud, options).size()) / static_cast<double>(cloud.size()), 14.4);
}

TEST(StreamedFrame, OptionsOutOfRangeAreRefusedByName) {
  const auto refused = [](const auto& change) {
    stream::EncodingOptions options;
    change(options);
    try {
      stream::FrameEncoder encoder(options);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  using O = stream::EncodingOptions;
  EXPECT_NE(refused([](O& o) { o.step = 0; }).find("step"), std::string::npos);
  EXPECT_NE(refused([](O& o) { o.step = std::nan(""); }).find("step"), std::string::npos);
  EXPECT_NE(refused([](O& o) { o.layers = 9; }).find("layers"), std::string::npos);
  EXPECT_NE(refused([](O& o) { o.chunk_points = 65537; }).find("chunk_points"), std::string::npos);
  EXPECT_NE(refused([](O& o) { o.chroma_step = -1; }).find("chroma_step"), std::string::npos);
}

// Parts of frames.

TEST(StreamSelection, EachDensityIsAnEvenPartOfTheNext) {
  const auto cloud = wall();
  stream::EncodingOptions options;
  options.layers = 5;
  options.chunk_points = 4096;
  stream::FrameEncoder encoder(options);
  const auto frame = encoder.encode(cloud, {});
  std::set<Steps> before;
  for (int layers = 1; layers <= 5; ++layers) {
    stream::Selection selection;
    selection.layers.assign(frame->chunks.size(), static_cast<std::uint8_t>(layers));
    for (const auto& chunk : frame->chunks)
      for (int layer = 0; layer < layers; ++layer)
        selection.points += chunk.layer_points[static_cast<std::size_t>(layer)];
    const auto out = decoded(stream::messageOf(frame, selection).joined());
    const double share = std::pow(2.0, layers - 5);
    EXPECT_NEAR(static_cast<double>(out.size()), share * static_cast<double>(cloud.size()), 30);
    EXPECT_EQ(out.points_of_frame, cloud.size());
    std::set<Steps> here;
    std::map<std::array<long, 2>, int> in_square;  // of 200 mm, which have 400 points
    for (std::size_t k = 0; k < out.size(); ++k) {
      here.insert(stepsOf(&out.positions[3 * k], 0.001));
      ++in_square[{static_cast<long>(out.positions[3 * k] / 0.2f), static_cast<long>(out.positions[3 * k + 2] / 0.2f)}];
    }
    EXPECT_TRUE(std::includes(here.begin(), here.end(), before.begin(), before.end()));
    for (long column = 0; column < 20; ++column)
      for (long row = 0; row < 12; ++row) {
        const int count = in_square[{column, row}];
        EXPECT_NEAR(count, 400 * share, 0.25 * 400 * share + 6) << layers << " layers at " << column << ", " << row;
      }
    before = std::move(here);
  }
}

TEST(StreamSelection, KeepsToItsBudgetsAndSaysWhatItTakes) {
  const auto cloud = wall();
  stream::EncodingOptions options;
  options.chunk_points = 4096;
  stream::FrameEncoder encoder(options);
  const auto frame = encoder.encode(cloud, {});
  std::uint32_t fewer = 0;
  for (const std::uint64_t points : {20000u, 30000u, 50000u, 70000u, 99999u, 100000u, 1000000u}) {
    stream::Wishes wishes;
    wishes.points = points;
    const stream::Selection selection = stream::select(*frame, wishes);
    EXPECT_LE(selection.points, points);
    EXPECT_GE(selection.points, fewer);
    EXPECT_GE(selection.points, std::min<std::uint64_t>(points, cloud.size()) - 2048 - 4096);
    fewer = selection.points;
    const Bytes bytes = stream::messageOf(frame, selection).joined();
    EXPECT_EQ(bytes.size(), selection.bytes);
    EXPECT_EQ(decoded(bytes).size(), selection.points);
  }
  EXPECT_EQ(fewer, cloud.size());
  for (const std::size_t most : {1000u, 50000u, 100000u, 200000u}) {
    const stream::Selection selection = stream::select(*frame, {}, most);
    EXPECT_LE(selection.bytes, most);
    EXPECT_EQ(stream::messageOf(frame, selection).size(), selection.bytes);
  }
  EXPECT_EQ(stream::select(*frame, {}).bytes, frame->bytes());
}

TEST(StreamSelection, ARegionLeavesOutWhatIsElsewhere) {
  const auto cloud = wall();
  stream::EncodingOptions options;
  options.chunk_points = 1024;
  stream::FrameEncoder encoder(options);
  const auto frame = encoder.encode(cloud, {});
  stream::Wishes wishes;
  wishes.region = stream::Wishes::Box{{1.0, 0.5, 1.0}, {1.5, 1.5, 1.5}};
  const auto out = decoded(stream::messageOf(frame, stream::select(*frame, wishes)).joined());
  std::size_t inside = 0, expected = 0;
  const auto is_inside = [](const float* p) { return p[0] >= 1 && p[0] <= 1.5 && p[2] >= 1 && p[2] <= 1.5; };
  for (std::size_t k = 0; k < out.size(); ++k) inside += is_inside(&out.positions[3 * k]);
  for (const auto& point : cloud) expected += is_inside(point.data);
  EXPECT_NEAR(static_cast<double>(inside), static_cast<double>(expected), 60);  // rounding at its border
  EXPECT_LT(out.size(), cloud.size() / 4);
  wishes.region = stream::Wishes::Box{{10, 10, 10}, {11, 11, 11}};
  EXPECT_EQ(decoded(stream::messageOf(frame, stream::select(*frame, wishes)).joined()).size(), 0u);
}

TEST(StreamSelection, NearAViewpointItIsDenser) {
  auto cloud = wall();
  for (auto& point : cloud) point.x *= 10;  // 40 m
  stream::EncodingOptions options;
  options.chunk_points = 1024;
  stream::FrameEncoder encoder(options);
  const auto frame = encoder.encode(cloud, {});
  stream::Wishes wishes;
  wishes.viewpoint = std::array<double, 3>{0, 1, 1};
  const auto out = decoded(stream::messageOf(frame, stream::select(*frame, wishes)).joined());
  const auto between = [&](float from, float to) {
    std::size_t count = 0;
    for (std::size_t k = 0; k < out.size(); ++k) count += out.positions[3 * k] >= from && out.positions[3 * k] < to;
    return static_cast<double>(count) / 2500;  // of the 2500 points of a metre, all at the start
  };
  EXPECT_NEAR(between(0, 1), 1, 0.02);
  EXPECT_LT(between(8, 9), 0.3);
  EXPECT_GT(between(8, 9), 0.1);
  EXPECT_NEAR(between(38, 39), 0.125, 0.03);  // the least density is that of one layer
}

TEST(StreamSelection, AMessageIsAFrameAgain) {
  stream::FrameEncoder encoder;
  const auto frame = encoder.encode(wall(), {3, 4, 5});
  const Bytes whole = stream::messageOf(frame).joined();
  const auto again = stream::frameOf(whole.data(), whole.size());
  EXPECT_EQ(stream::messageOf(again).joined(), whole);
  stream::Wishes wishes;
  wishes.points = 30000;
  const Bytes part = stream::messageOf(frame, stream::select(*frame, wishes)).joined();
  EXPECT_EQ(stream::messageOf(again, stream::select(*again, wishes)).joined(), part);
  const auto of_part = stream::frameOf(part.data(), part.size());
  EXPECT_EQ(decoded(stream::messageOf(of_part).joined()).positions, decoded(part).positions);
}

// What is no frame.

TEST(DamagedFrame, CutOffAnywhereIsRefused) {
  auto cloud = wall();
  cloud.resize(300);
  const Bytes whole = encoded(cloud);
  for (std::size_t size = 0; size < whole.size(); ++size)
    ASSERT_NE(refusal(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))), "") << size;
  Bytes longer = whole;
  longer.push_back(0);
  EXPECT_NE(refusal(longer), "");
}

TEST(DamagedFrame, AnyChangedBitIsRefused) {
  auto cloud = wall();
  cloud.resize(200);
  const Bytes whole = encoded(cloud);
  for (std::size_t byte = 0; byte < whole.size(); ++byte)
    for (int bit = 0; bit < 8; ++bit) {
      Bytes damaged = whole;
      damaged[byte] ^= static_cast<std::uint8_t>(1u << bit);
      // Zstandard ignores an unused bit of its frame header: then nothing else has changed.
      if (refusal(damaged).empty()) {
        ASSERT_EQ(decoded(damaged).positions, decoded(whole).positions) << byte << ", " << bit;
      }
    }
}

/** \brief With the checksum that belongs to the header, whatever is in it. */
void sign(Bytes& bytes) {
  std::uint32_t size;
  std::memcpy(&size, bytes.data() + 4, 4);
  if (size < 88 || size > bytes.size()) return;
  const auto checksum = static_cast<std::uint32_t>(crc32(0, bytes.data(), size - 4));
  std::memcpy(bytes.data() + size - 4, &checksum, 4);
}

TEST(DamagedFrame, AHeaderThatLiesIsRefusedOrIsAFrame) {
  // Who means harm writes the right checksum: nothing that a header says may be believed. What is read beyond the message, or written
  // beyond the arrays, the address sanitizer finds.
  auto cloud = wall();
  cloud.resize(3000);
  stream::EncodingOptions options;
  options.chunk_points = 1000;
  options.camera_masks = true;
  const Bytes whole = encoded(cloud, options);
  std::uint32_t header;
  std::memcpy(&header, whole.data() + 4, 4);
  std::mt19937 random(11);
  std::size_t refused = 0;
  stream::FrameDecoder decoder(1, 1'000'000);
  stream::StreamedCloud out;
  for (int trial = 0; trial < 20000; ++trial) {
    Bytes lie = whole;
    for (unsigned int changes = 1 + random() % 3; changes > 0; --changes) {
      const std::size_t at = random() % (header - 4);
      constexpr std::uint8_t telling[] = {0, 1, 2, 127, 128, 255};
      lie[at] = random() % 2 ? static_cast<std::uint8_t>(random()) : telling[random() % 6];
    }
    sign(lie);
    try {
      decoder.decode(lie.data(), lie.size(), out);
    } catch (const stream::FormatError&) {
      ++refused;
    }
    try {
      stream::messageOf(stream::frameOf(lie.data(), lie.size())).joined();
    } catch (const stream::FormatError&) {
    }
  }
  EXPECT_GT(refused, 10000u);
}

TEST(DamagedFrame, LayersThatLieAreRefusedOrArePoints) {
  // The same for what is unpacked: any bytes, packed as they should be.
  pcl::PointCloud<pcl::PointXYZRGB> cloud;
  for (int i = 0; i < 64; ++i) {
    pcl::PointXYZRGB point(std::uint8_t{1}, 2, 3);
    point.x = 0.01f * static_cast<float>(i);
    cloud.push_back(point);
  }
  stream::EncodingOptions options;
  options.layers = 2;
  const Bytes whole = encoded(cloud, options);
  std::uint32_t header, first;
  std::memcpy(&header, whole.data() + 4, 4);
  std::memcpy(&first, whole.data() + 84 + 36, 4);
  Bytes layer(4096);
  layer.resize(ZSTD_decompress(layer.data(), layer.size(), whole.data() + header, first));
  ASSERT_GT(layer.size(), 32u * 4);
  std::mt19937 random(12);
  std::size_t refused = 0, read = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    Bytes lie = layer;
    for (unsigned int changes = 1 + random() % 4; changes > 0; --changes)
      lie[random() % lie.size()] = static_cast<std::uint8_t>(random());
    if (random() % 8 == 0) lie.resize(random() % (2 * lie.size()));
    Bytes packed(ZSTD_compressBound(lie.size()));
    packed.resize(ZSTD_compress(packed.data(), packed.size(), lie.data(), lie.size(), 1));
    Bytes message(whole.begin(), whole.begin() + header);
    const auto size = static_cast<std::uint32_t>(packed.size());
    std::memcpy(message.data() + 84 + 36, &size, 4);
    sign(message);
    message.insert(message.end(), packed.begin(), packed.end());
    message.insert(message.end(), whole.begin() + header + first, whole.end());
    (refusal(message).empty() ? read : refused) += 1;
  }
  EXPECT_GT(refused, 1000u);
  EXPECT_GT(read, 1000u);  // other colours are no damage
}

TEST(DamagedFrame, ALayerThatUnpacksToGigabytesIsRefusedAtItsSize) {
  auto cloud = wall();
  cloud.resize(100);
  stream::EncodingOptions options;
  options.layers = 1;
  const Bytes whole = encoded(cloud, options);
  std::uint32_t header;
  std::memcpy(&header, whole.data() + 4, 4);
  const Bytes zeros(64 << 20);
  Bytes packed(ZSTD_compressBound(zeros.size()));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), zeros.data(), zeros.size(), 1));
  Bytes message(whole.begin(), whole.begin() + header);
  const auto size = static_cast<std::uint32_t>(packed.size());
  std::memcpy(message.data() + 84 + 36, &size, 4);
  sign(message);
  message.insert(message.end(), packed.begin(), packed.end());
  EXPECT_NE(refusal(message), "");
}

TEST(DamagedFrame, MorePointsThanAreTakenAreRefusedBeforeMemoryIs) {
  const Bytes whole = encoded(wall());
  stream::FrameDecoder decoder(1, 99999);
  stream::StreamedCloud cloud;
  EXPECT_THROW(decoder.decode(whole.data(), whole.size(), cloud), stream::FormatError);
}

}  // namespace
