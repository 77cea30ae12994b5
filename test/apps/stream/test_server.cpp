#include "raw_socket.h"
#include "streams.h"

#include <gtest/gtest.h>
#include <pcl/point_types.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <thread>

namespace {

using namespace fuse_flow;
using namespace fuse_flow::test;
using stream::Client;
using stream::ReceivedFrame;
using stream::Server;
using stream::StreamedCloud;

/** \brief Publishes frames one after the other until the test is over. */
class Publisher {
 public:
  Publisher(Server& server, std::size_t points, std::chrono::milliseconds every)
      : thread_([this, &server, points, every] {
          std::vector<std::shared_ptr<const stream::EncodedFrame>> frames;
          for (std::uint64_t k = 0; k < 4; ++k) frames.push_back(frameOf(points, k));
          for (std::uint64_t number = 0; !over_; ++number) {
            auto frame = std::make_shared<stream::EncodedFrame>(*frames[number % frames.size()]);
            frame->times.number = number;
            newest = number;
            server.publish(frame);
            std::this_thread::sleep_for(every);
          }
        }) {}
  ~Publisher() {
    over_ = true;
    thread_.join();
  }
  std::atomic<std::uint64_t> newest{0};

 private:
  std::atomic<bool> over_{false};
  std::thread thread_;
};

TEST(StreamServer, TwoClientsGetEachFrameByteByByte) {
  Server server(anyPort());
  stream::Description description;
  description.name = "wall";
  description.cameras.resize(1);
  description.cameras[0].name = "left";
  description.cameras[0].intrinsics = {640, 480, 525, 525, 320, 240, {}};
  server.describe(description);
  Client one(server.link(), patient()), two("ws://localhost:" + std::to_string(server.port()), patient());
  ASSERT_TRUE(eventually([&] { return server.status().clients.size() == 2; }));
  for (std::uint64_t number = 0; number < 20; ++number) {
    const auto frame = frameOf(20'000, number);
    server.publish(frame);
    for (Client* client : {&one, &two}) {
      ReceivedFrame received;
      ASSERT_TRUE(client->pull(received, kLong));
      EXPECT_EQ(received.message, stream::messageOf(frame).joined());
      EXPECT_EQ(received.times.number, number);
      EXPECT_EQ(received.times.captured, 5);
      EXPECT_EQ(received.times.encoded, 7);
      EXPECT_EQ(received.description->name, "wall");
      ASSERT_EQ(received.description->cameras.size(), 1u);
      EXPECT_EQ(received.description->cameras[0].name, "left");
    }
  }
  ASSERT_TRUE(eventually([&] {
    const stream::ServerStatus status = server.status();
    return status.clients.size() == 2 && status.clients[0].frames == 20 && status.clients[1].frames == 20;
  }));
  const stream::ServerStatus status = server.status();
  EXPECT_EQ(status.published, 20u);
  EXPECT_EQ(status.connections, 2u);
  EXPECT_EQ(status.clients[0].subprotocol, "fuse_flow.v1");
  EXPECT_EQ(status.clients[0].replaced, 0u);
  EXPECT_EQ(status.clients[0].points, 20'000u);
  EXPECT_GT(status.clients[0].round_trip, 0);
  EXPECT_EQ(one.status().frames, 20u);
  EXPECT_EQ(one.status().dropped, 0u);
  EXPECT_TRUE(server.takeNotices().empty());
}

TEST(StreamServer, CloudsAreEncodedForWhoeverIsThere) {
  Server server(anyPort());
  const auto cloud = wall();
  EXPECT_FALSE(server.watched());
  server.publish(cloud, {1, 2, 0});
  for (std::uint64_t k = 2; k < 5; ++k) server.publish(cloud, {k, 2, 0});
  EXPECT_LE(server.status().encoded, 3u);  // one a second, for who comes next
  EXPECT_GE(server.status().encoded, 1u);
  Client client(server.link(), patient());
  StreamedCloud streamed;
  ASSERT_TRUE(client.pull(streamed, kLong));  // at once
  EXPECT_EQ(streamed.size(), cloud.size());
  EXPECT_EQ(streamed.times.captured, 2);
  EXPECT_GT(streamed.times.encoded, 1'000'000'000);
  EXPECT_TRUE(server.watched());
  server.publish(cloud, {9, 2, 3});
  // The first one may come again before: as the client's wishes want it, which were on their way.
  do {
    ASSERT_TRUE(client.pull(streamed, kLong));
  } while (streamed.times.number == 1);
  EXPECT_EQ(streamed.times.number, 9u);
  EXPECT_EQ(streamed.times.encoded, 3);
}

TEST(StreamServer, ADescriptionThatChangesComesBeforeTheNextFrame) {
  Server server(anyPort());
  Client client(server.link(), patient());
  for (const std::string name : {"first", "second"}) {
    stream::Description description;
    description.name = name;
    server.describe(description);
    server.publish(frameOf(10, 0));
    ReceivedFrame received;
    ASSERT_TRUE(client.pull(received, kLong));
    EXPECT_EQ(received.description->name, name);
  }
  EXPECT_EQ(client.description().name, "second");
}

TEST(StreamServer, ASlowClientGetsTheNewestFramesAndHoldsUpNobody) {
  Server server(anyPort());
  RawWebSocket slow(server.port());
  Client fast(server.link(), patient());
  slow.next(kText);
  const Publisher publisher(server, 20'000, std::chrono::milliseconds(2));
  const std::string unanswered = slow.next(kBinary).payload;
  ReceivedFrame received;
  std::uint64_t last = 0;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(fast.pull(received, kLong));
    EXPECT_GE(received.times.number, last);
    last = received.times.number;
  }
  // One frame, then none until it is answered; then the newest.
  std::uint64_t number;
  std::memcpy(&number, unanswered.data() + 8, sizeof(number));
  slow.send(kText, R"({"type":"got","frame":)" + std::to_string(number) + "}");
  const std::string frame = slow.nextFrame();
  std::memcpy(&number, frame.data() + 8, sizeof(number));
  EXPECT_GE(number + 2, last);
}

TEST(StreamServer, PointsThatAreTooFarAreCountedInOneNotice) {
  Server server(anyPort());
  pcl::PointCloud<pcl::PointXYZ> cloud;
  for (int i = 0; i < 100; ++i) cloud.push_back({0.01f * static_cast<float>(i), 0, 0});
  cloud.push_back({5000, 0, 0});
  cloud.push_back({std::numeric_limits<float>::quiet_NaN(), 0, 0});  // nowhere: nothing to say
  server.publish(cloud, {7, 0, 0});
  const std::vector<std::string> notices = server.takeNotices();
  ASSERT_EQ(notices.size(), 1u);
  EXPECT_NE(notices[0].find("1 of 101 points of frame 7"), std::string::npos) << notices[0];
  EXPECT_NE(notices[0].find("1049 m"), std::string::npos) << notices[0];
}

TEST(StreamServer, AtMostTwoFramesAreUnanswered) {
  Server server(anyPort());
  RawWebSocket client(server.port());
  const Publisher publisher(server, 1000, std::chrono::milliseconds(1));
  client.nextFrame();  // the first, alone
  client.next(kBinary);
  client.next(kBinary);
  client.send(kPing, "a");
  for (;;) {  // nothing but pings until the pong
    const RawWebSocket::Frame frame = client.read();
    ASSERT_NE(frame.opcode, kBinary);
    if (frame.opcode == kPong) break;
  }
}

TEST(StreamServer, WhoTakesFewBytesGetsFewerPointsAtTheRateOfFrames) {
  Server server(anyPort());
  stream::ClientOptions options = patient();
  options.wishes.bytes_per_second = 1'000'000;
  Client client(server.link(), options);
  const Publisher publisher(server, 100'000, std::chrono::milliseconds(50));
  StreamedCloud cloud;
  ASSERT_TRUE(eventually([&] { return client.pull(cloud, kLong) && cloud.size() < 100'000; }));
  for (int k = 0; k < 10; ++k) {
    ASSERT_TRUE(client.pull(cloud, kLong));
    EXPECT_LT(cloud.size(), 80'000u);
    EXPECT_GT(cloud.size(), 1000u);
    EXPECT_EQ(cloud.points_of_frame, 100'000u);
  }
}

TEST(StreamServer, WishesChangeWhatArrives) {
  Server server(anyPort());
  Client client(server.link(), patient());
  server.publish(frameOf(100'000, 0));
  StreamedCloud cloud;
  ASSERT_TRUE(client.pull(cloud, kLong));
  EXPECT_EQ(cloud.size(), 100'000u);

  stream::Wishes wishes;
  wishes.points = 10'000;
  client.wish(wishes);  // the frame that stands comes again, with what is wished for
  ASSERT_TRUE(client.pull(cloud, kLong));
  EXPECT_LE(cloud.size(), 10'000u);
  EXPECT_GT(cloud.size(), 1000u);

  wishes = {};
  wishes.region = {{0, 0, 0}, {0.5, 2, 0.5}};
  client.wish(wishes);
  ASSERT_TRUE(client.pull(cloud, kLong));
  EXPECT_LT(cloud.size(), 20'000u);
  EXPECT_GE(cloud.size(), 2500u);

  wishes = {};
  wishes.points = 30'000;
  wishes.viewpoint = {{0, 1, 0}};
  client.wish(wishes);
  ASSERT_TRUE(client.pull(cloud, kLong));
  EXPECT_LE(cloud.size(), 30'000u);
  // Density near the viewpoint and far from it.
  std::size_t near = 0, far = 0;
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    near += cloud.positions[3 * k] < 0.5f && cloud.positions[3 * k + 2] < 0.5f;
    far += cloud.positions[3 * k] > 3.5f && cloud.positions[3 * k + 2] > 2.0f;
  }
  EXPECT_GT(near, 2 * far);
}

TEST(StreamServer, ACoarserStepIsEncodedOnceForAllWhoWantIt) {
  stream::ServerOptions options = anyPort();
  options.encoding.step = 0.001;
  options.encoding.threads = 1;
  Server server(options);
  const auto cloud = wall();
  stream::ClientOptions coarse = patient();
  coarse.wishes.step = 0.0045;  // 0.004 is the coarsest that is not coarser
  Client fine(server.link(), patient()), one(server.link(), coarse), two(server.link(), coarse);
  const auto steps = [&] {
    server.publish(cloud, {0, 0, 0});
    std::array<double, 3> each{};
    StreamedCloud streamed;
    if (fine.pull(streamed, kLong)) each[0] = streamed.step;
    if (one.pull(streamed, kLong)) each[1] = streamed.step;
    if (two.pull(streamed, kLong)) each[2] = streamed.step;
    return each;
  };
  ASSERT_TRUE(eventually([&] { return server.status().clients.size() == 3; }));
  ASSERT_TRUE(eventually([&] { return steps() == std::array<double, 3>{0.001, 0.004, 0.004}; }));
  const std::uint64_t encoded = server.status().encoded;
  EXPECT_EQ(steps(), (std::array<double, 3>{0.001, 0.004, 0.004}));
  EXPECT_EQ(server.status().encoded, encoded + 2);
}

TEST(StreamServer, ACoarserStepOfEncodedFramesIsSaidNotToBe) {
  Server server(anyPort());
  server.publish(frameOf(100, 0));
  stream::ClientOptions options = patient();
  options.wishes.step = 1;
  Client client(server.link(), options);
  StreamedCloud cloud;
  ASSERT_TRUE(client.pull(cloud, kLong));
  EXPECT_EQ(cloud.step, 0.001);
  ASSERT_TRUE(eventually([&] { return anyHas(server.takeNotices(), "coarser step"); }));
}

TEST(StreamServer, APictureThatStandsBecomesComplete) {
  Server server(anyPort());
  stream::ClientOptions options = patient();
  options.wishes.bytes_per_second = 200'000;
  Client client(server.link(), options);
  server.publish(frameOf(100'000, 0));
  StreamedCloud cloud;
  ASSERT_TRUE(client.pull(cloud, kLong));
  EXPECT_LT(cloud.size(), 100'000u);
  ASSERT_TRUE(eventually([&] { return client.pull(cloud, kLong) && cloud.size() == 100'000; }));
}

TEST(StreamServer, EndsQuicklyWithClientsThatAreStuck) {
  auto server = std::make_unique<Server>(anyPort());
  std::vector<RawSocket> idle;
  for (int k = 0; k < 5; ++k) idle.push_back(RawSocket::to(server->port()));
  std::vector<RawWebSocket> stuck;
  for (int k = 0; k < 5; ++k) stuck.emplace_back(server->port());
  RawWebSocket good(server->port());
  for (std::uint64_t k = 0; k < 3; ++k) server->publish(frameOf(100'000, k));
  good.next(kBinary);
  const auto before = std::chrono::steady_clock::now();
  server.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(10));
  EXPECT_EQ(good.closeCode(), 1001);
}

TEST(StreamServer, ManyThreadsMayUseIt) {
  stream::ServerOptions options = anyPort();
  options.threads = 3;
  options.encoding.threads = 1;
  Server server(options);
  std::atomic<bool> over{false}, clients_over{false};
  std::vector<std::thread> threads, clients;
  const auto cloud = [] {
    auto small = wall();
    small.resize(2000);
    return small;
  }();
  threads.emplace_back([&] {
    for (std::uint64_t k = 0; !over; ++k) server.publish(cloud, {k, 0, 0});
  });
  threads.emplace_back([&] {
    const auto frame = frameOf(500, 0);
    while (!over) server.publish(frame);
  });
  threads.emplace_back([&] {
    while (!over) {
      server.describe({});
      server.serve("/a", {"text/plain", "a", ""});
      server.status();
      server.takeNotices();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  for (int k = 0; k < 3; ++k)
    clients.emplace_back([&] {
      while (!clients_over) {
        Client client(server.link(), patient());
        StreamedCloud got;
        for (int frame = 0; frame < 3; ++frame) EXPECT_TRUE(client.pull(got, kLong));
        stream::Wishes wishes;
        wishes.step = 0.002;
        client.wish(wishes);
        EXPECT_TRUE(client.pull(got, kLong));
      }
    });
  std::this_thread::sleep_for(std::chrono::seconds(1));
  clients_over = true;
  for (std::thread& thread : clients) thread.join();
  over = true;
  for (std::thread& thread : threads) thread.join();
}

TEST(StreamServer, OptionsThatAreWrongAreNamed) {
  const auto refused = [](const std::string& named, const auto& change) {
    stream::ServerOptions options = anyPort();
    change(options);
    try {
      const Server server(options);
      ADD_FAILURE() << named;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
    }
  };
  refused("address", [](auto& options) { options.address = "0.0.0.0"; });
  refused("address", [](auto& options) { options.address = "::"; });
  refused("address", [](auto& options) { options.address = "192.168.1.7"; });
  refused("address", [](auto& options) { options.address = "camera-room"; });
  refused("token", [](auto& options) { options.token = "short"; });
  refused("token", [](auto& options) { options.token = "with spaces and so on"; });
  refused("key", [](auto& options) { options.certificate = "a.pem"; });
  refused("threads", [](auto& options) { options.threads = 0; });
  refused("clients", [](auto& options) { options.clients = 0; });
  refused("connections", [](auto& options) { options.connections = options.clients - 1; });
  refused("header_bytes", [](auto& options) { options.header_bytes = 10; });
  refused("step", [](auto& options) { options.encoding.step = -1; });
}

TEST(StreamServer, APortThatIsTakenIsSaid) {
  const Server server(anyPort());
  stream::ServerOptions options = anyPort();
  options.port = server.port();
  try {
    const Server second(options);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("127.0.0.1:" + std::to_string(server.port())), std::string::npos);
  }
}

TEST(StreamServer, IsThereForOthersWithAToken) {
  stream::ServerOptions options = anyPort();
  options.address = "0.0.0.0";
  options.token = "0123456789abcdef";
  Server server(options);
  EXPECT_NE(server.link().find("/?token=0123456789abcdef"), std::string::npos);
  EXPECT_EQ(server.link().find("0.0.0.0"), std::string::npos);
  ASSERT_EQ(server.warnings().size(), 1u);
  EXPECT_NE(server.warnings()[0].find("not encrypted"), std::string::npos);
  Client client(server.link(), patient());
  server.publish(frameOf(100, 1));
  ReceivedFrame received;
  EXPECT_TRUE(client.pull(received, kLong));
}

TEST(StreamServer, AnotherImplementationsClientGetsFrames) {
  if (std::system("/usr/bin/env python3 -c 'import websockets' 2>/dev/null") != 0 &&
      std::system("/usr/bin/python3 -c 'import websockets' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3-websockets is not there";
  const std::string python = std::system("/usr/bin/env python3 -c 'import websockets' 2>/dev/null") == 0
                                 ? "/usr/bin/env python3"
                                 : "/usr/bin/python3";
  stream::ServerOptions options = anyPort();
  options.token = "0123456789abcdef";
  Server server(options);
  const auto frame = frameOf(50'000, 0);
  const Publisher publisher(server, 50'000, std::chrono::milliseconds(10));
  const std::string command = python +
                              " " FUSE_FLOW_TEST_SOURCE_DIR "/test/apps/stream/other_client.py ws://127.0.0.1:" +
                              std::to_string(server.port()) + "/stream 0123456789abcdef 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string output;
  for (std::array<char, 256> line; fgets(line.data(), line.size(), pipe) != nullptr;) output += line.data();
  EXPECT_EQ(pclose(pipe), 0) << output;
  EXPECT_NE(output.find("10 frames of 50000 points"), std::string::npos) << output;
}

}  // namespace
