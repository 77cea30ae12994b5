// One frame over several GPUs, a rank and a GPU each, beside one GPU with all of it: latency, where the time goes, bytes between the
// ranks, and whether the points are the same.
//   mpirun -n RANKS --bind-to none fuse_flow_multi_gpu_bench [--staged] [--interleaved] [CAMERAS WIDTH HEIGHT]      128 640 480
//   --staged       pixels go through host memory, not NCCL
//   --interleaved  camera i at rank i mod RANKS; otherwise each rank has cameras that stand beside each other
//   --in-flight    instead: several frames at a time over all ranks; frames a second
//   --frames       instead: every rank fuses every RANKS-th frame, all of it, several in flight; frames a second of all ranks

#include "gpu_in_flight.h"
#include "gpu_stages.h"

#include <fuse_flow/distributed/gpu/frames_in_flight.h>
#include <fuse_flow/distributed/gpu/fuse_flow.h>
#include <fuse_flow/distributed/mpi_communicator.h>

#if defined(FUSE_FLOW_WITH_NCCL)
#include <fuse_flow/distributed/gpu/nccl_exchange.h>
#define FUSE_FLOW_BENCH_NCCL 1
#else
#define FUSE_FLOW_BENCH_NCCL 0
#endif

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <memory>

namespace {

using namespace bench;
using Ranks = fuse_flow::distributed::FuseFlow<Point, fuse_flow::device::Thrust>;
using fuse_flow::distributed::PartStatistics;
using PointSpan = fuse_flow::gpu::PointSpan<Point>;

constexpr int kRepeats = 61;

struct Options {
  Size size{128, 640, 480};
  bool staged{false}, interleaved{false}, in_flight{false}, frames{false};
};

int rankOfProcess() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}
int rankCount() {
  int size = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  return size;
}

/** \brief A frame with the views of one rank. */
fuse_flow::RigFrame partOf(const fuse_flow::RigFrame& frame, bool interleaved) {
  const auto rank = static_cast<std::size_t>(rankOfProcess()), ranks = static_cast<std::size_t>(rankCount());
  fuse_flow::RigFrame part = frame;
  const std::size_t n = part.views.size();
  for (std::size_t i = 0; i < n; ++i)
    if ((interleaved ? i % ranks : i * ranks / n) != rank) part.views[i] = {};
  return part;
}

/** \brief Milliseconds until the last rank is done with a frame that all begin at once: the median after warming up. */
double latencyOfAll(const Frames& frames, const std::function<void(const fuse_flow::RigFrame&)>& fuse,
                    bool interleaved) {
  std::vector<double> times;
  for (int k = -9; k < kRepeats; ++k) {
    const fuse_flow::RigFrame part = partOf(frames.at(static_cast<std::size_t>(k + 9)), interleaved);
    MPI_Barrier(MPI_COMM_WORLD);
    const Clock::time_point start = Clock::now();
    fuse(part);
    double own = since(start), longest = 0;
    MPI_Allreduce(&own, &longest, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    if (k >= 0) times.push_back(longest);
  }
  return median(times);
}

/** \brief Prints one rank after the other. */
void inTurn(const std::function<void()>& print) {
  for (int rank = 0; rank < rankCount(); ++rank) {
    MPI_Barrier(MPI_COMM_WORLD);
    if (rank != rankOfProcess()) continue;
    print();
    std::fflush(stdout);
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

/** \brief Medians of a rank's stages, in their order. */
class RankTimes {
 public:
  void add(const std::vector<Stage>& stages, const PartStatistics& part) {
    order_.clear();
    std::map<std::string, double> sums;  // a stage may come several times
    for (const Stage& stage : stages) {
      if (sums.count(stage.name) == 0) order_.push_back(stage.name);
      sums[stage.name] += stage.ms;
    }
    for (const auto& [name, ms] : sums) ms_[name].push_back(ms);
    summary_.push_back(part.summary_ms);
    exchange_.push_back(part.exchange_ms);
    last_ = part;
  }

  void print() const {
    std::printf(
        "rank %d: %zu views, %zu cells, %zu points (%zu of others), sent %.1f MB (points alone %.1f MB), received %.1f "
        "MB; host: until all have met %.2f ms, until all has come and is in its cells %.2f ms\n ",
        rankOfProcess(), last_.views, last_.cells, last_.points, last_.foreign_points,
        1e-6 * static_cast<double>(last_.bytes_sent), 1e-6 * static_cast<double>(last_.bytes_of_points),
        1e-6 * static_cast<double>(last_.bytes_received), median(summary_), median(exchange_));
    double sum = 0;
    for (const std::string& name : order_) {
      std::printf(" %s %.3f,", name.c_str(), median(ms_.at(name)));
      sum += median(ms_.at(name));
    }
    std::printf(" together %.3f ms\n", sum);
  }

 private:
  std::vector<std::string> order_;
  std::map<std::string, std::vector<double>> ms_;
  std::vector<double> summary_, exchange_;
  PartStatistics last_;
};

using PointBytes = std::array<char, sizeof(Point)>;

std::vector<PointBytes> bytesOf(const PointSpan& points) {
  std::vector<PointBytes> bytes(points.size);
  if (points.size > 0) std::memcpy(bytes.data(), static_cast<const void*>(points.points), points.size * sizeof(Point));
  return bytes;
}

/** \brief At rank 0 the points of all ranks. */
std::vector<PointBytes> gather(const PointSpan& points) {
  std::vector<PointBytes> all = bytesOf(points);
  const std::size_t piece = 1 << 24;
  const auto count = [=](std::size_t begin, std::size_t size) {
    return static_cast<int>(std::min(piece, size - begin) * sizeof(Point));
  };
  std::uint64_t size = points.size;
  if (rankOfProcess() != 0) {
    MPI_Send(&size, sizeof size, MPI_BYTE, 0, 1, MPI_COMM_WORLD);
    for (std::size_t k = 0; k < size; k += piece)
      MPI_Send(all.data() + k, count(k, size), MPI_BYTE, 0, 2, MPI_COMM_WORLD);
    return {};
  }
  for (int rank = 1; rank < rankCount(); ++rank) {
    MPI_Recv(&size, sizeof size, MPI_BYTE, rank, 1, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    const std::size_t begin = all.size();
    all.resize(begin + size);
    for (std::size_t k = 0; k < size; k += piece)
      MPI_Recv(all.data() + begin + k, count(k, size), MPI_BYTE, rank, 2, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  }
  return all;
}

/** \brief What one GPU does with all of a frame, at rank 0; others wait. */
struct OneGpu {
  double pinned_ms{0}, device_ms{0};
  std::vector<PointBytes> points;  ///< of the first frame, sorted
};

OneGpu measureOne(const Frames& frames) {
  OneGpu result;
  if (rankOfProcess() == 0) {
    const fuse_flow::gpu::OwnStream stream;
    {
      Gpu fusion;
      fusion.setStream(stream.get());
      result.pinned_ms = latency(fusion, frames, kRoutes[0], kRepeats);
      std::vector<double> times;
      for (int k = 0; k < kRepeats; ++k) {
        const Clock::time_point start = Clock::now();
        fusion.fuseOnDevice(frames.at(static_cast<std::size_t>(k)));
#if FUSE_FLOW_CUDA
        fuse_flow::gpu::check(cudaStreamSynchronize(stream.get()), "cudaStreamSynchronize");
#endif
        times.push_back(since(start));
      }
      result.device_ms = median(times);
      measureStages(fusion, frames, kRepeats).print(measureBandwidth(true));
      result.points = bytesOf(fusion.fusePinned(frames.at(0)));
      std::sort(result.points.begin(), result.points.end());
    }
    std::printf("one GPU: %.2f ms to pinned memory, %.2f ms on the device, %zu points; frames/s in flight:",
                result.pinned_ms, result.device_ms, result.points.size());
    for (const std::size_t lanes : {std::size_t{3}, std::size_t{6}})
      std::printf(" %.0f with %zu", framesPerSecond(frames, kRoutes[0], lanes, {}, 500), lanes);
    std::printf("\n");
    std::fflush(stdout);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  return result;
}

std::unique_ptr<fuse_flow::distributed::DeviceExchange> makeExchange(fuse_flow::distributed::Communicator& ranks,
                                                                     bool staged) {
#if FUSE_FLOW_BENCH_NCCL
  if (!staged) return std::make_unique<fuse_flow::distributed::NcclExchange>(ranks);
#endif
  (void)staged;
  return std::make_unique<fuse_flow::distributed::StagedExchange>(ranks);
}

/** \brief Returns whether the points are those of one GPU. */
bool measureAll(const Frames& frames, const Options& options, const OneGpu& one) {
  fuse_flow::distributed::MpiCommunicator communicator(MPI_COMM_WORLD, 60);
  const auto exchange = makeExchange(communicator, options.staged);
  const fuse_flow::gpu::OwnStream stream;
  Ranks fusion(communicator, *exchange);
  fusion.setStream(stream.get());
  const double pinned = latencyOfAll(
      frames, [&](const fuse_flow::RigFrame& part) { fusion.fusePinned(part); }, options.interleaved);
  const double device = latencyOfAll(
      frames,
      [&](const fuse_flow::RigFrame& part) {
        fusion.fuseOnDevice(part);
#if FUSE_FLOW_CUDA
        fuse_flow::gpu::check(cudaStreamSynchronize(stream.get()), "cudaStreamSynchronize");
#endif
      },
      options.interleaved);
  if (rankOfProcess() == 0) {
    std::printf("%d GPUs, %s, %s: %.2f ms to pinned memory (%.2f of one's), %.2f ms on the device (%.2f of one's)\n",
                rankCount(), FUSE_FLOW_BENCH_NCCL && !options.staged ? "NCCL" : "through host memory",
                options.interleaved ? "cameras in turn" : "cameras beside each other", pinned, pinned / one.pinned_ms,
                device, device / one.device_ms);
    std::printf("imbalance %.3f\n", fusion.getPartStatistics().imbalance);
  }
  RankTimes times;
  fusion.stageTimes().enabled = true;
  for (int k = 0; k < kRepeats; ++k) {
    MPI_Barrier(MPI_COMM_WORLD);
    fusion.fusePinned(partOf(frames.at(static_cast<std::size_t>(k)), options.interleaved));
    times.add(fusion.stageTimes().stages(), fusion.getPartStatistics());
  }
  fusion.stageTimes().enabled = false;
  inTurn([&] { times.print(); });
  std::vector<PointBytes> all = gather(fusion.fusePinned(partOf(frames.at(0), options.interleaved)));
  int same = 1;
  if (rankOfProcess() == 0) {
    std::sort(all.begin(), all.end());
    same = all == one.points ? 1 : 0;
    std::printf("%zu points on all GPUs, %zu on one: %s\n", all.size(), one.points.size(),
                same ? "the same bytes" : "DIFFERENT");
  }
  MPI_Bcast(&same, 1, MPI_INT, 0, MPI_COMM_WORLD);
  return same != 0;
}

/** \brief Several frames at a time, each over all ranks. */
bool measureInFlight(const Frames& frames, const Options& options) {
  constexpr std::size_t kMost = 6, kDifferent = Frames::kCount, kFrames = 120;
  std::vector<fuse_flow::RigFrame> parts;
  for (std::size_t k = 0; k < kDifferent; ++k) parts.push_back(partOf(frames.at(k), options.interleaved));
  std::vector<std::unique_ptr<fuse_flow::distributed::MpiCommunicator>> ranks;
  for (std::size_t k = 0; k < kMost; ++k)
    ranks.push_back(std::make_unique<fuse_flow::distributed::MpiCommunicator>(MPI_COMM_WORLD, 60));
  fuse_flow::distributed::MpiCommunicator more(MPI_COMM_WORLD, 60);
  const auto exchange = makeExchange(more, options.staged);
  double alone = 0;
  std::vector<PointBytes> expected;
  if (rankOfProcess() == 0) {
    for (const std::size_t lanes : {std::size_t{3}, std::size_t{6}})
      alone = std::max(alone, framesPerSecond(frames, kRoutes[0], lanes, {}, 1000));
    Gpu one;
    expected = bytesOf(one.fusePinned(frames.at((kFrames - 1) % kDifferent)));
    std::sort(expected.begin(), expected.end());
    std::printf("one GPU alone: %.0f frames/s\n", alone);
    std::fflush(stdout);
  }
  int right = 1;
  for (const std::size_t lanes : {std::size_t{1}, std::size_t{2}, std::size_t{3}, std::size_t{4}, kMost}) {
    std::vector<fuse_flow::distributed::Communicator*> own;
    for (std::size_t k = 0; k < lanes; ++k) own.push_back(ranks[k].get());
    fuse_flow::distributed::FramesInFlight<Point, fuse_flow::device::Thrust> fusion(own, *exchange);
    fusion.setCopyAhead(false);
    std::vector<double> rates;
    std::vector<PointBytes> last;
    for (int run = -1; run < 3; ++run) {
      MPI_Barrier(MPI_COMM_WORLD);
      const Clock::time_point start = Clock::now();
      for (std::size_t k = 0; k < kFrames; ++k) {
        if (fusion.inFlight() == lanes) fusion.nextPinned([](const PointSpan&) {});
        fusion.submit(parts[k % kDifferent]);
      }
      while (fusion.inFlight() > 0)
        fusion.nextPinned([&](const PointSpan& points) {
          if (run == 2 && fusion.inFlight() == 0) last = bytesOf(points);
        });
      MPI_Barrier(MPI_COMM_WORLD);
      if (run >= 0) rates.push_back(1e3 * static_cast<double>(kFrames) / since(start));
    }
    std::vector<PointBytes> all = gather({reinterpret_cast<const Point*>(last.data()), last.size()});
    if (rankOfProcess() == 0) {
      std::sort(all.begin(), all.end());
      const bool same = all == expected;
      right = right && same ? 1 : 0;
      std::printf("%zu in flight over %d GPUs: %.0f frames/s (%.2f times), %.0f to %.0f; %s\n", lanes, rankCount(),
                  median(rates), median(rates) / alone, *std::min_element(rates.begin(), rates.end()),
                  *std::max_element(rates.begin(), rates.end()), same ? "the same bytes" : "DIFFERENT");
      std::fflush(stdout);
    }
  }
  MPI_Bcast(&right, 1, MPI_INT, 0, MPI_COMM_WORLD);
  return right != 0;
}

/** \brief Whole frames, each at one rank. */
void measureFrames(const Frames& frames) {
  for (const std::size_t lanes : {std::size_t{1}, std::size_t{3}, std::size_t{6}}) {
    double alone = 0;
    if (rankOfProcess() == 0) alone = framesPerSecond(frames, kRoutes[0], lanes, {}, 1000);
    MPI_Barrier(MPI_COMM_WORLD);
    double own = framesPerSecond(frames, kRoutes[0], lanes, {}, 2000), sum = 0;
    MPI_Reduce(&own, &sum, 1, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
    if (rankOfProcess() == 0)
      std::printf("%zu in flight: one GPU alone %.0f frames/s, %d GPUs together %.0f (%.2f times)\n", lanes, alone,
                  rankCount(), sum, sum / alone);
    std::fflush(stdout);
    MPI_Barrier(MPI_COMM_WORLD);
  }
}

bool parse(int argc, char** argv, Options& options) {
  std::vector<int> numbers;
  for (int k = 1; k < argc; ++k) {
    const std::string argument = argv[k];
    if (argument == "--staged") {
      options.staged = true;
    } else if (argument == "--interleaved") {
      options.interleaved = true;
    } else if (argument == "--in-flight") {
      options.in_flight = true;
    } else if (argument == "--frames") {
      options.frames = true;
    } else if (const int number = std::atoi(argv[k]); number > 0) {
      numbers.push_back(number);
    } else {
      std::fprintf(stderr, "fuse_flow_multi_gpu_bench: %s?\n", argv[k]);
      return false;
    }
  }
  if (numbers.empty()) return true;
  if (numbers.size() != 3) return false;
  options.size = {numbers[0], numbers[1], numbers[2]};
  return true;
}

int run(int argc, char** argv) {
  Options options;
  if (!parse(argc, argv, options)) return 2;
#if FUSE_FLOW_CUDA
  int devices = 0;
  fuse_flow::gpu::check(cudaGetDeviceCount(&devices), "cudaGetDeviceCount");
  fuse_flow::gpu::check(cudaSetDevice(rankOfProcess() % devices), "cudaSetDevice");
#endif
  const Frames frames(options.size);
  MPI_Barrier(MPI_COMM_WORLD);
  if (rankOfProcess() == 0)
    std::printf("%s, %d threads a rank\n", options.size.name().c_str(), fuse_flow::host::resolveThreads(0));
  if (options.frames) {
    measureFrames(frames);
    return 0;
  }
  if (options.in_flight) return measureInFlight(frames, options) ? 0 : 1;
  const OneGpu one = measureOne(frames);
  return measureAll(frames, options, one) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_MULTIPLE, &provided);
  if (provided < MPI_THREAD_MULTIPLE) {
    std::fprintf(stderr, "fuse_flow_multi_gpu_bench: this MPI does not allow several threads at once\n");
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
  int status = 1;
  try {
    status = run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fuse_flow_multi_gpu_bench, rank %d: %s\n", rankOfProcess(), error.what());
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
  MPI_Finalize();
  return status;
}
