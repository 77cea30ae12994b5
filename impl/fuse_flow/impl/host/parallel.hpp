#pragma once

#include <atomic>
#include <cstddef>
#include <exception>

#if defined(__SANITIZE_THREAD__)
#define FUSE_FLOW_STD_THREADS 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define FUSE_FLOW_STD_THREADS 1
#endif
#endif

#if defined(FUSE_FLOW_STD_THREADS)
#include <thread>
#include <vector>
#elif defined(_OPENMP)
#include <omp.h>
#endif

namespace fuse_flow {
namespace host {

/** \brief Threads to use for a setting of n; 0 means one per core. No more than any machine has cores: OpenMP ends the program where it
 *  cannot start as many as it was asked for. */
inline int resolveThreads(int n) {
  constexpr int most = 1024;
  if (n > 0) return n < most ? n : most;
#if defined(FUSE_FLOW_STD_THREADS)
  const unsigned int cores = std::thread::hardware_concurrency();
  return cores > 0 ? static_cast<int>(cores) : 1;
#elif defined(_OPENMP)
  return omp_get_num_procs();
#else
  return 1;
#endif
}

/** \brief Calls body(task, thread) for every task in [0, tasks), thread in [0, threads). Tasks are handed out one by
 *  one, so results must not depend on who runs which. Of the exceptions thrown, that of the smallest task is rethrown; tasks after it
 *  are left out: what a thread keeps from task to task may be half done.
 *
 *  OpenMP carries it. Under the thread sanitizer, which cannot see into OpenMP's run time, plain threads do. */
template <typename Body>
void parallelFor(int threads, std::size_t tasks, const Body& body) {
  std::exception_ptr error;
  std::atomic<std::size_t> error_task{tasks};
  const auto guarded = [&](std::size_t task, int thread, auto&& lock) {
    if (task > error_task.load(std::memory_order_relaxed)) return;
    try {
      body(task, thread);
    } catch (...) {
      lock([&] {
        if (task < error_task) {
          error_task = task;
          error = std::current_exception();
        }
      });
    }
  };
#if defined(FUSE_FLOW_STD_THREADS)
  std::atomic<std::size_t> next{0};
  std::atomic_flag busy = ATOMIC_FLAG_INIT;
  const auto lock = [&](auto&& action) {
    while (busy.test_and_set(std::memory_order_acquire)) std::this_thread::yield();
    action();
    busy.clear(std::memory_order_release);
  };
  const auto work = [&](int thread) {
    for (std::size_t task = next++; task < tasks; task = next++) guarded(task, thread, lock);
  };
  std::vector<std::thread> pool;
  for (int thread = 1; thread < threads; ++thread) pool.emplace_back(work, thread);
  work(0);
  for (std::thread& t : pool) t.join();
#elif defined(_OPENMP)
  const auto lock = [](auto&& action) {
#pragma omp critical(fuse_flow_parallel_for)
    action();
  };
  const long long count = static_cast<long long>(tasks);
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1)
  for (long long task = 0; task < count; ++task) guarded(static_cast<std::size_t>(task), omp_get_thread_num(), lock);
#else
  (void)threads;
  const auto lock = [](auto&& action) { action(); };
  for (std::size_t task = 0; task < tasks; ++task) guarded(task, 0, lock);
#endif
  if (error) std::rethrow_exception(error);
}

}  // namespace host
}  // namespace fuse_flow
