#pragma once

#include <fuse_flow/distributed/communicator.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

namespace fuse_flow {
namespace distributed {

/** \brief Ranks that are the threads of one process: for tests, and for a process that has its cameras in several threads. Each thread
 *  uses communicator(r) of its own number r. */
class ThreadRanks {
 public:
  /** \param ranks how many; > 0  \param timeout how long exchange() waits for a rank, seconds; > 0 */
  explicit ThreadRanks(int ranks, double timeout = 10) : mail_(std::make_shared<Mail>()) {
    for (int r = 0; r < ranks; ++r) communicators_.push_back(std::make_unique<Rank>(mail_, r, ranks, timeout));
  }

  /** \brief Of rank r, 0 … ranks − 1; lives as long as this. */
  Communicator& communicator(int r) { return *communicators_[static_cast<std::size_t>(r)]; }

 private:
  /** \brief What has been sent and not yet taken, by sender and receiver. */
  struct Mail {
    std::mutex mutex;
    std::condition_variable came;
    std::map<std::pair<int, int>, std::deque<Message>> messages;
  };

  class Rank : public Communicator {
   public:
    Rank(std::shared_ptr<Mail> mail, int rank, int size, double timeout)
        : mail_(std::move(mail)), rank_(rank), size_(size), timeout_(timeout) {}

    int rank() const override { return rank_; }
    int size() const override { return size_; }

    void exchange(const std::vector<Outgoing>& out, const std::vector<int>& from, std::vector<Message>& in) override {
      const auto deadline =
          std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::steady_clock::duration>(timeout_);
      std::unique_lock<std::mutex> lock(mail_->mutex);
      for (const Outgoing& message : out)
        mail_->messages[{rank_, message.rank}].emplace_back(message.data, message.data + message.size);
      mail_->came.notify_all();
      in.resize(from.size());
      for (std::size_t k = 0; k < from.size(); ++k) {
        std::deque<Message>& messages = mail_->messages[{from[k], rank_}];
        if (!mail_->came.wait_until(lock, deadline, [&] { return !messages.empty(); }))
          throw RankError(from[k], "has not answered rank " + std::to_string(rank_) + " for " +
                                       std::to_string(static_cast<int>(timeout_.count() + 0.5)) + " s");
        in[k] = std::move(messages.front());
        messages.pop_front();
      }
    }

   private:
    std::shared_ptr<Mail> mail_;
    int rank_, size_;
    std::chrono::duration<double> timeout_;
  };

  std::shared_ptr<Mail> mail_;
  std::vector<std::unique_ptr<Rank>> communicators_;
};

}  // namespace distributed
}  // namespace fuse_flow
