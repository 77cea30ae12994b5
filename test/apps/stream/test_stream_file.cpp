#include "clouds_to_stream.h"

#include <fuse_flow/stream/stream_file.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace {

using namespace fuse_flow;

class StreamFile : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = (std::filesystem::temp_directory_path() /
             ("fuse_flow_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) + ".ffs"))
                .string();
    auto cloud = test::wall();
    cloud.resize(500);
    for (std::size_t k = 0; k < 3; ++k) {
      for (auto& point : cloud) point.x += 0.1f;
      messages_.push_back(
          stream::messageOf(encoder_.encode(cloud, {k, 0, static_cast<std::int64_t>(100 * k)})).joined());
    }
    description_.name = "first";
    description_.cameras.resize(2);
    description_.cameras[0].name = "left";
    description_.cameras[0].intrinsics = {640, 480, 525.0f, 526.0f, 319.5f, 239.5f, {}};
    description_.cameras[1].name = "right";
    description_.cameras[1].intrinsics = {320, 240, 260.0f, 260.0f, 160.0f, 120.0f, {}};
    description_.cameras[1].T_world_camera = Eigen::Translation3d(1, 2, 3);
    stream::StreamWriter writer(path_, description_);
    writer.write(messages_[0].data(), messages_[0].size());
    writer.write(messages_[1].data(), messages_[1].size());
    before_last_ = std::filesystem::file_size(path_);
    description_.name = "second";
    writer.describe(description_);
    before_frame_ = std::filesystem::file_size(path_);
    writer.write(messages_[2].data(), messages_[2].size());
  }
  void TearDown() override { std::filesystem::remove(path_); }

  stream::FrameEncoder encoder_;
  std::string path_;
  std::vector<std::vector<std::uint8_t>> messages_;
  stream::Description description_;
  std::uintmax_t before_last_{0}, before_frame_{0};
};

TEST_F(StreamFile, FramesAndDescriptionsComeBack) {
  stream::StreamReader reader(path_);
  ASSERT_EQ(reader.frames(), 3u);
  EXPECT_FALSE(reader.cutOff());
  EXPECT_EQ(reader.description().name, "first");
  std::vector<std::uint8_t> message;
  for (const std::size_t k : {2u, 0u, 1u}) {
    reader.read(k, message);
    EXPECT_EQ(message, messages_[k]);
    EXPECT_EQ(reader.time(k), static_cast<std::int64_t>(100 * k));
    EXPECT_EQ(reader.description().name, k == 2 ? "second" : "first");
  }
  ASSERT_EQ(reader.description().cameras.size(), 2u);
  EXPECT_EQ(reader.description().cameras[0].name, "left");
  EXPECT_EQ(reader.description().cameras[0].intrinsics.fy, 526.0f);
  EXPECT_TRUE(reader.description().cameras[1].T_world_camera.translation().isApprox(Eigen::Vector3d(1, 2, 3)));
}

TEST_F(StreamFile, WhatWasCutOffPlaysUpToThere) {
  const auto whole = std::filesystem::file_size(path_);
  for (auto size = whole - 1; size > before_last_; size -= 7) {
    std::filesystem::resize_file(path_, size);
    stream::StreamReader reader(path_);
    EXPECT_EQ(reader.cutOff(), size != before_frame_) << size;
    ASSERT_EQ(reader.frames(), 2u) << size;
    std::vector<std::uint8_t> message;
    reader.read(1, message);
    EXPECT_EQ(message, messages_[1]);
    if (size < before_last_ + 7) break;
  }
}

TEST_F(StreamFile, OtherFilesAreRefusedByName) {
  const auto refusal = [&](const std::string& content) {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << content;
    try {
      stream::StreamReader reader(path_);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refusal("ply\nformat ascii 1.0\n").find(path_), std::string::npos);
  EXPECT_NE(refusal("").find("FFS1"), std::string::npos);
  EXPECT_NE(refusal(std::string("FFS1\0\0\0\0", 8)).find("description"), std::string::npos);
  EXPECT_NE(refusal(std::string("FFS1\0\0\0\0\2\0\0\0\1\0\0\0{]", 18)).find(path_), std::string::npos);
  EXPECT_NE(refusal(std::string("FFS1\0\0\0\0\4\0\0\0\2\0\0\0abcd", 20)).find("before"), std::string::npos);
  EXPECT_NE(refusal(std::string("FFS1\0\0\0\0\0\0\0\0\7\0\0\0", 16)).find("kind 7"), std::string::npos);
  EXPECT_THROW(stream::StreamReader("/nowhere/a.ffs"), std::runtime_error);
  EXPECT_THROW(stream::StreamWriter("/nowhere/a.ffs", {}), std::runtime_error);
}

}  // namespace
