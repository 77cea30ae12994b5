// Clients that come and go: fuse_flow_stream_soak MINUTES [CLIENTS]. Prints each minute what memory and descriptors the process has.

#include "process_state.h"
#include "restless_clients.h"

#include <fuse_flow/point_types.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
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

int run(double minutes, int count) {
  stream::ServerOptions options;
  options.port = 0;
  options.connections_per_second = 1000;
  stream::Server server(options);
  bench::RestlessClients clients(server, count);
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
      const bench::ProcessState state = bench::processState();
      std::printf("%5.1f min: %.1f MB, %zu descriptors, %zu clients now; %llu came, %llu frames, %llu that were none\n",
                  past, state.megabytes, state.descriptors, status.clients.size(),
                  static_cast<unsigned long long>(clients.came()), static_cast<unsigned long long>(clients.frames()),
                  static_cast<unsigned long long>(clients.intruders()));
      std::fflush(stdout);
    }
    if (past > minutes) break;
    server.publish(clouds[number % clouds.size()], {number, 0, 0});
    due += std::chrono::milliseconds(33);
    std::this_thread::sleep_until(due);
  }
  clients.stop();
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const bench::ProcessState state = bench::processState();
  std::printf("at the end: %.1f MB, %zu descriptors, %zu clients\n", state.megabytes, state.descriptors,
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
