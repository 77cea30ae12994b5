#include "foxglove_client.h"
#include "streams.h"

#include "stream/foxglove/cloud_payload.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

namespace {

using namespace fuse_flow;
using namespace fuse_flow::test;
using stream::Server;
using Json = nlohmann::json;

constexpr std::uint64_t kSecond = 1'000'000'000;

/** \brief Position, red, green, blue, alpha, confidence, number of views. */
using PackedPoint = std::array<double, 9>;

struct PackedCloud {
  std::uint64_t time{0};
  std::string frame;
  std::vector<PackedPoint> points;
};

/** \brief As Foxglove reads it: fields are where the message says. */
PackedCloud packedCloudOf(const std::string& payload) {
  const ProtobufMessage message(payload);
  PackedCloud cloud{message.time(1), message.text(2), {}};
  EXPECT_EQ(message.message(3).message(2).real(4), 1) << "no rotation";
  const std::size_t stride = message.fixed32(4);
  const std::string& data = message.text(6);
  EXPECT_EQ(data.size() % stride, 0u);
  const std::array<std::string, 9> names{"x", "y", "z", "red", "green", "blue", "alpha", "confidence", "view_count"};
  cloud.points.resize(data.size() / stride);
  EXPECT_EQ(message.count(5), names.size());
  for (std::size_t k = 0; k < message.count(5); ++k) {
    const ProtobufMessage field = message.message(5, k);
    EXPECT_EQ(field.text(1), names[k]);
    EXPECT_EQ(field.number(3), k < 3 ? 7u : 1u);  // FLOAT32, UINT8
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      const char* at = data.data() + i * stride + field.fixed32(2);
      float number = static_cast<unsigned char>(*at);
      if (k < 3) std::memcpy(&number, at, sizeof(number));
      cloud.points[i][k] = number;
    }
  }
  return cloud;
}

std::size_t packedSizeOf(const std::string& payload) {
  const ProtobufMessage message(payload);
  return message.text(6).size() / message.fixed32(4);
}

std::vector<PackedPoint> packedPointsOf(const std::vector<std::uint8_t>& message) {
  stream::FrameDecoder decoder(1);
  stream::StreamedCloud from;
  decoder.decode(message.data(), message.size(), from);
  std::vector<PackedPoint> points(from.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = {from.positions[3 * i],
                 from.positions[3 * i + 1],
                 from.positions[3 * i + 2],
                 double(from.colors[3 * i]),
                 double(from.colors[3 * i + 1]),
                 double(from.colors[3 * i + 2]),
                 255,
                 double(from.confidence[i]),
                 double(from.view_counts[i])};
  return points;
}

std::vector<PackedPoint> inOrder(std::vector<PackedPoint> points) {
  std::sort(points.begin(), points.end());
  return points;
}

/** \brief So many layers of each chunk. */
template <typename Layers>
stream::Selection selectionOf(const stream::EncodedFrame& frame, const Layers& layers) {
  stream::Selection selection = stream::select(frame, {});
  selection.points = 0;
  for (std::size_t chunk = 0; chunk < frame.chunks.size(); ++chunk) {
    selection.layers[chunk] = static_cast<std::uint8_t>(layers(chunk));
    for (std::size_t layer = 0; layer < layers(chunk); ++layer)
      selection.points += frame.chunks[chunk].layer_points[layer];
  }
  return selection;
}

stream::Description roomOfTwoCameras() {
  stream::Description description;
  description.name = "wall";
  description.frame = "room";
  description.cameras.resize(2);
  Camera& left = description.cameras[0];
  left.name = "left";
  left.intrinsics = {640, 480, 525, 526, 320, 240, {}};
  left.T_world_camera = Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ());
  description.cameras[1] = left;
  description.cameras[1].name = "right";
  description.cameras[1].T_world_camera = Eigen::Translation3d(-1, 0, 0);
  return description;
}

TEST(Foxglove, TheServerAndItsChannelsComeFirst) {
  Server server(anyPort());
  server.describe(roomOfTwoCameras());
  std::string session;
  for (const std::string subprotocol : {"foxglove.websocket.v1", "foxglove.sdk.v1"}) {
    FoxgloveClient client(server.port(), "", "/", subprotocol);
    EXPECT_NE(client.answer.find("Sec-WebSocket-Protocol: " + subprotocol), std::string::npos);
    const Json info = client.nextJson();
    EXPECT_EQ(info["op"], "serverInfo");
    EXPECT_EQ(info["name"], "wall");
    EXPECT_EQ(info["capabilities"], Json::array());
    EXPECT_TRUE(session.empty() || info["sessionId"] == session);
    session = info["sessionId"];
    const Json advertise = client.nextJson();
    EXPECT_EQ(advertise["op"], "advertise");
    std::map<std::string, std::string> schemas;
    for (const Json& channel : advertise["channels"]) {
      EXPECT_EQ(channel["encoding"], "protobuf");
      EXPECT_EQ(channel["schemaEncoding"], "protobuf");
      EXPECT_GT(channel["schema"].get<std::string>().size(), 300u);
      schemas[channel["topic"]] = channel["schemaName"];
    }
    EXPECT_EQ(schemas,
              (std::map<std::string, std::string>{{"/points", "foxglove.PointCloud"},
                                                  {"/tf", "foxglove.FrameTransforms"},
                                                  {"/cameras/left/calibration", "foxglove.CameraCalibration"},
                                                  {"/cameras/right/calibration", "foxglove.CameraCalibration"}}));
    ASSERT_TRUE(eventually([&] {
      const auto clients = server.status().clients;
      return !clients.empty() && clients.back().subprotocol == subprotocol;
    }));
  }
  Server other(anyPort());
  FoxgloveClient client(other.port());
  const Json info = client.nextJson();
  EXPECT_NE(info["sessionId"], session);
  EXPECT_EQ(info["name"], "FUSE-Flow");
}

TEST(Foxglove, OfSeveralSubprotocolsOneIsChosen) {
  Server server(anyPort());
  FoxgloveClient client(server.port(), "", "/", "foxglove.sdk.v1, foxglove.websocket.v1");
  EXPECT_EQ(client.nextJson()["op"], "serverInfo");
  EXPECT_THROW(FoxgloveClient(server.port(), "", "/", "fuse_flow.v1"), std::runtime_error);
  EXPECT_THROW(FoxgloveClient(server.port(), "", "/stream"), std::runtime_error);
}

TEST(Foxglove, PointsAreThoseThatWerePublished) {
  Server server(anyPort());
  server.describe(roomOfTwoCameras());
  FoxgloveClient client(server.port());
  client.channels();
  client.subscribe(77, 1);
  for (std::uint64_t number = 0; number < 5; ++number) {
    auto frame = std::make_shared<stream::EncodedFrame>(*frameOf(800, number));  // so few come whole
    frame->times.captured = number < 3 ? static_cast<std::int64_t>((1000 + number) * kSecond + 5) : 0;
    frame->times.encoded = static_cast<std::int64_t>(2000 * kSecond + number);
    server.publish(frame);
    const FoxgloveClient::Data data = client.nextData();
    EXPECT_EQ(data.subscription, 77u);
    EXPECT_EQ(data.time, number < 3 ? (1000 + number) * kSecond + 5 : 2000 * kSecond + number);
    const PackedCloud cloud = packedCloudOf(data.payload);
    EXPECT_EQ(cloud.time, data.time);
    EXPECT_EQ(cloud.frame, "room");
    EXPECT_EQ(cloud.points.size(), 800u);
    EXPECT_EQ(inOrder(cloud.points), inOrder(packedPointsOf(stream::messageOf(frame).joined())));
  }
  client.answerToUnknown();  // and the ping before it
  ASSERT_TRUE(eventually([&] { return server.status().clients[0].frames == 5; }));
  EXPECT_EQ(server.status().clients[0].points, 800u);
  EXPECT_EQ(server.status().clients[0].points_of_frame, 800u);
  EXPECT_TRUE(server.takeNotices().empty());
}

TEST(Foxglove, FewerLayersAreTheBeginningOfAll) {
  for (const std::size_t points : {0u, 1u, 3u, 1500u, 20'000u}) {
    SCOPED_TRACE(points);
    const auto frame = frameOf(points, 3);
    const auto payload = stream::foxglove::CloudPayloads(1).make(frame, "world");
    ASSERT_EQ(payload.up_to.size(), 4u);
    for (std::size_t layers = 1; layers <= 4; ++layers) {
      const stream::Selection selection = selectionOf(*frame, [&](std::size_t) { return layers; });
      const std::string data(
          payload.points.begin(),
          payload.points.begin() + static_cast<std::ptrdiff_t>(payload.stride * payload.up_to[layers - 1]));
      const PackedCloud cloud = packedCloudOf(payload.beginning(layers) + data);
      EXPECT_EQ(inOrder(cloud.points), inOrder(packedPointsOf(stream::messageOf(frame, selection).joined())));
    }
  }
}

TEST(Foxglove, OfAFrameThatCameInPartAllThatIsThereIsSent) {
  const auto frame = frameOf(5000, 1);
  const stream::Selection selection = selectionOf(*frame, [](std::size_t chunk) { return chunk % 5; });
  const std::vector<std::uint8_t> part = stream::messageOf(frame, selection).joined();
  const auto payload = stream::foxglove::CloudPayloads(1).make(stream::frameOf(part.data(), part.size()), "world");
  const std::string data(payload.points.begin(), payload.points.end());
  EXPECT_EQ(inOrder(packedCloudOf(payload.beginning(4) + data).points), inOrder(packedPointsOf(part)));
}

TEST(Foxglove, AFrameWithoutColourHasNoFieldsOfIt) {
  pcl::PointCloud<pcl::PointXYZ> cloud;
  cloud.push_back({1, 2, 3});
  stream::FrameEncoder encoder;
  const auto payload = stream::foxglove::CloudPayloads(1).make(encoder.encode(cloud, {1, 2, 3}), "world");
  EXPECT_EQ(payload.stride, 12u);
  const ProtobufMessage message(payload.beginning(1) + std::string(payload.points.begin(), payload.points.end()));
  EXPECT_EQ(message.count(5), 3u);
  std::array<float, 3> position;
  std::memcpy(position.data(), message.text(6).data(), 12);
  EXPECT_EQ(position, (std::array<float, 3>{1, 2, 3}));
}

TEST(Foxglove, CamerasAreTransformsAndCalibrations) {
  Server server(anyPort());
  server.describe(roomOfTwoCameras());
  FoxgloveClient client(server.port());
  const auto channels = client.channels();
  client.subscribe(1, channels.at("/tf"));
  const FoxgloveClient::Data tf = client.nextData();
  EXPECT_EQ(tf.subscription, 1u);
  const ProtobufMessage transforms(tf.payload);
  ASSERT_EQ(transforms.count(1), 2u);
  const ProtobufMessage left = transforms.message(1, 0);
  EXPECT_EQ(left.time(1), tf.time);
  EXPECT_EQ(left.text(2), "room");
  EXPECT_EQ(left.text(3), "left");
  for (std::uint64_t axis = 1; axis <= 3; ++axis) EXPECT_EQ(left.message(4).real(axis), static_cast<double>(axis));
  EXPECT_NEAR(left.message(5).real(3), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(left.message(5).real(4), std::sqrt(0.5), 1e-12);
  EXPECT_EQ(transforms.message(1, 1).text(3), "right");

  client.subscribe(2, channels.at("/cameras/left/calibration"));
  const FoxgloveClient::Data calibration = client.nextData();
  EXPECT_EQ(calibration.subscription, 2u);
  const ProtobufMessage camera(calibration.payload);
  EXPECT_EQ(camera.time(1), calibration.time);
  EXPECT_EQ(camera.fixed32(2), 640u);
  EXPECT_EQ(camera.fixed32(3), 480u);
  EXPECT_EQ(camera.reals(6), (std::vector<double>{525, 0, 320, 0, 526, 240, 0, 0, 1}));
  EXPECT_EQ(camera.reals(8), (std::vector<double>{525, 0, 320, 0, 0, 526, 240, 0, 0, 0, 1, 0}));
  EXPECT_EQ(camera.text(9), "left");
}

TEST(Foxglove, WhatChangesIsSentAgainAndWhatStaysIsNot) {
  Server server(anyPort());
  stream::Description description = roomOfTwoCameras();
  server.describe(description);
  FoxgloveClient client(server.port());
  auto channels = client.channels();
  client.subscribe(1, channels.at("/tf"));
  client.subscribe(2, channels.at("/cameras/left/calibration"));
  client.subscribe(3, channels.at("/cameras/right/calibration"));
  for (int k = 0; k < 3; ++k) client.nextData();
  server.describe(description);
  EXPECT_EQ(client.answerToUnknown()["level"], 2);
  description.cameras[0].T_world_camera.translation().x() = 9;
  server.describe(description);
  const FoxgloveClient::Data moved = client.nextData();
  EXPECT_EQ(moved.subscription, 1u);
  EXPECT_EQ(ProtobufMessage(moved.payload).message(1, 0).message(4).real(1), 9);

  // One goes, another comes.
  description.cameras[1].name = "new";
  server.describe(description);
  const Json gone = client.nextJson();
  EXPECT_EQ(gone["op"], "unadvertise");
  EXPECT_EQ(gone["channelIds"], Json::array({channels.at("/cameras/right/calibration")}));
  const auto more = client.channels();
  ASSERT_EQ(more.size(), 1u);
  EXPECT_EQ(more.begin()->first, "/cameras/new/calibration");
  for (const auto& [topic, id] : channels) EXPECT_NE(id, more.begin()->second);
  EXPECT_EQ(client.nextData().subscription, 1u);  // to the transforms, which name it
  client.unsubscribe(3);                          // went with its channel
  EXPECT_EQ(client.next("status")["level"], 1);
}

TEST(Foxglove, CamerasOfOneNameAreToldApart) {
  Server server(anyPort());
  stream::Description description = roomOfTwoCameras();
  description.frame = "world";
  description.cameras.resize(5, description.cameras[0]);
  description.cameras[1].name = "left";
  description.cameras[2].name = "";
  description.cameras[3].name = "world";
  description.cameras[4].name = "l\xff";  // no UTF-8
  server.describe(description);
  FoxgloveClient client(server.port());
  std::set<std::string> topics;
  for (const auto& [topic, id] : client.channels()) topics.insert(topic);
  EXPECT_EQ(topics, (std::set<std::string>{"/points", "/tf", "/cameras/left/calibration", "/cameras/left_2/calibration",
                                           "/cameras/camera/calibration", "/cameras/world_2/calibration",
                                           "/cameras/l\xef\xbf\xbd/calibration"}));
}

TEST(Foxglove, NothingIsMadeForWhoHasNotSubscribed) {
  Server server(anyPort());
  FoxgloveClient client(server.port());
  client.channels();
  ASSERT_TRUE(eventually([&] { return server.status().clients.size() == 1; }));
  EXPECT_FALSE(server.watched());
  client.subscribe(1, 1);
  ASSERT_TRUE(eventually([&] { return server.watched(); }));
  server.publish(wall(), {1, 2, 3});
  EXPECT_EQ(packedSizeOf(client.nextData().payload), wall().size());
  client.unsubscribe(1);
  ASSERT_TRUE(eventually([&] { return !server.watched(); }));
}

TEST(Foxglove, NothingComesAfterUnsubscribing) {
  Server server(anyPort());
  FoxgloveClient client(server.port());
  client.channels();
  client.subscribe(1, 1);
  server.publish(frameOf(100, 1));
  client.nextData();
  client.unsubscribe(1);
  client.answerToUnknown();
  server.publish(frameOf(100, 2));
  // What comes next is what was asked for next.
  client.send(kText, R"({"op":"unknown"})");
  EXPECT_EQ(client.read().opcode, kText);
  client.subscribe(2, 1);
  EXPECT_EQ(client.nextData().subscription, 2u);  // the newest, at once
}

TEST(Foxglove, TwoClientsGetEachFrame) {
  Server server(anyPort());
  FoxgloveClient one(server.port()), two(server.port());
  one.channels();
  two.channels();
  one.subscribe(5, 1);
  two.subscribe(6, 1);
  stream::Client ours(server.link(), patient());
  ASSERT_TRUE(eventually([&] { return server.status().clients.size() == 3; }));
  for (std::uint64_t number = 0; number < 10; ++number) {
    server.publish(frameOf(700 + number, number));  // so few come whole, however slow the test is
    const FoxgloveClient::Data first = one.nextData(), second = two.nextData();
    EXPECT_EQ(first.subscription, 5u);
    EXPECT_EQ(second.subscription, 6u);
    EXPECT_EQ(first.payload, second.payload);
    EXPECT_EQ(packedCloudOf(first.payload).points.size(), 700 + number);
    stream::ReceivedFrame received;
    ASSERT_TRUE(ours.pull(received, kLong));
    EXPECT_EQ(received.times.number, number);
  }
}

TEST(Foxglove, MalformedMessagesCloseTheConnection) {
  Server server(anyPort());
  const std::string deep(5000, '[');
  const std::vector<std::string> messages = {
      "",
      "x",
      "[]",
      "{}",
      R"({"op":1})",
      R"({"op":"subscribe"})",
      R"({"op":"subscribe","subscriptions":{}})",
      R"({"op":"subscribe","subscriptions":[1]})",
      R"({"op":"subscribe","subscriptions":[{"id":1}]})",
      R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})",
      R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":1}]})",
      R"({"op":"subscribe","subscriptions":[{"id":1.5,"channelId":1}]})",
      R"({"op":"subscribe","subscriptions":[{"id":"1","channelId":1}]})",
      R"({"op":"unsubscribe"})",
      R"({"op":"unsubscribe","subscriptionIds":[{}]})",
      R"({"op":"subscribe","subscriptions":)" + deep,
      "{\"op\":\"\xff\"}",
  };
  for (const std::string& message : messages) {
    FoxgloveClient client(server.port());
    client.send(kText, message);
    EXPECT_EQ(client.closeCode(), message.find('\xff') == std::string::npos ? 1008 : 1007) << message.substr(0, 80);
  }
  FoxgloveClient empty(server.port());
  empty.send(kBinary, "");
  EXPECT_EQ(empty.closeCode(), 1008);
  FoxgloveClient large(server.port());
  large.send(kText, std::string(16'385, ' '));
  EXPECT_EQ(large.closeCode(), 1009);
  EXPECT_TRUE(eventually([&] { return anyHas(server.takeNotices(), "a message of more than 16384 bytes"); }));
  EXPECT_TRUE(eventually([&] { return server.status().clients.empty(); }));
}

TEST(Foxglove, LongListsOfSubscriptionsAreTaken) {
  Server server(anyPort());
  FoxgloveClient client(server.port());
  client.channels();
  Json list = Json::array();
  for (std::uint32_t k = 0; k < 300; ++k) list.push_back({{"id", k}, {"channelId", k}});
  const std::string message = Json{{"op", "subscribe"}, {"subscriptions", list}}.dump();
  EXPECT_GT(message.size(), 4096u);
  client.send(kText, message);
  EXPECT_EQ(client.next("status")["message"], "there is no channel 0");
  server.publish(frameOf(10, 1));
  for (std::uint32_t id = 2; id > 0;) id = client.nextData().subscription - 1;  // 1, after the transforms
}

TEST(Foxglove, WhatTheServerDoesNotKnowIsAnsweredAndNothingElseHappens) {
  Server server(anyPort());
  FoxgloveClient client(server.port());
  client.channels();
  client.subscribe(1, 1);
  for (const std::string message :
       {R"({"op":"advertise","channels":[]})", R"({"op":"getParameters","parameterNames":[],"id":"1"})",
        R"({"op":"setParameters","parameters":[{"name":"a","value":{"b":[1,{"c":[2]}]}}]})",
        R"({"op":"subscribeConnectionGraph"})", R"({"op":"fetchAsset","uri":"file:///etc/passwd","requestId":1})"}) {
    client.send(kText, message);
    const Json status = client.next("status");
    EXPECT_EQ(status["level"], 2);
    EXPECT_NE(status["message"].get<std::string>().find(Json::parse(message)["op"].get<std::string>()),
              std::string::npos);
  }
  client.send(kBinary, std::string("\1\0\0\0\0x", 6));
  EXPECT_EQ(client.next("status")["level"], 2);
  client.subscribe(1, 2);  // the number is taken
  EXPECT_EQ(client.next("status")["level"], 1);
  client.subscribe(2, 1);  // twice the same channel
  EXPECT_EQ(client.next("status")["level"], 1);
  client.subscribe(3, 99);
  EXPECT_EQ(client.next("status")["level"], 1);
  client.unsubscribe(99);
  EXPECT_EQ(client.next("status")["level"], 1);
  server.publish(frameOf(10, 1));
  EXPECT_EQ(client.nextData().subscription, 1u);
  EXPECT_EQ(server.status().dropped, 0u);
}

TEST(Foxglove, TokenAndOriginAreTheServers) {
  stream::ServerOptions options = anyPort();
  options.token = "0123456789abcdef";
  options.allowed_origins = {"https://app.foxglove.dev"};
  Server server(options);
  const auto refusal = [&](const std::string& headers, const std::string& target) {
    try {
      FoxgloveClient(server.port(), headers, target);
      return 101;
    } catch (const std::runtime_error& error) {
      return statusOf(error.what());
    }
  };
  const std::string with_token = "/?token=" + options.token;
  EXPECT_EQ(refusal("", "/"), 401);
  EXPECT_EQ(refusal("", "/?token=0123456789abcdeX"), 401);
  EXPECT_EQ(refusal("", with_token), 101);
  EXPECT_EQ(refusal("Origin: https://evil.example\r\n", with_token), 403);
  EXPECT_EQ(refusal("Origin: https://app.foxglove.dev\r\n", with_token), 101);
  EXPECT_EQ(refusal("Origin: https://app.foxglove.dev\r\n", "/"), 401);
}

TEST(Foxglove, ThePageIsAtTheSamePath) {
  Server server(anyPort());
  const auto ask = [&] {
    RawSocket socket = RawSocket::to(server.port());
    socket.send("GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    return socket.all();
  };
  EXPECT_EQ(statusOf(ask()), 426);
  server.serve("/", {"text/html", "the page", ""});
  EXPECT_EQ(statusOf(ask()), 200);
  FoxgloveClient client(server.port());
  EXPECT_EQ(client.nextJson()["op"], "serverInfo");
}

/** \brief 300,000 points, whose payload is more than the first frame may have. */
std::shared_ptr<const stream::EncodedFrame> largeFrame() {
  auto cloud = wall();
  const auto one = cloud;
  for (const float y : {5.0f, 10.0f})
    for (auto point : one) {
      point.y += y;
      cloud.push_back(point);
    }
  return stream::FrameEncoder().encode(cloud, {1, 2, 3});
}

TEST(Foxglove, ALargeFrameComesWithFewerPointsFirstAndThenWithAll) {
  Server server(anyPort());
  FoxgloveClient client(server.port());
  client.channels();
  client.subscribe(1, 1);
  const auto frame = largeFrame();
  server.publish(frame);
  const std::size_t first = packedSizeOf(client.nextData().payload);
  EXPECT_LT(first, 200'000u);
  EXPECT_GT(first, 100'000u);
  for (std::size_t points = 0; points < 300'000;) {  // no other frame comes
    const std::size_t now = packedSizeOf(client.nextData().payload);
    ASSERT_GT(now, std::max(points, first));
    points = now;
  }
}

TEST(Foxglove, ASlowClientHoldsUpNobodyAndGetsTheNewest) {
  Server server(anyPort());
  const auto slow_socket = [&] {
    FoxgloveClient client(server.port());
    client.channels();
    client.subscribe(1, 1);
    return client;
  };
  FoxgloveClient slow = slow_socket();  // does not read on
  FoxgloveClient fast(server.port());
  fast.channels();
  fast.subscribe(1, 1);
  ASSERT_TRUE(eventually([&] { return server.watched(); }));
  std::uint64_t last = 0;
  const auto any = frameOf(50'000, 0);
  for (std::uint64_t number = 1; number <= 60; ++number) {
    auto frame = std::make_shared<stream::EncodedFrame>(*any);
    frame->times.captured = static_cast<std::int64_t>(number);
    server.publish(frame);
    last = fast.nextData().time;
    EXPECT_EQ(last, number);
  }
  std::vector<std::uint64_t> times;
  while (times.empty() || times.back() != last) times.push_back(slow.nextData().time);
  // What was under way when it did not read, and then the newest.
  EXPECT_LE(times.size(), 4u);
  EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
}

TEST(Foxglove, WhoDoesNotAnswerIsLetGo) {
  stream::ServerOptions options = anyPort();
  options.answer_time = std::chrono::milliseconds(500);
  Server server(options);
  server.publish(frameOf(10, 1));
  FoxgloveClient idle(server.port()), reading(server.port());
  reading.channels();
  reading.subscribe(1, 1);  // and gets the frame at once
  ASSERT_TRUE(eventually([&] { return server.status().dropped == 2; }));
  const std::vector<std::string> notices = server.takeNotices();
  EXPECT_TRUE(anyHas(notices, "does not answer pings")) << notices[0];
  EXPECT_TRUE(anyHas(notices, "was not taken in time")) << notices[0];
}

TEST(Foxglove, ManySlowClientsHoldNoMoreThanMayBe) {
  stream::ServerOptions options = anyPort();
  options.held_bytes = 1 << 20;
  Server server(options);
  FoxgloveClient slow(server.port());
  slow.socket.receiveBuffer(4096);
  slow.channels();
  slow.subscribe(1, 1);
  ASSERT_TRUE(eventually([&] { return server.watched(); }));
  const auto frame = largeFrame();
  ASSERT_TRUE(eventually([&] {
    server.publish(std::make_shared<stream::EncodedFrame>(*frame));
    return server.status().dropped == 1;
  }));
  EXPECT_TRUE(anyHas(server.takeNotices(), "hold more memory than may be"));
}

TEST(Foxglove, AFrameThatIsDamagedIsSaidAndTheNextOneComes) {
  Server server(anyPort());
  FoxgloveClient client(server.port());
  client.channels();
  client.subscribe(1, 1);
  auto damaged = std::make_shared<stream::EncodedFrame>(*frameOf(1000, 1));
  for (std::uint8_t& byte : damaged->chunks[0].bytes) byte ^= 0x55;
  ASSERT_TRUE(eventually([&] { return server.watched(); }));
  server.publish(damaged);
  ASSERT_TRUE(eventually([&] { return anyHas(server.takeNotices(), "cannot be sent to Foxglove"); }));
  server.publish(frameOf(10, 2));
  EXPECT_EQ(packedCloudOf(client.nextData().payload).points.size(), 10u);
}

/** \brief subscribe.cjs: @foxglove/ws-protocol and protobufjs, with Foxglove's own definitions of its types. */
TEST(Foxglove, AnotherImplementationReadsAll) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("fuse_flow_foxglove_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const std::string packages = " @foxglove/ws-protocol@0.8 @foxglove/schemas@0.7.3 protobufjs@7 ws@8";
  const std::string log = "'" + (folder / "log").string() + "'", said = "'" + (folder / "said").string() + "'";
  std::string modules = (folder / "node_modules").string();
  const char* given = std::getenv("FUSE_FLOW_TEST_FOXGLOVE_NODE_MODULES");
  if (given) modules = given;
  const std::string install = "timeout 60 npm install --no-audit --no-fund --prefix '" + folder.string() + "'";
  if (!given && std::system((install + packages + " > " + log + " 2>&1").c_str()) != 0) {
    std::filesystem::remove_all(folder);
    GTEST_SKIP() << "needs npm, and its registry for" << packages;
  }
  Server server(anyPort());
  server.describe(roomOfTwoCameras());
  const auto frame = frameOf(800, 1);
  const std::vector<Rgb8> pixels(640 * 480, Rgb8{200, 100, 50});
  server.publishImage(0, {pixels.data(), 640, 480}, {0, 2, 0});  // from here on there is a channel
  std::thread publisher([&] {
    // Until somebody has come and gone.
    eventually([&] { return server.watched(); });
    std::uint64_t time = 0;
    eventually([&] {
      auto next = std::make_shared<stream::EncodedFrame>(*frame);
      next->times.captured = static_cast<std::int64_t>(++time <= 1 ? 1 : 2);
      server.publish(next);
      server.publishImage(0, {pixels.data(), 640, 480}, {0, 2, 0});
      return !server.watched();
    });
  });
  const int code =
      std::system(("NODE_PATH='" + modules +
                   "' node " FUSE_FLOW_TEST_SOURCE_DIR "/test/apps/stream/foxglove/subscribe.cjs ws://127.0.0.1:" +
                   std::to_string(server.port()) + "/ > " + said + " 2> " + log)
                      .c_str());
  publisher.join();
  const auto textOf = [&](const char* name) {
    std::ifstream file(folder / name);
    return std::string((std::istreambuf_iterator<char>(file)), {});
  };
  EXPECT_EQ(code, 0) << textOf("log");
  PackedPoint sum{};
  for (const PackedPoint& point : packedPointsOf(stream::messageOf(frame).joined()))
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += point[k];
  char sums[400];
  std::snprintf(sums, sizeof(sums), "%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f", sum[0], sum[1], sum[2], sum[3],
                sum[4], sum[5], sum[6], sum[7], sum[8]);
  EXPECT_EQ(textOf("said"),
            "server wall, 0 capabilities\n"
            "/cameras/left/calibration foxglove.CameraCalibration left 640x480 525,0,320,0,526,240,0,0,1\n"
            "/cameras/left/image foxglove.CompressedImage 2 left jpeg ffd8..ffd9\n"
            "/cameras/right/calibration foxglove.CameraCalibration right 640x480 525,0,320,0,526,240,0,0,1\n"
            "/points foxglove.PointCloud 2 room 800 x:0:FLOAT32,y:4:FLOAT32,z:8:FLOAT32,red:12:UINT8,green:13:UINT8,"
            "blue:14:UINT8,alpha:15:UINT8,confidence:16:UINT8,view_count:17:UINT8 " +
                std::string(sums) +
                "\n"
                "/tf foxglove.FrameTransforms room>left:1:0.707,room>right:-1:1.000\n");
  std::filesystem::remove_all(folder);
}

TEST(Foxglove, AServerMayEndWhileACloudIsMade) {
  const auto frame = frameOf(60'000, 1);
  for (int k = 0; k < 60; ++k) {
    auto server = std::make_unique<Server>(anyPort());
    auto client = std::make_unique<FoxgloveClient>(server->port());
    client->channels();
    client->subscribe(1, 1);
    client->answerToUnknown();
    server->publish(frame);
    std::this_thread::sleep_for(std::chrono::microseconds(100 * k));
    client.reset();
    server.reset();
  }
}

TEST(Foxglove, AServerThatEndsSaysSo) {
  auto server = std::make_unique<Server>(anyPort());
  FoxgloveClient client(server->port());
  client.channels();
  client.subscribe(1, 1);
  server->publish(largeFrame());
  std::thread reader([&] { EXPECT_EQ(client.closeCode(), 1001); });
  server.reset();
  reader.join();
}

}  // namespace
