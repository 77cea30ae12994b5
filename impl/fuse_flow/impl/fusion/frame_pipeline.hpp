#pragma once

#include <fuse_flow/fusion/parameters.h>
#include <fuse_flow/fusion/statistics.h>
#include <fuse_flow/impl/fusion/cell_fusion.hpp>
#include <fuse_flow/impl/fusion/color_depth_map.hpp>
#include <fuse_flow/impl/fusion/consistency_evaluator.hpp>
#include <fuse_flow/impl/fusion/frame_tasks.hpp>
#include <fuse_flow/impl/fusion/point_row.hpp>
#include <fuse_flow/impl/fusion/weight_rows.hpp>
#include <fuse_flow/impl/parameters.hpp>
#include <fuse_flow/impl/sensors/depth_surface.hpp>
#include <fuse_flow/impl/sensors/preprocessing.hpp>
#include <fuse_flow/precompiled.h>
#include <fuse_flow/rig_frame.h>

#include <chrono>

namespace fuse_flow {
namespace detail {

/** \brief For the per-pixel maths. */
inline Box cropBox(const FuseFlowParameters& parameters) {
  if (!parameters.crop_box) return {};
  const Eigen::Vector3f &low = parameters.crop_box->min(), &high = parameters.crop_box->max();
  return {{low.x(), low.y(), low.z()}, {high.x(), high.y(), high.z()}};
}

/** \brief Whether measurements need others around them. */
inline bool asksForSupport(const FuseFlowParameters& parameters) {
  return parameters.use_measurement_confidence && parameters.min_support > 0;
}

/** \brief FuseFlowParameters::half_weight_noise, or 0 where all measurements weigh the same. */
inline float halfWeightNoise(const FuseFlowParameters& parameters) {
  return parameters.use_measurement_confidence ? parameters.half_weight_noise : 0.0f;
}

/** \brief FuseFlowParameters::max_noise, or 0 where every measurement counts. */
inline float maxNoise(const FuseFlowParameters& parameters) {
  return parameters.use_measurement_confidence ? parameters.max_noise : 0.0f;
}

}  // namespace detail

namespace host {

/** \brief All of a frame but the point type. Points are numbered camera by camera, pixel by pixel. */
class FramePipeline {
 public:
  FuseFlowParameters parameters;
  int threads{0};
  /** \brief Whether color() will be called. */
  bool with_color{true};
  FrameStatistics statistics;

  /** \brief Preprocessing, eq. 3, 8, 9. The frame must stay alive until its output has been read. */
  FUSE_FLOW_INLINE void generate(const RigFrame& frame);

  /** \brief Section 5; aggregation().forEachBlock() then tells the order of the fused points. */
  FUSE_FLOW_INLINE void aggregate(FusedPointSink& sink);

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
    const ImageView<Rgb8>& image = frame_->views[at.view].color;
    if (!view.own_color_camera) return pixelColor(image, at.u, at.v);  // depth may be far away in memory
    return viewColor(view, image, color_depths_[at.view].cells(), at.u, at.v, view.ray(at.u, at.v),
                     refined(at.view).row(at.v)[at.u]);
  }

  /** \brief Unit normal of the depth surface at a pixel, world frame, facing its camera; zero where neighbours are
   *  missing. */
  Vec3 normal(const FramePoints::Pixel& at) const {
    return surfaceNormal(rig_[at.view], DepthSurface{refined(at.view), rig_[at.view]}, at.u, at.v);
  }

  using Clock = std::chrono::steady_clock;
  static double since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  }

 private:
  using Step = FrameTasks::Step;
  using Stretch = FrameTasks::Stretch;

  struct Counts {
    std::size_t measured{0};
    std::size_t gated{0};
  };

  /** \brief Of a thread, in a cache line of its own. */
  struct alignas(64) BusyTimes {
    Clock::duration preprocess{0};
    Clock::duration generate{0};
  };

  void layOut() {
    const std::size_t n = frame_->cameras.size();
    std::vector<float> noise_scales = std::move(statistics.noise_scales);  // their memory
    std::vector<std::size_t> missing_cameras = std::move(statistics.missing_cameras);
    std::vector<DepthOutOfRange> out_of_range = std::move(statistics.out_of_range);
    statistics = {};
    noise_scales.assign(n, 1.0f);
    statistics.noise_scales = std::move(noise_scales);
    missing_cameras.clear();
    missing_cameras.reserve(n);
    statistics.missing_cameras = std::move(missing_cameras);
    out_of_range.clear();
    out_of_range.reserve(n);
    statistics.out_of_range = std::move(out_of_range);
    depths_.resize(n);
    multipath_.resize(n);
    refined_.resize(n);
    offsets_.assign(n + 1, 0);
    views_.resize(n);
    const int passes = parameters.smoothing.passes;
    std::size_t total = 0;
    for (std::size_t i = 0; i < n; ++i) {
      offsets_[i] = static_cast<std::uint32_t>(total);
      const Intrinsics& K = frame_->cameras[i].intrinsics;
      const bool missing = frame_->views[i].missing();
      views_[i] = {K.width, K.height, missing, needsWholeImage(parameters.preprocessing, rig_[i]),
                   parameters.adapt_noise};
      if (missing) {
        statistics.missing_cameras.push_back(i);
        depths_[i].clear();
        continue;
      }
      total += static_cast<std::size_t>(K.width) * static_cast<std::size_t>(K.height);
      if (total > std::numeric_limits<std::uint32_t>::max() - 1u)
        throw pcl::PCLException("fuse_flow::FuseFlow: a frame has more than 2^32 pixels");
      depths_[i].resize(K.width, K.height);
      if (passes > 0) refined_[i].resize(K.width, K.height);
    }
    offsets_[n] = static_cast<std::uint32_t>(total);
    tasks_.layOut(views_, passes, threads_);
    counts_.assign(tasks_.stretches().size(), {});
    if (passes > 0) reserveScratch();
  }

  /** \brief Only where hardly anything is in range, which costs a look at all of the image: more often than not its unit is wrong. */
  void lookForDepthOutOfRange() {
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const Intrinsics& K = frame_->cameras[i].intrinsics;
      if (views_[i].missing || !hardlyAny(measured_[i], K)) continue;
      const DepthOutOfRange found =
          depthOutOfRange(frame_->views[i], frame_->cameras[i].depth_scale, i, parameters.preprocessing);
      if (nearlyAll(found)) statistics.out_of_range.push_back(found);
    }
  }

  /** \brief What stands before the colour cameras that are not the depth cameras. */
  void findHiddenColors() {
    color_depths_.resize(depths_.size());
    const auto asked = [&](std::size_t i) {
      return with_color && rig_[i].own_color_camera && frame_->views[i].color && !depths_[i].empty();
    };
    bool any = false;
    for (std::size_t i = 0; i < depths_.size(); ++i) {
      any = any || asked(i);
      if (!asked(i)) color_depths_[i].clear();
    }
    if (!any) return;
    parallelFor(threads_, depths_.size(), [&](std::size_t i, int) {
      if (asked(i)) color_depths_[i].assign(rig_[i], DepthSurface{refined(i), rig_[i]});
    });
  }

  /** \brief Scratch maps are as large as any view is. What is not used is address space alone. */
  void reserveScratch() {
    std::size_t most = 0;
    for (const FrameTasks::View& view : views_)
      if (!view.missing) most = std::max(most, DepthMap::sizeOf(view.width, view.height));
    if (scratch_.size() < tasks_.scratchMaps()) scratch_.resize(tasks_.scratchMaps());
    for (DepthMap& map : scratch_) map.reserve(most);
  }

  /** \brief D^r of eq. 8, the paper's refined depth, and then the points. */
  void runTask(const FrameTasks::Task& task, int thread) {
    const std::size_t i = task.view;
    const PreprocessingParameters& p = parameters.preprocessing;
    switch (task.step) {
      case Step::TakeScratch:
        scratch_[tasks_.scratchOf(i)].resize(depths_[i].width(), depths_[i].height());
        break;
      case Step::Convert:
        forEachRow(task, [&](int v) {
          convertDepthRow(frame_->views[i], rig_[i].depth_scale, p.min_range, p.max_range, v, rig_[i].corrections(v),
                          depths_[i].row(v));
          if (parameters.smoothing.passes > 0 && !views_[i].whole_image) invert(i, v);  // while it is at hand
        });
        break;
      case Step::WholeView:
        if (views_[i].whole_image) preprocessDepthMap(p, rig_[i], multipath_[i], depths_[i]);
        if (views_[i].noise) statistics.noise_scales[i] = measureNoiseScale(parameters.confidence, depths_[i]);
        break;
      case Step::Invert:
        forEachRow(task, [&](int v) { invert(i, v); });
        break;
      case Step::Smooth:
        forEachRow(task, [&](int v) {
          smoothRow(parameters.smoothing, parameters.confidence, task.pass, statistics.noise_scales[i],
                    smoothed(i, task.pass), v, smoothed(i, task.pass + 1).row(v));
        });
        break;
      case Step::Points:
        generatePoints(task.stretch, static_cast<std::size_t>(thread));
        break;
    }
  }

  /** \brief Inverse depth before a pass: to and fro between two maps. After the last pass it is depth. */
  DepthMap& smoothed(std::size_t i, int pass) {
    return (parameters.smoothing.passes - pass) % 2 == 0 ? refined_[i] : scratch_[tasks_.scratchOf(i)];
  }

  void invert(std::size_t i, int v) { invertRow(depths_[i].row(v), depths_[i].width(), smoothed(i, 0).row(v)); }

  template <typename Action>
  void forEachRow(const FrameTasks::Task& task, const Action& action) const {
    const Stretch& stretch = tasks_.stretches()[task.stretch];
    for (int v = stretch.begin_row; v < stretch.end_row; ++v) action(v);
  }

  const std::vector<DepthMap>& refined() const { return parameters.smoothing.passes == 0 ? depths_ : refined_; }
  const DepthMap& refined(std::size_t i) const { return refined()[i]; }

  void startPoints() {
    const std::vector<Stretch>& stretches = tasks_.stretches();
    std::vector<RunBuilder>& builders = aggregation_.grid.start(stretches.size());
    for (std::size_t s = 0; s < stretches.size(); ++s)
      if (views_[stretches[s].view].missing) builders[s].start(parameters.aggregation.cell_size);
    points_.assign(*frame_, rig_, refined(), offsets_);
    crop_box_ = detail::cropBox(parameters);
    if (rows_.size() < static_cast<std::size_t>(threads_)) {
      rows_.resize(static_cast<std::size_t>(threads_));
      weight_rows_.resize(static_cast<std::size_t>(threads_));
    }
    std::size_t width = 0;
    for (const DepthMap& depth : depths_) width = std::max(width, static_cast<std::size_t>(depth.width()));
    for (PointRow& row : rows_) row.reserve(width);
    for (WeightRows& rows : weight_rows_) rows.reserve(width);
    busy_.assign(static_cast<std::size_t>(threads_), {});
  }

  void generatePoints(std::size_t s, std::size_t thread) {
    RunBuilder& builder = aggregation_.grid.builders()[s];
    builder.start(parameters.aggregation.cell_size);
    Counts counts;  // on this thread's stack: neighbours in an array would fight for one cache line
    generateRows(tasks_.stretches()[s], thread, builder, counts);
    builder.finish();
    counts_[s] = counts;
  }

  void generateRows(const Stretch& stretch, std::size_t thread, RunBuilder& builder, Counts& counts) {
    const std::uint32_t i = stretch.view;
    const int width = depths_[i].width(), height = depths_[i].height();
    const auto weightsOf = [&](int v) {
      return points_.weights() + offsets_[i] + static_cast<std::uint32_t>(v) * static_cast<std::uint32_t>(width);
    };
    if (!detail::asksForSupport(parameters)) {
      for (int v = stretch.begin_row; v < stretch.end_row; ++v) {
        counts.measured += weighRow(i, v, weightsOf(v));
        counts.gated += placeRow(i, v, weightsOf(v), rows_[thread], builder);
      }
      return;
    }
    const SlopeScale slope = slopeScale(parameters.confidence, 1.0f / rig_[i].intrinsics.fx);
    WeightRows& around = weight_rows_[thread];
    around.start(width);
    // The rows beside the stretch are weighed twice, here and there.
    for (int v = stretch.begin_row - 1; v <= stretch.end_row; ++v) {
      if (v < 0 || v >= height) {
        around.clear(v);
      } else {
        const std::size_t measured = weighRow(i, v, around.row(v));
        if (v >= stretch.begin_row && v < stretch.end_row) counts.measured += measured;
      }
      if (v <= stretch.begin_row) continue;
      around.keepSupported(parameters.confidence, slope, statistics.noise_scales[i], parameters.min_support, refined(i),
                           v - 1, weightsOf(v - 1));
      counts.gated += placeRow(i, v - 1, weightsOf(v - 1), rows_[thread], builder);
    }
  }

  /** \brief Eq. 3 and 9. \returns how many measurements there are */
  std::size_t weighRow(std::uint32_t i, int v, float* weights) const {
    const int width = depths_[i].width();
    if (parameters.use_measurement_confidence) {
      confidenceRow(parameters.confidence, depths_[i], 1.0f / rig_[i].intrinsics.fx, statistics.noise_scales[i], v,
                    weights);
    } else {
      std::fill(weights, weights + width, 1.0f);
    }
    const MeasurementGate gate =
        measurementGate(parameters.use_measurement_confidence ? parameters.confidence.threshold : 0.0f,
                        detail::maxNoise(parameters), detail::halfWeightNoise(parameters), statistics.noise_scales[i]);
    const std::size_t measured = PointRow::weigh(gate, parameters.confidence, refined(i).row(v), width, weights);
    if (const ImageView<float>& given = frame_->views[i].confidence)
      for (int u = 0; u < width; ++u) weights[u] *= givenWeight(given.row(v)[u], parameters.min_confidence);
    return measured;
  }

  /** \brief Eq. 8. \returns how many points there are */
  std::size_t placeRow(std::uint32_t i, int v, float* weights, PointRow& row, RunBuilder& builder) const {
    const int width = depths_[i].width();
    const std::size_t gated =
        row.place(rig_[i], v, crop_box_, parameters.aggregation.cell_size, refined(i).row(v), width, weights);
    const std::uint32_t first = offsets_[i] + static_cast<std::uint32_t>(v) * static_cast<std::uint32_t>(width);
    if (parameters.use_spatial_hash) row.addTo(builder, first);
    return gated;
  }

  ConsistencyEvaluator makeEvaluator() const {
    ConsistencyEvaluator evaluator(parameters.consistency, rig_, depths_);
    evaluator.setNoise(parameters.confidence, statistics.noise_scales);
    if (detail::usesConfirmation(parameters.smoothing, parameters.aggregation))
      evaluator.setRefined(refined(), parameters.aggregation, detail::halfWeightNoise(parameters));
    return evaluator;
  }

  FusedPoint fusePoint(std::uint32_t index, const ConsistencyEvaluator& evaluator, std::uint64_t& cameras) const {
    const std::uint32_t i = points_.viewOf(index);
    cameras = cameraBit(i);
    const WeightedPoint own{points_.position(index), points_.C(index)};
    PointWiseFusion fusion(own.p);
    if (parameters.use_distance_consistency) {
      fusion.add(index, own.p, own.C * consistency(parameters.consistency, evaluator(own.p, i)));
      evaluator.forEachOpinion(own.p, i, [&](std::uint32_t j, int u, int v, const ViewOpinion& opinion) {
        const std::uint32_t other = offsets_[j] + static_cast<std::uint32_t>(v * depths_[j].width() + u);
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
  std::vector<DepthMap> depths_;  ///< as measured
  std::vector<MultipathCorrection> multipath_;
  std::vector<DepthMap> refined_;  ///< D^r, where there is smoothing
  std::vector<DepthMap> scratch_;  ///< of the views that are being smoothed
  std::vector<std::uint32_t> offsets_;
  std::vector<ColorDepthMap> color_depths_;  ///< of the views whose colour camera stands beside
  std::vector<FrameTasks::View> views_;
  FrameTasks tasks_;
  FramePoints points_;
  std::vector<Counts> counts_;
  std::vector<std::size_t> measured_;  ///< of each view, in range
  std::vector<BusyTimes> busy_;
  Box crop_box_;
  std::vector<PointRow> rows_;
  std::vector<WeightRows> weight_rows_;
  HashAggregation aggregation_;
};

#if !defined(FUSE_FLOW_DECLARATIONS_ONLY)

FUSE_FLOW_INLINE void FramePipeline::generate(const RigFrame& frame) {
  const Clock::time_point start = Clock::now();  // a first frame lays out memory, which takes time too
  checkRigFrame(frame);
  frame_ = &frame;
  threads_ = resolveThreads(threads);
  rig_.update(frame);
  layOut();
  startPoints();
  const Clock::time_point laid_out = Clock::now();
  tasks_.run(threads_, [&](const FrameTasks::Task& task, int thread) {
    const Clock::time_point begin = Clock::now();
    runTask(task, thread);
    BusyTimes& busy = busy_[static_cast<std::size_t>(thread)];
    (task.step == Step::Points ? busy.generate : busy.preprocess) += Clock::now() - begin;
  });
  // The two overlap: each has its share of what they took together.
  BusyTimes busy{};
  for (const BusyTimes& of_thread : busy_) {
    busy.preprocess += of_thread.preprocess;
    busy.generate += of_thread.generate;
  }
  const double all = static_cast<double>((busy.preprocess + busy.generate).count());
  const double together = since(laid_out);
  statistics.generate_ms = all > 0 ? together * static_cast<double>(busy.generate.count()) / all : 0;
  statistics.preprocess_ms = since(start) - statistics.generate_ms;
  findHiddenColors();
  measured_.assign(rig_.size(), 0);
  for (std::size_t s = 0; s < counts_.size(); ++s) {
    measured_[tasks_.stretches()[s].view] += counts_[s].measured;
    statistics.measured_points += counts_[s].measured;
    statistics.gated_points += counts_[s].gated;
  }
  lookForDepthOutOfRange();
}

FUSE_FLOW_INLINE void FramePipeline::aggregate(FusedPointSink& sink) {
  const Clock::time_point start = Clock::now();
  aggregation_.grid.merge();
  statistics.merge_ms = since(start);
  statistics.coarse_cells = aggregation_.grid.cells().size();
  const Clock::time_point merged = Clock::now();
  if (parameters.use_distance_consistency) {
    const ConsistencyEvaluator evaluator = makeEvaluator();
    aggregation_.fuse(parameters.aggregation, threads_, points_, &evaluator, crop_box_, sink);
  } else {
    aggregation_.fuse(parameters.aggregation, threads_, points_, nullptr, crop_box_, sink);
  }
  statistics.fuse_ms = since(merged);
}

#endif

}  // namespace host
}  // namespace fuse_flow
