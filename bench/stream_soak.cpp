// Clients that come and go: fuse_flow_stream_soak MINUTES [CLIENTS]. Prints each minute what memory and descriptors the process has.
// They come with all kinds of wishes, stay for up to three seconds, read or do not, and leave with or without a word.

#include <fuse_flow/point_types.h>
#include <fuse_flow/stream/client.h>
#include <fuse_flow/stream/server.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace fuse_flow;
using Clock = std::chrono::steady_clock;

/** \brief A ball that breathes: 50,000 points. */
pcl::PointCloud<PointFused> ball(double radius) {
  pcl::PointCloud<PointFused> cloud;
  constexpr int count = 50000;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - 2 * (i + 0.5) / count, r = std::sqrt(1 - z * z), angle = 2.399963 * i;
    PointFused point;
    point.x = static_cast<float>(radius * r * std::cos(angle));
    point.y = static_cast<float>(radius * r * std::sin(angle));
    point.z = static_cast<float>(radius * z);
    point.r = static_cast<std::uint8_t>(i);
    cloud.push_back(point);
  }
  return cloud;
}

double residentMegabytes() {
  std::ifstream file("/proc/self/statm");
  long all = 0, resident = 0;
  file >> all >> resident;
  return 1e-6 * static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

std::size_t descriptors() {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) count += entry.exists() ? 1 : 0;
  return count;
}

/** \brief Says something that is no request, and is gone. */
void intrude(std::uint16_t port, std::mt19937& random) {
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

int run(double minutes, int clients) {
  stream::ServerOptions options;
  options.port = 0;
  options.connections_per_second = 1000;
  stream::Server server(options);
  std::atomic<bool> ending{false};
  std::atomic<std::uint64_t> came{0}, frames{0}, intruders{0};
  std::vector<std::thread> threads;
  for (int k = 0; k < clients; ++k)
    threads.emplace_back([&, k] {
      std::mt19937 random(static_cast<unsigned int>(k));
      while (!ending) {
        if (random() % 4 == 0) {
          ++intruders;
          intrude(server.port(), random);
          continue;
        }
        stream::ClientOptions of_client;
        if (random() % 2) of_client.wishes.points = 1000 + random() % 60000;
        if (random() % 3 == 0) of_client.wishes.step = 0.001 * (1 + random() % 10);
        if (random() % 3 == 0) of_client.wishes.region = stream::Wishes::Box{{-1, -1, 0}, {1, 1, 1}};
        stream::Client client(server.link(), of_client);
        ++came;
        const Clock::time_point leave = Clock::now() + std::chrono::milliseconds(random() % 3000);
        const bool reads = random() % 5 != 0;
        stream::ReceivedFrame frame;
        while (Clock::now() < leave && !ending) {
          if (!reads) {
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
          } else if (client.pull(frame, std::chrono::milliseconds(100))) {
            ++frames;
          }
        }
      }
    });
  std::vector<pcl::PointCloud<PointFused>> clouds;
  for (int k = 0; k < 8; ++k) clouds.push_back(ball(1 + 0.1 * k));
  const Clock::time_point start = Clock::now();
  Clock::time_point due = start, report = start;
  for (std::uint64_t number = 0;; ++number) {
    const double past = std::chrono::duration<double>(Clock::now() - start).count() / 60;
    if (Clock::now() >= report || past > minutes) {
      report += std::chrono::minutes(1);
      const stream::ServerStatus status = server.status();
      server.takeNotices();
      std::printf("%5.1f min: %.1f MB, %zu descriptors, %zu clients now; %llu came, %llu frames, %llu that were none\n",
                  past, residentMegabytes(), descriptors(), status.clients.size(),
                  static_cast<unsigned long long>(came), static_cast<unsigned long long>(frames),
                  static_cast<unsigned long long>(intruders));
      std::fflush(stdout);
    }
    if (past > minutes) break;
    server.publish(clouds[number % clouds.size()], {number, 0, 0});
    due += std::chrono::milliseconds(33);
    std::this_thread::sleep_until(due);
  }
  ending = true;
  for (std::thread& thread : threads) thread.join();
  std::this_thread::sleep_for(std::chrono::seconds(2));
  std::printf("at the end: %.1f MB, %zu descriptors, %zu clients\n", residentMegabytes(), descriptors(),
              server.status().clients.size());
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2 || !(std::atof(argv[1]) > 0)) {
    std::fprintf(stderr, "usage: fuse_flow_stream_soak MINUTES [CLIENTS]\n");
    return 2;
  }
  return run(std::atof(argv[1]), argc > 2 ? std::max(1, std::atoi(argv[2])) : 8);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
