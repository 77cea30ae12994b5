#pragma once

#include <fuse_flow/impl/host/frame_pipeline.hpp>
#include <fuse_flow/point_traits.h>

#include <algorithm>
#include <array>
#include <cstddef>

namespace fuse_flow::host {

/// Writes the fused points of a frame as points of type PointT; what PointT has no place for is not read. A function of
/// its own for each step: nvcc's parser loses itself in "if constexpr" around a loop within a lambda.
template <typename PointT>
class PointWriter {
 public:
  /// The pixels that a fused point is the mean of.
  using Sources = std::array<FramePoints::Pixel, kRepresentatives>;

  PointWriter(const FramePipeline& pipeline, bool with_normals) : pipeline_(pipeline), with_normals_(with_normals) {}

  /// Finds `sources`, and sends for their colours.
  void locate(const FusedPoint& fused, Sources& sources) const {
    if constexpr (point::has_color<PointT> || point::has_normal<PointT>) {
      for (std::size_t k = 0; k < fused.count; ++k) {
        sources[k] = pipeline_.locate(fused.source[k]);
        if constexpr (point::has_color<PointT>) pipeline_.prefetchColor(sources[k]);
      }
    }
  }

  void write(const FusedPoint& fused, const Sources& sources, PointT& point) const {
    point = PointT();
    point::setPosition(point, fused.p);
    point::setWeight(point, fused.weight);
    point::setViewCount(point, fused.views);
    ColorMean color;
    NormalMean normal;
    for (std::size_t k = 0; k < fused.count; ++k) {
      if constexpr (point::has_color<PointT>) color.add(fused.share[k], pipeline_.color(sources[k]));
      if constexpr (point::has_normal<PointT>) {
        if (with_normals_) normal.add(fused.share[k], pipeline_.normal(sources[k]));
      }
    }
    point::setColor(point, color.mean());
    point::setNormal(point, normal.mean());
  }

  /// The same for `n` points in a row, whose colours are on their way from memory a batch at a time.
  template <typename Iterator>
  void write(const FusedPoint* fused, std::size_t n, Iterator output) const {
    constexpr std::size_t batch = 16;
    std::array<Sources, batch> sources;
    for (std::size_t begin = 0; begin < n; begin += batch) {
      const std::size_t end = std::min(n, begin + batch);
      for (std::size_t k = begin; k < end; ++k) locate(fused[k], sources[k - begin]);
      for (std::size_t k = begin; k < end; ++k) write(fused[k], sources[k - begin], output[k]);
    }
  }

 private:
  const FramePipeline& pipeline_;
  bool with_normals_;
};

}  // namespace fuse_flow::host
