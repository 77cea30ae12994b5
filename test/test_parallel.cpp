#include <fuse_flow/impl/host/parallel.hpp>

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <vector>

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

TEST(Parallel, NoMoreThreadsThanAnyMachineHasCores) {
  EXPECT_EQ(resolveThreads(3), 3);
  EXPECT_EQ(resolveThreads(100000), 1024);
  EXPECT_GE(resolveThreads(0), 1);
}

}  // namespace
