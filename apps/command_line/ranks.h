#pragma once

#include "methods/distributed_fusion.h"

#include <fuse_flow/distributed/communicator.h>

#include <CLI/CLI.hpp>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::command_line {

/** \brief The processes that mpirun has started, of which this is one. */
class Ranks {
 public:
  virtual ~Ranks() = default;

  /** \brief Those of this run; null where mpirun has not started it, or only one. Throws InputError where it has, and the program was built
   *  without MPI: each process would believe that it is alone. */
  static std::unique_ptr<Ranks> ofThisRun();

  /** \brief For distributed::FuseFlow. */
  virtual distributed::Communicator& communicator() = 0;
  /** \brief Of the same ranks; waits for a minute, while devices are opened. */
  virtual distributed::Communicator& patientCommunicator() = 0;

  int rank() { return communicator().rank(); }
  int size() { return communicator().size(); }
  /** \brief Whether this one writes what is written once. */
  bool isFirst() { return rank() == 0; }

  /** \brief Whether ranks were started with the same command line, or each may have its own, and only rank 0 hears of all. */
  enum class Commands { Same, Own };

  /** \brief What run() returns. Of the fault of one rank one other prints a line, and the others end without one; where ranks are silent, all
   *  are ended. \param tool its name */
  virtual int guard(const std::string& tool, const std::function<int()>& run, Commands commands = Commands::Same) = 0;
};

/** \brief "--ranks cameras|frames": what processes that mpirun starts share out. */
class RanksArgument {
 public:
  explicit RanksArgument(CLI::App& app);
  /** \brief Whether each takes whole frames, in turn; or else each has some cameras of every frame. */
  bool shareFrames() const { return shared_ == "frames"; }

 private:
  std::string shared_{"cameras"};
};

/** \brief How processes that mpirun starts share the cameras of a frame: "--fuse-at all|first", which of them fuse, and
 *  "--rank-compression none|zstd", how what they send to each other is made shorter. */
class RankShareArguments {
 public:
  explicit RankShareArguments(CLI::App& app);
  /** \brief A line for each that was given and has no effect. \param sharing whether ranks share the cameras of a frame */
  std::vector<std::string> advice(bool sharing) const;
  io::RankShare of(int rank) const { return {fusing_ == "all" || rank == 0, compression_ != "none"}; }

 private:
  CLI::Option* fuse_at_;
  CLI::Option* compress_;
  std::string fusing_{"all"}, compression_{"none"};
};

}  // namespace fuse_flow::command_line
