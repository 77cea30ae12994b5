#pragma once

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Several lanes do jobs in cyclic order, each on a thread of its own: while one is at work, the next can be started. Its destructor waits
 *  for the jobs that were started. One thread at a time calls it: start() while fewer jobs are in flight than there are lanes, finishOldest() while
 *  there is one.
 *  \tparam Lane has begin(), which its thread calls first, and which throws nothing; and run(), which does the job: what it throws is thrown by
 *  finishOldest() */
template <typename Lane>
class LaneRing {
 public:
  /** \param make makes a lane: make(k) is a std::unique_ptr<Lane> */
  template <typename Make>
  LaneRing(std::size_t lanes, const Make& make) {
    for (std::size_t k = 0; k < lanes; ++k) workers_.push_back(std::make_unique<Worker>(make(k)));
  }

  std::size_t lanes() const { return workers_.size(); }
  /** \brief Jobs that have been started and not taken. */
  std::size_t inFlight() const { return started_ - taken_; }

  Lane& lane(std::size_t k) { return *workers_[k]->lane; }
  /** \brief The lane of the next job; it is free if fewer are in flight than there are lanes. */
  Lane& upcoming() { return *workers_[started_ % lanes()]->lane; }
  /** \brief Starts its job. */
  void start() { workers_[started_++ % lanes()]->start(); }
  /** \brief Waits for the oldest job; it is then taken, also if it has thrown. */
  Lane& finishOldest() {
    Worker& worker = *workers_[taken_++ % lanes()];
    worker.finish();
    return *worker.lane;
  }

 private:
  class Worker {
   public:
    const std::unique_ptr<Lane> lane;  // outlives the thread

    explicit Worker(std::unique_ptr<Lane> made) : lane(std::move(made)), thread_([this] { work(); }) {}

    ~Worker() {
      {
        std::unique_lock<std::mutex> lock(mutex_);
        // What was started is done, also where its thread has not yet woken: others may wait for it.
        changed_.wait(lock, [this] { return state_ == State::Idle; });
        state_ = State::Stop;
      }
      changed_.notify_all();
      thread_.join();
    }
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

    void start() {
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        state_ = State::Working;
      }
      changed_.notify_all();
    }

    void finish() {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [this] { return state_ == State::Idle; });
      if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
    }

   private:
    enum class State { Idle, Working, Stop };

    void work() {
      lane->begin();
      std::unique_lock<std::mutex> lock(mutex_);
      for (;;) {
        changed_.wait(lock, [this] { return state_ != State::Idle; });
        if (state_ == State::Stop) return;
        lock.unlock();
        std::exception_ptr error;
        try {
          lane->run();
        } catch (...) {
          error = std::current_exception();
        }
        lock.lock();
        error_ = error;
        state_ = State::Idle;
        changed_.notify_all();
      }
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    State state_{State::Idle};
    std::exception_ptr error_;
    std::thread thread_;  // last: it uses the others
  };

  std::vector<std::unique_ptr<Worker>> workers_;
  std::size_t started_{0}, taken_{0};
};

}  // namespace host
}  // namespace fuse_flow
