#pragma once

#include <fuse_flow/impl/fusion/frame_pipeline.hpp>
#include <fuse_flow/point_traits.h>

#include <Eigen/StdVector>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

namespace fuse_flow::host {

/// Writes the fused points of a frame as points of type PointT; what PointT has no place for is not read. A function of
/// its own for each step: nvcc's parser loses itself in "if constexpr" around a loop within a lambda.
template <typename PointT>
class PointWriter : public FusedPointSink {
 public:
  explicit PointWriter(const FramePipeline& pipeline) : pipeline_(pipeline) {}

  void setComputeNormals(bool compute) { with_normals_ = compute; }
  void setWeightInIntensity(bool weight) { weight_in_intensity_ = weight; }
  /// Whether a normal of the frame is NaN.
  bool anyUnknownNormal() const {
    return std::any_of(lanes_.begin(), lanes_.end(), [](const Lane& lane) { return lane.unknown_normal; });
  }

  void start(int threads) override {
    if (lanes_.size() < static_cast<std::size_t>(threads)) lanes_.resize(static_cast<std::size_t>(threads));
    for (Lane& lane : lanes_) {
      lane.chunks.clear();
      lane.points = 0;
      lane.unknown_normal = false;
    }
    taken_ = 0;
  }

  void add(int thread, const std::vector<FusedPoint>& fused, const std::vector<std::uint64_t>& cameras) override {
    Lane& lane = lanes_[static_cast<std::size_t>(thread)];
    for (std::size_t done = 0; done < fused.size();) {
      const std::size_t place = (lane.points + done) % kChunk;
      if (place == 0) lane.chunks.push_back(takeChunk());
      PointT* const points = lane.chunks.back()->data() + place;
      const std::size_t count = std::min(fused.size() - done, kChunk - place);
      for (std::size_t k = 0; k < count; ++k) write(thread, fused[done + k], cameras[done + k], points[k]);
      done += count;
    }
    lane.points += fused.size();  // once a cell: neighbouring lanes share a cache line
  }

  void reserve(std::size_t points) override {
    const std::size_t full = points / kChunk;
    while (chunks_.size() < full + lanes_.size()) addChunk();  // the last one of each thread is not full
    for (Lane& lane : lanes_) lane.chunks.reserve(full + 1);
  }

  void forgetMemory() {
    lanes_.clear();
    chunks_.clear();
  }

  /// The points of a thread that were added from the begin-th on.
  void copy(int thread, std::size_t begin, std::size_t n, PointT* output) const {
    const Lane& lane = lanes_[static_cast<std::size_t>(thread)];
    while (n > 0) {
      const std::size_t place = begin % kChunk, count = std::min(n, kChunk - place);
      output = std::copy_n(lane.chunks[begin / kChunk]->data() + place, count, output);
      begin += count;
      n -= count;
    }
  }

  void write(int thread, const FusedPoint& fused, std::uint64_t cameras, PointT& point) {
    point = PointT();
    point::setPosition(point, fused.p);
    point::setConfidence(point, fused.weight);
    point::setViewCount(point, fused.views);
    point::setCameraMask(point, cameras);
    ColorMean color;
    NormalMean normal;
    if constexpr (point::shows_color<PointT> || point::has_normal<PointT>) {
      for (std::size_t k = 0; k < fused.count; ++k) {
        const FramePoints::Pixel source = pipeline_.locate(fused.source[k]);
        if constexpr (point::shows_color<PointT>) color.add(fused.share[k], pipeline_.color(source));
        if constexpr (point::has_normal<PointT>) {
          if (with_normals_) normal.add(fused.share[k], pipeline_.normal(source));
        }
      }
    }
    point::setColor(point, color.mean());
    point::setIntensity(point, weight_in_intensity_ ? fused.weight : luminance(color.mean()));
    if (!with_normals_ || !point::has_normal<PointT>) return;
    point::setNormal(point, normal.meanOrNan());
    if (!normal.known()) lanes_[static_cast<std::size_t>(thread)].unknown_normal = true;
  }

 private:
  using Chunk = std::vector<PointT, Eigen::aligned_allocator<PointT>>;
  static constexpr std::size_t kChunk = 4096;

  /// What one thread has written. Which thread fuses what changes from frame to frame: chunks are anyone's, so that all
  /// threads together hold what a frame has, and not each of them.
  struct Lane {
    std::vector<Chunk*> chunks;
    std::size_t points{0};
    bool unknown_normal{false};
  };

  Chunk* takeChunk() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (taken_ == chunks_.size()) addChunk();
    return chunks_[taken_++].get();
  }

  void addChunk() { chunks_.push_back(std::make_unique<Chunk>(kChunk)); }

  const FramePipeline& pipeline_;
  bool with_normals_{false};
  bool weight_in_intensity_{false};
  std::vector<Lane> lanes_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Chunk>> chunks_;
  std::size_t taken_{0};
};

}  // namespace fuse_flow::host
