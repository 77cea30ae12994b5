// How the work of a frame and what is sent divide among ranks, which are threads of this process: processor time, bytes and messages are
// counted, not time, so that there may be more ranks than cores. fuse_flow_ranks_bench [--poses] [WIDTH HEIGHT]

#include "median.h"
#include "room.h"

#include <fuse_flow/distributed/calibration/extrinsic_tracking.h>
#include <fuse_flow/distributed/fuse_flow.h>
#include <fuse_flow/distributed/thread_ranks.h>
#include <fuse_flow/point_types.h>

#include <ctime>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <thread>

namespace {

using fuse_flow::RigFrame;
using fuse_flow::distributed::Ownership;
using fuse_flow::distributed::PartStatistics;

/** \brief Of this thread, milliseconds. */
double processorTime() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/** \brief Lets one rank run at a time, from exchange to exchange: what a rank takes of its processor is then what it takes of one that it has for
 *  itself. */
class InTurn : public fuse_flow::distributed::Communicator {
 public:
  InTurn(fuse_flow::distributed::Communicator& ranks, std::mutex& turn) : ranks_(ranks), lock_(turn) {}
  int rank() const override { return ranks_.rank(); }
  int size() const override { return ranks_.size(); }
  void exchange(const std::vector<Outgoing>& out, const std::vector<int>& from,
                std::vector<fuse_flow::distributed::Message>& in) override {
    for (const Outgoing& message : out) bytes_sent += message.size;
    messages += out.size();
    lock_.unlock();
    ranks_.exchange(out, from, in);
    lock_.lock();
  }

  std::size_t bytes_sent{0}, messages{0};

 private:
  fuse_flow::distributed::Communicator& ranks_;
  std::unique_lock<std::mutex> lock_;
};

/** \brief What a rank did in a frame, medians over some. */
struct Share {
  PartStatistics part;
  double work;  ///< milliseconds of its processor
};

RigFrame partOf(const RigFrame& frame, const std::vector<int>& rank_of, int rank) {
  RigFrame part = frame;
  for (std::size_t i = 0; i < part.views.size(); ++i)
    if (rank_of[i] != rank) part.views[i] = {};
  return part;
}

std::vector<Share> measure(const RigFrame& frame, const std::vector<int>& rank_of, int ranks, Ownership ownership) {
  fuse_flow::distributed::ThreadRanks group(ranks, 600);
  std::vector<Share> shares(static_cast<std::size_t>(ranks));
  std::vector<std::thread> threads;
  std::mutex turn;
  for (int r = 0; r < ranks; ++r)
    threads.emplace_back([&, r] {
      InTurn communicator(group.communicator(r), turn);
      fuse_flow::distributed::FuseFlow<fuse_flow::PointFused> fusion(communicator);
      fusion.setNumberOfThreads(1);
      fusion.setOwnership(ownership);
      const RigFrame part = partOf(frame, rank_of, r);
      pcl::PointCloud<fuse_flow::PointFused> cloud;
      fusion.fuse(part, cloud);  // lays out memory
      std::vector<double> times;
      for (int k = 0; k < 5; ++k) {
        const double start = processorTime();
        fusion.fuse(part, cloud);
        times.push_back(processorTime() - start);
      }
      shares[static_cast<std::size_t>(r)] = {fusion.getPartStatistics(), bench::median(times)};
    });
  for (std::thread& thread : threads) thread.join();
  return shares;
}

/** \brief One line; \p per_rank_alone of one rank with its share of the cameras, where each has as many however many ranks there are. */
void print(int ranks, int cameras, const std::vector<Share>& shares, double ideal) {
  double work = 0, most_work = 0, sent = 0, most_sent = 0, points = 0;
  for (const Share& share : shares) {
    work += share.work;
    most_work = std::max(most_work, share.work);
    sent += 1e-6 * static_cast<double>(share.part.bytes_sent);
    most_sent = std::max(most_sent, 1e-6 * static_cast<double>(share.part.bytes_sent));
    points += 1e-6 * static_cast<double>(share.part.bytes_of_points);
  }
  const double n = ranks;
  std::printf("| %d | %d | %.1f | %.1f | %.2f | %.2f | %.2f | %.2f | %zu | %.2f |\n", ranks, cameras, work / n,
              most_work, ideal > 0 ? work / n / ideal : 1.0, sent / n, most_sent, points / n, shares[0].part.messages,
              shares[0].part.imbalance);
  std::fflush(stdout);
}

void printHead(const char* what) {
  std::printf(
      "\n%s\n\n| ranks | cameras | work a rank, ms | most | over the ideal | MB sent a rank | most | of it points | "
      "messages a rank | "
      "imbalance |\n|---|---|---|---|---|---|---|---|---|---|\n",
      what);
}

/** \brief Cameras around one room, more and more ranks. \param in_turn neighbours are of different ranks */
void strong(int cameras, int width, int height, bool in_turn, Ownership ownership, const char* what) {
  const bench::Room room(cameras, width, height);
  std::vector<char> memory(room.bytes());
  const RigFrame frame = room.render(memory.data(), 1);
  printHead(what);
  double alone = 0;
  for (const int ranks : {1, 2, 4, 8, 16, 32, 64}) {
    if (ranks > cameras) break;
    std::vector<int> rank_of;
    for (int i = 0; i < cameras; ++i) rank_of.push_back(in_turn ? i % ranks : i * ranks / cameras);
    const std::vector<Share> shares = measure(frame, rank_of, ranks, ownership);
    if (ranks == 1) alone = shares[0].work;
    print(ranks, cameras, shares, alone / ranks);
  }
}

/** \brief A row of rooms of eight cameras; each rank has the four cameras of half a room, and the four of half the next. */
void weak(int width, int height) {
  printHead(
      "Eight cameras a rank, in a row of rooms, each watched by two ranks; over the ideal: over one rank with one "
      "room");
  const bench::Room room(8, width, height);
  double alone = 0;
  for (const int ranks : {1, 2, 4, 8, 16, 32, 64}) {
    std::vector<std::vector<char>> memory(static_cast<std::size_t>(ranks), std::vector<char>(room.bytes()));
    RigFrame frame;
    std::vector<int> rank_of;
    for (int r = 0; r < ranks; ++r) {
      const RigFrame one = room.render(memory[static_cast<std::size_t>(r)].data(), static_cast<std::uint32_t>(r));
      for (std::size_t i = 0; i < one.cameras.size(); ++i) {
        frame.cameras.push_back(one.cameras[i]);
        frame.cameras.back().name += " of room " + std::to_string(r);
        frame.cameras.back().T_world_camera.pretranslate(Eigen::Vector3d(6.5 * r, 0, 0));
        frame.views.push_back(one.views[i]);
        rank_of.push_back((r + (i < 4 ? 0 : 1)) % ranks);
      }
    }
    const std::vector<Share> shares = measure(frame, rank_of, ranks, Ownership::Curve);
    if (ranks == 1) alone = shares[0].work;
    print(ranks, 8 * ranks, shares, alone);
  }
}

/** \brief Poses, followed from frame to frame; cameras around one room, more and more ranks. */
void poses(int cameras, int width, int height) {
  const bench::Room room(cameras, width, height);
  std::vector<char> memory(room.bytes());
  const RigFrame frame = room.render(memory.data(), 1);
  std::printf(
      "\n%d cameras around one room, poses followed: of one frame\n\n| ranks | work a rank, ms | most | over the ideal "
      "| MB sent a rank | most | messages, at most |\n|---|---|---|---|---|---|---|\n",
      cameras);
  double alone = 0;
  for (const int ranks : {1, 2, 4, 8}) {
    fuse_flow::distributed::ThreadRanks group(ranks, 600);
    std::vector<double> work(static_cast<std::size_t>(ranks)), sent = work, messages = work;
    std::vector<std::thread> threads;
    std::mutex turn;
    std::vector<int> rank_of;
    for (int i = 0; i < cameras; ++i) rank_of.push_back(i * ranks / cameras);
    for (int r = 0; r < ranks; ++r)
      threads.emplace_back([&, r] {
        InTurn communicator(group.communicator(r), turn);
        fuse_flow::distributed::ExtrinsicTracking tracking(communicator, frame.cameras);
        tracking.setNumberOfThreads(1);
        tracking.setMinInterval(0);
        const RigFrame part = partOf(frame, rank_of, r);
        tracking.push(part);  // lays out memory
        std::vector<double> times;
        constexpr int frames = 5;
        communicator.bytes_sent = communicator.messages = 0;
        for (int k = 0; k < frames; ++k) {
          const double start = processorTime();
          tracking.push(part);
          times.push_back(processorTime() - start);
        }
        const auto rank = static_cast<std::size_t>(r);
        work[rank] = bench::median(times);
        sent[rank] = 1e-6 * static_cast<double>(communicator.bytes_sent) / frames;
        messages[rank] = static_cast<double>(communicator.messages) / frames;
      });
    for (std::thread& thread : threads) thread.join();
    const auto mean = [&](const std::vector<double>& of) { return std::accumulate(of.begin(), of.end(), 0.0) / ranks; };
    const auto most = [](const std::vector<double>& of) { return *std::max_element(of.begin(), of.end()); };
    if (ranks == 1) alone = work[0];
    std::printf("| %d | %.1f | %.1f | %.2f | %.2f | %.2f | %.0f |\n", ranks, mean(work), most(work),
                mean(work) * ranks / alone, mean(sent), most(sent), most(messages));
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const bool only_poses = argc > 1 && std::strcmp(argv[1], "--poses") == 0;
  argc -= only_poses;
  argv += only_poses;
  const int width = argc > 2 ? std::atoi(argv[1]) : 320, height = argc > 2 ? std::atoi(argv[2]) : 240;
  std::printf("Images of %dx%d; one thread a rank\n", width, height);
  if (only_poses) {
    poses(8, width, height);
    return 0;
  }
  strong(8, width, height, false, Ownership::Curve,
         "8 cameras around one room, neighbours at one rank, cells by the curve");
  strong(64, width, height, false, Ownership::Curve,
         "64 cameras around one room, neighbours at one rank, cells by the curve");
  strong(64, width, height, true, Ownership::Curve, "The same, neighbours at different ranks");
  strong(64, width, height, false, Ownership::Hash, "Neighbours at one rank, cells by the hash");
  weak(width, height);
  poses(8, width, height);
}
