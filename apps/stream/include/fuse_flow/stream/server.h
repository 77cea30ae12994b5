#pragma once

#include <fuse_flow/depth_view.h>
#include <fuse_flow/stream/description.h>
#include <fuse_flow/stream/encoded_frame.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::stream {

/** \brief What browsers get by HTTP, from memory. */
struct ServedFile {
  std::string content_type;  ///< "text/html; charset=utf-8"
  std::string bytes;
  /** \brief Content-Security-Policy; empty: the page may load scripts, styles, pictures and workers of this server only, and connect to
   *  nothing else. */
  std::string policy;
};

/** \brief Where a server listens, whom it lets in, and what it spends on them. */
struct ServerOptions {
  /** \brief An IP address; "0.0.0.0" and "::" are all of this machine's. Any but a loopback address needs a token. */
  std::string address{"127.0.0.1"};
  std::uint16_t port{8080};  ///< 0: one that is free, see Server::port()
  /** \brief What clients must know; 16 … 256 letters, digits, '-', '.', '_', '~'. Empty: none, which only a loopback address can have. */
  std::string token;
  std::string certificate;  ///< file, PEM, with the chain; with it, and a key, the server speaks TLS only
  std::string key;          ///< file, PEM, of the certificate
  /** \brief Pages of other servers that may connect, as browsers name them: "https://viewer.example". Those of this server may always. */
  std::vector<std::string> allowed_origins;
  /** \brief Names, beside localhost and loopback addresses, by which a server without a token may be asked for; without a port. A page
   *  whose name was made to lead here is refused. */
  std::vector<std::string> allowed_hosts;
  EncodingOptions encoding;  ///< of clouds
  int threads{1};            ///< of the network, ≥ 1; one fills a link of 10 Gbit/s

  std::size_t clients{100};                ///< at a time, ≥ 1
  std::size_t connections{0};              ///< at a time, with those that only ask for files, ≥ clients; 0: 100 more
  std::size_t connections_per_second{50};  ///< new ones, ≥ 1; more wait
  std::chrono::milliseconds handshake_time{5000};  ///< for TLS, and for each request, > 0
  std::size_t header_bytes{8192};                  ///< of a request, 256 … 1 MB
  /** \brief Of a client, with pings, but for answers to the server's, ≥ 1; more end its connection. */
  std::size_t messages_per_second{200};
  std::chrono::milliseconds answer_time{
      10'000};  ///< for a client to answer a frame, > 0; longer for many bytes: as for 100 KB/s
  std::size_t held_bytes{std::size_t{512}
                         << 20};  ///< of old frames that slow clients are still being sent; the slowest is let go
};

/** \brief How one client does. */
struct ClientReport {
  std::string address;  ///< with its port
  std::string subprotocol;
  double seconds{0};                 ///< since it came
  std::uint64_t frames{0};           ///< that it has answered
  std::uint64_t replaced{0};         ///< frames that it was not sent, as a newer one was there
  std::uint64_t images{0};           ///< of cameras, that it has answered
  std::uint64_t bytes{0};            ///< of the frames and images that it has answered
  double bytes_per_second{0};        ///< that it takes, as measured; 0: not known yet
  double round_trip{0};              ///< seconds; 0: not known yet
  std::uint32_t points{0};           ///< of the frame that was sent last
  std::uint32_t points_of_frame{0};  ///< as many had the whole one
};

struct ServerStatus {
  std::vector<ClientReport> clients;
  std::size_t connections{0};       ///< with those of clients
  std::uint64_t published{0};       ///< frames
  std::uint64_t encoded{0};         ///< of them from clouds, each step that was asked for counts
  std::uint64_t encoded_images{0};  ///< of cameras: those that somebody has subscribed to, and had time for
  std::uint64_t refused{0};         ///< requests: without the token, of other pages, malformed, too many
  std::uint64_t dropped{0};         ///< clients that broke the rules or did not answer
};

/** \brief Sends clouds to any number of clients, as doc/reference/stream_format.md has it, and files to browsers. Each client gets the
 *  newest frame that it can take, and of it as many points as it takes at the rate of frames. It has threads of its own; every member
 *  may be called by any thread. */
class Server {
 public:
  /** \brief Listens from here on. \throws std::invalid_argument naming the option that is wrong; std::runtime_error if the address cannot
   *  be listened at, or the certificate not be used, saying why */
  explicit Server(const ServerOptions& options);
  /** \brief Says good-bye to the clients (close code 1001), within half a second. */
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::uint16_t port() const;
  /** \brief What to open in a browser or give to Client: "http://127.0.0.1:8080/?token=…". It has the token in it. */
  std::string link() const;
  /** \brief What could be unwise, one line each, as a token without TLS. */
  std::vector<std::string> warnings() const;

  /** \brief What browsers get at a path, "/" or "/decoder.js", from here on; those who ask for it need no token. \throws
   *  std::invalid_argument if the path does not begin with '/', or is /stream or /healthz */
  void serve(const std::string& path, ServedFile file);
  /** \brief Clients learn of it before the next frame. Until then it is an empty one, with the step of ServerOptions::encoding. */
  void describe(const Description& description);

  /** \brief Encodes a cloud, on the thread that calls, for those who want it, and publishes it; it never waits for a client. While nobody
   *  is connected, a cloud is encoded once a second only, for whoever comes next to begin with.
   *  \param times times.encoded is now where it is 0 */
  template <typename PointT>
  void publish(const pcl::PointCloud<PointT>& cloud, const FrameTimes& times) {
    publish(viewOf(cloud), times);
  }
  void publish(const CloudView& cloud, const FrameTimes& times);
  /** \brief As it is: a client's wish for a coarser step has no effect. Null does nothing. */
  void publish(std::shared_ptr<const EncodedFrame> frame);
  /** \brief Whether anybody is connected who would get the next cloud: whoever makes clouds for the server alone need make none. */
  bool watched() const;

  /** \brief An image of a camera, for clients of Foxglove's protocol: `foxglove.CompressedImage` by JPEG, with the frame and the time stamp that
   *  belong to it, on the channel /cameras/NAME/image, which is there from a camera's first image on. Never waits: the image is encoded on a
   *  thread of the server, once, if a client that has subscribed can take it, and else replaced by the next one. Each client gets the
   *  newest; at most two of a camera are on their way to it.
   *  \param camera its position in the description's cameras
   *  \param pixels of the size of Camera::color's intrinsics, or of Camera::intrinsics where that is absent: it is what the calibration of the
   *  camera describes, with its distortion. No image (null) does nothing.
   *  \param times times.captured, or where that is 0 times.encoded, or now, is the stamp: give those of the cloud
   *  \param owner of the pixels, which must stay as they are until it is released, some time after the call; null: they are copied before
   *  the call returns, if somebody has subscribed
   *  \throws std::invalid_argument if the description has no such camera, or the image not its size, or more than 65500 pixels a side */
  void publishImage(std::size_t camera, const ImageView<Rgb8>& pixels, const FrameTimes& times,
                    std::shared_ptr<const void> owner = nullptr);
  /** \brief Whether anybody has subscribed to the images of a camera; before its first one, nobody can. */
  bool imageWanted(std::size_t camera) const;

  ServerStatus status() const;
  /** \brief What happened since the last call, one line each, without tokens: clients that were refused or let go, and why. */
  std::vector<std::string> takeNotices();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fuse_flow::stream
