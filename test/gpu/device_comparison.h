#pragma once

/** \file
 *  \brief The same frame on both devices, and how far apart the results are. */

#include <fuse_flow/gpu/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

// Compiled once, in instances.cpp.
extern template class fuse_flow::FuseFlow<fuse_flow::PointFused>;
extern template class fuse_flow::FuseFlow<fuse_flow::PointFused, fuse_flow::device::Thrust>;

namespace device_comparison {

using fuse_flow::PointFused;
using Cloud = pcl::PointCloud<PointFused>;
using Host = fuse_flow::FuseFlow<PointFused>;
using Device = fuse_flow::FuseFlow<PointFused, fuse_flow::device::Thrust>;

/** \brief Metres and levels of 255 within which a point of one device is that of the other. */
constexpr float kTolerance = 1e-5f;
constexpr int kLevels = 1;

inline bool samePoint(const PointFused& a, const PointFused& b) {
  const auto near = [](std::uint8_t c, std::uint8_t d) { return std::abs(int{c} - int{d}) <= kLevels; };
  return (a.getVector3fMap() - b.getVector3fMap()).norm() <= kTolerance && near(a.r, b.r) && near(a.g, b.g) &&
         near(a.b, b.b) && a.view_count == b.view_count && std::fabs(a.confidence - b.confidence) <= 1e-4f;
}

/** \brief Points of a that b does not have. */
inline std::size_t missingIn(const Cloud& a, const Cloud& b) {
  std::vector<PointFused> sorted(b.begin(), b.end());
  std::sort(sorted.begin(), sorted.end(), [](const PointFused& p, const PointFused& q) { return p.x < q.x; });
  std::size_t missing = 0;
  for (const PointFused& point : a) {
    auto other = std::lower_bound(sorted.begin(), sorted.end(), point.x - kTolerance,
                                  [](const PointFused& p, float x) { return p.x < x; });
    bool found = false;
    for (; !found && other != sorted.end() && other->x <= point.x + kTolerance; ++other)
      found = samePoint(point, *other);
    missing += found ? 0 : 1;
  }
  return missing;
}

/** \brief All that a cloud's points hold, without padding. */
using Bytes = std::array<char, 28>;
inline std::vector<Bytes> bytesOf(const Cloud& cloud) {
  std::vector<Bytes> result;
  for (const PointFused& point : cloud) {
    Bytes bytes;
    std::memcpy(bytes.data(), &point.x, 12);
    std::memcpy(bytes.data() + 12, &point.rgba, 4);
    std::memcpy(bytes.data() + 16, &point.confidence, 4);
    std::memcpy(bytes.data() + 20, &point.view_count, 4);
    std::memset(bytes.data() + 24, 0, 4);
    result.push_back(bytes);
  }
  return result;
}

/** \brief Of many frames: points on both devices, and those that only one of them has. */
struct Tally {
  std::size_t points{0};
  std::size_t alone{0};

  void add(const Cloud& host, const Cloud& device) {
    points += host.size() + device.size();
    alone += missingIn(host, device) + missingIn(device, host);
  }
  /** \brief 99.999 %, ten times as strict as what is promised: exp() may differ in its last bit, nothing else may. */
  bool good() const { return alone * 100000 <= points; }
};

inline void expectSameStatistics(const fuse_flow::FrameStatistics& host, const fuse_flow::FrameStatistics& device) {
  EXPECT_EQ(device.measured_points, host.measured_points);
  EXPECT_EQ(device.gated_points, host.gated_points);
  EXPECT_EQ(device.coarse_cells, host.coarse_cells);
  EXPECT_EQ(device.missing_cameras, host.missing_cameras);
  EXPECT_EQ(device.noise_scales, host.noise_scales);
}

/** \brief Fuses a frame on both and expects the same. */
inline void expectSame(const fuse_flow::RigFrame& frame, const fuse_flow::FuseFlowParameters& parameters, Host& host,
                       Device& device, Tally* tally = nullptr) {
  Cloud expected, cloud;
  host.setParameters(parameters);
  device.setParameters(parameters);
  host.fuse(frame, expected);
  device.fuse(frame, cloud);
  expectSameStatistics(host.getStatistics(), device.getStatistics());
  EXPECT_EQ(device.getStatistics().fused_points, cloud.size());
  EXPECT_EQ(cloud.header.stamp, expected.header.stamp);
  EXPECT_EQ(cloud.width, cloud.size());
  EXPECT_TRUE(cloud.is_dense);
  if (tally) {
    tally->add(expected, cloud);
    return;
  }
  Tally own;
  own.add(expected, cloud);
  EXPECT_TRUE(own.good()) << own.alone << " of " << own.points;
}

inline void expectSame(const fuse_flow::RigFrame& frame, const fuse_flow::FuseFlowParameters& parameters = {}) {
  Host host;
  Device device;
  expectSame(frame, parameters, host, device);
}

}  // namespace device_comparison
