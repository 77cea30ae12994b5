#pragma once

#include <fuse_flow/impl/host/task_flow.hpp>
#include <fuse_flow/math/smoothing.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief What is done to the views of a frame until their points are there: what in one task, in which order, and what before what. */
class FrameTasks {
 public:
  enum class Step : std::uint8_t {
    TakeScratch,  ///< the map that a view is smoothed in, once the view that had it is smoothed
    Convert,      ///< raw depth to metres
    WholeView,    ///< what is not done row by row: multipath interference, filling, the view's noise
    Invert,       ///< depth to inverse depth, where Convert could not do it yet
    Smooth,       ///< one pass
    AllViews,     ///< what comes after it has the depth of all views
    Points
  };

  /** \brief On a stretch of a view; TakeScratch and WholeView on all of it, AllViews on none. */
  struct Task {
    Step step;
    int pass;  ///< of Smooth
    std::uint32_t view;
    std::uint32_t stretch;
  };

  /** \brief Rows that one task works on: some 32,000 pixels, whatever the number of threads; none of a camera that is missing, whose
   *  memory others do not take: they would need more. */
  struct Stretch {
    std::uint32_t view{0};
    int begin_row{0};
    int end_row{0};
  };

  struct View {
    int width{0};
    int height{0};
    bool missing{false};
    bool whole_image{false};  ///< its depth changes other than row by row
    bool noise{false};        ///< is measured
  };

  /** \brief Views are begun as many at a time as keep all threads busy: their maps then stay in the caches from step to step.
   *  \param points_need_all whether the points of a view need the depth of all others */
  void layOut(const std::vector<View>& views, const SmoothingParameters& smoothing, int threads, bool points_need_all) {
    smoothing_ = smoothing;
    passes_ = smoothingPasses(smoothing);
    tasks_.clear();
    flow_.clear();
    owners_.clear();
    scratch_of_.assign(views.size(), 0);
    last_.assign(views.size(), {});
    cutIntoStretches(views);
    const std::uint32_t enough = 10 * static_cast<std::uint32_t>(threads);
    for (std::uint32_t begin = 0, end = 0; begin < views.size(); begin = end) {
      while (end < views.size() && first_stretch_[end] - first_stretch_[begin] < enough) ++end;
      addViews(views, begin, end);
      if (!points_need_all) addPoints(views, begin, end);
    }
    if (!points_need_all) return;
    awaitAllViews(views);
    addPoints(views, 0, static_cast<std::uint32_t>(views.size()));
  }

  const std::vector<Stretch>& stretches() const { return stretches_; }
  /** \brief The number of a view's scratch map. */
  std::uint32_t scratchOf(std::size_t view) const { return scratch_of_[view]; }
  /** \brief As many as frames of these cameras need, whichever are missing. */
  std::size_t scratchMaps() const { return owners_.size(); }

  /** \brief Calls body(task, thread). Exceptions as of parallelFor(). */
  template <typename Body>
  void run(int threads, const Body& body) {
    flow_.run(threads, [&](std::size_t task, int thread) { body(tasks_[task], thread); });
  }

 private:
  /** \brief Consecutive tasks: one for each stretch of a view, or one for all. */
  struct TaskRange {
    std::uint32_t begin{0};
    std::uint32_t end{0};
  };

  /** \brief Of a scratch map: what must be done before it is taken again, and who has taken it last. */
  struct Owner {
    TaskRange smoothed;
    std::uint32_t taken{0};
  };

  static int rowsOfStretch(int width) { return std::max(1, 32768 / width); }

  void cutIntoStretches(const std::vector<View>& views) {
    stretches_.clear();
    first_stretch_.clear();
    for (std::uint32_t i = 0; i < views.size(); ++i) {
      first_stretch_.push_back(static_cast<std::uint32_t>(stretches_.size()));
      const int rows = rowsOfStretch(views[i].width);
      for (int row = 0; row < views[i].height; row += rows)
        stretches_.push_back({i, row, views[i].missing ? row : std::min(row + rows, views[i].height)});
    }
    first_stretch_.push_back(static_cast<std::uint32_t>(stretches_.size()));
  }

  /** \brief Step by step, in each of them view by view. Smoothing goes to and fro between the view's own map and its scratch
   *  maps, so that the last pass writes into its own. */
  void addViews(const std::vector<View>& views, std::uint32_t begin, std::uint32_t end) {
    const auto forEachView = [&](const auto& add) {
      for (std::uint32_t i = begin; i < end; ++i)
        if (!views[i].missing) add(i, views[i]);
    };
    const bool first_into_scratch = smoothingMap(smoothing_, passes_) != 0;  // inverse depth; else the first pass
    if (owners_.size() < end - begin) owners_.resize(end - begin);
    std::uint32_t scratch = 0;
    if (passes_ > 0) forEachView([&](std::uint32_t i, const View&) { takeScratch(i, scratch++); });
    forEachView([&](std::uint32_t i, const View& view) {
      addStretches(Step::Convert, i, 0, 0);
      if (first_into_scratch && !view.whole_image) awaitScratch(i);
    });
    forEachView([&](std::uint32_t i, const View& view) {
      if (view.whole_image || view.noise) addWholeView(i);
    });
    forEachView([&](std::uint32_t i, const View& view) {
      if (passes_ == 0 || !view.whole_image) return;
      addStretches(Step::Invert, i, 0, 0);
      if (first_into_scratch) awaitScratch(i);
    });
    for (int pass = 0; pass < passes_; ++pass)
      forEachView([&](std::uint32_t i, const View& view) {
        // A pass reads what the pass before it has written, and writes over what that one has read.
        const int reach = std::max(largestStep(pass), pass > 0 ? largestStep(pass - 1) : 0);
        addStretches(Step::Smooth, i, pass, stretchesWithin(reach, view));
        if (pass == 0 && !first_into_scratch) awaitScratch(i);
        if (pass == passes_ - 1) owners_[scratch_of_[i]].smoothed = last_[i];
      });
  }

  /** \brief The last step. */
  void addPoints(const std::vector<View>& views, std::uint32_t begin, std::uint32_t end) {
    // Confidence looks one row up and down, support one more.
    for (std::uint32_t i = begin; i < end; ++i)
      if (!views[i].missing) addStretches(Step::Points, i, 0, stretchesWithin(2, views[i]));
  }

  /** \brief Each view goes on once all have come so far. */
  void awaitAllViews(const std::vector<View>& views) {
    const std::uint32_t all = add({Step::AllViews, 0, 0, 0});
    for (std::uint32_t i = 0; i < views.size(); ++i) {
      if (views[i].missing) continue;
      for (std::uint32_t before = last_[i].begin; before < last_[i].end; ++before) flow_.addDependency(before, all);
      last_[i] = {all, all + 1};
    }
  }

  /** \brief Of a pass: as in the noisiest view. */
  int largestStep(int pass) const { return smoothingStep(smoothing_, pass, std::numeric_limits<float>::infinity()); }

  static std::uint32_t stretchesWithin(int rows, const View& view) {
    const int each = rowsOfStretch(view.width);
    return static_cast<std::uint32_t>((rows + each - 1) / each);
  }

  std::uint32_t add(const Task& task) {
    tasks_.push_back(task);
    return flow_.add();
  }

  void takeScratch(std::uint32_t i, std::uint32_t scratch) {
    Owner& owner = owners_[scratch];
    scratch_of_[i] = scratch;
    owner.taken = add({Step::TakeScratch, 0, i, 0});
    for (std::uint32_t before = owner.smoothed.begin; before < owner.smoothed.end; ++before)
      flow_.addDependency(before, owner.taken);
  }

  /** \brief The view's last step writes into its scratch map. */
  void awaitScratch(std::uint32_t i) {
    for (std::uint32_t task = last_[i].begin; task < last_[i].end; ++task)
      flow_.addDependency(owners_[scratch_of_[i]].taken, task);
  }

  void addWholeView(std::uint32_t i) {
    const std::uint32_t whole = add({Step::WholeView, 0, i, 0});
    for (std::uint32_t before = last_[i].begin; before < last_[i].end; ++before) flow_.addDependency(before, whole);
    last_[i] = {whole, whole + 1};
  }

  /** \brief \param reach so many stretches around its own a stretch needs of the step before */
  void addStretches(Step step, std::uint32_t i, int pass, std::uint32_t reach) {
    const TaskRange before = last_[i];
    const bool one_for_all = before.end - before.begin == 1;
    const std::uint32_t first = first_stretch_[i], n = first_stretch_[i + 1] - first;
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t task = add({step, pass, i, first + k});
      // Of a step on the whole view there is one task, which everything needs.
      const std::uint32_t begin = before.begin + (k > reach ? k - reach : 0), end = before.begin + k + reach + 1;
      for (std::uint32_t b = one_for_all ? before.begin : begin;
           b < (one_for_all ? before.end : std::min(end, before.end)); ++b)
        flow_.addDependency(b, task);
    }
    last_[i] = {static_cast<std::uint32_t>(tasks_.size()) - n, static_cast<std::uint32_t>(tasks_.size())};
  }

  SmoothingParameters smoothing_;
  int passes_{0};  ///< all, those of twicing included
  TaskFlow flow_;
  std::vector<Task> tasks_;
  std::vector<Stretch> stretches_;
  std::vector<std::uint32_t> first_stretch_;  ///< of each view, and one past the last
  std::vector<TaskRange> last_;               ///< of each view: its last step so far
  std::vector<std::uint32_t> scratch_of_;
  std::vector<Owner> owners_;  ///< of the scratch maps
};

}  // namespace host
}  // namespace fuse_flow
