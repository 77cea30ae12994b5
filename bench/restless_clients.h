#pragma once

/** \file
 *  \brief Clients of a stream::Server that come with all kinds of wishes, stay for up to three seconds, read or do not, and leave with or without a word;
 *  among them some that are no clients at all. */

#include <fuse_flow/stream/client.h>
#include <fuse_flow/stream/server.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace bench {

/** \brief Says something that is no request, and is gone. */
inline void intrude(std::uint16_t port, std::mt19937& random) {
  const int socket_here = socket(AF_INET, SOCK_STREAM, 0);
  if (socket_here < 0) return;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(socket_here, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0) {
    std::string garbage(random() % 2000, '\0');
    for (char& c : garbage) c = static_cast<char>(random());
    (void)!write(socket_here, garbage.data(), garbage.size());
    std::this_thread::sleep_for(std::chrono::milliseconds(random() % 300));
    const linger now{1, 0};
    if (random() % 2) setsockopt(socket_here, SOL_SOCKET, SO_LINGER, &now, sizeof(now));  // a reset
  }
  close(socket_here);
}

/** \brief Threads, each of which is one client after the other until stop(). */
class RestlessClients {
 public:
  RestlessClients(const fuse_flow::stream::Server& server, int clients) {
    for (int k = 0; k < clients; ++k)
      threads_.emplace_back([this, &server, k] { run(server, static_cast<unsigned int>(k)); });
  }
  ~RestlessClients() { stop(); }
  RestlessClients(const RestlessClients&) = delete;
  RestlessClients& operator=(const RestlessClients&) = delete;

  void stop() {
    ending_ = true;
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }

  std::uint64_t came() const { return came_; }
  std::uint64_t frames() const { return frames_; }
  std::uint64_t intruders() const { return intruders_; }

 private:
  void run(const fuse_flow::stream::Server& server, unsigned int seed) {
    namespace stream = fuse_flow::stream;
    using Clock = std::chrono::steady_clock;
    std::mt19937 random(seed);
    while (!ending_) {
      if (random() % 4 == 0) {
        ++intruders_;
        intrude(server.port(), random);
        continue;
      }
      stream::ClientOptions options;
      if (random() % 2) options.wishes.points = 1000 + random() % 60000;
      if (random() % 3 == 0) options.wishes.step = 0.001 * (1 + random() % 10);
      if (random() % 3 == 0) options.wishes.region = stream::Wishes::Box{{-1, -1, 0}, {1, 1, 1}};
      stream::Client client(server.link(), options);
      ++came_;
      const Clock::time_point leave = Clock::now() + std::chrono::milliseconds(random() % 3000);
      const bool reads = random() % 5 != 0;
      stream::ReceivedFrame frame;
      while (Clock::now() < leave && !ending_) {
        if (!reads) {
          std::this_thread::sleep_for(std::chrono::milliseconds(50));
        } else if (client.pull(frame, std::chrono::milliseconds(100))) {
          ++frames_;
        }
      }
    }
  }

  std::atomic<bool> ending_{false};
  std::atomic<std::uint64_t> came_{0}, frames_{0}, intruders_{0};
  std::vector<std::thread> threads_;
};

}  // namespace bench
