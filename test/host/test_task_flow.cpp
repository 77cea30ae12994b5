#include <fuse_flow/impl/fusion/frame_tasks.hpp>
#include <fuse_flow/impl/host/task_flow.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <future>
#include <mutex>
#include <random>
#include <set>
#include <thread>
#include <utility>
#include <vector>

namespace {

using fuse_flow::SmoothingParameters;
using fuse_flow::host::FrameTasks;
using fuse_flow::host::TaskFlow;
using Dependencies = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/** \brief Tasks with up to three dependencies each on any before them. */
Dependencies randomDependencies(std::uint32_t tasks, std::mt19937& random) {
  Dependencies dependencies;
  for (std::uint32_t after = 1; after < tasks; ++after)
    for (std::uint32_t k = random() % 4; k > 0; --k)
      dependencies.emplace_back(static_cast<std::uint32_t>(random() % after), after);
  return dependencies;
}

void fill(TaskFlow& flow, std::uint32_t tasks, const Dependencies& dependencies) {
  flow.clear();
  for (std::uint32_t task = 0; task < tasks; ++task) EXPECT_EQ(flow.add(), task);
  for (const auto& [before, after] : dependencies) flow.addDependency(before, after);
}

TEST(TaskFlow, EveryTaskIsDoneOnceAndAfterWhatItDependsOn) {
  std::mt19937 random(1);
  TaskFlow flow;
  for (const std::uint32_t tasks : {0u, 1u, 2u, 63u, 64u, 65u, 300u})
    for (const int threads : {1, 2, 3, 8}) {
      const Dependencies dependencies = randomDependencies(tasks, random);
      fill(flow, tasks, dependencies);
      for (int repetition = 0; repetition < 3; ++repetition) {  // its second run is like its first
        std::vector<std::atomic<int>> done(tasks);
        std::atomic<int> too_early{0};
        flow.run(threads, [&](std::size_t task, int thread) {
          EXPECT_GE(thread, 0);
          EXPECT_LT(thread, threads);
          for (const auto& [before, after] : dependencies)
            if (after == task && done[before] == 0) ++too_early;
          ++done[task];
        });
        ASSERT_EQ(too_early, 0) << tasks << " tasks, " << threads << " threads";
        for (std::uint32_t task = 0; task < tasks; ++task) ASSERT_EQ(done[task], 1) << task;
      }
    }
}

TEST(TaskFlow, OneThreadGoesInTheTasksOrder) {
  std::mt19937 random(2);
  TaskFlow flow;
  fill(flow, 200, randomDependencies(200, random));
  std::vector<std::size_t> order;
  flow.run(1, [&](std::size_t task, int) { order.push_back(task); });
  ASSERT_EQ(order.size(), 200u);
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
}

TEST(TaskFlow, ATaskThatStandsStillHoldsUpOnlyWhatDependsOnIt) {
  // Two rows of five tasks, step by step. The first task of the first row goes on only when all of the second row is done.
  TaskFlow flow;
  for (std::uint32_t k = 0; k < 10; ++k) flow.add();
  for (std::uint32_t k = 2; k < 10; ++k) flow.addDependency(k - 2, k);
  std::promise<void> second_row;
  std::atomic<bool> in_time{false};
  flow.run(2, [&](std::size_t task, int) {
    if (task == 9) second_row.set_value();
    if (task == 0) in_time = second_row.get_future().wait_for(std::chrono::minutes(1)) == std::future_status::ready;
  });
  EXPECT_TRUE(in_time);
}

TEST(TaskFlow, WhatTheSmallestTaskThrowsIsRethrownAndAllTasksBeforeItAreDone) {
  std::mt19937 random(3);
  TaskFlow flow;
  fill(flow, 100, randomDependencies(100, random));
  for (int repetition = 0; repetition < 20; ++repetition)
    for (const int threads : {1, 4}) {
      std::vector<std::atomic<int>> done(100);
      std::size_t thrown = done.size();
      try {
        flow.run(threads, [&](std::size_t task, int) {
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

/** \brief Which step of which view last wrote each row of each map: a model of what the tasks of a frame read and write. */
class MapsInModel {
 public:
  MapsInModel(const std::vector<FrameTasks::View>& views, const SmoothingParameters& smoothing, bool points_need_all,
              const FrameTasks& tasks)
      : views_(views),
        points_need_all_(points_need_all),
        smoothing_(smoothing),
        passes_(smoothingPasses(smoothing)),
        tasks_(tasks),
        depth_(views.size()),
        kept_(views.size()),
        scratch_(tasks.scratchMaps()) {
    for (std::size_t i = 0; i < views.size(); ++i) {
      depth_[i].assign(rows(i), {i, -1});
      kept_[i].assign(rows(i), {i, -1});
    }
    points_.assign(tasks.stretches().size(), 0);
  }

  void run(const FrameTasks::Task& task) {
    const std::size_t i = task.view;
    const FrameTasks::Stretch stretch = tasks_.stretches()[task.stretch];
    switch (task.step) {
      case FrameTasks::Step::TakeScratch:
        for (Map& map : scratch_[tasks_.scratchOf(i)]) map.assign(rows(i), {i, -1});
        break;
      case FrameTasks::Step::Convert:
        write(depth_[i], stretch, {i, 0});
        if (passes_ > 0 && !views_[i].whole_image) write(map(i, 0), stretch, {i, 0});
        break;
      case FrameTasks::Step::WholeView:
        read(depth_[i], 0, views_[i].height, {i, 0});
        write(depth_[i], {task.view, 0, views_[i].height}, {i, 1});
        break;
      case FrameTasks::Step::Invert:
        read(depth_[i], stretch.begin_row, stretch.end_row, {i, 1});
        write(map(i, 0), stretch, {i, 0});
        break;
      case FrameTasks::Step::Smooth: {
        const int step = smoothingStep(smoothing_, task.pass, 1e9f);
        read(map(i, task.pass), stretch.begin_row - step, stretch.end_row + step, {i, task.pass});
        if (task.pass == passes_ - 1 && passes_ > smoothing_.passes)  // twicing looks at what was before it
          read(map(i, smoothing_.passes), stretch.begin_row - 1, stretch.end_row + 1, {i, smoothing_.passes});
        write(map(i, task.pass + 1), stretch, {i, task.pass + 1});
        break;
      }
      case FrameTasks::Step::AllViews:
        for (std::size_t k = 0; k < views_.size(); ++k)
          if (!views_[k].missing)
            read(passes_ > 0 ? kept_[k] : depth_[k], 0, views_[k].height,
                 {k, passes_ > 0                                ? passes_
                     : views_[k].whole_image || views_[k].noise ? 1
                                                                : 0});
        all_views_ = true;
        break;
      case FrameTasks::Step::Points:
        wrong_ += points_need_all_ != all_views_;
        read(depth_[i], stretch.begin_row - 2, stretch.end_row + 2,
             {i, views_[i].whole_image || views_[i].noise ? 1 : 0});
        if (passes_ > 0) read(kept_[i], stretch.begin_row - 2, stretch.end_row + 2, {i, passes_});
        ++points_[task.stretch];
        break;
    }
  }

  int wrongReads() const { return wrong_; }
  /** \brief How often each stretch's points have been made. */
  const std::vector<int>& points() const { return points_; }

 private:
  using Written = std::pair<std::size_t, int>;  ///< view and pass
  using Map = std::vector<Written>;

  std::size_t rows(std::size_t i) const { return static_cast<std::size_t>(views_[i].height); }
  Map& map(std::size_t i, int pass) {
    const int map = smoothingMap(smoothing_, pass);
    if (map == smoothingMap(smoothing_, passes_)) return kept_[i];
    return scratch_[tasks_.scratchOf(i)][static_cast<std::size_t>(map)];
  }

  static void write(Map& map, const FrameTasks::Stretch& stretch, const Written& what) {
    for (int v = stretch.begin_row; v < stretch.end_row; ++v) map.at(static_cast<std::size_t>(v)) = what;
  }
  void read(const Map& map, int begin, int end, const Written& expected) {
    for (int v = std::max(begin, 0); v < std::min(end, static_cast<int>(map.size())); ++v)
      wrong_ += map[static_cast<std::size_t>(v)] != expected;
  }

  const std::vector<FrameTasks::View>& views_;
  bool points_need_all_, all_views_{false};
  SmoothingParameters smoothing_;
  int passes_;
  const FrameTasks& tasks_;
  std::vector<Map> depth_, kept_;
  std::vector<std::array<Map, 3>> scratch_;  // as smoothingMap() numbers them; one of the three is the view's own
  std::vector<int> points_;
  int wrong_{0};
};

std::vector<FrameTasks::View> randomViews(std::mt19937& random) {
  const int widths[] = {160, 640, 5000, 20000, 70000};  // 204 rows a stretch to one
  std::vector<FrameTasks::View> views(1 + random() % 9);
  for (FrameTasks::View& view : views)
    view = {widths[random() % 5], 1 + static_cast<int>(random() % 90), random() % 5 == 0, random() % 3 == 0,
            random() % 2 == 0};
  return views;
}

TEST(FrameTasks, NoTaskReadsWhatIsNotWrittenYetOrWrittenOver) {
  std::mt19937 random(4);
  FrameTasks tasks;
  for (int repetition = 0; repetition < 300; ++repetition) {
    const std::vector<FrameTasks::View> views = randomViews(random);
    SmoothingParameters smoothing;
    smoothing.passes = static_cast<int>(random() % 5);
    smoothing.twicing = random() % 2 == 0;
    const int threads = 1 + static_cast<int>(random() % 4);
    const bool points_need_all = random() % 3 == 0;
    tasks.layOut(views, smoothing, 1 + static_cast<int>(random() % 4), points_need_all);
    MapsInModel maps(views, smoothing, points_need_all, tasks);
    std::mutex mutex;
    const std::uint32_t slow = static_cast<std::uint32_t>(random());
    tasks.run(threads, [&](const FrameTasks::Task& task, int) {
      // Some stretches take longer than others.
      volatile std::uint32_t left = (task.stretch * 2654435761u ^ slow) % 5 == 0 ? 3000 : 0;
      while (left > 0) left = left - 1;
      const std::lock_guard<std::mutex> lock(mutex);
      maps.run(task);
    });
    ASSERT_EQ(maps.wrongReads(), 0) << "repetition " << repetition << ", " << views.size() << " views, "
                                    << smoothing.passes << " passes, twicing " << smoothing.twicing;
    for (std::size_t s = 0; s < tasks.stretches().size(); ++s)
      ASSERT_EQ(maps.points()[s], views[tasks.stretches()[s].view].missing ? 0 : 1);
  }
}

TEST(FrameTasks, StretchesAreAllRowsOfEachViewInTheirOrderWhateverTheThreads) {
  const std::vector<FrameTasks::View> views = {
      {640, 480, false, false, true}, {640, 480, true, false, true}, {5000, 7, false, true, true}};
  FrameTasks tasks;
  for (const int threads : {1, 2, 5}) {
    tasks.layOut(views, {}, threads, false);
    int next_row = 0;
    std::uint32_t view = 0;
    for (const FrameTasks::Stretch& stretch : tasks.stretches()) {
      if (stretch.view != view) {
        EXPECT_TRUE(views[view].missing || next_row == views[view].height);
        ++view;
        ASSERT_EQ(stretch.view, view);
        next_row = 0;
      }
      if (views[view].missing) {
        EXPECT_EQ(stretch.begin_row, stretch.end_row);
        continue;
      }
      EXPECT_EQ(stretch.begin_row, next_row);
      EXPECT_GT(stretch.end_row, stretch.begin_row);
      next_row = stretch.end_row;
    }
    EXPECT_EQ(view, 2u);
    EXPECT_EQ(next_row, 7);
  }
}

TEST(FrameTasks, AsManyScratchMapsAsViewsThatAreBegunAtATimeWhicheverAreMissing) {
  std::vector<FrameTasks::View> views(8, {640, 480, false, false, true});  // ten stretches each
  FrameTasks tasks;
  for (std::size_t missing = 0; missing < 3; ++missing) {
    views[2 * missing].missing = missing > 0;
    for (const auto& [threads, maps] : {std::pair(1, 1u), std::pair(2, 2u), std::pair(3, 3u), std::pair(16, 8u)}) {
      tasks.layOut(views, {}, threads, false);
      EXPECT_EQ(tasks.scratchMaps(), maps) << threads << " threads";
    }
  }
}

}  // namespace
