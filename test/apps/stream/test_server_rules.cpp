#include "raw_socket.h"
#include "streams.h"

#include <gtest/gtest.h>

#include <sys/resource.h>

#include <ctime>
#include <fstream>
#include <thread>

// What clients do that mean no good, or know no better.

namespace {

using namespace fuse_flow;
using namespace fuse_flow::test;
using stream::Server;

const std::string kSecret = "0123456789abcdef";

/** \brief The whole answer to what is sent, after which the server hangs up or is asked to. */
std::string answerTo(const Server& server, const std::string& request) {
  RawSocket socket = RawSocket::to(server.port());
  socket.send(request);
  return socket.all();
}

std::string get(const std::string& target, const std::string& headers = "Host: localhost\r\n",
                const std::string& method = "GET") {
  return method + " " + target + " HTTP/1.1\r\n" + headers + "Connection: close\r\n\r\n";
}

/** \brief The status that a request for a stream gets; 101 is a stream. */
int statusFor(const Server& server, const std::string& headers, const std::string& target = "/stream",
              const std::string& subprotocol = "fuse_flow.v1") {
  RawSocket socket = RawSocket::to(server.port());
  socket.send(streamRequest(server.port(), headers, target, subprotocol));
  return statusOf(socket.until("\r\n\r\n"));
}

/** \brief A request for a stream whose header Host is another one. */
int statusForHost(const Server& server, const std::string& host, const std::string& headers = "") {
  std::string request = streamRequest(server.port(), headers);
  const std::string ours = "127.0.0.1:" + std::to_string(server.port());
  request.replace(request.find(ours), ours.size(), host);
  RawSocket socket = RawSocket::to(server.port());
  socket.send(request);
  return statusOf(socket.until("\r\n\r\n"));
}

/** \brief The server lives, and streams. */
void expectServes(Server& server) {
  stream::ClientOptions options = patient();
  stream::Client client(server.link(), options);
  server.publish(frameOf(100, 77));
  stream::ReceivedFrame frame;
  EXPECT_TRUE(client.pull(frame, kLong));
}

TEST(StreamServerAccess, WithoutTheTokenNobodyGetsAStream) {
  stream::ServerOptions options = anyPort();
  options.token = kSecret;
  Server server(options);
  EXPECT_EQ(statusFor(server, ""), 401);
  EXPECT_EQ(statusFor(server, "Authorization: Bearer 0123456789abcdeX\r\n"), 401);
  EXPECT_EQ(statusFor(server, "", "/stream?token=0123456789abcde"), 401);
  EXPECT_EQ(statusFor(server, "", "/stream?token="), 401);
  EXPECT_EQ(statusFor(server, "Authorization: Bearer " + kSecret + "\r\n"), 101);
  EXPECT_EQ(statusFor(server, "", "/stream?token=" + kSecret), 101);
  EXPECT_EQ(server.status().refused, 4u);
  const std::vector<std::string> notices = server.takeNotices();
  EXPECT_TRUE(anyHas(notices, "token is missing or wrong"));
  EXPECT_FALSE(anyHas(notices, "0123456789abc"));
}

TEST(StreamServerAccess, PagesOfOthersAreRefused) {
  Server server(anyPort());
  const std::string ours = "127.0.0.1:" + std::to_string(server.port());
  EXPECT_EQ(statusFor(server, "Origin: http://" + ours + "\r\n"), 101);
  EXPECT_EQ(statusFor(server, "Origin: http://evil.example\r\n"), 403);
  EXPECT_EQ(statusFor(server, "Origin: null\r\n"), 403);
  EXPECT_EQ(statusFor(server, "Origin: http://127.0.0.1:1\r\n"), 403);
  EXPECT_EQ(statusFor(server, "Origin: http://" + ours + "\r\nOrigin: http://evil.example\r\n"), 400);
  EXPECT_TRUE(anyHas(server.takeNotices(), "'http://evil.example'"));
  stream::ServerOptions options = anyPort();
  options.allowed_origins = {"https://viewer.example"};
  const Server other(options);
  EXPECT_EQ(statusFor(other, "Origin: https://viewer.example\r\n"), 101);
}

TEST(StreamServerAccess, ANameThatWasMadeToLeadHereIsRefused) {
  stream::ServerOptions options = anyPort();
  options.allowed_hosts = {"fusion.local"};
  Server server(options);
  server.serve("/", {"text/html", "page", ""});
  EXPECT_EQ(statusForHost(server, "evil.example", "Origin: http://evil.example\r\n"), 403);
  EXPECT_EQ(statusForHost(server, "evil.example"), 403);
  EXPECT_EQ(statusForHost(server, "localhost"), 101);
  EXPECT_EQ(statusForHost(server, "fusion.local:8080"), 101);
  EXPECT_EQ(statusOf(answerTo(server, get("/", "Host: evil.example\r\n"))), 403);
  EXPECT_EQ(statusOf(answerTo(server, get("/", "Host: localhost\r\n"))), 200);
  options.token = kSecret;  // says that it is no such page
  const Server with_token(options);
  EXPECT_EQ(statusForHost(with_token, "any.example", "Authorization: Bearer " + kSecret + "\r\n"), 101);
}

TEST(StreamServerAccess, AnotherSubprotocolIsRefused) {
  const Server server(anyPort());
  EXPECT_EQ(statusFor(server, "", "/stream", "other"), 400);
  EXPECT_EQ(statusFor(server, "", "/stream", "other, fuse_flow.v1"), 101);
  EXPECT_EQ(statusFor(server, "", "/other"), 404);
}

TEST(StreamServerFiles, AreServedFromMemory) {
  Server server(anyPort());
  server.serve("/", {"text/html; charset=utf-8", "<p>page</p>", ""});
  server.serve("/a.js", {"text/javascript", "let a;", "default-src 'self'"});
  const std::string page = answerTo(server, get("/?token=x", "Host: localhost:1\r\n"));
  EXPECT_EQ(statusOf(page), 200);
  EXPECT_NE(page.find("Content-Type: text/html; charset=utf-8\r\n"), std::string::npos);
  EXPECT_NE(page.find("Content-Length: 11\r\n"), std::string::npos);
  EXPECT_NE(page.find("X-Content-Type-Options: nosniff\r\n"), std::string::npos);
  EXPECT_NE(page.find("Cache-Control: no-store\r\n"), std::string::npos);
  EXPECT_NE(page.find("Referrer-Policy: no-referrer\r\n"), std::string::npos);
  EXPECT_NE(page.find("Content-Security-Policy: default-src 'none'; script-src 'self'"), std::string::npos);
  EXPECT_NE(page.find("connect-src 'self' ws://localhost:1;"), std::string::npos);
  EXPECT_EQ(page.substr(page.size() - 11), "<p>page</p>");
  EXPECT_NE(answerTo(server, get("/a.js")).find("Content-Security-Policy: default-src 'self'\r\n"), std::string::npos);

  const std::string head = answerTo(server, get("/", "Host: localhost\r\n", "HEAD"));
  EXPECT_EQ(statusOf(head), 200);
  EXPECT_NE(head.find("Content-Length: 11\r\n"), std::string::npos);
  EXPECT_EQ(head.substr(head.size() - 4), "\r\n\r\n");
  EXPECT_EQ(statusOf(answerTo(server, get("/healthz"))), 200);
}

TEST(StreamServerFiles, SeveralRequestsTakeOneConnection) {
  Server server(anyPort());
  server.serve("/", {"text/html", "page", ""});
  RawSocket socket = RawSocket::to(server.port());
  const std::string request = "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n";
  socket.send(request + request);
  for (int k = 0; k < 2; ++k) EXPECT_EQ(statusOf(socket.until("page")), 200);
  socket.send(request);
  EXPECT_EQ(statusOf(socket.until("page")), 200);
}

TEST(StreamServerFiles, WhatIsNotThereOrNotAllowedIsSaid) {
  Server server(anyPort());
  server.serve("/", {"text/html", "page", ""});
  for (const char* target : {"/x", "//", "/../etc/passwd", "/%2e%2e/etc/passwd", "/etc/passwd", "/a/../"})
    EXPECT_EQ(statusOf(answerTo(server, get(target))), 404) << target;
  EXPECT_EQ(statusOf(answerTo(server, get("/", "Host: localhost\r\n", "DELETE"))), 405);
  EXPECT_EQ(statusOf(answerTo(server, get("/", "Host: localhost\r\n", "PUT"))), 405);
  EXPECT_EQ(statusOf(answerTo(server, get("/stream"))), 426);
  EXPECT_EQ(statusOf(answerTo(server, get("x"))), 400);
  EXPECT_EQ(statusOf(answerTo(server, get("http://other/"))), 400);
  EXPECT_EQ(statusOf(answerTo(server, get("/", ""))), 400);
  EXPECT_EQ(statusOf(answerTo(server, get("/", "Host: localhost\r\nContent-Length: 5\r\n"))), 400);
  EXPECT_EQ(statusOf(answerTo(server, get("/", "Host: localhost\r\nTransfer-Encoding: chunked\r\n", "POST"))), 400);
  EXPECT_EQ(statusOf(answerTo(server, get("/", "Host: localhost\r\nHost: localhost\r\n"))), 400);
  EXPECT_EQ(statusOf(answerTo(server, "\x16\x03\x01 TLS, or nonsense\r\n\r\n")), 400);
  EXPECT_EQ(statusOf(answerTo(server, std::string(1000, '\0') + "\r\n\r\n")), 400);
  EXPECT_EQ(statusOf(answerTo(server, get("/", "Host: localhost\r\nX: " + std::string(20'000, 'x') + "\r\n"))), 431);
  EXPECT_EQ(statusOf(answerTo(server, get("/" + std::string(20'000, 'x')))), 431);
  EXPECT_THROW(server.serve("x", {}), std::invalid_argument);
  EXPECT_THROW(server.serve("/stream", {}), std::invalid_argument);
  expectServes(server);
}

TEST(StreamServerRules, AMessageThatIsOddEndsTheConnection) {
  Server server(anyPort());
  for (const std::string message : {"", "x", "{}", "[]", R"({"type":"got","frame":1})", R"({"type":"want","x":1})",
                                    R"({"type":"want","points":"many"})", "\xff\xfe"}) {
    RawWebSocket client(server.port());
    client.send(kText, message);
    const int code = client.closeCode();
    EXPECT_TRUE(code == 1008 || (message == "\xff\xfe" && code == 1007)) << message << ": " << code;
  }
  RawWebSocket binary(server.port());
  binary.send(kBinary, R"({"type":"want"})");
  EXPECT_EQ(binary.closeCode(), 1008);
  EXPECT_TRUE(anyHas(server.takeNotices(), "was let go"));
  EXPECT_GE(server.status().dropped, 8u);
  expectServes(server);
}

TEST(StreamServerRules, AFrameIsAnsweredOnce) {
  Server server(anyPort());
  RawWebSocket client(server.port());
  server.publish(frameOf(10, 17));
  client.nextFrame();
  client.send(kText, R"({"type":"got","frame":17})");
  EXPECT_EQ(client.closeCode(), 1008);
}

TEST(StreamServerRules, AMessageThatIsTooLongEndsTheConnection) {
  Server server(anyPort());
  RawWebSocket fits(server.port());
  const std::string json = R"({"type":"want"})";
  fits.send(kText, json + std::string(4096 - json.size(), ' '));
  fits.send(kText, "x");
  EXPECT_EQ(fits.closeCode(), 1008);  // for the second
  RawWebSocket longer(server.port());
  longer.send(kText, json + std::string(4097 - json.size(), ' '));
  EXPECT_EQ(longer.closeCode(), 1009);
  RawWebSocket huge(server.port());
  huge.socket.send(std::string("\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xff", 10) + std::string(1000, 'x'));
  EXPECT_EQ(huge.closeCode(), 1009);
  RawWebSocket parts(server.port());
  parts.socket.send(webSocketFrame(kText, "{", true, false));
  for (int k = 0; k < 5; ++k) parts.socket.send(webSocketFrame(kContinuation, std::string(1000, ' '), true, false));
  EXPECT_EQ(parts.closeCode(), 1009);
  expectServes(server);
}

TEST(StreamServerRules, WhatIsNoWebSocketProtocolEndsTheConnection) {
  Server server(anyPort());
  for (const std::string& bytes :
       {webSocketFrame(kText, "{}", false), std::string("\xff\xff\xff\xff", 4), webSocketFrame(3, "x", true),
        webSocketFrame(kContinuation, "x", true), webSocketFrame(kPing, std::string(126, 'x'), true)}) {
    RawWebSocket client(server.port());
    client.socket.send(bytes + std::string(100, '\0'));
    EXPECT_NE(client.closeCode(), 1000);
  }
  expectServes(server);
}

TEST(StreamServerRules, AFloodOfPingsOrMessagesEndsTheConnection) {
  Server server(anyPort());
  RawWebSocket pings(server.port());
  for (int k = 0; k < 2000 && pings.send(kPing, "x"); ++k) {
  }
  EXPECT_NE(pings.closeCode(), 1000);
  RawWebSocket wants(server.port());
  for (int k = 0; k < 2000 && wants.send(kText, R"({"type":"want"})"); ++k) {
  }
  EXPECT_NE(wants.closeCode(), 1000);
  ASSERT_TRUE(eventually([&] { return server.status().dropped == 2; }));
  EXPECT_TRUE(anyHas(server.takeNotices(), "messages a second"));
  expectServes(server);
}

TEST(StreamServerRules, AHeaderThatComesByteByByteIsNotWaitedFor) {
  stream::ServerOptions options = anyPort();
  options.handshake_time = std::chrono::milliseconds(300);
  Server server(options);
  RawSocket slow = RawSocket::to(server.port());
  const auto begin = std::chrono::steady_clock::now();
  while (slow.send("x") && std::chrono::steady_clock::now() - begin < std::chrono::seconds(30)) ::usleep(20'000);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(30));
  RawSocket silent = RawSocket::to(server.port());
  EXPECT_EQ(silent.all(), "");
  ASSERT_TRUE(eventually([&] { return server.status().connections == 0; }));
}

TEST(StreamServerRules, WhoDoesNotAnswerIsLetGo) {
  stream::ServerOptions options = anyPort();
  options.answer_time = std::chrono::milliseconds(300);
  Server server(options);
  RawWebSocket without_pongs(server.port());
  EXPECT_EQ(without_pongs.next(kText).opcode, kText);
  int code = -1;
  for (;;) {
    const RawWebSocket::Frame frame = without_pongs.read();
    if (frame.opcode != kClose) continue;
    code = frame.code();
    break;
  }
  EXPECT_EQ(code, 1008);
  RawWebSocket without_got(server.port());
  server.publish(frameOf(10, 1));
  EXPECT_EQ(without_got.closeCode(), 1008);
  ASSERT_TRUE(eventually([&] { return server.status().clients.empty(); }));
  const std::vector<std::string> notices = server.takeNotices();
  EXPECT_TRUE(anyHas(notices, "pings"));
  EXPECT_TRUE(anyHas(notices, "not answered"));
}

TEST(StreamServerRules, WhoVanishesIsForgotten) {
  Server server(anyPort());
  RawWebSocket reset(server.port()), closed(server.port()), in_the_midst(server.port());
  server.publish(frameOf(100'000, 1));
  in_the_midst.next(kText);
  reset.socket.reset();
  closed.socket.close();
  in_the_midst.socket.reset();
  RawSocket before = RawSocket::to(server.port());
  before.send("GET /str");
  before.reset();
  ASSERT_TRUE(eventually([&] {
    const stream::ServerStatus status = server.status();
    return status.clients.empty() && status.connections == 0;
  }));
  expectServes(server);
}

TEST(StreamServerRules, OnlySoManyAreLetIn) {
  stream::ServerOptions options = anyPort();
  options.clients = 2;
  options.connections = 4;
  Server server(options);
  RawWebSocket one(server.port());
  {
    RawWebSocket two(server.port());
    EXPECT_EQ(statusFor(server, ""), 503);
    ASSERT_TRUE(eventually([&] { return server.status().connections == 2; }));
    RawSocket third = RawSocket::to(server.port()), fourth = RawSocket::to(server.port());
    ASSERT_TRUE(eventually([&] { return server.status().connections == 4; }));
    EXPECT_EQ(RawSocket::to(server.port()).all(), "");
  }
  ASSERT_TRUE(eventually([&] { return server.status().connections == 1; }));
  RawWebSocket two(server.port());
}

TEST(StreamServerRules, NewConnectionsComeAtARate) {
  stream::ServerOptions options = anyPort();
  options.connections_per_second = 5;
  Server server(options);
  server.serve("/", {"text/html", "page", ""});
  const auto begin = std::chrono::steady_clock::now();
  for (int k = 0; k < 11; ++k) EXPECT_EQ(statusOf(answerTo(server, get("/"))), 200);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
}

/** \brief Bytes of memory that this process has. */
std::size_t residentBytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t all = 0, resident = 0;
  file >> all >> resident;
  return resident * 4096;
}

TEST(StreamServerRules, WhoNeverReadsTakesLittleMemory) {
  // Each on the server's side and on the test's.
  constexpr std::size_t count = 250;
  rlimit files{};
  getrlimit(RLIMIT_NOFILE, &files);
  if (files.rlim_cur < 2 * count + 100) GTEST_SKIP() << "too few files may be open";
  stream::ServerOptions options = anyPort();
  options.clients = count;
  options.held_bytes = 4 << 20;
  Server server(options);
  const auto frame = frameOf(100'000, 0);
  const std::size_t before = residentBytes();
  std::vector<RawWebSocket> never;
  std::uint64_t number = 0;
  const auto publish = [&] {  // each another one
    auto another = std::make_shared<stream::EncodedFrame>(*frame);
    another->times.number = number++;
    server.publish(another);
  };
  // They come one after the other, so that each is stuck with another frame.
  for (std::size_t k = 0; k < count; ++k) {
    never.emplace_back(server.port());
    never.back().socket.receiveBuffer(4096);
    publish();
  }
  for (int k = 0; k < 200; ++k) publish();
  if (std::string(FUSE_FLOW_TEST_SANITIZER).empty()) {
    EXPECT_LT(residentBytes(), before + (64u << 20)) << "frames have " << frame->bytes() << " bytes";
  }
  EXPECT_GT(frame->bytes() * count, std::size_t{64} << 20);  // as they would have, were all kept
  ASSERT_TRUE(eventually([&] {
    publish();
    return server.status().dropped > 0;
  }));
  EXPECT_TRUE(anyHas(server.takeNotices(), "memory"));
  never.clear();
  ASSERT_TRUE(eventually([&] { return server.status().connections == 0; }));
  expectServes(server);
}

TEST(StreamServerRules, WithoutFilesLeftItRestsAndGoesOn) {
  Server server(anyPort());
  server.serve("/", {"text/html", "page", ""});
  RawSocket client(::socket(AF_INET, SOCK_STREAM, 0));
  rlimit files{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &files), 0);
  const int lowest = ::dup(0);  // that is free; from there on none may be opened
  ::close(lowest);
  rlimit none = files;
  none.rlim_cur = static_cast<rlim_t>(lowest);
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &none), 0);
  const bool connected = client.connect(server.port());
  const std::clock_t before = std::clock();
  std::vector<std::string> notices;
  const bool noticed = eventually([&] { return !(notices = server.takeNotices()).empty(); });
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const std::clock_t after = std::clock();
  const std::vector<std::string> more = server.takeNotices();
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &files), 0);
  EXPECT_TRUE(connected);
  EXPECT_TRUE(noticed);
  EXPECT_TRUE(anyHas(notices, "no connection can be accepted"));
  EXPECT_TRUE(more.empty());
  EXPECT_LT(static_cast<double>(after - before) / CLOCKS_PER_SEC,
            0.4);  // of the processor: it does not try again and again
  client.send(get("/"));
  EXPECT_EQ(statusOf(client.all()), 200);
}

}  // namespace
