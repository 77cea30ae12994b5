#pragma once

#include <fuse_flow/gpu/filters/device_filter.h>
#include <fuse_flow/gpu/fusion/aggregation.h>
#include <fuse_flow/gpu/fusion/too_far.h>

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
  const std::uint32_t* view_counts;
  const std::uint64_t* cameras;
  const std::uint32_t* staying;
  FusedPoint* output;
  std::uint64_t* output_cameras;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    FusedPoint point = fused[staying[k]];
    point.weight = weights[staying[k]];
    point.views = view_counts[staying[k]];
    output[k] = point;
    output_cameras[k] = cameras[staying[k]];
  }
};

/** \brief Clouds on the device, one for each camera. Maps padded places, camera by camera, to points of the clouds. */
template <typename Layout>
struct CloudsOfCameras {
  const typename Layout::Words* const* clouds;
  const std::uint32_t* sizes;
  /** \brief Numbers the places. */
  PixelGrid grid;

  /** \brief Null beyond a cloud's end. */
  FUSE_FLOW_HD const typename Layout::Words* at(std::uint32_t place) const {
    const std::uint32_t camera = grid.viewOf(place), k = place - grid.offsets[camera];
    return k < sizes[camera] ? clouds[camera] + k : nullptr;
  }
};

/** \brief Positions and C of the points that take part. */
template <typename Layout>
struct TakePoints {
  CloudsOfCameras<Layout> clouds;
  /** \brief Null, or which points of all clouds, one cloud after the other, are wanted; and where each cloud's begin. */
  const std::uint8_t* wanted;
  const std::uint32_t* begins;
  WeightedPoint* points;

  FUSE_FLOW_HD void operator()(std::uint32_t place) const {
    points[place] = WeightedPoint{};
    const typename Layout::Words* w = clouds.at(place);
    if (w == nullptr) return;
    if (wanted != nullptr) {
      const std::uint32_t camera = clouds.grid.viewOf(place);
      if (!wanted[begins[camera] + place - clouds.grid.offsets[camera]]) return;
    }
    const Vec3 p = Layout::position(*w);
    if (isFinite(p)) points[place] = {p, givenConfidence(Layout::confidence(*w))};
  }
};

/** \brief Writes the fused points that stay: fields that are not fused are those of the representative with the largest
 *  share. */
template <typename Layout>
struct WriteFusedOfClouds {
  CloudsOfCameras<Layout> clouds;
  const FusedPoint* fused;
  const float* weights;
  const std::uint32_t* view_counts;
  /** \brief PointCameras::mask() of each; where Layout has_camera_mask. */
  const std::uint64_t* cameras;
  const std::uint32_t* staying;
  bool weight_in_intensity;
  /** \brief Null, or set for each place that represents a fused point. */
  std::uint8_t* represents;
  typename Layout::Words* output;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const FusedPoint point = fused[staying[k]];
    int main = 0;
    Vec3 color{};
    IntensityMean intensity;
    NormalMean normal;
    for (int s = 0; s < kRepresentatives; ++s) {
      if (s >= static_cast<int>(point.count)) continue;
      if (point.share[s] > point.share[main]) main = s;
      const typename Layout::Words& source = *clouds.at(point.source[s]);
      color = color + point.share[s] * Layout::color(source);
      intensity.add(point.share[s], Layout::intensity(source));
      normal.add(point.share[s], Layout::normal(source));
      if (represents != nullptr) represents[point.source[s]] = 1;
    }
    typename Layout::Words w = *clouds.at(point.source[main]);
    Layout::setPosition(w, point.p);
    Layout::setColor(w, color);
    if (normal.known()) Layout::setNormal(w, normal.mean());
    Layout::setIntensity(w, weight_in_intensity ? weights[staying[k]] : intensity.mean());
    Layout::setConfidence(w, weights[staying[k]]);
    if (Layout::has_view_count) Layout::setViewCount(w, view_counts[staying[k]]);
    if (Layout::has_camera_mask) Layout::setCameraMask(w, cameras[staying[k]]);
    output[k] = w;
  }
};

/** \brief Section 5 for points that come camera after camera. Each camera's points are padded to whole chunks. */
class CloudAggregation {
 public:
  explicit CloudAggregation(DeviceFilter& filter) : filter_(filter) {}

  /** \param cameras of each point, ascending  \param evaluator null: V = 1; else cameras are numbers of its views
   *  \param agreeing receives PointCameras::mask() of each fused point; without an evaluator nothing */
  std::vector<FusedPoint> fuse(const AggregationParameters& parameters, const std::vector<WeightedPoint>& points,
                               const std::vector<std::uint32_t>& cameras, const ConsistencyEvaluator* evaluator,
                               std::vector<std::uint64_t>& agreeing) {
    agreeing.clear();
    if (points.empty()) return {};
    layOut(points, cameras, evaluator != nullptr);
    filter_.upload(padded_.data(), padded_.size(), points_);
    const std::size_t count = aggregate(parameters, evaluator, CamerasWanted::Which);
    output_.resize(count);
    output_cameras_.resize(count);
    filter_.run.forEach(
        count, GatherFused{fused_.fused.data(), fused_.weights.data(), fused_.view_counts.data(), fused_.cameras.data(),
                           fused_.staying.data(), output_.data(), output_cameras_.data()});
    std::vector<FusedPoint> result(count);
    filter_.download(output_, count, result.data());
    if (evaluator != nullptr) {  // else ranges are not numbered as cameras are
      agreeing.resize(count);
      filter_.download(output_cameras_, count, agreeing.data());
    }
    for (FusedPoint& point : result)
      for (std::uint32_t k = 0; k < point.count; ++k) point.source[k] = numbers_[point.source[k]];
    return result;
  }

  /** \brief The same for clouds on the device: cloud i is of camera i; null: that camera has none. \param wanted null, or
   *  one byte for each point of all clouds, in device memory  \param represents if not null, set for each point of all
   *  clouds, one cloud after the other, that represents a point of the output */
  template <typename PointT>
  void fuse(const AggregationParameters& parameters,
            const std::vector<std::shared_ptr<const DeviceCloud<PointT>>>& clouds, const std::uint8_t* wanted,
            const ConsistencyEvaluator* evaluator, bool weight_in_intensity, DeviceCloud<PointT>& output,
            std::vector<std::uint8_t>* represents) {
    using Layout = PointLayout<PointT>;
    using Words = typename Layout::Words;
    Execution& run = filter_.run;
    layOut(clouds);
    std::size_t count = 0;
    const CloudsOfCameras<Layout> on_device{reinterpret_cast<const Words* const*>(device_clouds_), device_sizes_,
                                            grid()};
    if (places_ > 0) {
      points_.resize(places_);
      run.forEach(places_, TakePoints<Layout>{on_device, wanted, device_begins_, points_.data()});
      count = aggregate(parameters, evaluator, Layout::has_camera_mask ? CamerasWanted::Which : CamerasWanted::HowMany);
    }
    output.resize(static_cast<std::uint32_t>(count), 1);
    if (represents && places_ > 0) {
      represents_.resize(places_);
      run.fill(represents_.data(), places_, 0);
    }
    run.forEach(count, WriteFusedOfClouds<Layout>{on_device, fused_.fused.data(), fused_.weights.data(),
                                                  fused_.view_counts.data(), fused_.cameras.data(),
                                                  fused_.staying.data(), weight_in_intensity,
                                                  represents ? represents_.data() : nullptr, output.words()});
    if (represents) downloadRepresents(*represents);
  }

 private:
  PixelGrid grid() const { return {nullptr, device_offsets_, static_cast<std::uint32_t>(offsets_.size() - 1)}; }

  /** \brief Section 5 over points_. Returns how many fused points there are. */
  std::size_t aggregate(const AggregationParameters& parameters, const ConsistencyEvaluator* evaluator,
                        CamerasWanted wanted) {
    enter(parameters);
    return aggregation_.fuse(parameters,
                             {points_.data(), slots_.data(), places_, grid(), table_view_, counters_.host().cells},
                             evaluator, wanted, nullptr, fused_);
  }

  template <typename PointT>
  void layOut(const std::vector<std::shared_ptr<const DeviceCloud<PointT>>>& clouds) {
    offsets_.assign(1, 0);
    begins_.assign(1, 0);
    sizes_.clear();
    clouds_.clear();
    std::uint64_t places = 0;
    for (const auto& cloud : clouds) {
      const std::size_t size = cloud ? cloud->size() : 0;
      places += (size + kChunk - 1) / kChunk * kChunk;
      checkPlaces(places);
      clouds_.push_back(cloud ? cloud->words() : nullptr);
      sizes_.push_back(static_cast<std::uint32_t>(size));
      begins_.push_back(begins_.back() + static_cast<std::uint32_t>(size));
      offsets_.push_back(static_cast<std::uint32_t>(places));
    }
    places_ = static_cast<std::size_t>(places);
    uploadLayout();
  }

  /** \brief What layOut() has found, in one copy. */
  void uploadLayout() {
    layout_.clear();
    const auto add = [this](const auto& values) {
      const std::size_t place = layout_.size();
      const char* bytes = reinterpret_cast<const char*>(values.data());
      layout_.insert(layout_.end(), bytes, bytes + values.size() * sizeof(values[0]));
      return place;
    };
    const std::size_t clouds = add(clouds_);  // first, where they are aligned
    const std::size_t offsets = add(offsets_), begins = add(begins_), sizes = add(sizes_);
    filter_.upload(layout_.data(), layout_.size(), device_layout_);
    const auto at = [this](std::size_t place) { return device_layout_.data() + place; };
    device_clouds_ = reinterpret_cast<const void* const*>(at(clouds));
    device_offsets_ = reinterpret_cast<const std::uint32_t*>(at(offsets));
    device_begins_ = reinterpret_cast<const std::uint32_t*>(at(begins));
    device_sizes_ = reinterpret_cast<const std::uint32_t*>(at(sizes));
  }

  /** \brief From places to points of all clouds. */
  void downloadRepresents(std::vector<std::uint8_t>& represents) {
    std::vector<std::uint8_t> of_places(places_);
    filter_.download(represents_, places_, of_places.data());
    represents.clear();
    for (std::size_t i = 0; i < sizes_.size(); ++i)
      represents.insert(represents.end(), of_places.begin() + offsets_[i], of_places.begin() + offsets_[i] + sizes_[i]);
  }

  static void checkPlaces(std::uint64_t places) {
    if (places > ChildRun::kMaxPixels)
      throw pcl::PCLException("fuse_flow::AdaptiveHashFusion: a cloud on the GPU has more than 2^27 points");
  }

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
    places_ = padded_.size();
    checkPlaces(places_);
    clouds_.clear();
    begins_.clear();
    sizes_.clear();
    uploadLayout();
  }

  void enter(const AggregationParameters& parameters) {
    Execution& run = filter_.run;
    Counters* counters = counters_.device(run);
    slots_.resize(places_);
    std::size_t capacity = table_.capacity();
    do {
      table_view_ = table_.start(run, capacity, &counters->cells, &counters->table_too_full);
      run.fill(&counters->points.too_far, 1, 0xff);
      run.forEach(places_, EnterPoints{points_.data(), 1.0f / parameters.cell_size, table_view_, slots_.data(),
                                       &counters->points});
      const Counters& counted = counters_.read(run);
      if (counted.points.too_far != 0xffffffffu) throwTooFarPoint(counted.points.too_far, parameters.cell_size);
      capacity = 4 * table_.capacity();
    } while (counters_.host().table_too_full > 0);
  }

  [[noreturn]] void throwTooFarPoint(std::uint32_t place, float cell_size) {
    WeightedPoint point;
    filter_.run.copy(&point, points_.data() + place, 1);
    filter_.run.wait();
    throwTooFar(point.p, cell_size);
  }

  DeviceFilter& filter_;
  std::vector<WeightedPoint> padded_;
  std::vector<std::uint32_t> numbers_, offsets_, begins_, sizes_;
  std::vector<const void*> clouds_;
  std::vector<char> layout_;
  DeviceBuffer<char> device_layout_;
  /** \brief In device_layout_. */
  const void* const* device_clouds_{nullptr};
  const std::uint32_t *device_offsets_{nullptr}, *device_begins_{nullptr}, *device_sizes_{nullptr};
  /** \brief Points of all cameras, padded. */
  std::size_t places_{0};
  CounterBuffer counters_;
  CellTable table_;
  CellTableView table_view_{};
  DeviceBuffer<WeightedPoint> points_;
  DeviceBuffer<std::uint32_t> slots_;
  DeviceBuffer<std::uint8_t> represents_;
  Aggregation aggregation_{filter_.run, filter_.times, counters_};
  FusedPoints fused_;
  DeviceBuffer<FusedPoint> output_;
  DeviceBuffer<std::uint64_t> output_cameras_;
};

}  // namespace gpu
}  // namespace fuse_flow
