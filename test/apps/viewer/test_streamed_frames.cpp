#ifdef FUSE_FLOW_WITH_STREAM

#include "viewer/streamed_frames.h"
#include "viewer_fixture.h"

#include <fuse_flow/recordings/error.h>
#include <fuse_flow/stream/server.h>

#include <chrono>
#include <filesystem>

namespace viewer_test {
namespace {

using namespace fuse_flow;

/** \brief A red square of 1 m, two metres before the origin, every 10 mm; at the right of x = 0 green. */
pcl::PointCloud<PointFused> square(float x = 0) {
  pcl::PointCloud<PointFused> cloud;
  for (int column = -50; column < 50; ++column)
    for (int row = -50; row < 50; ++row) {
      PointFused point;
      point.x = x + 0.005f + 0.01f * static_cast<float>(column);
      point.y = 0.005f + 0.01f * static_cast<float>(row);
      point.z = 2;
      point.r = column < 0 ? 250 : 0;
      point.g = column < 0 ? 0 : 250;
      point.confidence = 1;
      point.view_count = 2;
      cloud.push_back(point);
    }
  return cloud;
}

stream::Description twoCameras() {
  stream::Description description;
  description.cameras.resize(2);
  for (Camera& camera : description.cameras) camera.intrinsics = {64, 48, 50.0f, 50.0f, 31.5f, 23.5f, {}};
  description.cameras[0].name = "left";
  description.cameras[1].name = "right";
  return description;
}

std::string streamFile(const std::string& name, std::size_t frames) {
  const std::string path = (fs::temp_directory_path() / ("fuse_flow_viewer_" + name + ".ffs")).string();
  stream::StreamWriter writer(path, twoCameras());
  stream::FrameEncoder encoder;
  for (std::size_t k = 0; k < frames; ++k)
    writer.write(stream::messageOf(encoder.encode(square(0.1f * static_cast<float>(k)),
                                                  {k, 0, 1'000'000'000 + static_cast<std::int64_t>(k) * 100'000'000})));
  return path;
}

TEST(KeptStream, IsPlayedAtTheRateAtWhichItCame) {
  const std::string path = streamFile("rate", 5);
  KeptFrames frames(path);
  EXPECT_EQ(frames.frameCount(), 5u);
  EXPECT_DOUBLE_EQ(frames.framesPerSecond().value(), 10);
  io::LoadedFrame frame;
  frames.read(3, frame);
  ASSERT_EQ(frames.finished().cloud->size(), 10000u);
  EXPECT_EQ(frame.rig.cameras.at(1).name, "right");
  float least = 1e9f;
  for (const auto& point : *frames.finished().cloud) least = std::min(least, point.x);
  EXPECT_NEAR(least, 0.3f - 0.495f, 0.0006f);
  fs::remove(path);
}

TEST(KeptStream, SaysWhatItsPointsHaveAndDrawsThoseWithoutColour) {
  const std::string path = (fs::temp_directory_path() / "fuse_flow_viewer_plain.ffs").string();
  stream::FrameEncoder encoder;
  pcl::PointCloud<pcl::PointXYZ> plain;
  plain.push_back({1, 2, 3});
  {
    stream::StreamWriter writer(path, twoCameras());
    writer.write(stream::messageOf(encoder.encode(square(), {})));
    writer.write(stream::messageOf(encoder.encode(plain, {})));
  }
  KeptFrames frames(path);
  io::LoadedFrame frame;
  frames.read(0, frame);
  EXPECT_TRUE(frames.finished().has_confidence && frames.finished().counts_views);
  frames.read(1, frame);
  EXPECT_FALSE(frames.finished().has_confidence || frames.finished().counts_views);
  EXPECT_GT(frames.finished().cloud->at(0).g, 100);
  fs::remove(path);
}

TEST(KeptStream, WithoutAFrameOrDamagedIsRefusedByName) {
  const std::string path = streamFile("none", 0);
  try {
    KeptFrames frames(path);
    FAIL();
  } catch (const io::InputError& error) {
    EXPECT_NE(std::string(error.what()).find(path), std::string::npos);
  }
  fs::resize_file(path, 3);
  EXPECT_THROW(KeptFrames frames(path), io::InputError);
  fs::remove(path);
}

TEST(StreamedFrames, TheNewestCloudIsShownWhateverIsAskedFor) {
  stream::ServerOptions options;
  options.port = 0;
  stream::Server server(options);
  server.describe(twoCameras());
  StreamedFrames frames(server.link(), {});
  io::LoadedFrame frame;
  for (const float x : {0.0f, 0.5f}) {
    server.publish(square(x), {});
    // Its connection may not have been there yet when the first came.
    for (int k = 0; k < 50; ++k) {
      frames.read(static_cast<std::size_t>(k), frame);
      if (std::abs(frames.finished().cloud->points[0].x - x) < 0.6f) break;
      server.publish(square(x), {});
    }
    float least = 1e9f;
    for (const auto& point : *frames.finished().cloud) least = std::min(least, point.x);
    EXPECT_NEAR(least, x - 0.495f, 0.0006f);
    EXPECT_EQ(frame.rig.cameras.size(), 2u);
  }
  EXPECT_NE(frames.status().at(0).find("10000 of 10000 points"), std::string::npos) << frames.status().at(0);
}

TEST(StreamedFrames, WhatIsNoLinkAndWhatDoesNotAnswerIsSaid) {
  EXPECT_FALSE(isStream("build/demo/recording"));
  EXPECT_TRUE(isStream("ws://robot:8080"));
  EXPECT_TRUE(isStream("kept.ffs"));
  EXPECT_THROW(StreamedFrames("http://", {}), std::invalid_argument);
  stream::ClientOptions once;
  once.reconnect = false;
  StreamedFrames frames("ws://127.0.0.1:9", once);  // the port for what is discarded: nobody listens
  io::LoadedFrame frame;
  try {
    frames.read(0, frame);
    FAIL();
  } catch (const io::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("127.0.0.1:9"), std::string::npos) << error.what();
  }
}

TEST_F(ViewerWindow, AStreamThatWasKeptIsDrawnAndHowItIsFusedCannotBeChanged) {
  const std::string path = streamFile("window", 3);
  options_.from = {0, 0, 0};
  options_.at = {0, 0, 2};
  options_.up = {0, -1, 0};
  options_.point_size = 5;
  options_.method = kStreamed;
  options_.measure = false;
  viewer_ = std::make_unique<Viewer>(std::make_unique<KeptFrames>(path), options_);
  viewer_->settle();
  ASSERT_EQ(viewer_->error(), "");
  const io::ColorImage image = bare();
  EXPECT_GT(image.at(kWidth / 2 - 20, kHeight / 2).r, 200);
  EXPECT_GT(image.at(kWidth / 2 + 20, kHeight / 2).g, 200);
  EXPECT_NE(viewer_->overlay().status().find("streamed: 10000 points"), std::string::npos)
      << viewer_->overlay().status();
  EXPECT_EQ(viewer_->overlay().status().find("MF"), std::string::npos);
  for (const char* key : {"1", "2", "3", "v", "k", "0"}) {
    press(key);
    EXPECT_EQ(viewer_->message().rfind("these clouds come fused", 0), 0u) << key << ": " << viewer_->message();
    EXPECT_FALSE(viewer_->panes().comparing());
  }
  press("5");  // confidence: 1 everywhere
  EXPECT_EQ(viewer_->error(), "");
  viewer_.reset();
  fs::remove(path);
}

}  // namespace
}  // namespace viewer_test

#endif
