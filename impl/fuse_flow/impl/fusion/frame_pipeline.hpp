#pragma once

#include <fuse_flow/fusion/parameters.h>
#include <fuse_flow/fusion/statistics.h>
#include <fuse_flow/impl/fusion/color_depth_map.hpp>
#include <fuse_flow/impl/fusion/consistency_evaluator.hpp>
#include <fuse_flow/impl/fusion/frame_depths.hpp>
#include <fuse_flow/impl/fusion/frame_measurements.hpp>
#include <fuse_flow/impl/fusion/frame_tasks.hpp>
#include <fuse_flow/impl/fusion/hash_aggregation.hpp>
#include <fuse_flow/impl/parameters.hpp>
#include <fuse_flow/impl/sensors/depth_surface.hpp>
#include <fuse_flow/precompiled.h>
#include <fuse_flow/rig_frame.h>

#include <chrono>
#include <functional>

namespace fuse_flow {
namespace host {

/** \brief Section II of the paper for one frame: all but the point type. What each step does to a row or to a cell stands in a file of its
 *  own: depth and refined depth (frame_depths.hpp); confidence, gate, back-projection, partition (frame_measurements.hpp); representatives,
 *  consistency, fusion (fuse_cell.hpp). Points are numbered camera by camera, pixel by pixel. */
class FramePipeline {
 public:
  FuseFlowParameters parameters;
  int threads{0};
  /** \brief Whether color() will be called. */
  bool with_color{true};
  /** \brief Whether the pixels of missing cameras have numbers too, as if they were there: others may have their views. */
  bool number_missing{false};
  /** \brief Called, where measurements need others that agree, once D^r of all views is there, and before the first measurement is weighed. */
  std::function<void()> all_refined;
  FrameStatistics statistics;

  /** \brief Eq. 3, 8, 9 and the partition into coarse cells. The frame must stay alive until its output has been read. */
  FUSE_FLOW_INLINE void generate(const RigFrame& frame);

  /** \brief Section 5, cell by cell; aggregation().forEachBlock() then tells the order of the fused points. */
  FUSE_FLOW_INLINE void aggregate(FusedPointSink& sink);

  /** \brief The same for some of the cells. \param wanted whether a cell of this key is one */
  template <typename Wanted>
  void aggregateIf(FusedPointSink& sink, const Wanted& wanted) {
    const Clock::time_point start = Clock::now();
    aggregation_.grid.mergeIf(wanted);
    statistics.merge_ms = since(start);
    fuseCells(sink);
  }

  /** \brief The ablation's point-wise fusion: every gated point, of weight C V, with the points that other views have in
   *  its place, each of weight C exp(−d²/σ²). Calls emit(fused point, PointCameras::mask()) in the order of the pixels. */
  template <typename Emit>
  void fusePointWise(const Emit& emit) const {
    const ConsistencyEvaluator evaluator = makeEvaluator();
    for (std::uint32_t index = 0; index < points_.size(); ++index)
      if (points_.C(index) > 0) {
        std::uint64_t cameras = 0;
        const FusedPoint fused = fusePoint(index, evaluator, cameras);
        emit(fused, cameras);
      }
  }

  const HashAggregation& aggregation() const { return aggregation_; }
  int resolvedThreads() const { return threads_; }

  /** \brief Where a point was measured. */
  FramePoints::Pixel locate(std::uint32_t index) const { return points_.locate(index); }

  /** \brief Colour of a pixel, from its view's image. */
  ViewColor color(const FramePoints::Pixel& at) const {
    const ViewGeometry& view = rig_[at.view];
    if (!resolved_colors_.empty() && resolved_colors_[at.view] != nullptr)
      return resolved_colors_[at.view][static_cast<std::ptrdiff_t>(at.v) * view.intrinsics.width + at.u];
    const ImageView<Rgb8>& image = frame_->views[at.view].color;
    if (!view.own_color_camera) return pixelColor(image, at.u, at.v);  // depth may be far away in memory
    return viewColor(view, image, color_depths_[at.view].cells(), at.u, at.v, view.ray(at.u, at.v),
                     depths_.refined(at.view).row(at.v)[at.u]);
  }

  /** \brief Unit normal of the depth surface at a pixel, world frame, facing its camera; zero where neighbours are
   *  missing. */
  Vec3 normal(const FramePoints::Pixel& at) const {
    return surfaceNormal(rig_[at.view], DepthSurface{depths_.refined(at.view), rig_[at.view]}, at.u, at.v);
  }

  using Clock = std::chrono::steady_clock;
  static double since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  }

 protected:  // for a pipeline whose views are not all its own
  using Step = FrameTasks::Step;
  using Stretch = FrameTasks::Stretch;

  /** \brief Of a thread, in a cache line of its own. */
  struct alignas(64) BusyTimes {
    Clock::duration preprocess{0};
    Clock::duration generate{0};
  };

  /** \brief One step on some rows of a view, or on all of it: D, D^r, and then the points. */
  void runTask(const FrameTasks::Task& task, int thread) {
    const std::size_t i = task.view;
    const std::uint32_t scratch = tasks_.scratchOf(i);
    switch (task.step) {
      case Step::TakeScratch:
        depths_.takeScratch(i, scratch);
        break;
      case Step::Convert:
        forEachRow(task, [&](int v) { depths_.convert(i, v, scratch); });
        break;
      case Step::WholeView:
        depths_.finishMeasured(i);
        break;
      case Step::Invert:
        forEachRow(task, [&](int v) { depths_.invert(i, v, scratch); });
        break;
      case Step::Smooth:
        forEachRow(task, [&](int v) { depths_.smooth(i, task.pass, v, scratch); });
        break;
      case Step::AllViews:
        if (all_refined) all_refined();
        break;
      case Step::Points:
        generatePoints(task.stretch, static_cast<std::size_t>(thread));
        break;
    }
  }

  template <typename Action>
  void forEachRow(const FrameTasks::Task& task, const Action& action) const {
    const Stretch& stretch = tasks_.stretches()[task.stretch];
    for (int v = stretch.begin_row; v < stretch.end_row; ++v) action(v);
  }

  void generatePoints(std::size_t s, std::size_t thread) {
    RunBuilder& cells = aggregation_.grid.builders()[s];
    cells.start(parameters.aggregation.cell_size);
    counts_[s] = measurements_.measure(tasks_.stretches()[s], thread, cells);
    cells.finish();
  }

  /** \brief Memory and tasks of a frame. */
  void layOut() {
    startStatistics();
    depths_.start(*frame_, rig_, parameters, number_missing);
    tasks_.layOut(depths_.views(), parameters.smoothing, threads_, detail::asksForAgreement(parameters));
    depths_.reserveScratch(tasks_.scratchMaps());
    const std::vector<Stretch>& stretches = tasks_.stretches();
    counts_.assign(stretches.size(), {});
    std::vector<RunBuilder>& cells = aggregation_.grid.start(stretches.size());
    for (std::size_t s = 0; s < stretches.size(); ++s)
      if (depths_.views()[stretches[s].view].missing) cells[s].start(parameters.aggregation.cell_size);
    points_.assign(*frame_, rig_, depths_.refined(), depths_.offsets(), depths_.noise(), parameters.smoothing);
    measurements_.start(*frame_, rig_, parameters, depths_, points_, threads_);
    busy_.assign(static_cast<std::size_t>(threads_), {});
  }

  /** \brief Keeps the memory of the last frame's. */
  void startStatistics() {
    FrameStatistics fresh;
    fresh.noise_scales = std::move(statistics.noise_scales);
    fresh.missing_cameras = std::move(statistics.missing_cameras);
    fresh.out_of_range = std::move(statistics.out_of_range);
    statistics = std::move(fresh);
    const std::size_t n = frame_->cameras.size();
    statistics.noise_scales.assign(n, 1.0f);
    statistics.missing_cameras.clear();
    statistics.missing_cameras.reserve(n);
    statistics.out_of_range.clear();
    statistics.out_of_range.reserve(n);
    for (std::size_t i = 0; i < n; ++i)
      if (frame_->views[i].missing()) statistics.missing_cameras.push_back(i);
  }

  /** \brief Depth and points overlap: each has its share of what they took together. */
  void keepTimes(double before, double together) {
    BusyTimes busy{};
    for (const BusyTimes& of_thread : busy_) {
      busy.preprocess += of_thread.preprocess;
      busy.generate += of_thread.generate;
    }
    const double all = static_cast<double>((busy.preprocess + busy.generate).count());
    statistics.generate_ms = all > 0 ? together * static_cast<double>(busy.generate.count()) / all : 0;
    statistics.preprocess_ms = before + together - statistics.generate_ms;
  }

  void keepCounts() {
    for (std::size_t i = 0; i < rig_.size(); ++i) statistics.noise_scales[i] = depths_.noise(i).scale;
    measured_.assign(rig_.size(), 0);
    for (std::size_t s = 0; s < counts_.size(); ++s) {
      measured_[tasks_.stretches()[s].view] += counts_[s].measured;
      statistics.measured_points += counts_[s].measured;
      statistics.gated_points += counts_[s].gated;
    }
  }

  /** \brief Only where hardly anything is in range, which costs a look at all of the image: more often than not its unit is wrong. */
  void lookForDepthOutOfRange() {
    for (std::size_t i = 0; i < rig_.size(); ++i) {
      if (frame_->views[i].missing() || !hardlyAny(measured_[i], frame_->cameras[i].intrinsics)) continue;
      const DepthOutOfRange found =
          depthOutOfRange(frame_->views[i], frame_->cameras[i].depth_scale, i, parameters.preprocessing);
      if (nearlyAll(found)) statistics.out_of_range.push_back(found);
    }
  }

  /** \brief What stands before the colour cameras that are not the depth cameras. */
  void findHiddenColors() {
    color_depths_.resize(rig_.size());
    const auto asked = [&](std::size_t i) {
      return with_color && rig_[i].own_color_camera && frame_->views[i].color && !depths_.measured(i).empty();
    };
    bool any = false;
    for (std::size_t i = 0; i < rig_.size(); ++i) {
      any = any || asked(i);
      if (!asked(i)) color_depths_[i].clear();
    }
    if (!any) return;
    parallelFor(threads_, rig_.size(), [&](std::size_t i, int) {
      if (asked(i)) color_depths_[i].assign(rig_[i], DepthSurface{depths_.refined(i), rig_[i]});
    });
  }

  FUSE_FLOW_INLINE void fuseCells(FusedPointSink& sink);

  /** \brief Eq. 4–7. */
  ConsistencyEvaluator makeEvaluator() const {
    ConsistencyEvaluator evaluator(parameters.consistency, rig_, depths_.measured());
    evaluator.setNoise(depths_.noise());
    evaluator.setConfidence(&frame_->views);
    if (detail::usesConfirmation(parameters.smoothing, parameters.aggregation))
      evaluator.setRefined(depths_.refined(), parameters.aggregation, detail::halfWeightNoise(parameters));
    return evaluator;
  }

  FusedPoint fusePoint(std::uint32_t index, const ConsistencyEvaluator& evaluator, std::uint64_t& cameras) const {
    const std::uint32_t i = points_.viewOf(index);
    cameras = cameraBit(i);
    const WeightedPoint own{points_.position(index), points_.C(index)};
    PointWiseFusion fusion(own.p);
    if (parameters.use_distance_consistency) {
      const Vec3 normal = evaluator.asksForNormals() ? points_.normal(index, i) : Vec3{};
      fusion.add(index, own.p, own.C * consistency(parameters.consistency, evaluator(own.p, normal, i)));
      evaluator.forEachOpinion(own.p, normal, i, [&](std::uint32_t j, int u, int v, const ViewOpinion& opinion) {
        const std::uint32_t other =
            depths_.offsets()[j] + static_cast<std::uint32_t>(v * depths_.measured(j).width() + u);
        if (!(points_.C(other) > 0) || opinion.verdict != ViewOpinion::Distance) return;
        cameras |= cameraBit(j);
        fusion.add(other, points_.position(other), points_.C(other) * expOfNegative(-opinion.squared_distance));
      });
    } else {
      fusion.add(index, own.p, own.C);
    }
    return fusion.finish();
  }

  const RigFrame* frame_{nullptr};
  int threads_{1};
  RigGeometry rig_;
  FrameTasks tasks_;
  FrameDepths depths_;
  FrameMeasurements measurements_;
  FramePoints points_;
  HashAggregation aggregation_;
  std::vector<ColorDepthMap> color_depths_;  ///< of the views whose colour camera stands beside
  /** \brief Of each view the colours of its pixels, row by row, where they have come from elsewhere; empty: of none. */
  std::vector<const ViewColor*> resolved_colors_;
  std::vector<FrameMeasurements::Counts> counts_;
  std::vector<std::size_t> measured_;  ///< of each view, in range
  std::vector<BusyTimes> busy_;
};

#if !defined(FUSE_FLOW_DECLARATIONS_ONLY)

FUSE_FLOW_INLINE void FramePipeline::generate(const RigFrame& frame) {
  const Clock::time_point start = Clock::now();  // a first frame lays out memory, which takes time too
  checkRigFrame(frame);
  detail::checkGivenConfidence(parameters, frame);
  detail::checkAgreement(parameters, frame);
  frame_ = &frame;
  threads_ = resolveThreads(threads);
  rig_.update(frame);
  layOut();
  const double before = since(start);
  const Clock::time_point laid_out = Clock::now();
  tasks_.run(threads_, [&](const FrameTasks::Task& task, int thread) {
    const Clock::time_point begin = Clock::now();
    runTask(task, thread);
    BusyTimes& busy = busy_[static_cast<std::size_t>(thread)];
    (task.step == Step::Points ? busy.generate : busy.preprocess) += Clock::now() - begin;
  });
  keepTimes(before, since(laid_out));
  findHiddenColors();
  keepCounts();
  lookForDepthOutOfRange();
}

FUSE_FLOW_INLINE void FramePipeline::aggregate(FusedPointSink& sink) {
  aggregateIf(sink, [](std::uint64_t) { return true; });
}

FUSE_FLOW_INLINE void FramePipeline::fuseCells(FusedPointSink& sink) {
  statistics.coarse_cells = aggregation_.grid.cells().size();
  const Clock::time_point merged = Clock::now();
  const ConsistencyEvaluator evaluator = makeEvaluator();
  aggregation_.fuse(parameters.aggregation, threads_, points_,
                    parameters.use_distance_consistency ? &evaluator : nullptr, measurements_.cropBox(), sink);
  statistics.fuse_ms = since(merged);
}

#endif

}  // namespace host
}  // namespace fuse_flow
