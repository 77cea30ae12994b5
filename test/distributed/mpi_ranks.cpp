// One of the processes that mpirun starts in mpi_ranks.sh: each has some cameras of a rig, and the first compares what all of them fuse with
// what it fuses alone. With an argument, a rank does something else instead.

#include "ranks.h"
#include "run_lengths.h"

#include <fuse_flow/distributed/frames_in_flight.h>
#include <fuse_flow/distributed/mpi_communicator.h>

#include <csignal>
#include <iostream>
#include <memory>
#include <vector>

namespace {

using fuse_flow::distributed::Communicator;
using fuse_flow::distributed::MpiCommunicator;
using fuse_flow::distributed::RankError;
using Fusion = fuse_flow::distributed::FuseFlow<fuse_flow::PointFused>;

/** \brief Frames of two rigs, by one object; whether all are right. */
bool sharesFrames(Communicator& ranks) {
  Fusion fusion(ranks);
  fusion.setNumberOfThreads(1);
  bool right = true;
  for (unsigned int seed = 1; seed <= 4; ++seed) {
    const scenes::Scene scene = ranks::noisyRoom(seed % 2 ? 7 : 4, seed);
    fuse_flow::FuseFlowParameters parameters;
    if (seed == 3) parameters.agreement.min_views = 1;
    fusion.setParameters(parameters);
    fusion.setCodec(seed > 2 ? std::make_shared<ranks::RunLengths>() : nullptr);
    scenes::Cloud part, whole, alone;
    fusion.fuse(ranks::partOf(scene.rig, ranks::inTurn(scene.rig.cameras.size(), ranks.size()), ranks.rank()), part);
    fusion.gather(part, whole, 0);
    if (ranks.rank() != 0) continue;
    fuse_flow::FuseFlow<fuse_flow::PointFused> one;
    one.setParameters(parameters);
    one.fuse(scene.rig, alone);
    right = right && !alone.empty() && ranks::sameBytes(whole, alone);
  }
  return right;
}

/** \brief Several frames at a time, each over messages of its own. */
bool sharesFramesInFlight(int count, int rank) {
  constexpr std::size_t kLanes = 3;
  std::vector<std::unique_ptr<MpiCommunicator>> lanes;
  std::vector<Communicator*> communicators;
  for (std::size_t k = 0; k < kLanes; ++k) {
    lanes.push_back(std::make_unique<MpiCommunicator>(MPI_COMM_WORLD, 30));
    communicators.push_back(lanes.back().get());
  }
  fuse_flow::distributed::FramesInFlight<fuse_flow::PointFused> fusion(communicators);
  fusion.forEachLane([](Fusion& lane) { lane.setNumberOfThreads(1); });
  fusion.setGatherAt(0);
  std::vector<scenes::Scene> all;
  for (unsigned int seed = 1; seed <= 7; ++seed) all.push_back(ranks::noisyRoom(seed % 2 ? 5 : 3, seed));
  bool right = true;
  std::size_t taken = 0;
  scenes::Cloud whole, alone;
  fuse_flow::FuseFlow<fuse_flow::PointFused> one;
  const auto take = [&] {
    fusion.next(whole);
    if (rank == 0) one.fuse(all[taken].rig, alone);
    right = right && (rank != 0 || (!alone.empty() && ranks::sameBytes(whole, alone)));
    ++taken;
  };
  for (const scenes::Scene& scene : all) {
    if (fusion.inFlight() == kLanes) take();
    fusion.submit(ranks::partOf(scene.rig, ranks::inTurn(scene.rig.cameras.size(), count), rank));
  }
  while (fusion.inFlight() > 0) take();
  return right && taken == all.size();
}

/** \brief Whether every rank's message of more bytes than MPI sends at once comes as it was sent. */
bool exchangesMuch(Communicator& ranks) {
  const auto byte = [](int rank, std::size_t k) {
    return static_cast<char>(static_cast<std::size_t>(rank) * 31 + k * k % 251);
  };
  fuse_flow::distributed::Message own(3 << 20);
  for (std::size_t k = 0; k < own.size(); ++k) own[k] = byte(ranks.rank(), k);
  std::vector<Communicator::Outgoing> out;
  const std::vector<int> others = fuse_flow::distributed::otherRanks(ranks);
  for (const int r : others) out.push_back({r, own.data(), own.size()});
  std::vector<fuse_flow::distributed::Message> in;
  ranks.exchange(out, others, in);
  for (std::size_t k = 0; k < others.size(); ++k)
    for (std::size_t b = 0; b < in[k].size(); ++b)
      if (in[k].size() != own.size() || in[k][b] != byte(others[k], b)) return false;
  return true;
}

int run(const std::string& instead) {
  MpiCommunicator ranks(MPI_COMM_WORLD, instead.empty() ? 30 : 4);
  const bool mine = ranks.rank() == 1;
  if (mine && instead == "stops") std::raise(SIGSTOP);
  if (mine && instead == "leaves") std::_Exit(3);
  const bool right = sharesFrames(ranks) && exchangesMuch(ranks) && sharesFramesInFlight(ranks.size(), ranks.rank());
  if (ranks.rank() == 0)
    std::cout << ranks.size() << " ranks: " << (right ? "the same bytes" : "OTHER BYTES") << std::endl;
  return right ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_MULTIPLE, &provided);
  if (provided < MPI_THREAD_MULTIPLE) {
    std::cerr << "this MPI does not allow several threads at once" << std::endl;
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
  try {
    const int result = run(argc > 1 ? argv[1] : "");
    MPI_Finalize();
    return result;
  } catch (const std::exception& error) {
    std::cerr << error.what() << std::endl;
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
}
