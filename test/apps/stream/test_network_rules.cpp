#include "stream/network/link.h"
#include "stream/network/text.h"
#include "stream/server/access.h"
#include "stream/server/client_messages.h"
#include "stream/server/pace.h"

#include <fuse_flow/stream/description.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

namespace {

using namespace fuse_flow;
using namespace fuse_flow::stream::network;
using std::chrono::milliseconds;
using stream::FormatError;

const std::string kToken = "0123456789abcdef";

Credentials from(std::string_view host, std::string_view origin = "", std::string_view authorization = "",
                 std::string_view query = "") {
  return {host, origin, authorization, query};
}

TEST(StreamAccess, TheTokenComesInTheQueryOrAHeader) {
  const Access access(kToken, {}, {});
  EXPECT_FALSE(access.hasToken(from("h")));
  EXPECT_TRUE(access.hasToken(from("h", "", "Bearer " + kToken)));
  EXPECT_TRUE(access.hasToken(from("h", "", "bearer " + kToken)));
  EXPECT_TRUE(access.hasToken(from("h", "", "", "token=" + kToken)));
  EXPECT_TRUE(access.hasToken(from("h", "", "", "a=b&token=%30123456789abcdef&c")));
  for (const std::string query :
       {"token=0123456789abcdeg", "token=0123456789abcde", "token=0123456789abcdef0", "Token=0123456789abcdef",
        "token=", "token", "xtoken=0123456789abcdef", "token=%3", "token=%zz123456789abcdef"})
    EXPECT_FALSE(access.hasToken(from("h", "", "", query))) << query;
  for (const std::string header : {"Bearer", "Bearer ", "Basic 0123456789abcdef", "0123456789abcdef"})
    EXPECT_FALSE(access.hasToken(from("h", "", header))) << header;
}

TEST(StreamAccess, WithoutATokenTheServerHasANameOfThisMachine) {
  const Access access("", {}, {"fusion.local"});
  for (const char* host : {"localhost", "localhost:8080", "LOCALHOST:80", "127.0.0.1", "127.0.0.1:1", "127.1.2.3",
                           "[::1]", "[::1]:8080", "fusion.local", "Fusion.Local:8080"})
    EXPECT_TRUE(access.mayAsk(from(host))) << host;
  for (const char* host : {"evil.example", "evil.example:8080", "127.0.0.1.evil.example", "localhost.evil.example",
                           "127.evil.example", "127.0.0.", "0.0.0.0", "192.168.1.7", "[::2]", "", ":80", "::1"})
    EXPECT_FALSE(access.mayAsk(from(host))) << host;
  EXPECT_TRUE(Access(kToken, {}, {}).mayAsk(from("evil.example")));
}

TEST(StreamAccess, APageIsThisServersOrOfAnAllowedOrigin) {
  const Access access(kToken, {"https://viewer.example"}, {});
  EXPECT_TRUE(access.mayConnectFrom(from("a:8080")));
  EXPECT_TRUE(access.mayConnectFrom(from("a:8080", "http://a:8080")));
  EXPECT_TRUE(access.mayConnectFrom(from("a", "http://a:80")));
  EXPECT_TRUE(access.mayConnectFrom(from("a:443", "https://a")));
  EXPECT_TRUE(access.mayConnectFrom(from("a:8080", "https://viewer.example")));
  for (const char* origin : {"http://a", "http://a:8081", "http://b:8080", "null", "a:8080", "file://", "file://a:8080",
                             "http://", "https://viewer.example.evil", "http://a:8080.evil"})
    EXPECT_FALSE(access.mayConnectFrom(from("a:8080", origin))) << origin;
}

TEST(StreamText, TokensAreLongAndStandInLinksAsTheyAre) {
  EXPECT_TRUE(isToken("0123456789abcdef"));
  EXPECT_TRUE(isToken("ABC-def_123.~456x"));
  EXPECT_FALSE(isToken("0123456789abcde"));
  EXPECT_FALSE(isToken("0123456789abcde "));
  EXPECT_FALSE(isToken("0123456789abcde&"));
  EXPECT_FALSE(isToken(std::string(257, 'a')));
}

TEST(StreamText, AFloodOfNoticesIsCounted) {
  Notices notices;
  for (int k = 0; k < 1000; ++k) notices.add("line");
  const std::vector<std::string> lines = notices.take();
  ASSERT_EQ(lines.size(), 101u);
  EXPECT_EQ(lines.back(), "and 900 notices more");
  EXPECT_TRUE(notices.take().empty());
}

TEST(StreamLink, IsReadAsTheServerPrintsIt) {
  Link link = parseLink("http://127.0.0.1:8080/?token=" + kToken);
  EXPECT_FALSE(link.tls);
  EXPECT_EQ(link.authority(), "127.0.0.1:8080");
  EXPECT_EQ(link.path, "/stream");
  EXPECT_EQ(link.token, kToken);
  link = parseLink("WSS://[fe80::1]/room/stream#x");
  EXPECT_TRUE(link.tls);
  EXPECT_EQ(link.host, "fe80::1");
  EXPECT_EQ(link.authority(), "[fe80::1]:443");
  EXPECT_EQ(link.path, "/room/stream");
  EXPECT_EQ(parseLink("ws://host").authority(), "host:80");
  EXPECT_EQ(parseLink("ws://host?token=a").token, "a");
}

TEST(StreamLink, IsRefusedWithoutItsToken) {
  for (const std::string text :
       {"", "host", "host:80", "ftp://host", "ws://", "ws://:80", "ws://host:", "ws://host:0", "ws://host:65536",
        "ws://host:99999999999", "ws://host:8o", "ws://[::1", "ws://[::1]x", "ws://user:pass@host", "ws://ho st",
        "ws://host\r\nX: y", "ws://host/a b", "ws://host/\r\nX: y", "ws://?token=secret-secret-secret"})
    try {
      parseLink(text);
      ADD_FAILURE() << text;
    } catch (const std::invalid_argument& error) {
      EXPECT_EQ(std::string(error.what()).find("secret"), std::string::npos);
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
}

TEST(StreamMessages, WishesComeBackAsTheyWere) {
  stream::Wishes wishes;
  wishes.points = 123456789012345ull;
  wishes.bytes_per_second = 1;
  wishes.region = {{-1, -2, -3}, {1, 2.5, 3}};
  wishes.viewpoint = {{0.1, 0.2, 0.3}};
  wishes.step = 0.004;
  const auto back = std::get<stream::Wishes>(clientMessage(toJson(wishes)));
  EXPECT_EQ(back.points, wishes.points);
  EXPECT_EQ(back.bytes_per_second, wishes.bytes_per_second);
  EXPECT_EQ(back.region->least, wishes.region->least);
  EXPECT_EQ(back.region->greatest, wishes.region->greatest);
  EXPECT_EQ(back.viewpoint, wishes.viewpoint);
  EXPECT_EQ(back.step, wishes.step);
  const auto none = std::get<stream::Wishes>(clientMessage(R"({"type":"want"})"));
  EXPECT_FALSE(none.points || none.bytes_per_second || none.region || none.viewpoint || none.step);
  EXPECT_EQ(std::get<Got>(clientMessage(toJson(Got{18446744073709551615ull}))).frame, 18446744073709551615ull);
}

TEST(StreamMessages, AreRefusedWhereAnythingIsOdd) {
  for (const std::string text : {R"()",
                                 R"(x)",
                                 R"([])",
                                 R"(1)",
                                 R"(null)",
                                 R"({})",
                                 R"({"type":1})",
                                 R"({"type":"go"})",
                                 R"({"type":"got"})",
                                 R"({"type":"got","frame":-1})",
                                 R"({"type":"got","frame":1.5})",
                                 R"({"type":"got","frame":"1"})",
                                 R"({"type":"got","frame":1e3})",
                                 R"({"type":"got","frame":18446744073709551616})",
                                 R"({"type":"got","frame":1,"x":2})",
                                 R"({"type":"got","frame":1,"frame":2})",
                                 R"({"type":"got","frame":1}x)",
                                 R"({"type":"want","point":1})",
                                 R"({"type":"want","points":-1})",
                                 R"({"type":"want","points":null})",
                                 R"({"type":"want","points":NaN})",
                                 R"({"type":"want","points":[1]})",
                                 R"({"type":"want","bytes_per_second":0})",
                                 R"({"type":"want","viewpoint":[1,2]})",
                                 R"({"type":"want","viewpoint":[1,2,3,4]})",
                                 R"({"type":"want","viewpoint":[1,2,"3"]})",
                                 R"({"type":"want","viewpoint":[1,2,1e999]})",
                                 R"({"type":"want","viewpoint":[1,2,1e10]})",
                                 R"({"type":"want","viewpoint":[1,2,NaN]})",
                                 R"({"type":"want","viewpoint":{"x":1}})",
                                 R"({"type":"want","region":{"min":[0,0,0]}})",
                                 R"({"type":"want","region":{"min":[1,0,0],"max":[0,1,1]}})",
                                 R"({"type":"want","region":{"min":[0,0,0],"max":[1,1,1],"x":1}})",
                                 R"({"type":"want","region":[]})",
                                 R"({"type":"want","step":0})",
                                 R"({"type":"want","step":-1})",
                                 R"({"type":"want","step":"1"})",
                                 R"({"type":"want","step":1e400})",
                                 R"({"type":"want","step":null})",
                                 "{\"type\":\"want\",\"\xff\":1}",
                                 R"({"type":["got"],"frame":1})"})
    EXPECT_THROW(clientMessage(text), FormatError) << text;
  EXPECT_THROW(clientMessage(R"({"type":"want","region":)" + std::string(2000, '[') + std::string(2000, ']') + "}"),
               FormatError);
  EXPECT_THROW(clientMessage(R"({"type":"want"})" + std::string(4096, ' ')), FormatError);
}

TEST(StreamMessages, WishesThatNoServerTakesAreNotSent) {
  stream::Wishes wishes;
  wishes.viewpoint = {{0, 0, std::numeric_limits<double>::quiet_NaN()}};
  EXPECT_THROW(toJson(wishes), std::invalid_argument);
  wishes = {};
  wishes.step = 0;
  EXPECT_THROW(toJson(wishes), std::invalid_argument);
  wishes = {};
  wishes.region = {{1, 0, 0}, {0, 1, 1}};
  EXPECT_THROW(toJson(wishes), std::invalid_argument);
  wishes = {};
  wishes.bytes_per_second = 0;
  EXPECT_THROW(toJson(wishes), std::invalid_argument);
}

stream::Description twoCameras() {
  stream::Description description;
  description.name = "demo \"quoted\" ü";
  description.step = 0.002;
  description.cameras.resize(2);
  description.cameras[0].name = "left";
  description.cameras[0].intrinsics = {640, 480, 525.5f, 526, 319.5f, 239.5f, {}};
  description.cameras[1].name = "right";
  description.cameras[1].intrinsics = {320, 240, 262, 263, 160, 120, {}};
  description.cameras[1].T_world_camera =
      Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized());
  return description;
}

TEST(StreamDescription, ComesBackAsItWas) {
  const stream::Description description = twoCameras();
  const stream::Description back = stream::descriptionFromJson(toJson(description));
  EXPECT_EQ(back.name, description.name);
  EXPECT_EQ(back.frame, "world");
  EXPECT_EQ(back.step, 0.002);
  ASSERT_EQ(back.cameras.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(back.cameras[k].name, description.cameras[k].name);
    EXPECT_EQ(back.cameras[k].intrinsics.width, description.cameras[k].intrinsics.width);
    EXPECT_EQ(back.cameras[k].intrinsics.fx, description.cameras[k].intrinsics.fx);
    EXPECT_EQ(back.cameras[k].T_world_camera.matrix(), description.cameras[k].T_world_camera.matrix());
  }
}

TEST(StreamDescription, ANameThatIsNoUtf8IsMadeToBe) {
  stream::Description description;
  description.name = "a\xff";
  EXPECT_EQ(stream::descriptionFromJson(toJson(description)).name, "a\xef\xbf\xbd");
}

TEST(StreamDescription, IsRefusedWhereAnythingIsOdd) {
  const std::string good = toJson(twoCameras());
  EXPECT_NO_THROW(stream::descriptionFromJson(good));
  const auto with = [&](const std::string& what, const std::string& instead) {
    std::string changed = good;
    const std::size_t at = changed.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return changed.replace(at, what.size(), instead);
  };
  for (const auto& [what, instead] :
       std::vector<std::pair<std::string, std::string>>{{"\"stream\"", "\"scream\""},
                                                        {"\"version\":1", "\"version\":2"},
                                                        {"\"version\":1", "\"version\":-1"},
                                                        {"\"version\":1", "\"version\":\"1\""},
                                                        {"\"step\":0.002", "\"step\":0"},
                                                        {"\"step\":0.002", "\"step\":-1"},
                                                        {"\"step\":0.002", "\"step\":1e999"},
                                                        {"\"step\":0.002", "\"step\":NaN"},
                                                        {"\"step\":0.002", "\"stop\":1"},
                                                        {"\"step\":0.002", "\"step\":null"},
                                                        {"\"width\":640", "\"width\":0"},
                                                        {"\"width\":640", "\"width\":-640"},
                                                        {"\"width\":640", "\"width\":640.5"},
                                                        {"\"width\":640", "\"width\":1000000"},
                                                        {"\"fx\":525.5", "\"fx\":0"},
                                                        {"\"fx\":525.5", "\"fx\":1e60"},
                                                        {"\"fx\":525.5", "\"fx\":1e-60"},
                                                        {"\"fx\":525.5", "\"fx\":[1]"},
                                                        {"\"name\":\"left\"", "\"name\":7"},
                                                        {"\"T_world_camera\":[1.0", "\"T_world_camera\":[2.0"},
                                                        {"\"T_world_camera\":[1.0,", "\"T_world_camera\":["},
                                                        {"\"T_world_camera\":[1.0", "\"T_world_camera\":[1e999"},
                                                        {"\"frame\"", "\"from\""},
                                                        {"\"cameras\":[", "\"cameras\":[7,"},
                                                        {"\"cameras\":[", "\"cameras\":{},\"x\":["}})
    EXPECT_THROW(stream::descriptionFromJson(with(what, instead)), FormatError) << instead;
  EXPECT_THROW(stream::descriptionFromJson(""), FormatError);
  EXPECT_THROW(stream::descriptionFromJson(good.substr(0, good.size() / 2)), FormatError);
  EXPECT_THROW(stream::descriptionFromJson(std::string(1'000'000, '[')), FormatError);
  EXPECT_NO_THROW(stream::descriptionFromJson(with("{", "{\"later\":{\"a\":[1]},")));
  stream::Description many;
  many.cameras.assign(1025, twoCameras().cameras[0]);
  EXPECT_THROW(stream::descriptionFromJson(toJson(many)), FormatError);
  many.cameras.pop_back();
  EXPECT_NO_THROW(stream::descriptionFromJson(toJson(many)));
}

/** \brief A client behind a link that takes so many bytes a second, and a round trip. */
class LinkOfRate {
 public:
  LinkOfRate(double bytes_per_second, Clock::duration round_trip) : rate(bytes_per_second), trip_(round_trip) {}

  /** \brief The next frame of `whole` bytes: what is sent of it. Two are under way, as in a session. */
  std::size_t next(std::size_t whole, Clock::duration interval) {
    const std::size_t budget = pace.budget(interval, whole, wished, false);
    const std::size_t bytes = budget > 0 ? std::min(budget, whole) : whole;
    const Clock::time_point sent = std::max(now_, free_);
    busy_ = std::max(busy_, sent) + std::chrono::duration_cast<Clock::duration>(
                                        std::chrono::duration<double>(static_cast<double>(bytes) / rate));
    const Clock::time_point answer = busy_ + trip_;
    pace.roundTrip(trip_);
    pace.answered(bytes, sent, answer, interval);
    now_ = sent + interval;
    free_ = last_answer_;  // one is unanswered while the next is sent
    last_answer_ = answer;
    return bytes;
  }
  /** \brief How far it is behind. */
  Clock::duration late() const { return busy_ > now_ ? busy_ - now_ : Clock::duration::zero(); }

  Pace pace;
  double rate;
  std::optional<std::uint64_t> wished;

 private:
  Clock::duration trip_;
  Clock::time_point now_{std::chrono::seconds(1000)}, free_{now_}, busy_{now_}, last_answer_{now_};
};

constexpr std::size_t kWhole = 1'000'000;  // bytes
constexpr Clock::duration kInterval = milliseconds(33);

TEST(StreamPace, WhoTakesAllGetsAll) {
  LinkOfRate link(100e6, milliseconds(1));
  for (int k = 0; k < 100; ++k) EXPECT_EQ(link.next(kWhole, kInterval), kWhole);
}

TEST(StreamPace, ALongWayIsNotTakenForASlowOne) {
  LinkOfRate link(100e6, milliseconds(200));
  for (int k = 0; k < 100; ++k) EXPECT_EQ(link.next(kWhole, kInterval), kWhole);
}

TEST(StreamPace, ASlowClientGetsFewerBytesAtTheRateOfFrames) {
  for (const int trip : {1, 50}) {
    LinkOfRate link(5e6, milliseconds(trip));  // 165 KB in 33 ms
    for (int k = 0; k < 10; ++k) link.next(kWhole, kInterval);
    for (int k = 0; k < 100; ++k) link.next(kWhole, kInterval);
    std::size_t sum = 0;
    for (int k = 0; k < 30; ++k) sum += link.next(kWhole, kInterval);
    EXPECT_GT(sum, 30u * 110'000u) << trip;
    EXPECT_LT(sum, 30u * 165'000u) << trip;
    EXPECT_LT(link.late(), kInterval) << trip;
  }
}

TEST(StreamPace, WhoBecomesFasterGetsMoreAgainSmoothly) {
  LinkOfRate link(5e6, milliseconds(1));
  std::size_t last = kWhole;
  for (int k = 0; k < 100; ++k) last = link.next(kWhole, kInterval);
  link.rate = 100e6;
  int frames = 0;
  for (; last < kWhole && frames < 200; ++frames) {
    const std::size_t bytes = link.next(kWhole, kInterval);
    EXPECT_LE(static_cast<double>(bytes), 1.2501 * static_cast<double>(last));
    last = bytes;
  }
  EXPECT_LT(frames, 60);
}

TEST(StreamPace, OneHiccupChangesNothing) {
  LinkOfRate link(100e6, milliseconds(1));
  for (int k = 0; k < 30; ++k) link.next(kWhole, kInterval);
  link.rate = 4e6;
  link.next(kWhole, kInterval);
  link.rate = 100e6;
  for (int k = 0; k < 30; ++k) EXPECT_EQ(link.next(kWhole, kInterval), kWhole);
}

TEST(StreamPace, WhatIsWishedForIsNotExceeded) {
  LinkOfRate link(100e6, milliseconds(1));
  link.wished = 3'000'000;
  for (int k = 0; k < 30; ++k) EXPECT_LE(link.next(kWhole, kInterval), 99'001u);
}

TEST(StreamPace, WhatIsSmallTellsNothingUnlessItTakesLong) {
  LinkOfRate link(100e6, milliseconds(1));
  for (int k = 0; k < 30; ++k) link.next(kWhole, kInterval);
  const Clock::time_point start{std::chrono::seconds(2000)};
  // 50 KB in 10 ms: slow, as a thread was late.
  for (int k = 0; k < 30; ++k)
    link.pace.answered(50'000, start + k * kInterval, start + k * kInterval + milliseconds(10), kInterval, true);
  EXPECT_EQ(link.pace.budget(kInterval, kWhole, {}, false), 0u);
  for (int k = 30; k < 60; ++k)
    link.pace.answered(50'000, start + k * kInterval, start + k * kInterval + milliseconds(50), kInterval, true);
  EXPECT_LT(link.pace.budget(kInterval, kWhole, {}, true), 60'000u);
}

TEST(StreamPace, TheFirstFrameIsNotHuge) {
  EXPECT_EQ(Pace().budget(kInterval, 100'000'000, {}, false), Pace::kFirst);
  EXPECT_EQ(Pace().budget(kInterval, 1'000'000, {}, false), 0u);
}

}  // namespace
