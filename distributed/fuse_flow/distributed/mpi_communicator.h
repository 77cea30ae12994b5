#pragma once

#include <fuse_flow/distributed/communicator.h>

// The C interface alone: that of C++ is in no standard any more, and in a library of its own.
#if !defined(OMPI_SKIP_MPICXX)
#define OMPI_SKIP_MPICXX 1
#endif
#if !defined(MPICH_SKIP_MPICXX)
#define MPICH_SKIP_MPICXX 1
#endif
#include <mpi.h>

#include <chrono>
#include <limits>
#include <list>
#include <thread>

namespace fuse_flow {
namespace distributed {

/** \brief Ranks that are processes, started by mpirun. MPI_Init() must have been called, and MPI_Finalize() may be called only once no
 *  object is left. Makes a communicator of its own, so that nothing else that the processes send gets in its way. */
class MpiCommunicator : public Communicator {
 public:
  /** \brief All ranks of \p group together. \param timeout how long exchange() waits for a rank, seconds; > 0 */
  explicit MpiCommunicator(MPI_Comm group = MPI_COMM_WORLD, double timeout = 10) : timeout_(timeout) {
    check(MPI_Comm_dup(group, &communicator_), "MPI_Comm_dup");
    check(MPI_Comm_set_errhandler(communicator_, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
    check(MPI_Comm_rank(communicator_, &rank_), "MPI_Comm_rank");
    check(MPI_Comm_size(communicator_, &size_), "MPI_Comm_size");
  }
  ~MpiCommunicator() override {
    if (broken_) return;  // who is silent would be waited for
    MPI_Comm_free(&communicator_);
  }
  MpiCommunicator(const MpiCommunicator&) = delete;
  MpiCommunicator& operator=(const MpiCommunicator&) = delete;

  int rank() const override { return rank_; }
  int size() const override { return size_; }

  void exchange(const std::vector<Outgoing>& out, const std::vector<int>& from, std::vector<Message>& in) override {
    if (broken_) throw pcl::PCLException("fuse_flow::distributed: a rank has been lost: these ranks cannot go on");
    tag_ = (tag_ + 1) % kTags;
    std::vector<MPI_Request> requests;
    for (const Outgoing& message : out) {
      if (message.size > static_cast<std::size_t>(std::numeric_limits<int>::max()))
        throw pcl::PCLException("fuse_flow::distributed: rank " + std::to_string(rank_) + " has " +
                                std::to_string(message.size) + " bytes for rank " + std::to_string(message.rank) +
                                ", more than 2^31; more ranks would share them");
      requests.emplace_back();
      check(MPI_Isend(message.data, static_cast<int>(message.size), MPI_BYTE, message.rank, tag_, communicator_,
                      &requests.back()),
            "MPI_Isend");
    }
    in.resize(from.size());
    std::vector<std::size_t> awaited;
    for (std::size_t k = 0; k < from.size(); ++k) awaited.push_back(k);
    Clock::time_point start = Clock::now(), last = start;
    for (;;) {
      // A process that was stopped itself, and goes on, must not say that it was the others.
      const Clock::time_point now = Clock::now();
      if (now - last > std::chrono::seconds(1)) start += now - last;
      last = now;
      for (std::size_t a = 0; a < awaited.size();)
        if (begins(from[awaited[a]], in[awaited[a]], requests)) {
          awaited.erase(awaited.begin() + static_cast<std::ptrdiff_t>(a));
        } else {
          ++a;
        }
      int done = 0;
      check(MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE), "MPI_Testall");
      if (awaited.empty() && done) return;
      const std::chrono::duration<double> waited = now - start;
      if (waited > timeout_) giveUp(awaited.empty() ? -1 : from[awaited.front()], out, in);
      // Who waits for long leaves the core to others of the machine.
      if (waited > std::chrono::milliseconds(1)) std::this_thread::sleep_for(std::chrono::microseconds(20));
    }
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr int kTags = 32768;  // any MPI has so many

  /** \brief Whether a rank's message has come; it is then being received. */
  bool begins(int from, Message& message, std::vector<MPI_Request>& requests) {
    int came = 0;
    MPI_Message matched;
    MPI_Status status;
    check(MPI_Improbe(from, tag_, communicator_, &came, &matched, &status), "MPI_Improbe");
    if (!came) return false;
    int size = 0;
    check(MPI_Get_count(&status, MPI_BYTE, &size), "MPI_Get_count");
    message.resize(static_cast<std::size_t>(size));
    requests.emplace_back();
    check(MPI_Imrecv(message.data(), size, MPI_BYTE, &matched, &requests.back()), "MPI_Imrecv");
    return true;
  }

  [[noreturn]] void giveUp(int silent, const std::vector<Outgoing>& out, std::vector<Message>& in) {
    broken_ = true;
    lost_ = std::move(in);  // MPI may still write there
    if (silent < 0) silent = out.empty() ? rank_ : out.front().rank;
    throw RankError(silent, "has not answered rank " + std::to_string(rank_) + " for " +
                                std::to_string(static_cast<int>(timeout_.count() + 0.5)) + " s");
  }

  void check(int result, const char* what) {
    if (result == MPI_SUCCESS) return;
    broken_ = true;
    char text[MPI_MAX_ERROR_STRING] = {};
    int length = 0;
    MPI_Error_string(result, text, &length);
    throw pcl::PCLException(std::string("fuse_flow::distributed: ") + what + ": " + std::string(text, text + length));
  }

  MPI_Comm communicator_{MPI_COMM_NULL};
  int rank_{0}, size_{1}, tag_{0};
  std::chrono::duration<double> timeout_;
  bool broken_{false};
  std::vector<Message> lost_;
};

}  // namespace distributed
}  // namespace fuse_flow
