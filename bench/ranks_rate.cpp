// Frames a second of several ranks, each on its CPUs, from images in memory to the whole cloud at rank 0, with one or more frames in flight.
//   mpirun -n RANKS fuse_flow_ranks_rate_bench [--zstd] [--all-cores] [CAMERAS WIDTH HEIGHT]      4 640 480
//   sudo bench/emulated_network.sh 1gbit 2 build/bin/fuse_flow_ranks_rate_bench    as if each rank were a computer of its own
//   --zstd       what ranks send is compressed
//   --all-cores  a thread for each core, for ranks that have a computer each; otherwise one thread a frame in flight

#include "median.h"
#include "room.h"

#include <fuse_flow/distributed/frames_in_flight.h>
#include <fuse_flow/distributed/mpi_communicator.h>
#include <fuse_flow/point_types.h>

#if defined(FUSE_FLOW_WITH_ZSTD)
#include <fuse_flow/distributed/zstd_codec.h>
#endif

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace {

using fuse_flow::distributed::Communicator;
using fuse_flow::distributed::MpiCommunicator;
using InFlight = fuse_flow::distributed::FramesInFlight<fuse_flow::PointFused>;

struct Options {
  std::vector<int> size{4, 640, 480};
  bool compresses{false};
  unsigned int threads{1};
};

std::shared_ptr<const fuse_flow::distributed::Codec> codecOf(const Options& options) {
  if (!options.compresses) return nullptr;
#if defined(FUSE_FLOW_WITH_ZSTD)
  return std::make_shared<fuse_flow::distributed::ZstdCodec>();
#else
  std::fprintf(stderr, "fuse_flow_ranks_rate_bench: built without Zstandard\n");
  std::exit(2);
#endif
}

/** \brief Frames of one rank, each with memory of its own. */
class Parts {
 public:
  static constexpr std::size_t kCount = 3;

  Parts(const Options& options, int rank, int ranks) : room_(options.size[0], options.size[1], options.size[2]) {
    for (std::size_t k = 0; k < kCount; ++k) {
      memory_[k].resize(room_.bytes());
      frames_[k] = room_.render(memory_[k].data(), static_cast<std::uint32_t>(k));
      const int cameras = options.size[0];
      for (int i = 0; i < cameras; ++i)
        if (i * ranks / cameras != rank) frames_[k].views[static_cast<std::size_t>(i)] = {};
    }
  }
  const fuse_flow::RigFrame& at(std::size_t k) const { return frames_[k % kCount]; }

 private:
  bench::Room room_;
  std::vector<char> memory_[kCount];
  fuse_flow::RigFrame frames_[kCount];
};

/** \brief Of a run, milliseconds from frame to frame. */
double millisecondsAFrame(InFlight& fusion, std::size_t lanes, const Parts& parts, std::size_t frames) {
  MPI_Barrier(MPI_COMM_WORLD);
  const auto start = std::chrono::steady_clock::now();
  pcl::PointCloud<fuse_flow::PointFused> cloud;
  for (std::size_t k = 0; k < frames; ++k) {
    if (fusion.inFlight() == lanes) fusion.next(cloud);
    fusion.submit(parts.at(k));
  }
  while (fusion.inFlight() > 0) fusion.next(cloud);
  MPI_Barrier(MPI_COMM_WORLD);
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
  return taken.count() / static_cast<double>(frames);
}

void run(const Options& options) {
  constexpr std::size_t kLanes = 3, kRuns = 3, kFrames = 12;
  std::vector<std::unique_ptr<MpiCommunicator>> ranks;
  for (std::size_t k = 0; k < kLanes; ++k) ranks.push_back(std::make_unique<MpiCommunicator>(MPI_COMM_WORLD, 60));
  const Parts parts(options, ranks[0]->rank(), ranks[0]->size());
  const bool first = ranks[0]->rank() == 0;
  if (first)
    std::printf("%d cameras of %dx%d, %d ranks, threads of a frame: %d%s\n", options.size[0], options.size[1],
                options.size[2], ranks[0]->size(), fuse_flow::host::resolveThreads(static_cast<int>(options.threads)),
                options.compresses ? ", compressed" : "");
  std::vector<std::unique_ptr<InFlight>> fusions;
  for (std::size_t lanes = 1; lanes <= kLanes; ++lanes) {
    std::vector<Communicator*> own;
    for (std::size_t k = 0; k < lanes; ++k) own.push_back(ranks[k].get());
    fusions.push_back(std::make_unique<InFlight>(own));
    fusions.back()->setGatherAt(0);
    fusions.back()->forEachLane([&](InFlight::Fusion& lane) {
      lane.setNumberOfThreads(options.threads);
      lane.setCodec(codecOf(options));
    });
    millisecondsAFrame(*fusions.back(), lanes, parts, 2 * lanes);
  }
  std::vector<std::vector<double>> times(kLanes);
  for (std::size_t run = 0; run < kRuns; ++run)  // in turns
    for (std::size_t k = 0; k < kLanes; ++k) times[k].push_back(millisecondsAFrame(*fusions[k], k + 1, parts, kFrames));
  const double megabytes = 1e-6 * static_cast<double>(fusions[0]->getPartStatistics().bytes_sent +
                                                      fusions[0]->getPartStatistics().bytes_received);
  for (std::size_t k = 0; first && k < kLanes; ++k)
    std::printf("%zu in flight: %.1f ms a frame (%.1f to %.1f), %.1f frames a second, %.2f MB to and from rank 0\n",
                k + 1, bench::median(times[k]), *std::min_element(times[k].begin(), times[k].end()),
                *std::max_element(times[k].begin(), times[k].end()), 1e3 / bench::median(times[k]), megabytes);
}

}  // namespace

int main(int argc, char** argv) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_MULTIPLE, &provided);
  if (provided < MPI_THREAD_MULTIPLE) {
    std::fprintf(stderr, "fuse_flow_ranks_rate_bench: this MPI does not allow several threads at once\n");
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
  Options options;
  std::vector<int> numbers;
  for (int k = 1; k < argc; ++k) {
    if (std::string(argv[k]) == "--zstd") {
      options.compresses = true;
    } else if (std::string(argv[k]) == "--all-cores") {
      options.threads = 0;
    } else if (std::atoi(argv[k]) > 0) {
      numbers.push_back(std::atoi(argv[k]));
    } else {
      numbers.assign(1, 0);  // not known
      break;
    }
  }
  if (!numbers.empty() && numbers.size() != 3) {
    std::fprintf(stderr, "fuse_flow_ranks_rate_bench: [--zstd] [--all-cores] [CAMERAS WIDTH HEIGHT]\n");
    MPI_Abort(MPI_COMM_WORLD, 2);
  }
  if (numbers.size() == 3) options.size = numbers;
  try {
    run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fuse_flow_ranks_rate_bench: %s\n", error.what());
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
  MPI_Finalize();
}
