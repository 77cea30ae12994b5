#include "raw_socket.h"
#include "streams.h"

#include <gtest/gtest.h>

#include <openssl/evp.h>

#include <functional>
#include <thread>

namespace {

using namespace fuse_flow;
using namespace fuse_flow::test;
using stream::Client;
using stream::ClientOptions;
using stream::ReceivedFrame;
using stream::Server;

/** \brief What the header Sec-WebSocket-Accept has to be, RFC 6455. */
std::string acceptOf(const std::string& request) {
  const std::string name = "Sec-WebSocket-Key: ";
  const std::size_t at = request.find(name) + name.size();
  const std::string text = request.substr(at, request.find("\r\n", at) - at) + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
  unsigned char digest[EVP_MAX_MD_SIZE], base64[64];
  unsigned int size = 0;
  EVP_Digest(text.data(), text.size(), digest, &size, EVP_sha1(), nullptr);
  const int length = EVP_EncodeBlock(base64, digest, static_cast<int>(size));
  return std::string(base64, base64 + length);
}

std::string welcome(const std::string& request, const std::string& more = "Sec-WebSocket-Protocol: fuse_flow.v1\r\n") {
  return "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: " +
         acceptOf(request) + "\r\n" + more + "\r\n";
}

std::string frameMessage(std::uint64_t number) {
  const std::vector<std::uint8_t> bytes = stream::messageOf(frameOf(100, number)).joined();
  return {bytes.begin(), bytes.end()};
}

/** \brief A server that sends what a test says, and nothing that it should. */
class HostileServer {
 public:
  /** \param play for each connection, with the client's request */
  explicit HostileServer(std::function<void(RawSocket&, const std::string& request)> play)
      : play_(std::move(play)), thread_([this] {
          while (!over_) {
            RawSocket socket = listener_.accept();
            if (over_) return;
            ++connections;
            try {
              play_(socket, socket.until("\r\n\r\n"));
            } catch (const std::exception&) {  // the client has left
            }
          }
        }) {}
  ~HostileServer() {
    over_ = true;
    try {
      RawSocket::to(listener_.port());
    } catch (const std::exception&) {
    }
    thread_.join();
  }
  std::string link() const { return listener_.link(); }
  std::atomic<int> connections{0};

 private:
  RawListener listener_;
  std::function<void(RawSocket&, const std::string&)> play_;
  std::atomic<bool> over_{false};
  std::thread thread_;
};

ClientOptions once() {
  ClientOptions options = patient();
  options.reconnect = false;
  return options;
}

/** \brief The error that a client ends with. */
std::string errorOf(const std::function<void(RawSocket&, const std::string&)>& play, ClientOptions options = once()) {
  const HostileServer server(play);
  Client client(server.link(), options);
  ReceivedFrame frame;
  EXPECT_TRUE(eventually([&] {
    while (client.pull(frame, std::chrono::milliseconds(10))) {
    }
    return client.status().ended;
  }));
  EXPECT_FALSE(client.status().connected);
  const std::string error = client.status().error;
  EXPECT_EQ(error.find('\n'), std::string::npos);
  for (const char c : error) EXPECT_TRUE(static_cast<unsigned char>(c) >= ' ') << error;
  return error;
}

::testing::AssertionResult has(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "'" << text << "' has no '" << part << "'";
}

TEST(StreamClient, ASlowReaderGetsTheNewestFrameAndTheOthersAreCounted) {
  Server server(anyPort());
  Client client(server.link(), patient());
  ASSERT_TRUE(eventually([&] { return server.watched(); }));
  for (std::uint64_t number = 0; number < 10; ++number) {
    server.publish(frameOf(10, number));
    ASSERT_TRUE(eventually([&] { return client.status().frames == number + 1; }));
  }
  ReceivedFrame frame;
  ASSERT_TRUE(client.pull(frame, kLong));
  EXPECT_EQ(frame.times.number, 9u);
  EXPECT_GT(frame.arrived, 1'000'000'000'000'000'000);
  EXPECT_EQ(client.status().dropped, 9u);
  EXPECT_FALSE(client.pull(frame, std::chrono::milliseconds(1)));
}

TEST(StreamClient, ComesBackWhenTheServerDoes) {
  stream::ServerOptions options = anyPort();
  auto server = std::make_unique<Server>(options);
  options.port = server->port();
  ClientOptions client_options = patient();
  client_options.wishes.points = 50;
  Client client(server->link(), client_options);
  ReceivedFrame frame;
  server->publish(frameOf(100, 1));
  ASSERT_TRUE(client.pull(frame, kLong));
  server.reset();
  ASSERT_TRUE(eventually([&] { return !client.status().connected; }));
  EXPECT_TRUE(has(client.status().error, "the server has ended"));
  EXPECT_FALSE(client.status().ended);
  EXPECT_FALSE(client.pull(frame, std::chrono::milliseconds(300)));
  server = std::make_unique<Server>(options);
  server->publish(frameOf(4000, 2));
  ASSERT_TRUE(client.pull(frame, kLong));
  EXPECT_EQ(frame.times.number, 2u);
  EXPECT_EQ(client.status().connections, 2u);
  EXPECT_EQ(client.status().error, "");
  const std::vector<std::string> notices = client.takeNotices();
  EXPECT_TRUE(anyHas(notices, "the server has ended"));
  EXPECT_TRUE(anyHas(notices, "connected again"));
  // Its wishes have come back with it.
  stream::StreamedCloud cloud;
  for (std::uint64_t number = 3;; ++number) {
    server->publish(frameOf(4000, number));
    ASSERT_TRUE(client.pull(cloud, kLong));
    if (cloud.size() <= 50) break;
  }
}

TEST(StreamClient, WaitsForAServerThatIsNotThereYet) {
  std::uint16_t port = 0;
  {
    const RawListener listener;
    port = listener.port();
  }
  Client client("ws://127.0.0.1:" + std::to_string(port), patient());
  ASSERT_TRUE(eventually([&] { return !client.status().error.empty(); }));
  EXPECT_TRUE(has(client.status().error, "127.0.0.1:" + std::to_string(port) + ": cannot be connected to"));
  stream::ServerOptions options = anyPort();
  options.port = port;
  Server server(options);
  server.publish(frameOf(10, 1));
  ReceivedFrame frame;
  EXPECT_TRUE(client.pull(frame, kLong));
}

TEST(StreamClient, WithAWrongTokenItEnds) {
  stream::ServerOptions options = anyPort();
  options.token = "0123456789abcdef";
  Server server(options);
  ClientOptions wrong = patient();
  wrong.token = "0123456789abcdeX";
  Client client(server.link(), wrong);
  ReceivedFrame frame;
  EXPECT_FALSE(client.pull(frame, kLong));
  EXPECT_TRUE(client.status().ended);
  EXPECT_TRUE(has(client.status().error, "token"));
  EXPECT_FALSE(has(client.status().error, "abcde"));
}

TEST(StreamClient, OptionsThatAreWrongAreNamed) {
  const auto refused = [](const std::string& named, const std::string& link, const auto& change) {
    ClientOptions options = patient();
    change(options);
    try {
      const Client client(link, options);
      ADD_FAILURE() << named;
    } catch (const std::invalid_argument& error) {
      EXPECT_TRUE(has(error.what(), named)) << error.what();
    }
  };
  const std::string link = "ws://127.0.0.1:1";
  refused("link", "127.0.0.1", [](auto&) {});
  refused("token", link, [](auto& options) { options.token = "a\r\nX: y"; });
  refused("most_bytes", link, [](auto& options) { options.most_bytes = 0; });
  refused("connect_time", link, [](auto& options) { options.connect_time = std::chrono::seconds(0); });
  refused("silence", link, [](auto& options) { options.silence = std::chrono::seconds(-1); });
  refused("step", link, [](auto& options) { options.wishes.step = -1; });
  ClientOptions options;
  options.certificate_authority = "/nowhere.pem";
  EXPECT_THROW(Client("wss://127.0.0.1:1", options), std::runtime_error);
  Client client(link, patient());
  stream::Wishes wishes;
  wishes.step = 0;
  EXPECT_THROW(client.wish(wishes), std::invalid_argument);
}

TEST(StreamClient, EndsQuicklyWhateverItIsDoing) {
  const auto begin = std::chrono::steady_clock::now();
  { const Client nobody("ws://127.0.0.1:1", patient()); }
  {
    RawListener silent;
    const Client waiting(silent.link(), patient());
    RawSocket socket = silent.accept();
  }
  {
    const HostileServer stuck([](RawSocket& socket, const std::string& request) {
      socket.send(welcome(request) + webSocketFrame(kBinary, std::string(5'000'000, 'x'), false).substr(0, 1'000'000));
      socket.all();
    });
    const Client client(stuck.link(), patient());
    EXPECT_TRUE(eventually([&] { return client.status().connected; }));
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
}

TEST(StreamClient, AnswersThatAreNoStreamEndIt) {
  EXPECT_TRUE(has(errorOf([](RawSocket& socket, const std::string&) { socket.send("nonsense\r\n\r\n"); }),
                  "no server of streams"));
  EXPECT_TRUE(has(errorOf([](RawSocket& socket, const std::string&) {
                    socket.send("HTTP/1.1 302 Found\r\nLocation: http://127.0.0.1:1/\r\nContent-Length: 0\r\n\r\n");
                  }),
                  "HTTP 302"));
  EXPECT_TRUE(has(errorOf([](RawSocket& socket, const std::string&) {
                    socket.send("HTTP/1.1 200 OK\r\nContent-Length: 4\r\n\r\npage");
                  }),
                  "HTTP 200"));
  EXPECT_TRUE(has(errorOf([](RawSocket& socket, const std::string& request) { socket.send(welcome(request, "")); }),
                  "does not speak fuse_flow.v1"));
  EXPECT_TRUE(has(errorOf([](RawSocket& socket, const std::string& request) {
                    socket.send(welcome(request, "Sec-WebSocket-Protocol: other\r\n"));
                  }),
                  "does not speak fuse_flow.v1"));
  EXPECT_TRUE(has(errorOf([](RawSocket& socket, const std::string& request) {
                    std::string answer = welcome(request);
                    answer[answer.find("Accept: ") + 8] ^= 1;
                    socket.send(answer);
                  }),
                  "no server of streams"));
  EXPECT_TRUE(has(errorOf([](RawSocket& socket, const std::string&) {
                    socket.send("HTTP/1.1 101 Switching Protocols\r\n");
                    while (socket.send("X: " + std::string(1000, 'x') + "\r\n")) {
                    }
                  }),
                  "no server of streams"));
  ClientOptions hasty = once();
  hasty.connect_time = std::chrono::milliseconds(200);
  EXPECT_FALSE(errorOf([](RawSocket& socket, const std::string&) { socket.all(); }, hasty).empty());
  EXPECT_FALSE(errorOf(
                   [](RawSocket& socket, const std::string&) {
                     while (socket.send("H")) ::usleep(10'000);
                   },
                   hasty)
                   .empty());
}

TEST(StreamClient, MessagesThatAreNoStreamEndIt) {
  const auto after = [](const std::string& bytes, ClientOptions options = once()) {
    options.silence =
        std::min<std::chrono::milliseconds>(options.silence, std::chrono::seconds(2));  // who does not hang up
    return errorOf(
        [bytes](RawSocket& socket, const std::string& request) {
          socket.send(welcome(request) + bytes);
          socket.all();
        },
        options);
  };
  for (const std::string text : {"", "x", "{}", R"({"type":"stream"})", R"({"type":"stream","version":2})"})
    EXPECT_TRUE(has(after(webSocketFrame(kText, text, false)), "no stream")) << text;
  EXPECT_TRUE(has(after(webSocketFrame(kText, std::string(5 << 20, ' '), false)), "no stream"));
  EXPECT_TRUE(has(after(webSocketFrame(kBinary, "FFC1", false)), "no stream"));
  EXPECT_TRUE(has(after(webSocketFrame(kBinary, std::string(88, 'x'), false)), "no stream"));
  EXPECT_TRUE(has(after(webSocketFrame(kBinary, "", false)), "no stream"));
  ClientOptions small = once();
  small.most_bytes = 2000;
  EXPECT_TRUE(has(after(webSocketFrame(kBinary, std::string(2001, 'x'), false), small), "more than 2000 bytes"));
  EXPECT_TRUE(has(after(std::string("\x82\x7f\x7f\xff\xff\xff\xff\xff\xff\xff", 10)), "more than"));
  EXPECT_FALSE(after(webSocketFrame(kBinary, frameMessage(1), true)).empty());  // a server does not mask
  EXPECT_FALSE(after(webSocketFrame(5, "x", false)).empty());
  EXPECT_FALSE(after(webSocketFrame(kContinuation, "x", false)).empty());
  EXPECT_TRUE(has(after(webSocketFrame(kClose, std::string("\x03\xf0\x1b[31m\n", 8), false)), "1008"));
  ClientOptions hasty = once();
  hasty.silence = std::chrono::milliseconds(200);
  EXPECT_TRUE(has(after("", hasty), "silent"));
}

TEST(StreamClient, AServerThatTakesNoAnswersOrFloodsDoesNotFillIt) {
  // Frames without end, and nothing is read: the answers find no room.
  const std::string message = webSocketFrame(kBinary, frameMessage(1), false);
  HostileServer server([&](RawSocket& socket, const std::string& request) {
    socket.send(welcome(request));
    for (int k = 0; k < 200'000 && socket.send(message); ++k) {
    }
  });
  Client client(server.link(), once());
  ASSERT_TRUE(eventually([&] { return client.status().ended; }, std::chrono::seconds(60)));
  EXPECT_GT(client.status().frames, 10u);
}

TEST(StreamClient, AFrameThatIsDamagedIsCountedAndTheNextOneComes) {
  std::string damaged = frameMessage(1);
  damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 1);
  std::atomic<bool> pulled{false};
  HostileServer server([&](RawSocket& socket, const std::string& request) {
    socket.send(welcome(request) + webSocketFrame(kBinary, damaged, false));
    while (!pulled) ::usleep(1000);
    socket.send(webSocketFrame(kBinary, frameMessage(2), false));
    socket.all();
  });
  Client client(server.link(), patient());
  std::thread next([&] {
    eventually([&] { return client.status().damaged == 1; });
    pulled = true;
  });
  stream::StreamedCloud cloud;
  EXPECT_TRUE(client.pull(cloud, kLong));
  next.join();
  EXPECT_EQ(cloud.times.number, 2u);
  EXPECT_EQ(client.status().damaged, 1u);
  EXPECT_TRUE(anyHas(client.takeNotices(), "frame 1 is damaged"));
}

TEST(StreamClient, WhoMisbehavesIsAskedLessAndLessOften) {
  HostileServer server([](RawSocket& socket, const std::string& request) { socket.send(welcome(request) + "\xff"); });
  Client client(server.link(), patient());
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  EXPECT_LE(server.connections, 4);  // at 0, 0.2, 0.6, 1.4 s
  EXPECT_GE(server.connections, 1);
}

}  // namespace
