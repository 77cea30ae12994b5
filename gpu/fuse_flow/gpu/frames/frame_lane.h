#pragma once

#include <fuse_flow/gpu/device_cloud.h>
#include <fuse_flow/gpu/frames/point_span.h>
#include <fuse_flow/gpu/fusion/frame_pipeline.h>
#include <fuse_flow/gpu/runtime/on_error.h>

#include <pcl/point_cloud.h>

#include <algorithm>
#include <atomic>

namespace fuse_flow {
namespace gpu {

/** \brief A frame pipeline with its output: one lane fuses one frame at a time, with memory and a stream of its own. \tparam Pipeline
 *  FramePipeline, or what is one */
template <typename PointT, typename Pipeline = FramePipeline>
class FrameLane {
 public:
  using Layout = PointLayout<PointT>;
  using Words = typename Layout::Words;

  Pipeline pipeline;
  bool compute_normals{false};
  bool weight_in_intensity{false};

  /** \brief The fused points in device memory, once the lane's stream has passed. */
  PointSpan<PointT> fuseOnDevice(const RigFrame& frame) {
    fuseInto(frame, output_);
    return {output_.data(), output_.size()};
  }

  /** \copydoc fuseOnDevice */
  void fuseInto(const RigFrame& frame, DeviceCloud<PointT>& output) {
    const OnError abandon([this] { pipeline.abandon(); });
    const std::size_t size = pipeline.fuse(frame, Layout::shows_color,
                                           Layout::has_camera_mask ? CamerasWanted::Which : CamerasWanted::HowMany);
    DeviceCloud<PointT>::copyHeader(DeviceCloud<PointT>(), output);
    output.header.stamp = frame.stamp;
    output.resize(static_cast<std::uint32_t>(size), 1);
    output.is_dense = !(compute_normals && Layout::has_normal);  // nobody has looked whether all are known
    pipeline.write(layout_, compute_normals, weight_in_intensity, output.words());
  }

  /** \brief The fused points in pinned host memory, which the lane owns until its next frame. */
  PointSpan<PointT> fusePinned(const RigFrame& frame) {
    fuseOnDevice(frame);
    return download();
  }

  /** \brief Those of the last fuseOnDevice(). */
  PointSpan<PointT> download() {
    const std::size_t size = output_.size();
    const OnError abandon([this] { pipeline.abandon(); });
    pinned_.resize(size);
    pipeline.run.copy(pinned_.data(), std::as_const(output_).words(), size);
    pipeline.times.mark("download", 2.0 * static_cast<double>(size * sizeof(Words)));
    pipeline.run.wait();
    pipeline.finish();
    return {reinterpret_cast<const PointT*>(pinned_.data()), size};
  }

  /** \brief Those of the last fuseOnDevice() for the caller's memory; once the stream has been waited for. */
  void swapOutput(DeviceCloud<PointT>& other) { std::swap(output_, other); }

  std::size_t bytes() const { return pipeline.bytes() + output_.bytes(); }

 private:
  PointLayout<PointT> layout_;
  DeviceCloud<PointT> output_;
  PinnedBuffer<Words> pinned_;
};

/** \brief Whether all normals are known. */
template <typename PointT>
bool allNormalsKnown(const PointT* points, std::size_t count) {
  return std::all_of(points, points + count, [](const PointT& p) { return isFinite(point::getNormal(p)); });
}

/** \brief A fused frame as a cloud, not dense where a normal is unknown. \param threads to copy with  \param copy the bytes of a block:
 *  memcpy, or streamCopy() where other frames need the memory's bandwidth as well */
template <typename PointT, typename Copy>
void toCloud(const PointSpan<PointT>& points, std::uint64_t stamp, int threads, const Copy& copy,
             pcl::PointCloud<PointT>& cloud) {
  cloud.resize(points.size);
  std::atomic<bool> dense{true};
  constexpr std::size_t block = 1 << 15;
  host::parallelFor(threads, (points.size + block - 1) / block, [&](std::size_t b, int) {
    const std::size_t begin = b * block, count = std::min(block, points.size - begin);
    copy(static_cast<void*>(cloud.data() + begin), points.points + begin, count * sizeof(PointT));
    if (point::has_normal<PointT> && !allNormalsKnown(points.points + begin, count)) dense = false;
  });
  cloud.header = {};
  cloud.header.stamp = stamp;
  cloud.width = static_cast<std::uint32_t>(points.size);
  cloud.height = 1;
  cloud.is_dense = dense;
  cloud.sensor_origin_.setZero();
  cloud.sensor_orientation_.setIdentity();
}

}  // namespace gpu
}  // namespace fuse_flow
