// How many clients a server feeds: fuse_flow_stream_clients_bench CLIENTS SECONDS RATE CLOUDS.ffs. Encodes and publishes the clouds in
// turn, RATE a second, for clients of this process that take every frame and do not unpack it. The
// environment's FUSE_FLOW_SERVER_THREADS is ServerOptions::threads.

#include <fuse_flow/point_types.h>
#include <fuse_flow/stream/client.h>
#include <fuse_flow/stream/server.h>
#include <fuse_flow/stream/stream_file.h>

#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <thread>
#include <vector>

namespace {

using namespace fuse_flow;
using Clock = std::chrono::steady_clock;

std::int64_t nanoseconds() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

double processorSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/** \brief What a client saw. */
struct Taken {
  std::uint64_t frames{0}, points{0}, points_of_frames{0};
  std::vector<double> latency;  ///< ms, from what was published to what arrived
};

int run(char** argv) {
  const auto clients = static_cast<std::size_t>(std::max(1, std::atoi(argv[1])));
  const double seconds = std::atof(argv[2]), rate = std::atof(argv[3]);
  stream::StreamReader reader(argv[4]);
  std::vector<pcl::PointCloud<PointFused>> clouds(reader.frames());
  stream::FrameDecoder decoder;
  std::vector<std::uint8_t> message;
  stream::StreamedCloud streamed;
  for (std::size_t k = 0; k < clouds.size(); ++k) {
    reader.read(k, message);
    decoder.decode(message.data(), message.size(), streamed);
    stream::toPointCloud(streamed, clouds[k]);
  }

  stream::ServerOptions options;
  options.port = 0;
  options.clients = clients;
  options.connections = 2 * clients + 10;
  options.connections_per_second = 1000;
  options.encoding.confidence = options.encoding.view_count = false;
  if (std::getenv("FUSE_FLOW_SERVER_THREADS")) options.threads = std::atoi(std::getenv("FUSE_FLOW_SERVER_THREADS"));
  stream::Server server(options);

  std::atomic<bool> measuring{false}, ending{false};
  std::vector<Taken> taken(clients);
  std::vector<std::thread> threads;
  for (Taken& mine : taken)
    threads.emplace_back([&] {
      stream::Client client(server.link());
      stream::ReceivedFrame frame;
      while (!ending) {
        if (!client.pull(frame, std::chrono::milliseconds(200)) || !measuring) continue;
        std::uint32_t of_frame, here;
        std::memcpy(&of_frame, frame.message.data() + 72, 4);
        std::memcpy(&here, frame.message.data() + 76, 4);
        ++mine.frames;
        mine.points += here;
        mine.points_of_frames += of_frame;
        mine.latency.push_back(1e-6 * static_cast<double>(frame.arrived - frame.times.captured));
      }
    });
  while (server.status().clients.size() < clients) std::this_thread::sleep_for(std::chrono::milliseconds(20));

  const auto publish = [&](std::uint64_t number) {
    stream::FrameTimes times;
    times.number = number;
    times.captured = nanoseconds();
    server.publish(clouds[number % clouds.size()], times);
  };
  std::uint64_t number = 0, published = 0;
  Clock::time_point due = Clock::now();
  Clock::time_point start;
  double processor = 0;
  std::vector<double> encoding;
  for (;; ++number) {
    const Clock::time_point now = Clock::now();
    if (!measuring && number >= static_cast<std::uint64_t>(2 * rate)) {  // as many points as they take is known by then
      measuring = true;
      start = now;
      processor = processorSeconds();
    }
    if (measuring && std::chrono::duration<double>(now - start).count() > seconds) break;
    publish(number);
    if (measuring) {
      ++published;
      encoding.push_back(std::chrono::duration<double, std::milli>(Clock::now() - now).count());
    }
    due += std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / rate));
    std::this_thread::sleep_until(due);
  }
  processor = processorSeconds() - processor;
  measuring = false;
  ending = true;
  for (std::thread& thread : threads) thread.join();

  std::vector<double> latency;
  std::uint64_t frames = 0, least = ~std::uint64_t{0};
  double points = 0, points_of_frames = 0;
  for (const Taken& one : taken) {
    frames += one.frames;
    least = std::min(least, one.frames);
    points += static_cast<double>(one.points);
    points_of_frames += static_cast<double>(one.points_of_frames);
    latency.insert(latency.end(), one.latency.begin(), one.latency.end());
  }
  std::sort(latency.begin(), latency.end());
  std::sort(encoding.begin(), encoding.end());
  const auto quantile = [](const std::vector<double>& values, double share) {
    return values.empty() ? 0 : values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  };
  std::printf(
      "%zu clients, %.1f published a second, of %.0f points; each client took %.1f a second (the least %.1f), %.0f %% "
      "of "
      "the points; encoding %.1f ms (median), from before encoding to arrival %.1f ms (median; 95 %%: %.1f); %.2f "
      "cores\n",
      clients, static_cast<double>(published) / seconds,
      points_of_frames / std::max<double>(1, static_cast<double>(frames)),
      static_cast<double>(frames) / static_cast<double>(clients) / seconds, static_cast<double>(least) / seconds,
      100 * points / std::max(1.0, points_of_frames), quantile(encoding, 0.5), quantile(latency, 0.5),
      quantile(latency, 0.95), processor / seconds);
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 5 || std::atof(argv[3]) <= 0) {
    std::fprintf(stderr, "usage: fuse_flow_stream_clients_bench CLIENTS SECONDS RATE CLOUDS.ffs\n");
    return 2;
  }
  return run(argv);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
