#pragma once

#include <fuse_flow/gpu/fusion/child_runs_kernel.h>
#include <fuse_flow/gpu/fusion/counters.h>
#include <fuse_flow/gpu/fusion/fuse_children_kernel.h>
#include <fuse_flow/gpu/fusion/fused_points.h>
#include <fuse_flow/gpu/fusion/select_points_kernel.h>
#include <fuse_flow/impl/fusion/hash_aggregation.hpp>

#include <thrust/iterator/transform_iterator.h>

namespace fuse_flow {
namespace gpu {

/** \brief Points on the device, each with the slot of its coarse cell. */
struct PointsInCells {
  const WeightedPoint* points;
  /** \brief kNone: no point. */
  const std::uint32_t* slots;
  /** \brief A multiple of kChunk; a chunk's points are of one view. */
  std::size_t size;
  /** \brief Which of them are of which view. */
  PixelGrid grid;
  CellTableView table;
  /** \brief Coarse cells in the table. */
  std::size_t cells;
};

/** \brief Section 5 over points in coarse cells: host::HashAggregation's counterpart. */
class Aggregation {
 public:
  Aggregation(Execution& run, StageTimes& times, CounterBuffer& counters)
      : run_(run), times_(times), counters_(counters) {}

  /** \brief Returns how many points there are then; \p points receives them. \param evaluator null: V = 1
   *  \param wanted what of the cameras of each point  \param crop_box null, or points that views confirm outside of it are dropped */
  std::size_t fuse(const AggregationParameters& parameters, const PointsInCells& in,
                   const ConsistencyEvaluator* evaluator, CamerasWanted wanted, const Box* crop_box,
                   FusedPoints& points) {
    if (in.cells == 0) return 0;
    parameters_ = parameters;
    in_ = in;
    evaluator_ = evaluator;
    wanted_ = wanted;
    orderCells(in.cells);
    const std::size_t runs = sortRuns();
    fuseCells(in.cells, runs, points);
    const std::size_t count = points.compact(run_, times_, counters_, runs, confirms() ? crop_box : nullptr);
    if (times_.enabled) setBytes(static_cast<double>(runs));
    return count;
  }

  std::size_t bytes() const {
    return numbers_.bytes() + chunk_runs_.bytes() + run_places_.bytes() + cells_.bytes() +
           first_child_numbers_.bytes() + sorted_.bytes() + child_begins_.bytes() + ranks_.bytes() + cameras_.bytes() +
           positions_.bytes() + cells_of_children_.bytes() + first_points_.bytes() + order_.bytes() + marks_.bytes() +
           marks_before_.bytes();
  }

 private:
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

  bool confirms() const { return evaluator_ != nullptr && evaluator_->refined != nullptr; }
  int maxLevel() const { return host::HashAggregation::maxLevel(parameters_); }

  ChildrenOfCell childrenOfCell() const { return {in_.table, order_.data(), parameters_.points_per_cell, maxLevel()}; }

  /** \brief Cells by their first points, and the numbers of their children. */
  void orderCells(std::size_t cells) {
    first_points_.resize(cells);
    order_.resize(cells);
    first_child_numbers_.resize(cells + 1);
    cells_.resize(in_.table.mask + std::size_t{1});
    const std::size_t words = in_.size / 32;
    marks_.resize(words);
    marks_before_.resize(words + 1);
    run_.fill(marks_.data(), words, 0);
    run_.forEach(cells, MarkFirstPoints{in_.table, marks_.data()});
    const thrust::counting_iterator<std::uint32_t> all(0);
    run_.sumUp(thrust::make_transform_iterator(all, CountMarks{marks_.data()}), words, marks_before_.data());
    run_.forEach(cells, RankCells{in_.table, marks_.data(), marks_before_.data(), first_points_.data(), order_.data()});
    const auto children = thrust::make_transform_iterator(all, childrenOfCell());
    run_.sumUp(children, cells, first_child_numbers_.data());
    run_.copySmall(&counters_.device(run_)->child_numbers, first_child_numbers_.data() + cells, 1);
    run_.forEach(cells,
                 DescribeCells{childrenOfCell(), first_child_numbers_.data(), parameters_.cell_size, cells_.data()});
    // Of a cell: key, count, first point and slot; first point and slot in order, number of the first child. What the five steps
    // read again of that, and the marks with the sums over them, is only moved.
    const double read = 8 + 4 + 4 + 4, written = 4 + 4 + 8 + sizeof(CoarseCell);
    const auto of_cells = static_cast<double>(cells);
    times_.mark("order of cells", of_cells * (read + written),
                of_cells * (read + written + (4 + 4 + 8) + (4 + 4) + (4 + 4) + (4 + 8)) +
                    static_cast<double>(words) * (4 + 4 + 4));
  }

  /** \brief Runs of points that fall into one child, sorted by child and pixel. */
  std::size_t sortRuns() {
    const std::size_t pixels = in_.size;
    numbers_.resize(pixels);
    chunk_runs_.resize(in_.size / kChunk);
    run_places_.resize(in_.size / kChunk + 1);
    const CountRuns count{
        {in_.points, in_.slots, cells_.data(), parameters_.cell_size}, numbers_.data(), chunk_runs_.data()};
    const auto chunk_count = static_cast<std::uint32_t>(in_.size / kChunk);
#if FUSE_FLOW_CUDA
    const unsigned int blocks = static_cast<unsigned int>((pixels + kRunThreads - 1) / kRunThreads);
    run_.launch("countRunsKernel", countRunsKernel, blocks, kRunThreads, count, chunk_count);
#else
    run_.forEach(chunk_count, count);
#endif
    const auto of_pixels = static_cast<double>(pixels), of_chunks = static_cast<double>(chunk_count);
    times_.mark("children of points", of_pixels * (sizeof(WeightedPoint) + 4 + 4) + of_chunks * 4 +
                                          static_cast<double>(in_.cells) * sizeof(CoarseCell));
    run_.sumUp(chunk_runs_.data(), chunk_count, run_places_.data());
    run_.copySmall(&counters_.device(run_)->runs, run_places_.data() + chunk_count, 1);
    const Counters& counted = counters_.read(run_);
    if (counted.child_numbers >= CellTableView::kNone)
      throw pcl::PCLException(
          "fuse_flow::FuseFlow: a frame on the GPU has more than 2^32 child cells; raise min_cell_size "
          "or points_per_cell");
    const std::size_t runs = counted.runs;
    sorted_.resize(runs);
    const WriteRuns write{numbers_.data(), run_places_.data(), sorted_.keys.data(), sorted_.values.data()};
#if FUSE_FLOW_CUDA
    run_.launch("writeRunsKernel", writeRunsKernel, blocks, kRunThreads, write, chunk_count);
#else
    run_.forEach(chunk_count, write);
#endif
    const auto of_runs = static_cast<double>(runs);
    times_.mark("runs", of_pixels * 4 + of_chunks * 4 + of_runs * 8, of_pixels * 4 + of_chunks * 12 + of_runs * 8);
    const int bits = bitsFor(counted.child_numbers);
    run_.sortByKey(sorted_.keys, sorted_.other_keys, sorted_.values, sorted_.other_values, runs, bits);
    times_.mark("sort", of_runs * 16, of_runs * (4 + 16.0 * ((bits + 7) / 8)));  // 8 bits a pass, counted in the first
    return runs;
  }

  /** \brief Child by child, then the choice among each coarse cell's points. */
  void fuseCells(std::size_t cells, std::size_t runs, FusedPoints& points) {
    child_begins_.resize(runs);
    Counters* counters = counters_.device(run_);
    run_.select(runs, BeginsChild{sorted_.keys.data()}, child_begins_.data(), &counters->children);
    times_.mark("children");
    cells_of_children_.resize(cells);
    ranks_.resize(runs);
    cameras_.resize(runs);
    points.resize(runs, wanted_);
    positions_.resize(runs);
    const AggregationParameters& p = parameters_;
    const Children children{in_.points,
                            in_.slots,
                            cells_.data(),
                            sorted_.keys.data(),
                            sorted_.values.data(),
                            child_begins_.data(),
                            &counters->children,
                            static_cast<std::uint32_t>(runs)};
    run_.forEach(
        runs, FindCells{children, first_points_.data(), cells_of_children_.data(), ranks_.data(), positions_.data()});
    times_.mark("cells of children");
    const FuseChildren fuse{
        {children, p.representatives, in_.grid}, points.fused.data(), cameras_.data(), points.view_counts.data()};
#if FUSE_FLOW_CUDA
    fuseChildrenInBlocks(fuse, runs, run_.stream);
#else
    run_.forEach(runs, fuse);
#endif
    times_.mark("fuse children");
    judge(fuse, runs, points);
    if (p.weak_weight > 0) {
      const SelectPoints select{points.weights.data(), positions_.data(),   cells_of_children_.data(),
                                cells_.data(),         &counters->children, static_cast<std::uint32_t>(cells),
                                points.states.data()};
#if FUSE_FLOW_CUDA
      if (!selectPointsInSharedMemory(select, maxLevel(), run_.stream)) run_.forEach(cells, select);
#else
      run_.forEach(cells, select);
#endif
    }
    times_.mark("selection");
  }

  /** \brief V, and what it makes of each child. */
  void judge(const FuseChildren& fuse, std::size_t runs, FusedPoints& points) {
    run_.fill(points.states.data(), runs, 0);
    if (wanted_ == CamerasWanted::Which) {
      judge<PointCameras>(fuse, runs, points);
    } else {
      judge<PointCameraCount>(fuse, runs, points);
    }
    times_.mark("consistency");
  }

  template <typename Cameras>
  void judge(const FuseChildren& fuse, std::size_t runs, FusedPoints& points) {
    const JudgeChildren<Cameras> judge{parameters_,
                                       evaluator_ ? *evaluator_ : ConsistencyEvaluator{},
                                       evaluator_ != nullptr,
                                       points.fused.data(),
                                       cameras_.data(),
                                       ranks_.data(),
                                       cells_of_children_.data(),
                                       &counters_.device(run_)->children,
                                       points.weights.data(),
                                       points.states.data(),
                                       points.view_counts.data(),
                                       wanted_ == CamerasWanted::Which ? points.cameras.data() : nullptr};
    if (evaluator_ != nullptr && parameters_.consistency_at == ConsistencyAt::Representatives) {
      run_.forEach(runs, JudgeRepresentatives<Cameras>{fuse.select, judge, points.fused.data()});
    } else {
      run_.forEach(runs, judge);
    }
  }

  /** \brief Of what the host knows only now. */
  void setBytes(double runs) {
    const double children = counters_.host().children, gated = counters_.host().points.gated;
    const auto cells = static_cast<double>(in_.cells);
    const bool normals = evaluator_ != nullptr && evaluator_->knowsNormals();
    const double maps = evaluator_ == nullptr ? 0 : (confirms() || normals ? 8.0 : 4.0) * static_cast<double>(in_.size);
    times_.setBytes("children", runs * 4 + children * 4);
    times_.setBytes("cells of children",
                    children * ((4 + 4 + 4 + 4) + (4 + 2)) + cells * (4 + sizeof(CoarseCell) + sizeof(CellOfChildren)));
    times_.setBytes("fuse children", gated * sizeof(WeightedPoint) + runs * 4 +
                                         children * ((4 + 4) + (sizeof(FusedPoint) + 4 + 4)) +
                                         cells * sizeof(CoarseCell));
    // Of the representatives, normals ask for their points, shares and number.
    const double representatives = normals ? kRepresentatives * (4 + 4) + 4 : 0;
    const double judged = children * ((sizeof(Vec3) + 4 + 4 + 4 + 4) + representatives + (4 + 4 + 1) +
                                      (confirms() ? sizeof(Vec3) : 0) + (wanted_ == CamerasWanted::Which ? 8 : 0)) +
                          cells * sizeof(CellOfChildren) + maps;
    times_.setBytes("consistency", judged, judged + runs);  // states are cleared first
    if (!(parameters_.weak_weight > 0)) return;
    // State, weight and position in, state out. The states are looked through for weak ones first, and gone through again at last.
    const double of_cells = cells * (sizeof(CellOfChildren) + sizeof(CoarseCell));
    times_.setBytes("selection", children * (1 + 4 + 2 + 1) + of_cells,
                    children * (1 + 1 + 4 + 2 + 1 + 2 + 1) + of_cells);
  }

  /** \brief Bits of numbers below n. */
  static int bitsFor(std::uint64_t n) {
    int bits = 0;
    while (bits < 32 && (std::uint64_t{1} << bits) < n) ++bits;
    return bits;
  }

  Execution& run_;
  StageTimes& times_;
  CounterBuffer& counters_;
  AggregationParameters parameters_;
  PointsInCells in_{};
  const ConsistencyEvaluator* evaluator_{nullptr};
  CamerasWanted wanted_{CamerasWanted::HowMany};

  SortBuffers sorted_;
  DeviceBuffer<std::uint32_t> marks_, marks_before_, first_points_, order_;
  DeviceBuffer<std::uint64_t> first_child_numbers_;
  DeviceBuffer<CoarseCell> cells_;
  DeviceBuffer<std::uint32_t> numbers_, chunk_runs_, run_places_, child_begins_, ranks_, cameras_;
  DeviceBuffer<CellOfChildren> cells_of_children_;
  DeviceBuffer<std::uint16_t> positions_;
};

}  // namespace gpu
}  // namespace fuse_flow
