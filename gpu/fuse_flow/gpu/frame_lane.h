#pragma once

#include <fuse_flow/gpu/frame_pipeline.h>
#include <fuse_flow/gpu/point_layout.h>
#include <fuse_flow/gpu/point_span.h>

#include <pcl/point_cloud.h>

namespace fuse_flow {
namespace gpu {

/** \brief A frame pipeline with its output: one lane fuses one frame at a time, with memory and a stream of its own. */
template <typename PointT>
class FrameLane {
 public:
  using Words = typename PointLayout<PointT>::Words;

  FramePipeline pipeline;
  bool compute_normals{false};

  /** \brief The fused points in device memory, once the lane's stream has passed. */
  PointSpan<PointT> fuseOnDevice(const RigFrame& frame) {
    size_ = pipeline.fuse(frame, PointLayout<PointT>::has_color);
    output_.resize(size_);
    pipeline.write(layout_, compute_normals, output_.data());
    return {reinterpret_cast<const PointT*>(output_.data()), size_};
  }

  /** \brief The fused points in pinned host memory, which the lane owns until its next frame. */
  PointSpan<PointT> fusePinned(const RigFrame& frame) {
    fuseOnDevice(frame);
    pinned_.resize(size_);
    pipeline.run.copy(pinned_.data(), output_.data(), size_);
    pipeline.times.mark("download", 2.0 * static_cast<double>(size_ * sizeof(Words)));
    pipeline.run.wait();
    pipeline.finish();
    return {reinterpret_cast<const PointT*>(pinned_.data()), size_};
  }

  std::size_t bytes() const { return pipeline.bytes() + output_.bytes(); }

 private:
  PointLayout<PointT> layout_;
  DeviceBuffer<Words> output_;
  PinnedBuffer<Words> pinned_;
  std::size_t size_{0};
};

/** \brief A fused frame as a cloud. \param threads to copy with */
template <typename PointT>
void toCloud(const PointSpan<PointT>& points, std::uint64_t stamp, int threads, pcl::PointCloud<PointT>& cloud) {
  cloud.resize(points.size);
  constexpr std::size_t block = 1 << 15;
  host::parallelFor(threads, (points.size + block - 1) / block, [&](std::size_t b, int) {
    const std::size_t begin = b * block, count = std::min(block, points.size - begin);
    std::memcpy(static_cast<void*>(cloud.data() + begin), points.points + begin, count * sizeof(PointT));
  });
  cloud.header = {};
  cloud.header.stamp = stamp;
  cloud.width = static_cast<std::uint32_t>(points.size);
  cloud.height = 1;
  cloud.is_dense = true;
  cloud.sensor_origin_.setZero();
  cloud.sensor_orientation_.setIdentity();
}

}  // namespace gpu
}  // namespace fuse_flow
