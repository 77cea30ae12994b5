#pragma once

#include <fuse_flow/impl/host/helper_pool.hpp>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>

namespace fuse_flow {
namespace host {

/** \brief Threads to use for a setting of n; 0 means one for each core that the process may use. No more than any machine has cores. */
inline int resolveThreads(int n) {
  constexpr int most = 1024;
  if (n > 0) return n < most ? n : most;
#if defined(__linux__)
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof(allowed), &allowed) == 0) return CPU_COUNT(&allowed);
#endif
  const unsigned int cores = std::thread::hardware_concurrency();
  return cores > 0 ? static_cast<int>(cores) : 1;
}

/** \brief Keeps the exception of the task with the smallest number, independent of threads and order. */
class FirstError {
 public:
  /** \brief Runs a task, but none after one that has thrown: what a thread keeps from task to task may then be half done. */
  template <typename Body>
  void guard(std::size_t task, const Body& body) noexcept {
    if (task > task_.load(std::memory_order_relaxed)) return;
    try {
      body();
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (task > task_) return;
      task_ = task;
      error_ = std::current_exception();
    }
  }

  /** \brief Once all threads are done. */
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::atomic<std::size_t> task_{static_cast<std::size_t>(-1)};
  std::mutex mutex_;
  std::exception_ptr error_;
};

/** \brief Tasks that depend on nothing, begun one after the other. */
template <typename Body>
class IndependentTasks final : public HelperPool::Job {
 public:
  IndependentTasks(std::size_t tasks, const Body& body) : tasks_(tasks), body_(body) {}

  void work(int thread) noexcept override {
    for (std::size_t task = next_++; task < tasks_; task = next_++) error_.guard(task, [&] { body_(task, thread); });
  }

  const FirstError& error() const { return error_; }

 private:
  const std::size_t tasks_;
  const Body& body_;
  std::atomic<std::size_t> next_{0};
  FirstError error_;
};

/** \brief How many helpers so many tasks keep busy. */
inline int helpersFor(int threads, std::size_t tasks) {
  return static_cast<int>(
             std::min<std::size_t>(static_cast<std::size_t>(std::max(threads, 1)), std::max<std::size_t>(tasks, 1))) -
         1;
}

/** \brief Calls body(task, thread) for every task in [0, tasks), thread in [0, threads). Tasks are handed out one by
 *  one, so results must not depend on who runs which. Of the exceptions thrown, that of the smallest task is rethrown; tasks after it
 *  are left out: what a thread keeps from task to task may be half done. Within a task, tasks of tasks are done by its thread alone. */
template <typename Body>
void parallelFor(int threads, std::size_t tasks, const Body& body) {
  IndependentTasks<Body> job(tasks, body);
  HelperPool::instance().run(job, helpersFor(threads, tasks));
  job.error().rethrow();
}

/** \brief Calls body(k) for every k in [0, n), many of them in one task: for what takes little time. Exceptions as of parallelFor(). */
template <typename Body>
void parallelForEach(int threads, std::size_t n, const Body& body) {
  constexpr std::size_t of_task = 1024;
  parallelFor(threads, (n + of_task - 1) / of_task, [&](std::size_t task, int) {
    const std::size_t end = std::min(n, (task + 1) * of_task);
    for (std::size_t k = task * of_task; k < end; ++k) body(k);
  });
}

}  // namespace host
}  // namespace fuse_flow
