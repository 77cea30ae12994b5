#pragma once

/** \file
 *  \brief The same frame on both devices, and how far apart the results are. */

#include <fuse_flow/gpu/fuse_flow.h>
#include <fuse_flow/math/cell.h>
#include <fuse_flow/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <ostream>
#include <string>
#include <tuple>
#include <unordered_map>
#include <unordered_set>
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

/** \brief kTolerance, but at least the few steps of a float that rounding takes so far from the origin. */
template <typename PointT>
float toleranceAt(const PointT& point) {
  constexpr float step = std::numeric_limits<float>::epsilon();
  return std::max(kTolerance, 4 * step * point.getVector3fMap().cwiseAbs().maxCoeff());
}

template <typename PointT>
bool samePosition(const PointT& a, const PointT& b) {
  return (a.getVector3fMap() - b.getVector3fMap()).norm() <= toleranceAt(a);
}

inline bool samePoint(const PointFused& a, const PointFused& b) {
  const auto near = [](std::uint8_t c, std::uint8_t d) { return std::abs(int{c} - int{d}) <= kLevels; };
  return samePosition(a, b) && near(a.r, b.r) && near(a.g, b.g) && near(a.b, b.b) && a.view_count == b.view_count &&
         std::fabs(a.confidence - b.confidence) <= 1e-4f;
}

/** \brief Points that only one of two clouds has. Each point is paired with the nearest that is the same and has no partner
 *  yet: nothing counts twice, though several points may lie within the tolerance. */
template <typename PointT, typename Same, typename Difference>
std::size_t pointsAlone(const pcl::PointCloud<PointT>& a, const pcl::PointCloud<PointT>& b, const Same& same,
                        const Difference& difference) {
  std::vector<PointT, Eigen::aligned_allocator<PointT>> sorted(b.begin(), b.end());
  std::sort(sorted.begin(), sorted.end(), [](const PointT& p, const PointT& q) { return p.x < q.x; });
  std::vector<bool> taken(sorted.size(), false);
  std::size_t pairs = 0;
  for (const PointT& point : a) {
    const float tolerance = toleranceAt(point);
    float nearest = std::numeric_limits<float>::infinity();
    std::size_t partner = sorted.size();
    auto other = std::lower_bound(sorted.begin(), sorted.end(), point.x - tolerance,
                                  [](const PointT& p, float x) { return p.x < x; });
    for (; other != sorted.end() && other->x <= point.x + tolerance; ++other) {
      const auto k = static_cast<std::size_t>(other - sorted.begin());
      if (taken[k] || !same(point, *other) || difference(point, *other) >= nearest) continue;
      nearest = difference(point, *other);
      partner = k;
    }
    if (partner == sorted.size()) continue;
    taken[partner] = true;
    ++pairs;
  }
  return a.size() + b.size() - 2 * pairs;
}

template <typename PointT, typename Same>
std::size_t pointsAlone(const pcl::PointCloud<PointT>& a, const pcl::PointCloud<PointT>& b, const Same& same) {
  return pointsAlone(a, b, same,
                     [](const PointT& p, const PointT& q) { return (p.getVector3fMap() - q.getVector3fMap()).norm(); });
}

/** \brief The same for fused points, of which several may have one position but not one confidence. */
inline std::size_t fusedPointsAlone(const Cloud& a, const Cloud& b) {
  return pointsAlone(a, b, samePoint, [](const PointFused& p, const PointFused& q) {
    return (p.getVector3fMap() - q.getVector3fMap()).norm() + std::fabs(p.confidence - q.confidence);
  });
}

/** \brief Indices that only one of two lists has, counted as often as they are there. */
inline std::size_t indicesAlone(pcl::Indices a, pcl::Indices b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  pcl::Indices alone;
  std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(alone));
  return alone.size();
}

/** \brief The coarse cells of a cloud in order of appearance, each once. Points on the border of two cells tell nothing: rounding
 *  may have put them into either. */
inline std::vector<std::uint64_t> cellsInTurn(const Cloud& cloud, float cell_size) {
  std::vector<std::uint64_t> cells;
  if (!(cell_size > 0)) return cells;
  std::unordered_set<std::uint64_t> seen;
  for (const PointFused& p : cloud) {
    const Eigen::Array3f at = p.getArray3fMap() / cell_size;
    if ((cell_size * (at - at.round()).abs() <= toleranceAt(p)).any()) continue;
    const std::uint64_t key = cellKey(fuse_flow::cellIndex({at.x(), at.y(), at.z()}));
    if (seen.insert(key).second) cells.push_back(key);
  }
  return cells;
}

/** \brief How often a cell of the second list comes before the one ahead of it, in the first. */
inline std::size_t cellsOutOfTurn(const std::vector<std::uint64_t>& expected, const std::vector<std::uint64_t>& cells) {
  std::unordered_map<std::uint64_t, std::size_t> turn;
  for (const std::uint64_t cell : expected) turn.emplace(cell, turn.size());
  std::size_t out_of_turn = 0, last = 0;
  for (const std::uint64_t cell : cells) {
    const auto found = turn.find(cell);
    if (found == turn.end()) continue;
    out_of_turn += found->second < last ? 1 : 0;
    last = found->second;
  }
  return out_of_turn;
}

/** \brief All that the points of a cloud or span hold, without padding. */
using Bytes = std::array<char, 28>;
template <typename Points>
std::vector<Bytes> bytesOf(const Points& points) {
  std::vector<Bytes> result;
  for (const PointFused& point : points) {
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

/** \brief Of many frames: points on both devices, those that only one of them has, and coarse cells in another order. */
struct Tally {
  std::size_t points{0};
  std::size_t alone{0};
  std::size_t cells{0};
  std::size_t out_of_turn{0};

  /** \brief Also expects that no single frame is far off, however many good ones there are.
   *  \param cell_size of the coarse cells, metres; 0: points may have left them, and their order is not looked at */
  void add(const Cloud& host, const Cloud& device, float cell_size) {
    const std::vector<std::uint64_t> expected = cellsInTurn(host, cell_size);
    const std::size_t both = host.size() + device.size();
    const std::size_t frame_alone = fusedPointsAlone(host, device);
    const std::size_t frame_out_of_turn = cellsOutOfTurn(expected, cellsInTurn(device, cell_size));
    EXPECT_LE(frame_alone, std::min(both / 20, 4 + both / 1000)) << host.size() << " and " << device.size();
    EXPECT_LE(frame_out_of_turn, std::min(expected.size() / 10, 2 + expected.size() / 1000)) << expected.size();
    points += both;
    alone += frame_alone;
    cells += expected.size();
    out_of_turn += frame_out_of_turn;
  }
  /** \brief 99.999 % of points, ten times as strict as what is promised: exp() may differ in its last bit, nothing else may. */
  bool good() const { return alone * 100000 <= points && out_of_turn * 10000 <= cells; }
};

inline std::ostream& operator<<(std::ostream& out, const Tally& tally) {
  return out << tally.alone << " of " << tally.points << " points on one device only, " << tally.out_of_turn << " of "
             << tally.cells << " cells out of turn";
}

inline void expectSameStatistics(const fuse_flow::FrameStatistics& host, const fuse_flow::FrameStatistics& device) {
  EXPECT_EQ(device.measured_points, host.measured_points);
  EXPECT_EQ(device.gated_points, host.gated_points);
  EXPECT_EQ(device.coarse_cells, host.coarse_cells);
  EXPECT_EQ(device.missing_cameras, host.missing_cameras);
  EXPECT_EQ(device.noise_scales, host.noise_scales);
  ASSERT_EQ(device.out_of_range.size(), host.out_of_range.size());
  for (std::size_t k = 0; k < host.out_of_range.size(); ++k) {
    const fuse_flow::DepthOutOfRange &a = device.out_of_range[k], &b = host.out_of_range[k];
    EXPECT_EQ(std::tie(a.camera, a.measured, a.in_range, a.nearest, a.farthest),
              std::tie(b.camera, b.measured, b.in_range, b.nearest, b.farthest));
  }
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
  // Confirmation moves points, at times out of their cells.
  const bool in_cells = !(parameters.aggregation.confirmation_reach > 0);
  const float cell_size = in_cells ? parameters.aggregation.cell_size : 0.0f;
  if (tally) {
    tally->add(expected, cloud, cell_size);
    return;
  }
  Tally own;
  own.add(expected, cloud, cell_size);
  EXPECT_TRUE(own.good()) << own;
}

inline void expectSame(const fuse_flow::RigFrame& frame, const fuse_flow::FuseFlowParameters& parameters = {}) {
  Host host;
  Device device;
  expectSame(frame, parameters, host, device);
}

}  // namespace device_comparison
