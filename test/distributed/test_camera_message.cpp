#include <fuse_flow/distributed/camera_message.h>
#include <fuse_flow/distributed/frame_digest.h>

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace fuse_flow;
using distributed::CameraMessage;
using distributed::Message;
using distributed::MessageReader;
using distributed::MessageWriter;

/** \brief Two cameras with something in every place, and one with nothing. */
std::vector<Camera> rig() {
  Camera full;
  full.name = "left \xc3\xa9";
  full.intrinsics = {64, 48, 51.3f, 50.7f, 31.9f, 23.1f, {0.1f, -0.2f, 0.001f, 0.002f, 0.3f, 0.04f, -0.05f, 0.06f}};
  full.depth_scale = 0.00025f;
  full.T_world_camera = Eigen::Translation3d(1.0 / 3, -2e-7, 12345.678901234567) *
                        Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  full.color.emplace();
  full.color->intrinsics = {80, 60, 70.1f, 70.2f, 40.3f, 30.4f, {-0.01f, 0.02f, 0, 0, 0, 0, 0, 0}};
  full.color->T_depth_color =
      Eigen::Translation3d(0.05, 0.001, -0.002) * Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY());
  full.depth_correction.columns = 2;
  full.depth_correction.rows = 2;
  full.depth_correction.relative = {0.01f, -0.02f, 0.03f, 0};
  full.depth_correction.per_metre = {0.001f, 0.002f, -0.003f, 0.004f};
  full.multipath.modulation_frequency = 200e6f;
  full.multipath.reflectance = 0.35f;
  full.noise = NoiseModel{0.002f, 0.0001f, 0.0007f};
  Camera bare;
  bare.intrinsics = {4, 3, 4, 4, 1.5f, 1, {}};
  return {full, bare, full};
}

Message messageOf(const std::vector<Camera>& cameras) {
  Message message;
  MessageWriter writer(message);
  CameraMessage::put(writer, cameras);
  return message;
}

std::vector<Camera> read(const Message& message) {
  MessageReader reader(message, 3);
  std::vector<Camera> cameras = CameraMessage::get(reader);
  reader.finish();
  return cameras;
}

std::uint64_t digestOf(const std::vector<Camera>& cameras) { return distributed::FrameDigest().add(cameras).value(); }

TEST(CameraMessage, CarriesEveryNumberAsItIs) {
  const std::vector<Camera> cameras = rig(), copies = read(messageOf(cameras));
  ASSERT_EQ(copies.size(), 3u);
  EXPECT_EQ(digestOf(copies), digestOf(cameras));
  EXPECT_EQ(copies[0].name, cameras[0].name);
  EXPECT_EQ(copies[0].T_world_camera.matrix(), cameras[0].T_world_camera.matrix());
  EXPECT_EQ(copies[0].color->intrinsics.cy, 30.4f);
  EXPECT_EQ(copies[0].noise->quadratic, 0.0007f);
  EXPECT_FALSE(copies[1].color);
  EXPECT_FALSE(copies[1].noise);
  EXPECT_TRUE(copies[1].depth_correction.empty());
  EXPECT_TRUE(read(messageOf({})).empty());
}

TEST(CameraMessage, WhatIsCutOffOrCannotBeIsRefusedWithTheRank) {
  const Message whole = messageOf(rig());
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_THROW(read(Message(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))),
                 distributed::RankError)
        << size;
  std::vector<Camera> wrong = rig();
  wrong[1].intrinsics.fx = std::nanf("");
  try {
    read(messageOf(wrong));
    FAIL() << "a focal length that is no number";
  } catch (const distributed::RankError& error) {
    EXPECT_EQ(error.rank(), 3);
  }
}

TEST(CameraMessage, NumbersOfWhatFollowsAreBelievedOfNobody) {
  Message message;
  MessageWriter writer(message);
  writer.put(std::uint32_t{4000000000u});
  EXPECT_THROW(read(message), distributed::RankError);
}

}  // namespace
