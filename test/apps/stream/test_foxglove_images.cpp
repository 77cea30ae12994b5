#include "decoded_jpeg.h"
#include "foxglove_client.h"
#include "streams.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <random>
#include <thread>

namespace {

using namespace fuse_flow;
using namespace fuse_flow::test;
using stream::Server;

const std::string kLeftImage = "/cameras/left/image";

/** \brief An image that keeps itself. */
struct OwnedImage {
  OwnedImage(int width, int height) : pixels(new std::vector<Rgb8>(static_cast<std::size_t>(width * height))) {
    view = ImageView<Rgb8>(pixels->data(), width, height);
  }
  Rgb8& at(int u, int v) { return (*pixels)[static_cast<std::size_t>(v * view.width + u)]; }

  std::shared_ptr<std::vector<Rgb8>> pixels;
  ImageView<Rgb8> view;
};

/** \brief Smooth, as photographs are, and not alike in any two directions, corners or colours. */
OwnedImage smoothImage(int width, int height, int shade = 0) {
  OwnedImage image(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      image.at(u, v) = {static_cast<std::uint8_t>(20 + 200 * u / width),
                        static_cast<std::uint8_t>(30 + 180 * v / height),
                        static_cast<std::uint8_t>((60 + shade + 60 * u / width + 40 * v / height) % 256)};
  return image;
}

/** \brief What JPEG hardly makes smaller. */
OwnedImage noisyImage(int width, int height) {
  OwnedImage image(width, height);
  std::mt19937 random(1);
  for (Rgb8& pixel : *image.pixels) {
    const auto bits = static_cast<std::uint32_t>(random());
    pixel = {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
             static_cast<std::uint8_t>(bits >> 16)};
  }
  return image;
}

/** \brief Mean difference of the channels, of 255. */
double differenceOf(const DecodedJpeg& image, const ImageView<Rgb8>& expected) {
  if (image.width != expected.width || image.height != expected.height) return 255;
  double sum = 0;
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      const std::uint8_t* a = &image.rgb[3 * static_cast<std::size_t>(v * image.width + u)];
      const Rgb8& b = expected.row(v)[u];
      sum += std::abs(a[0] - b.r) + std::abs(a[1] - b.g) + std::abs(a[2] - b.b);
    }
  return sum / (3.0 * image.width * image.height);
}

/** \brief left: 160 × 120; right: the same, with a colour camera of 200 × 100 beside; a third one. */
stream::Description threeCameras() {
  stream::Description description;
  description.cameras.resize(3);
  Camera& left = description.cameras[0];
  left.name = "left";
  left.intrinsics = {160, 120, 131, 132, 80, 60, {}};
  Camera& right = description.cameras[1] = left;
  right.name = "right";
  right.T_world_camera = Eigen::Translation3d(1, 2, 3) * Eigen::Isometry3d::Identity();
  right.color.emplace();
  right.color->intrinsics = {200, 100, 151, 152, 101, 51, {}};
  right.color->T_depth_color =
      Eigen::Translation3d(0.03, 0, 0.01) * Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX());
  description.cameras[2] = left;
  description.cameras[2].name = "third";
  return description;
}

/** \brief Images of the left camera that no socket holds: a slow client's stay with the server. */
constexpr int kLargeWidth = 3000, kLargeHeight = 2000;  // 4 MB as JPEG of noise

stream::Description camerasOfLargeImages() {
  stream::Description description = threeCameras();
  description.cameras[0].intrinsics.width = kLargeWidth;
  description.cameras[0].intrinsics.height = kLargeHeight;
  return description;
}

/** \brief A server that has had an image of the camera on the left, so that there is a channel. */
class FoxgloveImages : public testing::Test {
 protected:
  explicit FoxgloveImages(const stream::ServerOptions& options = anyPort()) : server(options) {
    server.describe(threeCameras());
    publish(smoothImage(160, 120), 0);
  }
  void publish(const OwnedImage& image, std::int64_t time, std::size_t camera = 0) {
    server.publishImage(camera, image.view, {0, time, 0}, image.pixels);
  }
  /** \brief Subscribed to the left camera's images, as 1. */
  FoxgloveClient subscribed() {
    FoxgloveClient client(server.port());
    const std::uint32_t channel = client.channels().at(kLeftImage);
    client.subscribe(1, channel);
    client.answerToUnknown();
    return client;
  }

  Server server;
};

TEST_F(FoxgloveImages, WhoHasSubscribedGetsThePictureOfTheCamera) {
  FoxgloveClient client = subscribed();
  EXPECT_TRUE(server.imageWanted(0));
  for (const int shade : {0, 40, 80}) {
    const OwnedImage image = smoothImage(160, 120, shade);
    publish(image, 1'000'000'000'000 + shade);
    const FoxgloveClient::Data data = client.nextData();
    EXPECT_EQ(data.subscription, 1u);
    EXPECT_EQ(data.time, 1'000'000'000'000u + static_cast<unsigned>(shade));
    const ProtobufMessage message(data.payload);
    EXPECT_EQ(message.time(1), data.time);
    EXPECT_EQ(message.text(3), "jpeg");
    EXPECT_EQ(message.text(4), "left");
    const DecodedJpeg decoded = decodedJpeg(message.text(2));
    EXPECT_LT(differenceOf(decoded, image.view), 2.0);
    EXPECT_GT(differenceOf(decoded, smoothImage(160, 120, shade + 20).view), 4.0) << "the test would not notice";
  }
  client.answerToUnknown();
  ASSERT_TRUE(eventually([&] { return server.status().clients[0].images == 3; }));
  EXPECT_EQ(server.status().encoded_images, 3u);
  EXPECT_EQ(server.status().clients[0].frames, 0u);
}

TEST_F(FoxgloveImages, WhoHasNotSubscribedGetsNoneAndNothingIsEncoded) {
  FoxgloveClient client(server.port());
  const auto channels = client.channels();
  client.subscribe(1, channels.at("/tf"));
  client.nextData();
  const OwnedImage image = smoothImage(160, 120);
  for (int k = 0; k < 5; ++k) publish(image, k);
  EXPECT_EQ(image.pixels.use_count(), 1) << "an image is kept that nobody wants";
  EXPECT_FALSE(server.imageWanted(0));
  client.send(kText, R"({"op":"unknown"})");
  EXPECT_EQ(client.next("status")["level"], 2);  // and nothing before it
  EXPECT_EQ(server.status().encoded_images, 0u);

  client.subscribe(2, channels.at(kLeftImage));
  client.answerToUnknown();
  publish(image, 7);
  EXPECT_EQ(client.nextData().subscription, 2u);
  client.unsubscribe(2);
  client.answerToUnknown();
  publish(image, 8);
  EXPECT_FALSE(server.imageWanted(0));
  client.answerToUnknown();
  EXPECT_EQ(server.status().encoded_images, 1u);
  EXPECT_EQ(image.pixels.use_count(), 1);
}

TEST_F(FoxgloveImages, AClientThatGoesIsNotEncodedFor) {
  { const FoxgloveClient client = subscribed(); }
  ASSERT_TRUE(eventually([&] { return !server.imageWanted(0); }));
}

TEST_F(FoxgloveImages, TheChannelOfACameraComesWithItsFirstImage) {
  FoxgloveClient client(server.port());
  EXPECT_EQ(client.channels().count("/cameras/right/image"), 0u);
  const OwnedImage image = smoothImage(200, 100);
  publish(image, 1, 1);
  const auto more = client.next("advertise")["channels"];
  ASSERT_EQ(more.size(), 1u);
  EXPECT_EQ(more[0]["topic"], "/cameras/right/image");
  EXPECT_EQ(more[0]["schemaName"], "foxglove.CompressedImage");
  client.subscribe(1, more[0]["id"]);
  client.answerToUnknown();
  publish(image, 2, 1);
  EXPECT_EQ(client.nextData().time, 2u);
  // A description of the same cameras changes nothing; of one with another name, the channel goes.
  stream::Description description = threeCameras();
  server.describe(description);
  client.answerToUnknown();
  publish(image, 3, 1);
  EXPECT_EQ(client.nextData().time, 3u);
  description.cameras[1].name = "new";
  server.describe(description);
  EXPECT_EQ(client.next("unadvertise")["channelIds"].size(), 2u);  // with its calibration
  ASSERT_TRUE(eventually([&] { return !server.imageWanted(1); }));
}

TEST_F(FoxgloveImages, CalibrationAndFrameAreThoseOfTheColourCamera) {
  publish(smoothImage(200, 100), 1, 1);
  FoxgloveClient client(server.port());
  const auto channels = client.channels();
  client.subscribe(1, channels.at("/cameras/right/calibration"));
  const ProtobufMessage calibration(client.nextData().payload);
  client.subscribe(2, channels.at("/tf"));
  const ProtobufMessage transforms(client.nextData().payload);
  client.subscribe(3, channels.at("/cameras/right/image"));
  client.answerToUnknown();
  const OwnedImage sent = smoothImage(200, 100);
  publish(sent, 2, 1);
  const ProtobufMessage image(client.nextData().payload);
  const DecodedJpeg decoded = decodedJpeg(image.text(2));
  EXPECT_LT(differenceOf(decoded, sent.view), 2.0);
  EXPECT_EQ(calibration.fixed32(2), static_cast<std::uint32_t>(decoded.width));
  EXPECT_EQ(calibration.fixed32(3), static_cast<std::uint32_t>(decoded.height));
  EXPECT_EQ(calibration.reals(6), (std::vector<double>{151, 0, 101, 0, 152, 51, 0, 0, 1}));
  EXPECT_EQ(calibration.text(9), "right_color");
  EXPECT_EQ(image.text(4), "right_color");
  ASSERT_EQ(transforms.count(1), 4u);
  std::vector<std::string> frames;
  for (std::size_t k = 0; k < 4; ++k)
    frames.push_back(transforms.message(1, k).text(2) + ">" + transforms.message(1, k).text(3));
  EXPECT_EQ(frames, (std::vector<std::string>{"world>left", "world>right", "right>right_color", "world>third"}));
  const ProtobufMessage color = transforms.message(1, 2);
  EXPECT_EQ(color.message(4).real(1), 0.03);
  EXPECT_EQ(color.message(4).real(3), 0.01);
  EXPECT_NEAR(color.message(5).real(1), std::sqrt(0.5), 1e-12);
}

TEST_F(FoxgloveImages, CalibrationsHaveTheDistortionOfTheImage) {
  stream::Description description = threeCameras();
  Distortion& brown = description.cameras[0].intrinsics.distortion;
  brown.k1 = 1;
  brown.k2 = 2;
  brown.p1 = 3;
  brown.p2 = 4;
  brown.k3 = 5;
  Distortion& rational = description.cameras[2].intrinsics.distortion = brown;
  rational.k4 = 6;
  rational.k6 = 8;
  server.describe(description);
  FoxgloveClient client(server.port());
  const auto channels = client.channels();
  client.subscribe(1, channels.at("/cameras/left/calibration"));
  const ProtobufMessage left(client.nextData().payload);
  EXPECT_EQ(left.text(4), "plumb_bob");
  EXPECT_EQ(left.reals(5), (std::vector<double>{1, 2, 3, 4, 5}));
  client.subscribe(2, channels.at("/cameras/third/calibration"));
  const ProtobufMessage third(client.nextData().payload);
  EXPECT_EQ(third.text(4), "rational_polynomial");
  EXPECT_EQ(third.reals(5), (std::vector<double>{1, 2, 3, 4, 5, 6, 0, 8}));
}

TEST_F(FoxgloveImages, TheNameOfAColourCamerasFrameIsNobodyElses) {
  stream::Description description = threeCameras();
  description.cameras[2].name = "right_color";
  server.describe(description);
  FoxgloveClient client(server.port());
  client.subscribe(1, client.channels().at("/cameras/right/calibration"));
  EXPECT_EQ(ProtobufMessage(client.nextData().payload).text(9), "right_color_2");
}

TEST_F(FoxgloveImages, OneEncodingIsForAll) {
  FoxgloveClient one = subscribed(), two = subscribed();
  for (std::uint64_t time = 1; time <= 10; ++time) {
    publish(smoothImage(160, 120, static_cast<int>(time)), static_cast<std::int64_t>(time));
    const FoxgloveClient::Data first = one.nextData();
    EXPECT_EQ(first.time, time);
    EXPECT_EQ(first.payload, two.nextData().payload);
  }
  EXPECT_EQ(server.status().encoded_images, 10u);
}

TEST_F(FoxgloveImages, WithoutAnOwnerPixelsAreCopiedRowByRow) {
  FoxgloveClient client = subscribed();
  OwnedImage wide = smoothImage(240, 120);
  const ImageView<Rgb8> part(wide.pixels->data() + 50, 160, 120, 240 * sizeof(Rgb8));
  OwnedImage expected(160, 120);
  for (int v = 0; v < 120; ++v)
    for (int u = 0; u < 160; ++u) expected.at(u, v) = wide.at(u + 50, v);
  server.publishImage(0, part, {0, 5, 0});
  wide.pixels->assign(wide.pixels->size(), Rgb8{});
  const ProtobufMessage message(client.nextData().payload);
  EXPECT_LT(differenceOf(decodedJpeg(message.text(2)), expected.view), 2.0);
}

TEST_F(FoxgloveImages, OwnersAreLetGo) {
  FoxgloveClient client = subscribed();
  const OwnedImage first = smoothImage(160, 120), second = smoothImage(160, 120, 9);
  publish(first, 1);
  client.nextData();
  EXPECT_TRUE(eventually([&] { return first.pixels.use_count() == 1; }));
  publish(second, 2);
  publish(first, 3);
  for (std::uint64_t time = 0; time != 3;) time = client.nextData().time;
  EXPECT_TRUE(eventually([&] { return second.pixels.use_count() == 1 && first.pixels.use_count() == 1; }));
}

TEST_F(FoxgloveImages, WhatIsNoImageOfTheCameraIsRefused) {
  const auto refusal = [&](std::size_t camera, const OwnedImage& image) -> std::string {
    try {
      server.publishImage(camera, image.view, {});
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  const OwnedImage image = smoothImage(160, 120);
  EXPECT_EQ(refusal(3, image),
            "stream::Server::publishImage: camera 3: must be below 3, the cameras that are described");
  EXPECT_EQ(refusal(1, image),
            "stream::Server::publishImage: camera 1: its image is of 160x120 pixels, must be of 200x100, as its "
            "calibration");
  EXPECT_NE(refusal(0, smoothImage(120, 160)).find("its image is of 120x160"), std::string::npos);
  server.publishImage(7, {}, {});  // no image
  stream::Description description = threeCameras();
  description.cameras[0].intrinsics.width = 65'501;
  description.cameras[0].intrinsics.height = 1;
  server.describe(description);
  EXPECT_NE(refusal(0, smoothImage(65'501, 1)).find("must have sides of 1 to 65500"), std::string::npos);
  EXPECT_EQ(refusal(2, image), "");
}

TEST_F(FoxgloveImages, ImagesAndCloudsComeBesideEachOther) {
  FoxgloveClient client = subscribed();
  client.subscribe(2, 1);
  client.answerToUnknown();
  for (std::uint64_t time = 1; time <= 20; ++time) {
    publish(smoothImage(160, 120), static_cast<std::int64_t>(time));
    auto frame = std::make_shared<stream::EncodedFrame>(*frameOf(800, time));  // so few come whole
    frame->times.captured = static_cast<std::int64_t>(time);
    server.publish(frame);
    std::array<std::uint64_t, 3> times{};
    for (int k = 0; k < 2; ++k) {
      const FoxgloveClient::Data data = client.nextData();
      times[data.subscription] = data.time;
    }
    EXPECT_EQ(times, (std::array<std::uint64_t, 3>{0, time, time}));
  }
  client.answerToUnknown();
  ASSERT_TRUE(eventually([&] { return server.status().clients[0].frames == 20; }));
  EXPECT_EQ(server.status().clients[0].images, 20u);
}

class FoxgloveFewMessages : public FoxgloveImages {
 protected:
  static stream::ServerOptions fewMessages() {
    stream::ServerOptions options = anyPort();
    options.messages_per_second = 10;
    return options;
  }
  FoxgloveFewMessages() : FoxgloveImages(fewMessages()) {}
};

TEST_F(FoxgloveFewMessages, AnswersToPingsAreNoMessagesTooMany) {
  FoxgloveClient client = subscribed();
  const OwnedImage image = smoothImage(160, 120);
  for (std::uint64_t time = 1; time <= 100; ++time) {
    publish(image, static_cast<std::int64_t>(time));
    EXPECT_EQ(client.nextData().time, time);
  }
  EXPECT_EQ(server.status().dropped, 0u);
  for (int k = 0; k < 20; ++k) client.send(kPong, "unasked");
  EXPECT_EQ(client.closeCode(), 1008);
}

TEST_F(FoxgloveImages, ASlowClientHoldsUpNobodyAndGetsTheNewest) {
  server.describe(camerasOfLargeImages());
  FoxgloveClient slow = subscribed();  // does not read on
  FoxgloveClient fast = subscribed();
  FoxgloveClient clouds(server.port());
  clouds.channels();
  clouds.subscribe(1, 1);
  clouds.answerToUnknown();
  const OwnedImage image = noisyImage(kLargeWidth, kLargeHeight);
  std::uint64_t last = 0;
  for (std::uint64_t time = 1; time <= 20; ++time) {
    publish(image, static_cast<std::int64_t>(time));
    last = fast.nextData().time;
    EXPECT_EQ(last, time);
    server.publish(frameOf(100, time));
    clouds.nextData();
  }
  EXPECT_EQ(server.status().encoded_images, 20u);
  std::vector<std::uint64_t> times;
  while (times.empty() || times.back() != last) times.push_back(slow.nextData().time);
  // What was under way when it did not read, and then the newest.
  EXPECT_LE(times.size(), 4u);
  EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
}

TEST_F(FoxgloveImages, WhatNobodyCanTakeIsNotEncoded) {
  server.describe(camerasOfLargeImages());
  FoxgloveClient slow = subscribed();
  const OwnedImage image = noisyImage(kLargeWidth, kLargeHeight);
  publish(image, 1);
  ASSERT_TRUE(eventually([&] { return server.status().encoded_images == 1; }));
  for (std::int64_t time = 2; time <= 30; ++time) {
    publish(image, time);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_LE(server.status().encoded_images, 3u);
  for (std::uint64_t time = 0; time != 30;) time = slow.nextData().time;
  EXPECT_LE(server.status().encoded_images, 4u);
}

class FoxgloveLittleMemory : public FoxgloveImages {
 protected:
  static stream::ServerOptions littleMemory() {
    stream::ServerOptions options = anyPort();
    options.held_bytes = 8 << 20;
    return options;
  }
  FoxgloveLittleMemory() : FoxgloveImages(littleMemory()) {}
};

TEST_F(FoxgloveLittleMemory, SlowClientsHoldNoMoreImagesThanMayBe) {
  server.describe(camerasOfLargeImages());
  const OwnedImage image = noisyImage(kLargeWidth, kLargeHeight);
  std::vector<FoxgloveClient> slow;
  for (std::uint64_t k = 0; k < 8; ++k) {  // each holds another image
    slow.push_back(subscribed());
    slow.back().socket.receiveBuffer(4096);
    const std::uint64_t before = server.status().encoded_images;
    publish(image, static_cast<std::int64_t>(k + 1));
    ASSERT_TRUE(eventually([&] { return server.status().encoded_images > before; }));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ASSERT_TRUE(eventually([&] {
    publish(image, 100);
    return server.status().dropped >= 1;
  }));
  EXPECT_LT(server.status().dropped, 8u) << "the newest are within what may be held";
  EXPECT_TRUE(anyHas(server.takeNotices(), "hold more memory than may be"));
}

TEST_F(FoxgloveImages, MalformedSubscriptionsAreRefusedAsBefore) {
  FoxgloveClient client = subscribed();
  const std::uint32_t channel = 5;  // /points, /tf and the three calibrations come before, or between
  client.subscribe(1, channel);     // the number is taken
  EXPECT_EQ(client.next("status")["level"], 1);
  FoxgloveClient other(server.port());
  const std::uint32_t image = other.channels().at(kLeftImage);
  other.subscribe(1, image);
  other.subscribe(2, image);  // twice the same channel
  EXPECT_EQ(other.next("status")["level"], 1);
  other.send(kText, R"({"op":"subscribe","subscriptions":[{"id":3,"channelId":"image"}]})");
  EXPECT_EQ(other.closeCode(), 1008);
  ASSERT_TRUE(eventually([&] { return server.status().clients.size() == 1; }));
  EXPECT_TRUE(server.imageWanted(0));  // by the first one
}

TEST(FoxgloveImagesEnd, AServerMayEndWhileAnImageIsEncoded) {
  stream::Description description = threeCameras();
  description.cameras[0].intrinsics.width = 800;
  description.cameras[0].intrinsics.height = 600;
  const OwnedImage image = noisyImage(800, 600);
  for (int k = 0; k < 40; ++k) {
    auto server = std::make_unique<Server>(anyPort());
    server->describe(description);
    server->publishImage(0, image.view, {}, image.pixels);
    auto client = std::make_unique<FoxgloveClient>(server->port());
    client->subscribe(1, client->channels().at(kLeftImage));
    client->answerToUnknown();
    server->publishImage(0, image.view, {}, image.pixels);
    std::this_thread::sleep_for(std::chrono::microseconds(200 * k));
    client.reset();
    server.reset();
  }
  EXPECT_EQ(image.pixels.use_count(), 1);
}

}  // namespace
