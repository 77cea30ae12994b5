#pragma once

#include <fuse_flow/impl/host/parallel.hpp>

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Tasks with dependencies. A free thread begins the first task in the order of the tasks that may begin. If a thread stops within a
 *  task because the system has given its core to another program, only tasks that depend on this task wait. Keeps its memory. */
class TaskFlow {
 public:
  void clear() {
    tasks_.clear();
    edges_.clear();
  }

  std::size_t size() const { return tasks_.size(); }

  /** \brief A task after all others. \returns its number */
  std::uint32_t add() {
    tasks_.emplace_back();
    return static_cast<std::uint32_t>(tasks_.size() - 1);
  }

  /** \brief A task begins when another one is done. \param before < after, so that a single thread need never wait */
  void addDependency(std::uint32_t before, std::uint32_t after) {
    edges_.push_back({after, tasks_[before].first_edge});
    tasks_[before].first_edge = static_cast<std::uint32_t>(edges_.size() - 1);
    ++tasks_[after].dependencies;
  }

  /** \brief Calls body(task, thread) for every task, thread in [0, threads). Exceptions as of parallelFor(). */
  template <typename Body>
  void run(int threads, const Body& body) {
    Running<Body> job(*this, body);
    HelperPool::instance().run(job, helpersFor(threads, tasks_.size()));
    job.error().rethrow();
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  struct Task {
    std::uint32_t first_edge{kNone};
    std::uint32_t dependencies{0};
    std::uint32_t open{0};  ///< dependencies that are not done
  };

  struct Edge {
    std::uint32_t after;
    std::uint32_t next;  ///< edge of the same task before
  };

  /** \brief Numbers of tasks; the smallest is taken first. */
  class ReadyTasks {
   public:
    explicit ReadyTasks(std::vector<std::uint64_t>& bits) : bits_(bits) {}

    std::size_t count() const { return count_; }

    void add(std::uint32_t task) {
      bits_[task / 64] |= std::uint64_t{1} << task % 64;
      first_word_ = std::min<std::size_t>(first_word_, task / 64);
      ++count_;
    }

    std::uint32_t take() {
      while (bits_[first_word_] == 0) ++first_word_;
      std::uint64_t& word = bits_[first_word_];
      std::uint32_t bit = 0;
      while ((word >> bit & 1) == 0) ++bit;
      word &= word - 1;
      --count_;
      return static_cast<std::uint32_t>(64 * first_word_) + bit;
    }

   private:
    std::vector<std::uint64_t>& bits_;
    std::size_t first_word_{0};  ///< none is in a word before it
    std::atomic<std::size_t> count_{0};
  };

  template <typename Body>
  class Running final : public HelperPool::Job {
   public:
    Running(TaskFlow& flow, const Body& body)
        : tasks_(flow.tasks_), edges_(flow.edges_), body_(body), ready_(flow.ready_), left_(flow.size()) {
      flow.ready_.assign((tasks_.size() + 63) / 64, 0);
      for (std::uint32_t task = 0; task < tasks_.size(); ++task) {
        tasks_[task].open = tasks_[task].dependencies;
        if (tasks_[task].open == 0) ready_.add(task);
      }
    }

    void work(int thread) noexcept override {
      std::unique_lock<std::mutex> lock(mutex_);
      while (waitForTask(lock)) {
        const std::uint32_t task = ready_.take();
        if (--left_ == 0) changed_.notify_all();
        lock.unlock();
        error_.guard(task, [&] { body_(task, thread); });
        lock.lock();
        finish(task);
      }
    }

    const FirstError& error() const { return error_; }

   private:
    /** \brief With the lock. \returns false if all tasks have begun: nothing is left to wait for */
    bool waitForTask(std::unique_lock<std::mutex>& lock) {
      const auto any = [&] { return ready_.count() > 0 || left_ == 0; };
      if (!any()) {
        lock.unlock();
        comesSoon(any);
        lock.lock();
        ++waiting_;
        changed_.wait(lock, any);
        --waiting_;
      }
      return left_ > 0;
    }

    /** \brief With the lock, by a thread that then looks for a task itself. */
    void finish(std::uint32_t task) {
      for (std::uint32_t e = tasks_[task].first_edge; e != kNone; e = edges_[e].next)
        if (--tasks_[edges_[e].after].open == 0) ready_.add(edges_[e].after);
      for (std::size_t k = 1; k < ready_.count() && k <= waiting_; ++k) changed_.notify_one();
    }

    std::vector<Task>& tasks_;
    const std::vector<Edge>& edges_;
    const Body& body_;
    FirstError error_;
    std::mutex mutex_;
    std::condition_variable changed_;
    ReadyTasks ready_;
    std::atomic<std::size_t> left_;  ///< tasks that have not begun
    std::size_t waiting_{0};
  };

  std::vector<Task> tasks_;
  std::vector<Edge> edges_;
  std::vector<std::uint64_t> ready_;  ///< a bit a task
};

}  // namespace host
}  // namespace fuse_flow
