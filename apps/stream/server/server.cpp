#include "stream/codec/morton.h"
#include "stream/foxglove/feed.h"
#include "stream/foxglove/foxglove_session.h"
#include "stream/server/frame_hub.h"
#include "stream/server/frame_session.h"
#include "stream/server/gate.h"
#include "stream/server/listener.h"

#include <fuse_flow/stream/server.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <thread>
#include <utility>

namespace fuse_flow::stream {

using network::Clock;
using network::kSteps;

namespace {

constexpr auto kFarewell = std::chrono::milliseconds(500);
constexpr auto kEncodeUnwatched = std::chrono::seconds(1);

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("stream::ServerOptions::" + what);
}

/** \brief The options, if they are all right. */
const ServerOptions& checked(const ServerOptions& options) {
  const bool loopback = network::isLoopbackAddress(options.address);
  require(loopback || !options.token.empty(),
          "address: " + options.address + " can be reached by others, and needs a token");
  require(options.token.empty() || network::isToken(options.token),
          "token: must be 16 to 256 letters, digits, '-', '.', '_', '~'");
  require(options.certificate.empty() == options.key.empty(), "certificate and key: must both be given, or none");
  require(options.threads >= 1 && options.threads <= 256, "threads: must be 1 to 256");
  require(options.clients >= 1, "clients: must be 1 or more");
  require(options.connections == 0 || options.connections >= options.clients,
          "connections: must be as many as clients, or more");
  require(options.connections_per_second >= 1, "connections_per_second: must be 1 or more");
  require(options.handshake_time.count() > 0, "handshake_time: must be above 0");
  require(options.header_bytes >= 256 && options.header_bytes <= std::size_t{1} << 20,
          "header_bytes: must be 256 to 1048576");
  require(options.messages_per_second >= 1, "messages_per_second: must be 1 or more");
  require(options.answer_time.count() > 0, "answer_time: must be above 0");
  return options;
}

network::Gate::Limits limitsOf(const ServerOptions& options) {
  const std::size_t for_files = 100;
  return {options.clients, options.connections > 0 ? options.connections : options.clients + for_files,
          options.header_bytes, options.messages_per_second, options.handshake_time};
}

network::Listener::Options listening(const ServerOptions& options) {
  network::Listener::Options listening;
  listening.address = options.address;
  listening.port = options.port;
  listening.certificate = options.certificate;
  listening.key = options.key;
  listening.threads = options.threads;
  listening.connections_per_second = options.connections_per_second;
  return listening;
}

}  // namespace

struct Server::State {
  explicit State(const ServerOptions& of)
      : options(checked(of)),
        encoder(options.encoding),
        hub(std::make_shared<network::FrameHub>(options.held_bytes, options.encoding.step)),
        gate(std::make_shared<network::Gate>(
            limitsOf(options), network::Access(options.token, options.allowed_origins, options.allowed_hosts))),
        feed(std::make_shared<foxglove::Feed>(hub, gate->notices, options.encoding.threads)) {
    gate->subprotocols.push_back(
        {network::kSubprotocol, "/stream", [hub = hub, gate = gate.get(), time = options.answer_time](const auto& to) {
           return std::make_unique<network::FrameSession>(to, hub, *gate, time);
         }});
    for (const char* name : foxglove::kSubprotocols)
      gate->subprotocols.push_back(
          {name, "/",
           [hub = hub, feed = feed, gate = gate.get(), time = options.answer_time, name](const auto& to) {
             return std::make_unique<foxglove::FoxgloveSession>(to, hub, feed, *gate, time, name);
           },
           foxglove::kMostClientMessage});
    listener = std::make_unique<network::Listener>(listening(options), gate);
  }
  ~State() {
    feed->stop();  // first: it may hold a connection, which must not outlive the listener's threads
    listener.reset();
  }

  /** \brief In a step; encoders keep their memory. */
  std::shared_ptr<const EncodedFrame> encode(const CloudView& cloud, const FrameTimes& times, std::size_t step) {
    if (step == 0) return encoder.encode(cloud, times);
    std::unique_ptr<FrameEncoder>& coarser = coarser_encoders[step - 1];
    if (!coarser) {
      EncodingOptions encoding = options.encoding;
      encoding.step = std::ldexp(encoding.step, static_cast<int>(step));
      coarser = std::make_unique<FrameEncoder>(encoding);
    }
    return coarser->encode(cloud, times);
  }

  /** \brief Once: what is missing in one frame is missing in most. */
  void sayWhatIsTooFar(const EncodedFrame& frame) {
    if (frame.too_far == 0 || std::exchange(said_too_far, true)) return;
    char metres[32];
    std::snprintf(metres, sizeof metres, "%.0f", std::ldexp(frame.step, kCoordinateBits - 1));
    gate->notices.add(std::to_string(frame.too_far) + " of " + std::to_string(frame.too_far + frame.points) +
                      " points of frame " + std::to_string(frame.times.number) +
                      " are not streamed: they are more than " + metres +
                      " m from the others; a coarser step reaches farther");
  }

  void shed() {
    if (const std::size_t ended = hub->shed(); ended > 0) {
      gate->dropped += ended;
      gate->notices.add(std::to_string(ended) +
                        " clients were let go: they take too long, and hold more memory than may be");
    }
  }

  const ServerOptions options;
  std::mutex encode_mutex;
  // The mutex guards the following members.
  FrameEncoder encoder;
  std::array<std::unique_ptr<FrameEncoder>, kSteps - 1> coarser_encoders;
  std::optional<Clock::time_point> last_encoded;
  bool said_too_far{false};

  std::atomic<std::uint64_t> encoded{0};
  const std::shared_ptr<network::FrameHub> hub;
  const std::shared_ptr<network::Gate> gate;
  const std::shared_ptr<foxglove::Feed> feed;
  std::unique_ptr<network::Listener> listener;
};

Server::Server(const ServerOptions& options) : state_(new State(options)) {
  Description empty;
  empty.step = options.encoding.step;
  describe(empty);
  state_->listener->start();
}

Server::~Server() {
  state_->listener->shut();
  state_->hub->goAway();
  const Clock::time_point end = Clock::now() + kFarewell;
  while (state_->hub->members() > 0 && Clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

std::uint16_t Server::port() const { return state_->listener->port(); }

std::string Server::link() const {
  const ServerOptions& options = state_->options;
  std::string link = (options.certificate.empty() ? "http://" : "https://") + network::hostInLinks(options.address) +
                     ":" + std::to_string(port()) + "/";
  if (!options.token.empty()) link += "?token=" + options.token;
  return link;
}

std::vector<std::string> Server::warnings() const {
  const ServerOptions& options = state_->options;
  if (network::isLoopbackAddress(options.address) || !options.certificate.empty()) return {};
  return {
      "whoever can listen on the network on the way can read the token and the clouds: they are not encrypted; a "
      "certificate and its key encrypt them"};
}

void Server::serve(const std::string& path, ServedFile file) {
  if (path.empty() || path[0] != '/' || path == "/stream" || path == "/healthz")
    throw std::invalid_argument("stream::Server::serve: '" + network::printable(path) +
                                "' cannot be a path; must begin with '/', and not be /stream or /healthz");
  auto held = std::make_shared<const network::HeldFile>(
      network::HeldFile{std::move(file.content_type), std::move(file.bytes), std::move(file.policy)});
  const std::lock_guard<std::mutex> lock(state_->gate->files_mutex);
  state_->gate->files[path] = std::move(held);
}

void Server::describe(const Description& description) {
  state_->feed->describe(description);
  state_->hub->describe(toJson(description));  // which wakes all
}

void Server::publish(const CloudView& cloud, const FrameTimes& times) {
  const std::lock_guard<std::mutex> lock(state_->encode_mutex);
  const Clock::time_point now = Clock::now();
  if (!watched() && state_->last_encoded && now - *state_->last_encoded < kEncodeUnwatched) return;
  state_->last_encoded = now;
  std::array<std::size_t, kSteps> wanted = state_->hub->wanted();
  if (wanted == std::array<std::size_t, kSteps>{}) wanted[0] = 1;  // for whoever comes
  network::PublishedFrame frame;
  frame.from_cloud = true;
  for (std::size_t step = 0; step < kSteps; ++step) {
    if (wanted[step] == 0) continue;
    FrameTimes of_step = times;
    if (of_step.encoded == 0) of_step.encoded = network::nanosecondsSince1970();
    const std::shared_ptr<const EncodedFrame> encoded = state_->encode(cloud, of_step, step);
    state_->sayWhatIsTooFar(*encoded);
    frame.of_step[step] = encoded;
    ++state_->encoded;
  }
  state_->hub->publish(std::move(frame));
  state_->shed();
}

void Server::publish(std::shared_ptr<const EncodedFrame> encoded) {
  if (!encoded) return;
  network::PublishedFrame frame;
  frame.of_step[0] = std::move(encoded);
  state_->hub->publish(std::move(frame));
  state_->shed();
}

void Server::publishImage(std::size_t camera, const ImageView<Rgb8>& pixels, const FrameTimes& times,
                          std::shared_ptr<const void> owner) {
  if (!pixels) return;
  std::int64_t time = times.captured > 0 ? times.captured : times.encoded;
  if (time <= 0) time = network::nanosecondsSince1970();
  if (state_->feed->publishImage(camera, pixels, static_cast<std::uint64_t>(time), std::move(owner)))
    state_->hub->wake();
  state_->shed();
}

bool Server::imageWanted(std::size_t camera) const { return state_->feed->imageWanted(camera); }

bool Server::watched() const { return state_->hub->watchers() > 0; }

ServerStatus Server::status() const {
  ServerStatus status;
  status.clients = state_->hub->reports();
  status.connections = *state_->gate->connections;
  status.published = state_->hub->published();
  status.encoded = state_->encoded;
  status.encoded_images = state_->feed->images().encoded();
  status.refused = state_->gate->refused;
  status.dropped = state_->gate->dropped;
  return status;
}

std::vector<std::string> Server::takeNotices() { return state_->gate->notices.take(); }

}  // namespace fuse_flow::stream
