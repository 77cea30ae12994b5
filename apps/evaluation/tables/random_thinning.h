#pragma once

#include <fuse_flow/point_types.h>

#include <pcl/point_cloud.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

namespace fuse_flow::tables {

/** \brief A number drawn for a point from its position: the same wherever it stands in its cloud. */
inline std::uint64_t drawFor(const PointFused& point, std::uint64_t seed) {
  std::uint64_t state = seed;
  for (const float coordinate : {point.x, point.y, point.z}) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &coordinate, sizeof bits);
    state += 0x9e3779b97f4a7c15u + bits;  // splitmix64
    state = (state ^ state >> 30) * 0xbf58476d1ce4e5b9u;
    state = (state ^ state >> 27) * 0x94d049bb133111ebu;
    state ^= state >> 31;
  }
  return state;
}

/** \brief Leaves a number of a cloud's points, each as likely as any other. Which ones does not depend on their order, only on
 *  where they are and on the seed; fewer points all stay. */
inline void thinAtRandom(pcl::PointCloud<PointFused>& cloud, std::size_t number, std::uint64_t seed) {
  if (cloud.size() <= number) return;
  struct Ticket {
    std::uint64_t draw;
    std::size_t point;
  };
  std::vector<Ticket> tickets;
  tickets.reserve(cloud.size());
  for (std::size_t k = 0; k < cloud.size(); ++k) tickets.push_back({drawFor(cloud[k], seed), k});
  const auto end = tickets.begin() + static_cast<std::ptrdiff_t>(number);
  std::nth_element(tickets.begin(), end, tickets.end(),
                   [](const Ticket& a, const Ticket& b) { return a.draw < b.draw; });
  pcl::PointCloud<PointFused> kept;
  kept.header = cloud.header;
  kept.reserve(number);
  for (auto ticket = tickets.begin(); ticket != end; ++ticket) kept.push_back(cloud[ticket->point]);
  cloud = std::move(kept);
}

}  // namespace fuse_flow::tables
