#pragma once

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/gpu/fusion/aggregation.h>
#include <fuse_flow/gpu/fusion/find_hidden_colors.h>
#include <fuse_flow/gpu/fusion/fuse_point_wise.h>
#include <fuse_flow/gpu/fusion/generate_points_kernel.h>
#include <fuse_flow/gpu/fusion/too_far.h>
#include <fuse_flow/gpu/fusion/view_agreement.h>
#include <fuse_flow/gpu/fusion/write_points.h>
#include <fuse_flow/gpu/runtime/launch_graph.h>
#include <fuse_flow/gpu/sensors/depth_maps.h>
#include <fuse_flow/gpu/sensors/measure_range.h>

#include <chrono>

namespace fuse_flow {
namespace gpu {

/** \brief All of a frame on the device but the point type: host::FramePipeline's counterpart. The host waits three times a
 *  frame, where it must know how much there is: coarse cells, runs to sort, points to hand out. */
class FramePipeline {
 public:
  FuseFlowParameters parameters;
  FrameStatistics statistics;
  /** \brief Host threads that copy pageable images to pinned memory, and points into clouds. */
  int threads{1};
  Execution run;
  StageTimes times;

  /** \brief Everything up to the fused points; returns how many there are. \param wanted what of the cameras of each point */
  std::size_t fuse(const RigFrame& frame, bool with_color, CamerasWanted wanted) {
    start(frame, with_color, wanted);
    if (views_.pixels() == 0) return 0;
    generate();
    if (parameters.use_spatial_hash) {
      aggregate();
    } else {
      fusePointWise();
    }
    return point_count_;
  }

  /** \brief Writes the fused points of the last fuse() to device memory. */
  template <typename Layout>
  void write(const Layout& layout, bool with_normals, bool weight_in_intensity, typename Layout::Words* output) {
    if (Layout::shows_color) findHiddenColors(run, views_, maps_.refined());
    const Appearance appearance{views_.grid(), maps_.refined()};
    run.forEach(point_count_, WritePoints<Layout>{layout, appearance, with_normals, weight_in_intensity,
                                                  fused_.fused.data(), fused_.weights.data(), fused_.view_counts.data(),
                                                  fused_.cameras.data(), fused_.staying.data(), output});
    times.mark("write points",
               static_cast<double>(point_count_) * (sizeof(FusedPoint) + 4 + 4 + sizeof(typename Layout::Words) +
                                                    (Layout::shows_color ? 9 : 0) + (Layout::has_camera_mask ? 8 : 0)));
  }

  /** \brief After the output has been waited for. */
  void finish() {
    statistics.fused_points = point_count_;
    statistics.output_ms = lap();
    statistics.total_ms = milliseconds(start_, last_);
  }

  /** \brief Of a frame that an error has ended: waits until the device has nothing more to do with it. */
  void abandon() noexcept { views_.stopUpload(run); }

  /** \brief Frames whose first half was launched as a graph captured before. */
  std::size_t graphReplays() const { return graph_.replays(); }

  /** \brief Device memory held. */
  std::size_t bytes() const {
    return views_.bytes() + maps_.bytes() + table_.bytes() + weights_.bytes() + points_.bytes() + slots_.bytes() +
           gated_.bytes() + measured_.bytes() + aggregation_.bytes() + fused_.bytes() + run.scratchBytes();
  }

 protected:
  using Clock = std::chrono::steady_clock;

  /** \brief Checks a frame, and has its images uploaded. */
  void start(const RigFrame& frame, bool with_color, CamerasWanted wanted) {
    checkRigFrame(frame);
    detail::checkGivenConfidence(parameters, frame);
    detail::checkAgreement(parameters, frame);
    start_ = last_ = Clock::now();
    startStatistics(frame);
    times.start(run.stream);
    views_.assign(run, frame, &parameters.confidence, with_color, threads);
    times.mark("upload", 2.0 * static_cast<double>(views_.uploadedBytes()));
    statistics.preprocess_ms = lap();
    point_count_ = 0;
    cameras_wanted_ = wanted;
  }

  static double milliseconds(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double, std::milli>(to - from).count();
  }
  double lap() {
    const Clock::time_point now = Clock::now();
    return milliseconds(std::exchange(last_, now), now);
  }

  /** \brief Keeps the memory of the last frame's. */
  void startStatistics(const RigFrame& frame) {
    std::vector<std::size_t> missing_cameras = std::move(statistics.missing_cameras);
    std::vector<float> noise_scales = std::move(statistics.noise_scales);
    std::vector<DepthOutOfRange> out_of_range = std::move(statistics.out_of_range);
    statistics = {};
    out_of_range.clear();
    statistics.out_of_range = std::move(out_of_range);
    missing_cameras.clear();
    for (std::size_t i = 0; i < frame.views.size(); ++i)
      if (frame.views[i].missing()) missing_cameras.push_back(i);
    noise_scales.assign(frame.views.size(), 1.0f);
    statistics.missing_cameras = std::move(missing_cameras);
    statistics.noise_scales = std::move(noise_scales);
  }

  std::size_t chunks() const { return views_.pixels() / kChunk; }

  /** \brief Depth maps; eq. 3, 8, 9; and the coarse cells. */
  void generate() {
    slots_.resize(views_.pixels());
    const std::size_t capacity =
        parameters.use_spatial_hash ? std::max(table_.capacity(), std::size_t{views_.pixels()} / 64) : 1;
    generate(table_, capacity, [this](std::size_t slots) { generateInto(slots); });
  }

  /** \brief The same with other places than coarse cells. \param table that counts the points of each  \param into launches what puts
   *  points into it, given room for so many */
  template <typename Into>
  void generate(const CellTable& table, std::size_t capacity, const Into& into) {
    const std::size_t pixels = views_.pixels();
    points_.resize(pixels);
    if (weighsFirst()) weights_.resize(pixels);
    counters_.device(run);  // the first time it starts something of its own
    measured_.resize(views_.grid().view_count);
    measured_on_host_.resize(views_.grid().view_count);
    const auto launches = [&] {
      maps_.make(run, times, views_,
                 {parameters.preprocessing, parameters.smoothing, parameters.confidence, parameters.adapt_noise});
      if (weighsFirst()) weigh();
      if (detail::asksForAgreement(parameters)) keepAgreed();
      into(capacity);
    };
    if (times.enabled || parameters.preprocessing.bilateral) {  // which wait in between
      launches();
    } else {
      graph_(run, launches);
    }
    run.wait();
    while (counters_.host().table_too_full > 0) {
      into(4 * table.capacity());
      run.wait();
    }
    const Counters& counted = counters_.host();
    if (parameters.adapt_noise) keepNoiseScales();
    if (counted.points.too_far != 0xffffffffu) throwTooFarPoint(counted.points.too_far);
    for (std::uint32_t i = 0; i < views_.grid().view_count; ++i)
      statistics.measured_points += measured_on_host_.data()[i];
    statistics.gated_points = counted.points.gated;
    lookForDepthOutOfRange();
    statistics.generate_ms = lap();
  }

  /** \brief See host::FramePipeline. */
  void lookForDepthOutOfRange() {
    for (std::size_t i = 0; i < views_.grid().view_count; ++i) {
      const DeviceView& view = views_.hostView(i);
      if (!view.present || !host::hardlyAny(measured_on_host_.data()[i], view.model.intrinsics)) continue;
      const DepthOutOfRange found =
          range_.measure(run, views_.grid(), i, view.model.intrinsics, parameters.preprocessing);
      if (host::nearlyAll(found)) statistics.out_of_range.push_back(found);
    }
  }

  /** \brief Into a table of at least that capacity, which may be too small for the frame's cells. */
  void generateInto(std::size_t capacity) {
    startTable(capacity);
    launchGenerate(CoarseCells{table_view_}, slots_.data());
  }

  /** \brief An empty table of coarse cells. */
  void startTable(std::size_t capacity) {
    table_view_ = table_.start(run, capacity, &counters_.device(run)->cells, &counters_.device(run)->table_too_full);
  }

  /** \brief Eq. 8 and 9, and where each point belongs. */
  template <typename Places>
  void launchGenerate(const Places& places, std::uint32_t* slots) {
    const std::size_t pixels = views_.pixels();
    PointCounts* counts = &counters_.device(run)->points;
    run.fill(counts, 1, 0);
    run.fill(&counts->too_far, 1, 0xff);
    run.fill(measured_.data(), views_.grid().view_count, 0);
    const GeneratePoints<Places> step{views_.grid(),
                                      measurement(),
                                      weighsFirst() ? weights_.data() : nullptr,
                                      detail::asksForSupport(parameters) ? parameters.min_support : 0,
                                      parameters.use_spatial_hash,
                                      1.0f / parameters.aggregation.cell_size,
                                      detail::cropBox(parameters),
                                      places,
                                      points_.data(),
                                      slots,
                                      measured_.data(),
                                      counts};
#if FUSE_FLOW_CUDA
    run.launch("generatePointsKernel", generatePointsKernel<Places>, views_.tiles().count, kTileThreads, step,
               views_.tiles());
#else
    run.forEach(chunks(), step);
#endif
    const double read = weighsFirst() ? 8 : readToWeigh();
    times.mark("points, cells",
               static_cast<double>(pixels) * (read + sizeof(WeightedPoint) + (parameters.use_spatial_hash ? 4 : 0)));
    counters_.fetch(run);
    run.copySmall(measured_on_host_.data(), std::as_const(measured_).data(), views_.grid().view_count);
  }

  /** \brief Bytes of depth a pixel. */
  double readToWeigh() const {
    return parameters.smoothing.passes > 0 && parameters.use_measurement_confidence ? 8 : 4;
  }

  WeighMeasurement measurement() const {
    return {views_.grid(),
            maps_.measured(),
            maps_.refined(),
            parameters.confidence,
            detail::halfWeightNoise(parameters),
            parameters.gate_noise,
            detail::maxNoise(parameters),
            parameters.min_confidence,
            parameters.use_measurement_confidence};
  }

  /** \brief Whether what measurements weigh is known before they become points. */
  bool weighsFirst() const { return detail::asksForSupport(parameters) || detail::asksForAgreement(parameters); }

  /** \brief What every measurement weighs, for its neighbours. */
  void weigh() {
    const WeighMeasurements step{measurement(), weights_.data()};
#if FUSE_FLOW_CUDA
    run.launch("weighMeasurementsKernel", weighMeasurementsKernel, views_.tiles().count, kTileThreads, step,
               views_.tiles());
#else
    run.forEach(views_.pixels(), step);
#endif
    times.mark("confidence", static_cast<double>(views_.pixels()) * (readToWeigh() + 4));
  }

  /** \brief What too few other views measure, too, weighs nothing. */
  void keepAgreed() {
    const KeepAgreed step{views_.grid(), maps_.refined(), parameters.agreement, weights_.data()};
#if FUSE_FLOW_CUDA
    run.launch("keepAgreedKernel", keepAgreedKernel, views_.tiles().count, kTileThreads, step, views_.tiles());
#else
    run.forEach(views_.pixels(), step);
#endif
    const double others = std::min(parameters.agreement.min_views, static_cast<int>(views_.grid().view_count) - 1);
    times.mark("agreement", static_cast<double>(views_.pixels()) * (12 + 4 * others));
  }

  void keepNoiseScales() {
    for (std::size_t i = 0; i < statistics.noise_scales.size(); ++i)
      statistics.noise_scales[i] = maps_.noiseScales()[i];
  }

  [[noreturn]] void throwTooFarPoint(std::uint32_t index) {
    PinnedBuffer<WeightedPoint> point;
    point.resize(1);
    run.copy(point.data(), points_.data() + index, 1);
    run.wait();
    throwTooFar(point.data()->p, parameters.aggregation.cell_size);
  }

  ConsistencyEvaluator evaluator() const {
    ConsistencyEvaluator evaluator{views_.grid().views, maps_.measured(), parameters.consistency};
    evaluator.surface = maps_.refined();
    evaluator.smoothing = parameters.smoothing;
    if (!detail::usesConfirmation(parameters.smoothing, parameters.aggregation)) return evaluator;
    evaluator.refined = maps_.refined();
    evaluator.weighing = confirmationWeighing(parameters.aggregation, detail::halfWeightNoise(parameters));
    return evaluator;
  }

  /** \brief Section 5. */
  void aggregate() {
    statistics.coarse_cells = counters_.host().cells;
    const ConsistencyEvaluator evaluator = this->evaluator();
    const Box crop_box = detail::cropBox(parameters);
    point_count_ = aggregation_.fuse(
        parameters.aggregation,
        {points_.data(), slots_.data(), views_.pixels(), views_.grid(), table_view_, statistics.coarse_cells},
        parameters.use_distance_consistency ? &evaluator : nullptr, cameras_wanted_,
        parameters.crop_box ? &crop_box : nullptr, fused_);
    statistics.fuse_ms = lap();
  }

  void fusePointWise() {
    const std::size_t gated = statistics.gated_points;
    gated_.resize(gated + 1);
    fused_.resize(gated, cameras_wanted_);
    run.select(views_.pixels(), HasPoint{points_.data()}, gated_.data(), &counters_.device(run)->children);
    run.forEach(gated, FusePointWise{views_.grid(), evaluator(), points_.data(), gated_.data(),
                                     parameters.aggregation.min_weight, parameters.use_distance_consistency,
                                     fused_.fused.data(), fused_.weights.data(), fused_.states.data(),
                                     fused_.view_counts.data(),
                                     cameras_wanted_ == CamerasWanted::Which ? fused_.cameras.data() : nullptr});
    const auto pixels = static_cast<double>(views_.pixels()), points = static_cast<double>(gated);
    const double bytes = pixels * (sizeof(WeightedPoint) + (parameters.use_distance_consistency ? 4 : 0)) +
                         points * (sizeof(FusedPoint) + 4 + 1);
    times.mark("point-wise", bytes,
               bytes + points * (4 + 4 + sizeof(WeightedPoint)));  // the list of points, and these again
    point_count_ = fused_.compact(run, times, counters_, gated);
    statistics.fuse_ms = lap();
  }

  LaunchGraph graph_;
  CounterBuffer counters_;
  FrameViews views_;
  DepthMaps maps_;
  CellTable table_;
  CellTableView table_view_{};
  DeviceBuffer<float> weights_;
  DeviceBuffer<WeightedPoint> points_;
  DeviceBuffer<std::uint32_t> slots_, gated_;
  DeviceBuffer<std::uint32_t> measured_;  ///< of each view, in range
  PinnedBuffer<std::uint32_t> measured_on_host_;
  RangeMeasurement range_;
  Aggregation aggregation_{run, times, counters_};
  FusedPoints fused_;
  std::size_t point_count_{0};
  CamerasWanted cameras_wanted_{CamerasWanted::HowMany};
  Clock::time_point start_, last_;
};

}  // namespace gpu
}  // namespace fuse_flow
