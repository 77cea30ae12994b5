#include <fuse_flow/impl/host/parallel.hpp>

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <future>
#include <thread>
#include <vector>

#if defined(__linux__)
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>
#endif

namespace {

using fuse_flow::host::parallelFor;
using fuse_flow::host::resolveThreads;

TEST(Parallel, EveryTaskIsDoneOnce) {
  for (const int threads : {1, 4}) {
    std::array<std::atomic<int>, 100> done{};
    parallelFor(threads, done.size(), [&](std::size_t task, int thread) {
      ++done[task];
      EXPECT_GE(thread, 0);
      EXPECT_LT(thread, threads);
    });
    for (std::size_t task = 0; task < done.size(); ++task) EXPECT_EQ(done[task], 1) << task;
  }
}

TEST(Parallel, WhatTheSmallestTaskThrowsIsRethrownAndAllTasksBeforeItAreDone) {
  for (int repetition = 0; repetition < 50; ++repetition)
    for (const int threads : {1, 4}) {
      std::array<std::atomic<int>, 100> done{};
      std::size_t thrown = done.size();
      try {
        parallelFor(threads, done.size(), [&](std::size_t task, int) {
          ++done[task];
          if (task == 40 || task == 41 || task == 70) throw task;
        });
      } catch (const std::size_t task) {
        thrown = task;
      }
      ASSERT_EQ(thrown, 40u) << threads << " threads";
      for (std::size_t task = 0; task <= 40; ++task) ASSERT_EQ(done[task], 1) << task;
    }
}

TEST(Parallel, AThreadDoesNothingMoreAfterItHasThrown) {
  for (const int threads : {1, 4}) {
    std::vector<std::atomic<bool>> broken(static_cast<std::size_t>(threads));
    std::atomic<int> went_on{0};
    EXPECT_THROW(parallelFor(threads, 1000,
                             [&](std::size_t task, int thread) {
                               std::atomic<bool>& mine = broken[static_cast<std::size_t>(thread)];
                               if (mine) ++went_on;
                               if (task % 10 != 9) return;
                               mine = true;
                               throw task;
                             }),
                 std::size_t);
    EXPECT_EQ(went_on, 0) << threads << " threads";
  }
}

TEST(Parallel, TasksOfATaskAreDoneByItsThread) {
  std::atomic<int> inner{0}, elsewhere{0};
  parallelFor(4, 8, [&](std::size_t, int) {
    const std::thread::id outer = std::this_thread::get_id();
    parallelFor(4, 10, [&](std::size_t, int thread) {
      ++inner;
      if (thread != 0 || std::this_thread::get_id() != outer) ++elsewhere;
    });
  });
  EXPECT_EQ(inner, 80);
  EXPECT_EQ(elsewhere, 0);
}

TEST(Parallel, SeveralThreadsMayAskAtOnceAndNoNumberIsOfTwoThreads) {
  std::atomic<int> wrong{0};
  std::vector<std::thread> callers;
  for (int caller = 0; caller < 4; ++caller)
    callers.emplace_back([&] {
      for (int repetition = 0; repetition < 100; ++repetition) {
        std::array<std::atomic<int>, 50> done{};
        std::array<std::atomic<bool>, 3> taken{};
        parallelFor(3, done.size(), [&](std::size_t task, int thread) {
          if (taken[static_cast<std::size_t>(thread)].exchange(true)) ++wrong;
          ++done[task];
          taken[static_cast<std::size_t>(thread)] = false;
        });
        for (const std::atomic<int>& times : done) wrong += times != 1;
      }
    });
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(wrong, 0);
}

#if defined(__linux__) && !defined(__SANITIZE_THREAD__)  // which lets a forked process start no threads
TEST(Parallel, AForkedProcessHasHelpersOfItsOwn) {
  parallelFor(3, 10, [](std::size_t, int) {});
  const pid_t child = fork();
  if (child == 0) {
    std::atomic<int> done{0};
    // Two tasks that need each other: a process without helpers would stay here.
    std::promise<void> first, second;
    parallelFor(2, 2, [&](std::size_t task, int) {
      (task == 0 ? first : second).set_value();
      const std::future_status other = (task == 0 ? second : first).get_future().wait_for(std::chrono::minutes(1));
      if (other == std::future_status::ready) ++done;
    });
    _exit(done == 2 ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}
#endif

#if defined(__linux__)
TEST(Parallel, NoNumberMeansAsManyThreadsAsCoresThatThisThreadMayUse) {
  cpu_set_t allowed, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof(allowed), &allowed), 0);
  EXPECT_EQ(resolveThreads(0), CPU_COUNT(&allowed));
  CPU_ZERO(&one);
  CPU_SET(static_cast<std::size_t>(sched_getcpu()), &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof(one), &one), 0);
  const int threads = resolveThreads(0);
  ASSERT_EQ(sched_setaffinity(0, sizeof(allowed), &allowed), 0);
  EXPECT_EQ(threads, 1);
}
#endif

TEST(Parallel, NoMoreThreadsThanAnyMachineHasCores) {
  EXPECT_EQ(resolveThreads(3), 3);
  EXPECT_EQ(resolveThreads(100000), 1024);
  EXPECT_GE(resolveThreads(0), 1);
}

}  // namespace
