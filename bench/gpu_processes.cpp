// How much processes slow each other down, each with a GPU: time of a frame from pageable images to a cloud, for one process alone and for
// all at once, interleaved. Each process uses the GPU of its number; if there are fewer GPUs, processes share them.
//
//   fuse_flow_gpu_processes_bench [CAMERASxWIDTHxHEIGHT] [processes] [threads]      64x640x480, 2, 0: the default

#include "median.h"
#include "room.h"

#include <fuse_flow/gpu/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <vector>

namespace {

constexpr int kMost = 16, kRounds = 7, kFrames = 20;

/** \brief In memory that all processes share: whose turn it is, and what they measured. */
struct Shared {
  std::atomic<int> turn{0};  ///< odd: the first process's alone
  std::atomic<int> done{0};
  std::atomic<bool> failed{false};
  std::array<std::array<double, kRounds * kFrames>, kMost> together{};
  std::array<double, kRounds * kFrames> alone{};
  std::array<std::size_t, kMost> points{};
};

struct Size {
  int cameras{64}, width{640}, height{480};
};

/** \brief Sleeps: nothing here must take a core from what is measured. */
template <typename Condition>
void sleepUntil(const Shared& shared, const Condition& condition) {
  while (!condition()) {
    if (shared.failed) throw std::runtime_error("another process has failed");
    usleep(200);
  }
}

void work(Shared& shared, int process, const Size& size, unsigned int threads) {
  int devices = 0;
  fuse_flow::gpu::check(cudaGetDeviceCount(&devices), "cudaGetDeviceCount");
  fuse_flow::gpu::check(cudaSetDevice(process % devices), "cudaSetDevice");
  const bench::Room room(size.cameras, size.width, size.height);
  std::vector<char> images(room.bytes());
  const fuse_flow::RigFrame frame = room.render(images.data(), static_cast<std::uint32_t>(process + 1));
  const fuse_flow::gpu::OwnStream stream;
  fuse_flow::FuseFlow<fuse_flow::PointFused, fuse_flow::device::Thrust> fusion;
  fusion.setStream(stream.get());
  fusion.setNumberOfThreads(threads);
  pcl::PointCloud<fuse_flow::PointFused> cloud;
  for (int k = 0; k < 5; ++k) fusion.fuse(frame, cloud);
  shared.points[static_cast<std::size_t>(process)] = cloud.size();
  ++shared.done;
  for (int turn = 1; turn <= 2 * kRounds; ++turn) {
    sleepUntil(shared, [&] { return shared.turn >= turn; });
    const bool alone = turn % 2 == 1;
    if (!alone || process == 0)
      for (int k = 0; k < kFrames; ++k) {
        const auto start = std::chrono::steady_clock::now();
        fusion.fuse(frame, cloud);
        const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        const auto place = static_cast<std::size_t>((turn - 1) / 2 * kFrames + k);
        (alone ? shared.alone : shared.together[static_cast<std::size_t>(process)])[place] = ms;
      }
    ++shared.done;
  }
}

int run(const Size& size, int processes, unsigned int threads) {
  void* const memory = mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("no memory to share");
  Shared& shared = *new (memory) Shared;
  std::vector<pid_t> children;
  for (int process = 0; process < processes;
       ++process) {  // before anything asks for a GPU, which a fork would not have
    const pid_t child = fork();
    if (child == 0) {
      try {
        work(shared, process, size, threads);
        _exit(0);
      } catch (const std::exception& error) {
        std::fprintf(stderr, "process %d: %s\n", process, error.what());
        shared.failed = true;
        _exit(1);
      }
    }
    children.push_back(child);
  }
  for (int turn = 0; turn <= 2 * kRounds && !shared.failed; ++turn) {
    shared.turn = turn;
    while (shared.done < processes * (turn + 1) && !shared.failed) usleep(200);
  }
  for (const pid_t child : children) waitpid(child, nullptr, 0);
  if (shared.failed) return 1;
  const double alone = bench::median({shared.alone.begin(), shared.alone.end()});
  std::printf("%d x %dx%d, %d processes, threads %u: alone %.2f ms, at once", size.cameras, size.width, size.height,
              processes, threads, alone);
  for (std::size_t process = 0; process < static_cast<std::size_t>(processes); ++process) {
    const double together = bench::median({shared.together[process].begin(), shared.together[process].end()});
    std::printf(" %.2f ms (%.2f)", together, together / alone);
  }
  std::printf(", %zu points\n", shared.points[0]);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Size size;
  if (argc > 1 && std::sscanf(argv[1], "%dx%dx%d", &size.cameras, &size.width, &size.height) != 3) {
    std::fprintf(stderr, "fuse_flow_gpu_processes_bench: %s is no CAMERASxWIDTHxHEIGHT\n", argv[1]);
    return 2;
  }
  const int processes = argc > 2 ? std::max(1, std::min(kMost, std::atoi(argv[2]))) : 2;
  const int threads = argc > 3 ? std::max(0, std::atoi(argv[3])) : 0;
  try {
    return run(size, processes, static_cast<unsigned int>(threads));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fuse_flow_gpu_processes_bench: %s\n", error.what());
    return 1;
  }
}
