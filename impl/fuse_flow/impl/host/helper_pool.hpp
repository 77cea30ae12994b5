#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <new>
#include <thread>
#include <utility>
#include <vector>

#if defined(__unix__) || defined(__APPLE__)
#include <pthread.h>
#endif
#if defined(__linux__)
#include <sched.h>
#endif

namespace fuse_flow {
namespace host {

/** \brief Looks for what another thread is about to do, for about as long as it takes to fall asleep and to be woken. Who waits for longer
 *  must sleep: then the core is free for the thread that is waited for. \returns whether it has come */
template <typename Condition>
bool comesSoon(const Condition& condition) {
  constexpr std::chrono::microseconds patience{50};
  std::chrono::steady_clock::time_point end{};
  for (int look = 0; !condition(); ++look) {
    if (look % 32 == 0) {
      const std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now();
      if (look == 0) end = now + patience;
      if (now >= end) return false;
    }
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    asm volatile("yield");
#endif
  }
  return true;
}

/** \brief The helper threads of a process. A thread that has work for several threads asks for helpers and works as well. At the end it
 *  waits only for helpers that have begun, not for a helper that has no core yet because the system is busy with other programs. Helpers
 *  are started on first use, and sleep between jobs. */
class HelperPool {
 public:
  /** \brief Work that several threads do together. */
  class Job {
   public:
    /** \brief Works until no work is left to begin. \param thread 0: the asking thread; each helper has its own number, from 1 on */
    virtual void work(int thread) noexcept = 0;

   protected:
    ~Job() = default;

   private:
    friend class HelperPool;
    Job* next_{nullptr};
    int asked_{0};                 ///< for so many helpers
    int wanted_{0};                ///< of them have not begun
    int core_{-1};                 ///< core of the asking thread
    std::atomic<int> working_{0};  ///< helpers
    std::condition_variable ended_;
  };

  static HelperPool& instance() {
    // Never destroyed, since a thread may go on while the program ends: alone, for the helpers end before their code is unloaded.
    static HelperPool& pool = *new HelperPool;
    static const Guard guard(pool);
    return pool;
  }

  /** \brief Does a job on the calling thread and at most so many helpers. Within a job there are none: its threads are at work. */
  void run(Job& job, int helpers) {
    bool& at_work = atWork();
    if (at_work || helpers <= 0) {
      job.work(0);
      return;
    }
    publish(job, helpers);
    at_work = true;
    job.work(0);
    at_work = false;
    withdraw(job);
  }

 private:
  /** \brief Of what happens to the process. */
  struct Guard {
    explicit Guard(HelperPool& guarded) : pool(guarded) {
#if defined(__unix__) || defined(__APPLE__)
      pthread_atfork([] { instance().mutex_.lock(); }, [] { instance().mutex_.unlock(); },
                     [] {
                       instance().forget();
                       instance().mutex_.unlock();
                     });
#endif
    }
    ~Guard() { pool.end(); }
    HelperPool& pool;
  };

  HelperPool() = default;

  /** \brief Whether this thread is within a job. */
  static bool& atWork() {
    static thread_local bool at_work = false;
    return at_work;
  }

  void publish(Job& job, int helpers) {
    std::unique_lock<std::mutex> lock(mutex_);
    if (ended_) return;
    asked_ += job.asked_ = helpers;
    wanted_ += job.wanted_ = helpers;
    job.core_ = currentCore();
    Job** place = &jobs_;
    while (*place != nullptr) place = &(*place)->next_;
    *place = &job;
    startHelpers();
    wakeHelpers(lock);
  }

  void withdraw(Job& job) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      asked_ -= job.asked_;
      wanted_ -= job.wanted_;
      job.wanted_ = 0;
      Job** place = &jobs_;
      while (*place != nullptr && *place != &job) place = &(*place)->next_;
      if (*place != nullptr) *place = job.next_;
    }
    const auto none_works = [&] { return job.working_ == 0; };
    comesSoon(none_works);
    std::unique_lock<std::mutex> lock(mutex_);
    job.ended_.wait(lock, none_works);
  }

  /** \brief With the lock. Fewer than asked for, if the system does not let so many start: the work is done all the same. */
  void startHelpers() {
    const std::size_t enough = static_cast<std::size_t>(std::min(asked_, 1023));
    try {
      while (helpers_.size() < enough) helpers_.emplace_back([this] { help(); });
    } catch (const std::exception&) {
    }
  }

  /** \brief Unlocks. Wakes two, each of whom wakes two more: all are awake soon, and nobody spends long on it. */
  void wakeHelpers(std::unique_lock<std::mutex>& lock) {
    const int missing = std::min({wanted_ - looking_, sleeping_, 2});
    lock.unlock();
    for (int k = 0; k < missing; ++k) work_there_.notify_one();
  }

  void help() {
    atWork() = true;
    std::unique_lock<std::mutex> lock(mutex_);
    while (!ended_) {
      if (wanted_ == 0) {
        waitForWork(lock);
        continue;
      }
      Job* job = jobs_;
      while (job->wanted_ == 0) job = job->next_;
      const int thread = 1 + job->asked_ - job->wanted_;
      --job->wanted_;
      --wanted_;
      ++job->working_;
      wakeHelpers(lock);
      leaveCore(job->core_);
      job->work(thread);
      lock.lock();
      if (--job->working_ == 0) job->ended_.notify_one();  // with the lock: else the job might be gone
    }
  }

  void waitForWork(std::unique_lock<std::mutex>& lock) {
    ++looking_;
    lock.unlock();
    comesSoon([&] { return wanted_ > 0; });
    lock.lock();
    --looking_;
    ++sleeping_;
    work_there_.wait(lock, [&] { return wanted_ > 0 || ended_; });
    --sleeping_;
  }

#if defined(__linux__)
  static int currentCore() { return sched_getcpu(); }

  /** \brief If all cores are busy, Linux puts a woken thread on the core of the thread that wakes it. Both would then share one core, while
   *  other programs use the other cores. */
  static void leaveCore(int core) {
    if (core < 0 || sched_getcpu() != core) return;
    cpu_set_t allowed;
    if (sched_getaffinity(0, sizeof(allowed), &allowed) != 0) return;
    cpu_set_t others = allowed;
    CPU_CLR(static_cast<unsigned int>(core), &others);
    if (CPU_COUNT(&others) > 0 && sched_setaffinity(0, sizeof(others), &others) == 0)
      sched_setaffinity(0, sizeof(allowed), &allowed);
  }
#else
  static int currentCore() { return -1; }
  static void leaveCore(int) {}
#endif

  /** \brief In a forked process, which has none of the helpers, nor of the threads that asked for them. */
  void forget() {
    new (&work_there_) std::condition_variable;
    new std::vector<std::thread>(std::move(helpers_));  // a thread can neither be joined here nor destroyed before
    helpers_.clear();
    jobs_ = nullptr;
    asked_ = looking_ = sleeping_ = 0;
    wanted_ = 0;
  }

  void end() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ended_ = true;
    }
    work_there_.notify_all();
    for (std::thread& helper : helpers_) helper.join();
  }

  std::mutex mutex_;
  std::condition_variable work_there_;
  std::vector<std::thread> helpers_;
  Job* jobs_{nullptr};
  int asked_{0};                ///< for so many helpers by all jobs
  std::atomic<int> wanted_{0};  ///< of them have not begun
  int looking_{0};
  int sleeping_{0};
  bool ended_{false};
};

}  // namespace host
}  // namespace fuse_flow
