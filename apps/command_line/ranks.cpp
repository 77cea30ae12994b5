#include "command_line/ranks.h"

#include "command_line/message_of.h"

#include <fuse_flow/recordings/error.h>

#if defined(FUSE_FLOW_WITH_MPI)
#include <fuse_flow/distributed/mpi_communicator.h>
#endif

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <thread>

namespace fuse_flow::command_line {
namespace {

/** \brief How many processes a launcher says that it has started: Open MPI's, or one that speaks PMI (MPICH's, Slurm's). */
int launchedProcesses() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
    if (const char* value = std::getenv(name)) return std::atoi(value);
  return 1;
}

#if defined(FUSE_FLOW_WITH_MPI)
class MpiRanks : public Ranks {
 public:
  MpiRanks() {
    // One thread at a time calls MPI, but not always the same: measurements are shared by whichever thread has the last of them.
    int provided = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
    if (provided < MPI_THREAD_SERIALIZED)
      throw io::InputError("this MPI is not made for programs with threads: MPI_THREAD_SERIALIZED is needed");
    communicator_ = std::make_unique<distributed::MpiCommunicator>();
    patient_ = std::make_unique<distributed::MpiCommunicator>(MPI_COMM_WORLD, 60);
  }
  ~MpiRanks() override {
    communicator_.reset();
    patient_.reset();
    MPI_Finalize();
  }

  distributed::Communicator& communicator() override { return *communicator_; }
  distributed::Communicator& patientCommunicator() override { return *patient_; }

  int guard(const std::string& tool, const std::function<int()>& run, Commands commands) override {
    const std::string name = tool + ", rank " + std::to_string(rank());
    const bool own = commands == Commands::Own;
    int code = 1;
    try {
      return run();
    } catch (const distributed::RankError& error) {
      // Who waits for rank 0 may wait since that waits for another, and says whom. Whoever is no speaker says it where that one has not noticed.
      if (!isFirst()) wait(error.rank() == 0 ? 3 : 1);
      if (rank() != (error.rank() == 0 ? 1 : 0)) wait(3);
      say(tool + ": " + io::messageOf(error));
    } catch (const io::OptionError& error) {
      if (!own) {  // all have it
        if (isFirst()) say(tool + ": " + error.what());
        return 2;
      }
      if (!isFirst()) wait(1);  // what all have rank 0 has said by then
      say((isFirst() ? tool : name) + ": " + error.what());
      code = 2;
    } catch (const pcl::PCLException& error) {
      say(name + ": " + io::messageOf(error));
    } catch (const std::bad_alloc&) {
      say(name + ": not enough memory");
    } catch (const std::exception& error) {
      say(name + ": " + error.what());
    }
    // Whoever still waits for this rank must not wait for ever.
    MPI_Abort(MPI_COMM_WORLD, code);
    return code;
  }

 private:
  static void wait(int seconds) { std::this_thread::sleep_for(std::chrono::seconds(seconds)); }
  /** \brief A line at once: of pieces some may be lost when another rank ends all. */
  static void say(const std::string& line) { std::cerr << line + "\n" << std::flush; }

  std::unique_ptr<distributed::MpiCommunicator> communicator_, patient_;
};
#endif

}  // namespace

std::unique_ptr<Ranks> Ranks::ofThisRun() {
  if (launchedProcesses() <= 1) return nullptr;
#if defined(FUSE_FLOW_WITH_MPI)
  return std::make_unique<MpiRanks>();
#else
  throw io::InputError(
      "started by mpirun, but built without MPI: each process would fuse alone; install libopenmpi-dev, and build "
      "again");
#endif
}

RanksArgument::RanksArgument(CLI::App& app) {
  app.add_option("--ranks", shared_,
                 "started by mpirun: what the processes share out, the cameras of each frame, which gives each frame "
                 "sooner, or whole "
                 "frames, which gives more frames a second")
      ->check(CLI::IsMember({"cameras", "frames"}))
      ->capture_default_str();
}

RankShareArguments::RankShareArguments(CLI::App& app) {
  fuse_at_ =
      app.add_option("--fuse-at", fusing_,
                     "started by mpirun: which of the processes fuse; first: the others only prepare the views of "
                     "their cameras, and send them")
          ->check(CLI::IsMember({"all", "first"}))
          ->capture_default_str();
  compress_ =
      app.add_option(
             "--rank-compression", compression_,
             "started by mpirun: what the processes send to each other is compressed, without loss; for networks of 1 "
             "Gbit/s. The same at all processes")
          ->check(CLI::IsMember({"none", "zstd"}))
          ->capture_default_str();
}

std::vector<std::string> RankShareArguments::advice(bool sharing) const {
  std::vector<std::string> lines;
  if (sharing) return lines;
  for (const CLI::Option* option : {fuse_at_, compress_})
    if (option->count() > 0)
      lines.push_back(option->get_name() +
                      " has no effect: it is for processes that mpirun starts, and that share the cameras of a frame");
  return lines;
}

}  // namespace fuse_flow::command_line
