#pragma once

/** \file
 *  \brief What the parts of the GPU benchmark share: its frames, and how they are timed. */

#include "median.h"
#include "room.h"

#include <fuse_flow/gpu/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

namespace bench {

using Point = fuse_flow::PointFused;
using Cloud = pcl::PointCloud<Point>;
using Gpu = fuse_flow::FuseFlow<Point, fuse_flow::device::Thrust>;
using Clock = std::chrono::steady_clock;

/** \brief Milliseconds. */
inline double since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/** \brief Cameras of a rig and their images. */
struct Size {
  int cameras, width, height;

  std::string name() const {
    return std::to_string(cameras) + " × " + std::to_string(width) + "×" + std::to_string(height);
  }
  double megapixels() const { return 1e-6 * cameras * width * height; }
};

/** \brief Where images come from and where points go to. */
struct Route {
  const char* name;
  bool pageable, to_cloud;
};

/** \brief The fastest; the same into pcl::PointClouds; and what who keeps images in a std::vector gets. */
constexpr Route kRoutes[] = {{"pinned images, pinned points", false, false},
                             {"pinned images, clouds", false, true},
                             {"pageable images, clouds", true, true}};
constexpr std::size_t kRouteCount = 3;

/** \brief Different frames of one size, to be fused one after the other; in pinned memory, and byte for byte the same in pageable
 *  memory. */
class Frames {
 public:
  static constexpr std::size_t kCount = 3;

  explicit Frames(const Size& size) : room_(size.cameras, size.width, size.height) {
    for (std::size_t k = 0; k < kCount; ++k) {
      pinned_memory_[k].resize(room_.bytes());
      pinned_.push_back(room_.render(pinned_memory_[k].data(), static_cast<std::uint32_t>(k)));
      pageable_memory_[k].assign(pinned_memory_[k].data(), pinned_memory_[k].data() + room_.bytes());
      pageable_.push_back(room_.frameAt(pageable_memory_[k].data()));
    }
  }

  /** \brief The k-th of an endless row. */
  const fuse_flow::RigFrame& at(std::size_t k, bool pageable = false) const {
    return (pageable ? pageable_ : pinned_)[k % kCount];
  }
  /** \brief Its images: see Room. */
  const std::vector<char>& bytes(std::size_t k) const { return pageable_memory_[k % kCount]; }

 private:
  Room room_;
  fuse_flow::gpu::PinnedBuffer<char> pinned_memory_[kCount];
  std::vector<char> pageable_memory_[kCount];
  std::vector<fuse_flow::RigFrame> pinned_, pageable_;
};

/** \brief Milliseconds from the images of one frame to its points, nothing else in flight: the median after warming up. */
inline double latency(Gpu& fusion, const Frames& frames, const Route& route, int repeats) {
  Cloud cloud;
  std::vector<double> times;
  constexpr int warm = 2 * static_cast<int>(Frames::kCount);
  for (int k = 0; k < warm + repeats; ++k) {
    const fuse_flow::RigFrame& frame = frames.at(static_cast<std::size_t>(k), route.pageable);
    const Clock::time_point start = Clock::now();
    if (route.to_cloud) {
      fusion.fuse(frame, cloud);
    } else {
      fusion.fusePinned(frame);
    }
    if (k >= warm) times.push_back(since(start));
  }
  return median(times);
}

/** \brief The CPU pipeline: milliseconds a frame, the median of seven, and the points of the first frame. */
struct CpuTime {
  double ms{0};
  std::size_t points{0};
};

inline CpuTime timeCpu(const Frames& frames, const fuse_flow::FuseFlowParameters& parameters) {
  fuse_flow::FuseFlow<Point> fusion;
  fusion.setParameters(parameters);
  Cloud cloud;
  fusion.fuse(frames.at(0), cloud);
  CpuTime result;
  result.points = cloud.size();
  std::vector<double> times;
  for (std::size_t k = 0; k < 7; ++k) {
    const Clock::time_point start = Clock::now();
    fusion.fuse(frames.at(k), cloud);
    times.push_back(since(start));
  }
  result.ms = median(times);
  return result;
}

}  // namespace bench
