#pragma once

#include <fuse_flow/gpu/aggregation.h>
#include <fuse_flow/gpu/device_filter.h>
#include <fuse_flow/gpu/too_far.h>

namespace fuse_flow {
namespace gpu {

/** \brief The coarse cell of each point of a cloud. */
struct EnterPoints {
  const WeightedPoint* points;
  float inverse_cell_size;
  CellTableView table;
  std::uint32_t* slots;
  PointCounts* counts;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    slots[index] = CellTableView::kNone;
    if (!(points[index].C > 0)) return;
    const Vec3 cells = inverse_cell_size * points[index].p;
    if (!fitsCellKey(cells)) {
      atomicMinTo(&counts->too_far, index);
      return;
    }
    slots[index] = table.findOrAdd(cellKey(cellIndex(cells)));
    table.addPoints(slots[index], index, 1);
  }
};

/** \brief The points that stay, one after the other. */
struct GatherFused {
  const FusedPoint* fused;
  const float* weights;
  const std::uint32_t* staying;
  FusedPoint* output;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    FusedPoint point = fused[staying[k]];
    point.weight = weights[staying[k]];
    output[k] = point;
  }
};

/** \brief Section 5 for points from the host that come camera after camera. Each camera's points are padded to whole chunks. */
class CloudAggregation {
 public:
  explicit CloudAggregation(DeviceFilter& filter) : filter_(filter) {}

  /** \param cameras of each point, ascending  \param evaluator null: V = 1; else cameras are numbers of its views */
  std::vector<FusedPoint> fuse(const AggregationParameters& parameters, const std::vector<WeightedPoint>& points,
                               const std::vector<std::uint32_t>& cameras, const ConsistencyEvaluator* evaluator) {
    if (points.empty()) return {};
    layOut(points, cameras, evaluator != nullptr);
    enter(parameters, points);
    const PixelGrid grid{nullptr, device_offsets_.data(), static_cast<std::uint32_t>(offsets_.size() - 1)};
    const std::size_t count = aggregation_.fuse(
        parameters, {points_.data(), slots_.data(), padded_.size(), grid, table_view_, counters_.host().cells},
        evaluator, fused_);
    output_.resize(count);
    filter_.run.forEach(count,
                        GatherFused{fused_.fused.data(), fused_.weights.data(), fused_.staying.data(), output_.data()});
    std::vector<FusedPoint> result(count);
    filter_.download(output_, count, result.data());
    for (FusedPoint& point : result)
      for (std::uint32_t k = 0; k < point.count; ++k) point.source[k] = numbers_[point.source[k]];
    return result;
  }

 private:
  /** \brief \param by_number camera i is range i; else only those that have points get one */
  void layOut(const std::vector<WeightedPoint>& points, const std::vector<std::uint32_t>& cameras, bool by_number) {
    padded_.clear();
    numbers_.clear();
    offsets_.assign(1, 0);
    const auto pad = [&] {
      while (padded_.size() % kChunk != 0) {
        padded_.push_back({});
        numbers_.push_back(0);
      }
    };
    for (std::size_t k = 0; k < points.size(); ++k) {
      const bool begins = k == 0 || cameras[k] != cameras[k - 1];
      if (begins && (by_number || k > 0)) {
        pad();
        const std::size_t range = by_number ? cameras[k] : offsets_.size();
        while (offsets_.size() <= range) offsets_.push_back(static_cast<std::uint32_t>(padded_.size()));
      }
      padded_.push_back(points[k]);
      numbers_.push_back(static_cast<std::uint32_t>(k));
    }
    pad();
    offsets_.push_back(static_cast<std::uint32_t>(padded_.size()));
    if (padded_.size() > ChildRun::kMaxPixels)
      throw pcl::PCLException("fuse_flow::AdaptiveHashFusion: a cloud on the GPU has more than 2^27 points");
    filter_.upload(padded_.data(), padded_.size(), points_);
    filter_.upload(offsets_.data(), offsets_.size(), device_offsets_);
  }

  void enter(const AggregationParameters& parameters, const std::vector<WeightedPoint>& points) {
    Execution& run = filter_.run;
    Counters* counters = counters_.device(run);
    slots_.resize(padded_.size());
    std::size_t capacity = table_.capacity();
    do {
      table_view_ = table_.start(run, capacity, &counters->cells, &counters->table_too_full);
      run.fill(&counters->points.too_far, 1, 0xff);
      run.forEach(padded_.size(), EnterPoints{points_.data(), 1.0f / parameters.cell_size, table_view_, slots_.data(),
                                              &counters->points});
      const Counters& counted = counters_.read(run);
      if (counted.points.too_far != 0xffffffffu)
        throwTooFar(points[numbers_[counted.points.too_far]].p, parameters.cell_size);
      capacity = 4 * table_.capacity();
    } while (counters_.host().table_too_full > 0);
  }

  DeviceFilter& filter_;
  std::vector<WeightedPoint> padded_;
  std::vector<std::uint32_t> numbers_, offsets_;
  CounterBuffer counters_;
  CellTable table_;
  CellTableView table_view_{};
  DeviceBuffer<WeightedPoint> points_;
  DeviceBuffer<std::uint32_t> device_offsets_, slots_;
  Aggregation aggregation_{filter_.run, filter_.times, counters_};
  FusedPoints fused_;
  DeviceBuffer<FusedPoint> output_;
};

}  // namespace gpu
}  // namespace fuse_flow
