#include "stream/network/client_connection.h"
#include "stream/network/text.h"
#include "stream/server/client_messages.h"
#include "stream/server/frame_session.h"

#include <fuse_flow/stream/client.h>

#include <algorithm>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

namespace fuse_flow::stream {

namespace {

constexpr std::size_t kLeastFrame = 88;                  // bytes: a header without chunks
constexpr std::size_t kMostText = std::size_t{4} << 20;  // bytes: a description of as many cameras as there may be

void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(std::string("stream::ClientOptions::") + what);
}

network::ClientConnection::Options connectionOptions(const std::string& link, const ClientOptions& options) {
  require(options.most_bytes >= 1024 && options.most_bytes <= std::size_t{4} << 30, "most_bytes: must be 1 KB to 4 GB");
  require(options.connect_time.count() > 0, "connect_time: must be above 0");
  require(options.silence.count() > 0, "silence: must be above 0");
  require(options.certificate_authority.empty() || options.verify,
          "certificate_authority: has no effect without verify");
  network::ClientConnection::Options connection;
  connection.link = network::parseLink(link);
  connection.token = options.token.empty() ? connection.link.token : options.token;
  // It becomes a part of a header.
  require(connection.token.empty() || network::isToken(connection.token),
          "token: must be 16 to 256 letters, digits, '-', '.', '_', '~'");
  connection.subprotocol = network::kSubprotocol;
  connection.most_bytes = options.most_bytes;
  connection.certificate_authority = options.certificate_authority;
  connection.verify = options.verify;
  connection.reconnect = options.reconnect;
  connection.connect_time = options.connect_time;
  connection.silence = options.silence;
  return connection;
}

/** \brief What can be read of a frame without unpacking it. \throws FormatError */
FrameTimes timesOf(const std::vector<std::uint8_t>& message) {
  if (message.size() < kLeastFrame || std::memcmp(message.data(), "FFC1", 4) != 0)
    throw FormatError("a binary message is no frame");
  FrameTimes times;
  std::memcpy(&times.number, message.data() + 8, sizeof(times.number));
  std::memcpy(&times.captured, message.data() + 16, sizeof(times.captured));
  std::memcpy(&times.encoded, message.data() + 24, sizeof(times.encoded));
  return times;
}

}  // namespace

struct Client::State {
  State(const std::string& link, const ClientOptions& of)
      : want(network::toJson(of.wishes)),
        decoder(of.threads, of.most_points),
        connection(connectionOptions(link, of),
                   {[this] { opened(); }, [this](std::string&& text) { describe(text); },
                    [this](std::vector<std::uint8_t>&& bytes) { take(std::move(bytes)); },
                    [this](const std::string& error, bool final) { lost(error, final); }}) {}

  void opened() {
    std::string wishes;
    {
      const std::lock_guard<std::mutex> lock(mutex);
      status.connected = true;
      status.error.clear();
      ++status.connections;
      wishes = want;
    }
    notices.add(last_error.empty() ? "connected" : "connected again");
    last_error.clear();
    connection.send("want", wishes);
  }

  void lost(const std::string& error, bool final) {
    // Once for many attempts that fail alike.
    if (error != last_error) notices.add(error + (final ? "" : "; it is tried again"));
    last_error = error;
    const std::lock_guard<std::mutex> lock(mutex);
    status.connected = false;
    status.ended = final;
    status.error = error;
    changed.notify_all();
  }

  void describe(const std::string& json) {
    if (json.size() > kMostText) throw FormatError("a text of more than 4 MB");
    auto parsed = std::make_shared<const Description>(descriptionFromJson(json));
    const std::lock_guard<std::mutex> lock(mutex);
    description = std::move(parsed);
  }

  void take(std::vector<std::uint8_t>&& bytes) {
    const FrameTimes times = timesOf(bytes);
    connection.send("", network::toJson(network::Got{times.number}));
    const std::lock_guard<std::mutex> lock(mutex);
    ++status.frames;
    status.bytes += bytes.size();
    if (newest) ++status.dropped;
    newest.emplace();
    newest->message = std::move(bytes);
    newest->times = times;
    newest->arrived = network::nanosecondsSince1970();
    newest->description = description;
    changed.notify_all();
  }

  mutable std::mutex mutex;
  std::condition_variable changed;
  // The mutex guards the following members.
  std::optional<ReceivedFrame> newest;
  std::shared_ptr<const Description> description{std::make_shared<Description>()};
  ClientStatus status;
  std::string want;

  network::Notices notices;
  std::string last_error;                ///< of the connection's thread
  FrameDecoder decoder;                  ///< of whoever pulls
  network::ClientConnection connection;  ///< last, as its thread uses the others
};

Client::Client(const std::string& link, const ClientOptions& options) : state_(new State(link, options)) {
  state_->connection.start();
}

Client::~Client() = default;

bool Client::pull(ReceivedFrame& frame, std::chrono::milliseconds timeout) {
  std::unique_lock<std::mutex> lock(state_->mutex);
  state_->changed.wait_for(lock, timeout, [&] { return state_->newest || state_->status.ended; });
  if (!state_->newest) return false;
  frame = std::move(*state_->newest);
  state_->newest.reset();
  return true;
}

bool Client::pull(std::vector<std::uint8_t>& message, std::chrono::milliseconds timeout) {
  ReceivedFrame frame;
  if (!pull(frame, timeout)) return false;
  message = std::move(frame.message);
  return true;
}

bool Client::pull(StreamedCloud& cloud, std::chrono::milliseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  ReceivedFrame frame;
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    if (!pull(frame, std::max(left, std::chrono::milliseconds(0)))) return false;
    try {
      state_->decoder.decode(frame.message.data(), frame.message.size(), cloud);
      return true;
    } catch (const FormatError& error) {
      state_->notices.add("frame " + std::to_string(frame.times.number) + " is damaged: " + error.what());
      const std::lock_guard<std::mutex> lock(state_->mutex);
      ++state_->status.damaged;
    }
  }
}

Description Client::description() const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return *state_->description;
}

void Client::wish(const Wishes& wishes) {
  std::string want = network::toJson(wishes);
  {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    state_->want = want;
  }
  state_->connection.send("want", std::move(want));
}

ClientStatus Client::status() const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return state_->status;
}

std::vector<std::string> Client::takeNotices() { return state_->notices.take(); }

}  // namespace fuse_flow::stream
