#pragma once

#include <fuse_flow/impl/host/frame_pipeline.hpp>
#include <fuse_flow/point_traits.h>

#include <Eigen/StdVector>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace fuse_flow::host {

/// Writes the fused points of a frame as points of type PointT; what PointT has no place for is not read. A function of
/// its own for each step: nvcc's parser loses itself in "if constexpr" around a loop within a lambda.
template <typename PointT>
class PointWriter : public FusedPointSink {
 public:
  explicit PointWriter(const FramePipeline& pipeline) : pipeline_(pipeline) {}

  void setComputeNormals(bool compute) { with_normals_ = compute; }

  void start(int threads) override {
    if (points_.size() < static_cast<std::size_t>(threads)) points_.resize(static_cast<std::size_t>(threads));
    for (Points& of_thread : points_) of_thread.clear();
  }

  void add(int thread, const std::vector<FusedPoint>& fused) override {
    Points& points = points_[static_cast<std::size_t>(thread)];
    const std::size_t begin = points.size();
    points.resize(begin + fused.size());
    for (std::size_t k = 0; k < fused.size(); ++k) write(fused[k], points[begin + k]);
  }

  void reserve(std::size_t points) override {
    for (Points& of_thread : points_) of_thread.reserve(points);
  }

  /// The points of a thread that were added from the begin-th on.
  void copy(int thread, std::size_t begin, std::size_t n, PointT* output) const {
    const Points& points = points_[static_cast<std::size_t>(thread)];
    std::copy_n(points.begin() + static_cast<std::ptrdiff_t>(begin), n, output);
  }

  /// \param point as it is constructed
  void write(const FusedPoint& fused, PointT& point) const {
    point::setPosition(point, fused.p);
    point::setWeight(point, fused.weight);
    point::setViewCount(point, fused.views);
    ColorMean color;
    NormalMean normal;
    if constexpr (point::has_color<PointT> || point::has_normal<PointT>) {
      for (std::size_t k = 0; k < fused.count; ++k) {
        const FramePoints::Pixel source = pipeline_.locate(fused.source[k]);
        if constexpr (point::has_color<PointT>) color.add(fused.share[k], pipeline_.color(source));
        if constexpr (point::has_normal<PointT>) {
          if (with_normals_) normal.add(fused.share[k], pipeline_.normal(source));
        }
      }
    }
    point::setColor(point, color.mean());
    point::setNormal(point, normal.mean());
  }

 private:
  using Points = std::vector<PointT, Eigen::aligned_allocator<PointT>>;

  const FramePipeline& pipeline_;
  bool with_normals_{false};
  std::vector<Points> points_;  ///< of each thread
};

}  // namespace fuse_flow::host
