#pragma once

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/gpu/child_runs_kernel.h>
#include <fuse_flow/gpu/convert_depth.h>
#include <fuse_flow/gpu/fill_holes.h>
#include <fuse_flow/gpu/frame_views.h>
#include <fuse_flow/gpu/fuse_children_kernel.h>
#include <fuse_flow/gpu/fuse_point_wise.h>
#include <fuse_flow/gpu/generate_points_kernel.h>
#include <fuse_flow/gpu/noise_scale_kernel.h>
#include <fuse_flow/gpu/select_points_kernel.h>
#include <fuse_flow/gpu/smooth_depth.h>
#include <fuse_flow/gpu/stage_times.h>
#include <fuse_flow/gpu/write_points.h>

#include <thrust/iterator/transform_iterator.h>

#include <chrono>
#include <sstream>

namespace fuse_flow {
namespace gpu {

/** \brief All of a frame on the device but the point type: host::FramePipeline's counterpart. The host waits three times a
 *  frame, where it must know how much there is: coarse cells, runs to sort, points to hand out. */
class FramePipeline {
 public:
  FuseFlowParameters parameters;
  FrameStatistics statistics;
  /** \brief Host threads that copy pageable images to pinned memory. */
  int threads{1};
  Execution run;
  StageTimes times;

  /** \brief Everything up to the fused points; returns how many there are. */
  std::size_t fuse(const RigFrame& frame, bool with_color) {
    checkRigFrame(frame);
    if (parameters.preprocessing.bilateral)
      detail::throwBadArgument(
          "fuse_flow::FuseFlow: the bilateral filter runs on the CPU only; use device::Host for it");
    start_ = last_ = Clock::now();
    statistics = {};
    statistics.noise_scales.assign(frame.views.size(), 1.0f);
    for (std::size_t i = 0; i < frame.views.size(); ++i)
      if (frame.views[i].missing()) statistics.missing_cameras.push_back(i);
    times.start(run.stream);
    if (counters_.capacity() == 0) {
      counters_.resize(1);
      run.fill(counters_.data(), 1, 0);
    }
    counted_.resize(1);
    views_.assign(run, frame, parameters.confidence, with_color, threads);
    times.mark("upload", 2.0 * static_cast<double>(views_.uploadedBytes()));
    statistics.preprocess_ms = lap();
    point_count_ = 0;
    if (views_.pixels() == 0) return 0;
    makeDepthMaps();
    measureNoise();
    refine();
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
  void write(const Layout& layout, bool with_normals, typename Layout::Words* output) {
    const Appearance appearance{views_.grid(), refined()};
    run.forEach(point_count_, WritePoints<Layout>{layout, appearance, with_normals, fused_.data(), weights_.data(),
                                                  staying_.data(), output});
    times.mark("write points",
               static_cast<double>(point_count_) *
                   (sizeof(FusedPoint) + 4 + sizeof(typename Layout::Words) + (Layout::has_color ? 9 : 0)));
  }

  /** \brief After the output has been waited for. */
  void finish() {
    statistics.fused_points = point_count_;
    statistics.output_ms = lap();
    statistics.total_ms = milliseconds(start_, last_);
  }

  /** \brief Device memory held. */
  std::size_t bytes() const {
    return views_.bytes() + z_.bytes() + filled_z_.bytes() + maps_[0].bytes() + maps_[1].bytes() +
           noise_counts_.bytes() + points_.bytes() + slots_.bytes() + numbers_.bytes() + chunk_runs_.bytes() +
           run_places_.bytes() + table_.bytes() + cells_.bytes() + first_child_numbers_.bytes() + sorted_.bytes() +
           child_begins_.bytes() + ranks_.bytes() + cameras_.bytes() + cells_of_children_.bytes() +
           cell_order_.bytes() + fused_.bytes() + weights_.bytes() + positions_.bytes() + states_.bytes() +
           staying_.bytes() + run.scratchBytes();
  }

 private:
  using Clock = std::chrono::steady_clock;

  /** \brief What the host reads back. */
  struct Counters {
    PointCounts points;
    std::uint32_t cells;
    std::uint32_t table_too_full;
    std::uint32_t runs;
    std::uint32_t children;
    std::uint32_t fused;
    std::uint64_t child_numbers;
  };

  /** \brief A pair of each, for the radix sort. */
  struct SortBuffers {
    DeviceBuffer<std::uint32_t> keys, other_keys, values, other_values;
    void resize(std::size_t n) {
      keys.resize(n);
      other_keys.resize(n);
      values.resize(n);
      other_values.resize(n);
    }
    std::size_t bytes() const { return keys.bytes() + other_keys.bytes() + values.bytes() + other_values.bytes(); }
  };

  static double milliseconds(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double, std::milli>(to - from).count();
  }
  double lap() {
    const Clock::time_point now = Clock::now();
    return milliseconds(std::exchange(last_, now), now);
  }

  const Counters& readCounters() {
    run.copy(counted_.data(), counters_.data(), 1);
    run.wait();
    return counted_.data()[0];
  }

  std::size_t chunks() const { return views_.pixels() / kChunk; }

  /** \brief Raw depth to metres and, for the smoothing, to 1/metres. */
  void makeDepthMaps() {
    const PreprocessingParameters& p = parameters.preprocessing;
    const std::size_t pixels = views_.pixels();
    const bool smooth = parameters.smoothing.passes > 0, fill = p.fill_neighbours > 0;
    z_.resize(pixels);
    if (smooth)
      for (DeviceBuffer<float>& map : maps_) map.resize(pixels);
    float* q = smooth ? maps_[0].data() : nullptr;
    run.forEach(pixels / ConvertDepth::kPixels,
                ConvertDepth{views_.grid(), p.min_range, p.max_range, z_.data(), fill ? nullptr : q});
    times.mark("metres", (smooth ? 10.0 : 6.0) * static_cast<double>(pixels));
    if (!fill) return;
    filled_z_.resize(pixels);
    run.forEach(pixels, FillHoles{views_.grid(), p, z_.data(), filled_z_.data(), q});
    std::swap(z_, filled_z_);
    times.mark("holes", (smooth ? 12.0 : 8.0) * static_cast<double>(pixels));
  }

  /** \brief How noisy each view is; stays on the device, with a copy for the statistics. */
  void measureNoise() {
    if (!parameters.adapt_noise) return;
    const std::size_t n = views_.rig().size();
    noise_counts_.resize(n * kNoiseBins);
    noise_scales_.resize(n);
    counted_noise_.resize(n);
    run.fill(noise_counts_.data(), n * kNoiseBins, 0);
    const CountNoise count{views_.grid(), parameters.confidence, z_.data(), noise_counts_.data()};
    const MeasureNoise measure{{parameters.confidence, views_.deviceViews(), noise_scales_.data()},
                               noise_counts_.data()};
#if FUSE_FLOW_CUDA
    const auto views = static_cast<unsigned int>(n);
    countNoiseKernel<<<dim3(kNoiseBlocks, views), kNoiseThreads, 0, run.stream>>>(count);
    measureNoiseKernel<<<views, kNoiseThreads, 0, run.stream>>>(measure);
    check(cudaGetLastError(), "measureNoiseKernel");
#else
    run.forEach(chunks(), count);
    run.forEach(n, measure);
#endif
    run.copy(counted_noise_.data(), noise_scales_.data(), n);
    times.mark("noise", static_cast<double>(views_.pixels()) * 5 * 4 / (kNoiseStride * kNoiseStride));
  }

  /** \brief D^r of eq. 8. */
  void refine() {
    const int passes = parameters.smoothing.passes;
    for (int pass = 0; pass < passes; ++pass) {
      const SmoothDepth step{views_.grid(), parameters.smoothing,   parameters.confidence,
                             pass,          maps_[pass % 2].data(), maps_[(pass + 1) % 2].data()};
#if FUSE_FLOW_CUDA
      smoothDepthKernel<<<views_.tiles().count, kTileThreads, 0, run.stream>>>(step, views_.tiles());
      check(cudaGetLastError(), "smoothDepthKernel");
#else
      run.forEach(views_.pixels(), step);
#endif
    }
    if (passes > 0) times.mark("smoothing", 8.0 * passes * static_cast<double>(views_.pixels()));
  }

  const float* refined() const {
    const int passes = parameters.smoothing.passes;
    return passes == 0 ? z_.data() : maps_[passes % 2].data();
  }

  /** \brief Eq. 3, 8, 9, and the coarse cells. */
  void generate() {
    const std::size_t pixels = views_.pixels();
    points_.resize(pixels);
    slots_.resize(pixels);
    std::size_t capacity = std::max(table_.capacity(), pixels / 64);
    while (!generateInto(table_.start(run, parameters.use_spatial_hash ? capacity : 1, &counters_.data()->cells,
                                      &counters_.data()->table_too_full)))
      capacity = 4 * table_.capacity();
    statistics.generate_ms = lap();
  }

  /** \brief False if the table is too small for the frame's cells. */
  bool generateInto(const CellTableView& table) {
    const std::size_t pixels = views_.pixels();
    table_view_ = table;
    PointCounts* counts = &counters_.data()->points;
    run.fill(counts, 1, 0);
    run.fill(&counts->too_far, 1, 0xff);
    const GeneratePoints step{views_.grid(),
                              z_.data(),
                              refined(),
                              parameters.confidence,
                              parameters.half_weight_noise,
                              parameters.use_measurement_confidence,
                              parameters.use_spatial_hash,
                              1.0f / parameters.aggregation.cell_size,
                              cropBox(),
                              table,
                              points_.data(),
                              slots_.data(),
                              counts};
#if FUSE_FLOW_CUDA
    generatePointsKernel<<<views_.tiles().count, kTileThreads, 0, run.stream>>>(step, views_.tiles());
    check(cudaGetLastError(), "generatePointsKernel");
#else
    run.forEach(chunks(), step);
#endif
    times.mark("confidence, points, cells", static_cast<double>(pixels) * (parameters.smoothing.passes > 0 ? 8 : 4) +
                                                static_cast<double>(pixels) * (sizeof(WeightedPoint) + 4));
    const Counters& counted = readCounters();
    if (parameters.adapt_noise) keepNoiseScales();
    if (counted.points.too_far != 0xffffffffu) throwTooFar(counted.points.too_far);
    statistics.measured_points = counted.points.measured;
    statistics.gated_points = counted.points.gated;
    return counted.table_too_full == 0;
  }

  void keepNoiseScales() {
    for (std::size_t i = 0; i < statistics.noise_scales.size(); ++i)
      statistics.noise_scales[i] = counted_noise_.data()[i];
  }

  Box cropBox() const {
    if (!parameters.crop_box) return {};
    const Eigen::Vector3f &low = parameters.crop_box->min(), &high = parameters.crop_box->max();
    return {{low.x(), low.y(), low.z()}, {high.x(), high.y(), high.z()}, true};
  }

  [[noreturn]] void throwTooFar(std::uint32_t index) {
    PinnedBuffer<WeightedPoint> point;
    point.resize(1);
    run.copy(point.data(), points_.data() + index, 1);
    run.wait();
    const Vec3& p = point.data()->p;
    std::ostringstream message;
    message << "fuse_flow::AdaptiveHashFusion: point (" << p.x << ", " << p.y << ", " << p.z << ") m is more than "
            << kMaxCellCoordinate << " cells of " << parameters.aggregation.cell_size << " m from the origin";
    throw pcl::PCLException(message.str());
  }

  /** \brief Section 5. */
  void aggregate() {
    const std::size_t cells = counted_.data()->cells;
    statistics.coarse_cells = cells;
    if (cells == 0) return;
    orderCells(cells);
    const std::size_t runs = sortRuns();
    statistics.merge_ms = lap();
    fuseCells(cells, runs);
    statistics.fuse_ms = lap();
  }

  ChildrenOfCell childrenOfCell() const {
    return {table_view_, cell_order_.values.data(), parameters.aggregation.points_per_cell,
            host::HashAggregation::maxLevel(parameters.aggregation)};
  }

  /** \brief Cells by their first points, and the numbers of their children. */
  void orderCells(std::size_t cells) {
    cell_order_.resize(cells);
    first_child_numbers_.resize(cells + 1);
    cells_.resize(table_.capacity());
    run.forEach(cells, ListCells{table_view_, cell_order_.keys.data(), cell_order_.values.data()});
    run.sortByKey(cell_order_.keys, cell_order_.other_keys, cell_order_.values, cell_order_.other_values, cells,
                  bitsFor(views_.pixels()));
    const auto children =
        thrust::make_transform_iterator(thrust::counting_iterator<std::uint32_t>(0), childrenOfCell());
    run.sumUp(children, cells, first_child_numbers_.data());
    run.copy(&counters_.data()->child_numbers, first_child_numbers_.data() + cells, 1);
    run.forEach(cells, DescribeCells{childrenOfCell(), first_child_numbers_.data(), parameters.aggregation.cell_size,
                                     cells_.data()});
    times.mark("order of cells", static_cast<double>(cells) * (4 * 16 + 16 + sizeof(CoarseCell)));
  }

  /** \brief Runs of points that fall into one child, sorted by child and pixel. */
  std::size_t sortRuns() {
    const std::size_t pixels = views_.pixels();
    numbers_.resize(pixels);
    chunk_runs_.resize(chunks());
    run_places_.resize(chunks() + 1);
    const CountRuns count{{points_.data(), slots_.data(), cells_.data(), parameters.aggregation.cell_size},
                          numbers_.data(),
                          chunk_runs_.data()};
    const auto chunk_count = static_cast<std::uint32_t>(chunks());
#if FUSE_FLOW_CUDA
    const unsigned int blocks = static_cast<unsigned int>((pixels + kRunThreads - 1) / kRunThreads);
    countRunsKernel<<<blocks, kRunThreads, 0, run.stream>>>(count, chunk_count);
    check(cudaGetLastError(), "countRunsKernel");
#else
    run.forEach(chunk_count, count);
#endif
    times.mark("children of points", static_cast<double>(pixels) * (sizeof(WeightedPoint) + 8));
    run.sumUp(chunk_runs_.data(), chunk_count, run_places_.data());
    run.copy(&counters_.data()->runs, run_places_.data() + chunk_count, 1);
    const Counters& counted = readCounters();
    if (counted.child_numbers >= CellTableView::kNone)
      throw pcl::PCLException(
          "fuse_flow::FuseFlow: a frame on the GPU has more than 2^32 child cells; raise min_cell_size "
          "or points_per_cell");
    const std::size_t runs = counted.runs;
    sorted_.resize(runs);
    const WriteRuns write{numbers_.data(), run_places_.data(), sorted_.keys.data(), sorted_.values.data()};
#if FUSE_FLOW_CUDA
    writeRunsKernel<<<blocks, kRunThreads, 0, run.stream>>>(write, chunk_count);
    check(cudaGetLastError(), "writeRunsKernel");
#else
    run.forEach(chunk_count, write);
#endif
    times.mark("runs", static_cast<double>(pixels) * 4 + static_cast<double>(runs) * 8);
    const int bits = bitsFor(counted.child_numbers);
    run.sortByKey(sorted_.keys, sorted_.other_keys, sorted_.values, sorted_.other_values, runs, bits);
    times.mark("sort", static_cast<double>(runs) * (4 + 16.0 * ((bits + 7) / 8)));
    return runs;
  }

  /** \brief Child by child, then the choice among each coarse cell's points. */
  void fuseCells(std::size_t cells, std::size_t runs) {
    child_begins_.resize(runs);
    Counters* counters = counters_.data();
    run.select(runs, BeginsChild{sorted_.keys.data()}, child_begins_.data(), &counters->children);
    times.mark("children", static_cast<double>(runs) * 4);
    cells_of_children_.resize(cells);
    ranks_.resize(runs);
    cameras_.resize(runs);
    fused_.resize(runs);
    weights_.resize(runs);
    positions_.resize(runs);
    states_.resize(runs);
    staying_.resize(runs);
    const AggregationParameters& p = parameters.aggregation;
    const Children children{
        points_.data(),        slots_.data(),        cells_.data(),       sorted_.keys.data(),
        sorted_.values.data(), child_begins_.data(), &counters->children, static_cast<std::uint32_t>(runs)};
    run.forEach(runs, FindCells{children, cell_order_.keys.data(), cells_of_children_.data(), ranks_.data(),
                                positions_.data()});
    times.mark("cells of children");
    const FuseChildren fuse{{children, p.representatives, views_.grid()}, fused_.data(), cameras_.data()};
#if FUSE_FLOW_CUDA
    fuseChildrenInBlocks(fuse, runs, run.stream);
#else
    run.forEach(runs, fuse);
#endif
    times.mark("fuse children");
    judge(fuse, runs);
    if (p.weak_weight > 0) {
      const SelectPoints select{weights_.data(), positions_.data(),   cells_of_children_.data(),
                                cells_.data(),   &counters->children, static_cast<std::uint32_t>(cells),
                                states_.data()};
#if FUSE_FLOW_CUDA
      if (!selectPointsInSharedMemory(select, host::HashAggregation::maxLevel(p), run.stream))
        run.forEach(cells, select);
#else
      run.forEach(cells, select);
#endif
    }
    times.mark("selection", static_cast<double>(cells) * 8);
    selectStaying(runs);
  }

  /** \brief V, and what it makes of each child. */
  void judge(const FuseChildren& fuse, std::size_t runs) {
    run.fill(states_.data(), runs, 0);
    const JudgeChildren judge{parameters.aggregation,
                              {views_.grid().views, z_.data(), parameters.consistency},
                              parameters.use_distance_consistency,
                              fused_.data(),
                              cameras_.data(),
                              ranks_.data(),
                              cells_of_children_.data(),
                              &counters_.data()->children,
                              weights_.data(),
                              states_.data()};
    if (parameters.use_distance_consistency &&
        parameters.aggregation.consistency_at == ConsistencyAt::Representatives) {
      run.forEach(runs, JudgeRepresentatives{fuse.select, judge, fused_.data()});
    } else {
      run.forEach(runs, judge);
    }
    times.mark("consistency");
  }

  void selectStaying(std::size_t n) {
    run.select(n, Stays{states_.data()}, staying_.data(), &counters_.data()->fused);
    times.mark("compaction");
    point_count_ = readCounters().fused;
    const double children = static_cast<double>(counted_.data()->children);
    times.setBytes("cells of children", children * (4 + 4 + 4 + 4 + 2));
    times.setBytes("fuse children", static_cast<double>(statistics.gated_points) * sizeof(WeightedPoint) +
                                        children * (8 + sizeof(FusedPoint) + 4));
    times.setBytes("consistency", children * (16 + 4 + 4 + 5));
    times.setBytes("compaction", children);
  }

  void fusePointWise() {
    const std::size_t pixels = views_.pixels();
    const std::size_t gated = statistics.gated_points;
    child_begins_.resize(gated + 1);
    fused_.resize(gated);
    weights_.resize(gated);
    states_.resize(gated);
    staying_.resize(gated + 1);
    run.select(pixels, HasPoint{points_.data()}, child_begins_.data(), &counters_.data()->children);
    run.forEach(gated, FusePointWise{views_.grid(),
                                     {views_.grid().views, z_.data(), parameters.consistency},
                                     points_.data(),
                                     child_begins_.data(),
                                     parameters.aggregation.min_weight,
                                     parameters.use_distance_consistency,
                                     fused_.data(),
                                     weights_.data(),
                                     states_.data()});
    times.mark("point-wise", static_cast<double>(gated) * sizeof(WeightedPoint));
    selectStaying(gated);
    statistics.fuse_ms = lap();
  }

  /** \brief Bits of numbers below n. */
  static int bitsFor(std::uint64_t n) {
    int bits = 0;
    while (bits < 32 && (std::uint64_t{1} << bits) < n) ++bits;
    return bits;
  }

  FrameViews views_;
  CellTable table_;
  CellTableView table_view_{};
  DeviceBuffer<Counters> counters_;
  PinnedBuffer<Counters> counted_;
  /** \brief As measured, and what refine() works on. */
  DeviceBuffer<float> z_, filled_z_, maps_[2];
  DeviceBuffer<std::uint32_t> noise_counts_;
  DeviceBuffer<float> noise_scales_;
  PinnedBuffer<float> counted_noise_;
  DeviceBuffer<WeightedPoint> points_;
  DeviceBuffer<std::uint32_t> ranks_, cameras_;
  DeviceBuffer<std::uint32_t> slots_, numbers_, chunk_runs_, run_places_, child_begins_, staying_;
  SortBuffers cell_order_, sorted_;
  DeviceBuffer<std::uint64_t> first_child_numbers_;
  DeviceBuffer<CoarseCell> cells_;
  DeviceBuffer<CellOfChildren> cells_of_children_;
  DeviceBuffer<FusedPoint> fused_;
  DeviceBuffer<float> weights_;
  DeviceBuffer<std::uint16_t> positions_;
  DeviceBuffer<std::uint8_t> states_;
  std::size_t point_count_{0};
  Clock::time_point start_, last_;
};

}  // namespace gpu
}  // namespace fuse_flow
