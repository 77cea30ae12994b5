// Time of a frame while other processes keep cores busy, on one thread and on one thread for each core: without another process, with a
// process that computes, and with a process of low priority that copies memory. All cases are interleaved, on the same cores, with
// processes that this program starts. Linux only.
//
//   fuse_flow_busy_bench [cameras] [cores] [rounds]      4 cameras, 2 cores, 10 rounds

#include "median.h"
#include "room.h"

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <sched.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace {

enum class Neighbour { None, Computing, Copying };

const char* nameOf(Neighbour neighbour) {
  if (neighbour == Neighbour::None) return "alone";
  return neighbour == Neighbour::Computing ? "beside a busy process" : "beside one that copies memory, nice 19";
}

[[noreturn]] void compute() {
  volatile unsigned long number = 0;
  while (true) number = number + 1;
}

[[noreturn]] void copyMemory() {
  if (setpriority(PRIO_PROCESS, 0, 19) != 0) _exit(1);
  std::vector<char> from(std::size_t{256} << 20, 1), to(from.size(), 2);
  while (true) {
    std::memcpy(to.data(), from.data(), to.size());
    asm volatile("" : : "r"(to.data()) : "memory");  // it is read, or nothing need be copied
    std::memcpy(from.data(), to.data(), to.size());
    asm volatile("" : : "r"(from.data()) : "memory");
  }
}

/** \brief A process that runs until this one has what it wants. */
class BusyProcess {
 public:
  explicit BusyProcess(Neighbour neighbour) {
    if (neighbour == Neighbour::None) return;
    process_ = fork();
    if (process_ < 0) throw std::runtime_error("no process can be started");
    if (process_ == 0) neighbour == Neighbour::Computing ? compute() : copyMemory();
    usleep(300000);  // until its memory is there
  }
  BusyProcess(const BusyProcess&) = delete;
  ~BusyProcess() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }

 private:
  pid_t process_{0};
};

/** \brief The first so many of the cores that this process may use, for it and its children. \returns how many there are */
int useCores(int cores) {
  cpu_set_t allowed, used;
  if (sched_getaffinity(0, sizeof(allowed), &allowed) != 0) throw std::runtime_error("the cores cannot be asked for");
  CPU_ZERO(&used);
  for (std::size_t core = 0; core < CPU_SETSIZE && CPU_COUNT(&used) < cores; ++core)
    if (CPU_ISSET(core, &allowed)) CPU_SET(core, &used);
  if (sched_setaffinity(0, sizeof(used), &used) != 0) throw std::runtime_error("the cores cannot be chosen");
  return CPU_COUNT(&used);
}

std::uint64_t checksum(const pcl::PointCloud<fuse_flow::PointFused>& cloud) {
  std::uint64_t sum = 14695981039346656037u;
  const auto* bytes = reinterpret_cast<const unsigned char*>(cloud.points.data());
  for (std::size_t k = 0; k < cloud.size() * sizeof(fuse_flow::PointFused); ++k)
    sum = (sum ^ bytes[k]) * 1099511628211u;
  return sum;
}

struct Condition {
  Neighbour neighbour;
  int threads;
};

int run(int cameras, int wanted_cores, int rounds) {
  constexpr int frames = 8;
  const int cores = useCores(wanted_cores);
  const bench::Room room(cameras, 640, 480);
  std::vector<char> images(room.bytes());
  const fuse_flow::RigFrame frame = room.render(images.data(), 1);
  const std::vector<Condition> conditions = {{Neighbour::None, 1},      {Neighbour::None, cores},
                                             {Neighbour::Computing, 1}, {Neighbour::Computing, cores},
                                             {Neighbour::Copying, 1},   {Neighbour::Copying, cores}};
  std::vector<std::vector<double>> times(conditions.size());
  std::vector<std::uint64_t> sums;
  fuse_flow::FuseFlow<fuse_flow::PointFused> fusion;
  pcl::PointCloud<fuse_flow::PointFused> cloud;
  for (int round = 0; round < rounds; ++round)
    for (std::size_t c = 0; c < conditions.size(); ++c) {
      const BusyProcess neighbour(conditions[c].neighbour);
      fusion.setNumberOfThreads(static_cast<unsigned int>(conditions[c].threads));
      fusion.fuse(frame, cloud);
      for (int k = 0; k < frames; ++k) {
        const auto start = std::chrono::steady_clock::now();
        fusion.fuse(frame, cloud);
        times[c].push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
      }
      sums.push_back(checksum(cloud));
    }
  std::printf("%d cameras of 640x480 on %d cores, medians of %d frames, in turns\n", cameras, cores, rounds * frames);
  std::printf("%-40s %8s %10s %10s %10s %14s\n", "", "threads", "median", "9 of 10", "to alone", "to one thread");
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    std::sort(times[c].begin(), times[c].end());
    const double median = bench::median(times[c]);
    const double one_thread = bench::median(times[c % 2 == 0 ? c : c - 1]), alone = bench::median(times[c % 2]);
    std::printf("%-40s %8d %7.1f ms %7.1f ms %10.2f %14.2f\n", nameOf(conditions[c].neighbour), conditions[c].threads,
                median, times[c][times[c].size() * 9 / 10], median / alone, median / one_thread);
  }
  for (const std::uint64_t sum : sums)
    if (sum != sums[0]) throw std::runtime_error("the clouds differ");
  std::printf("all clouds have the same bytes, checksum %016llx\n", static_cast<unsigned long long>(sums[0]));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const auto number = [&](int k, int by_default) { return argc > k ? std::max(1, std::atoi(argv[k])) : by_default; };
  try {
    return run(number(1, 4), number(2, 2), number(3, 10));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fuse_flow_busy_bench: %s\n", error.what());
    return 1;
  }
}
