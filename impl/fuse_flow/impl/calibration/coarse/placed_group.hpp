#pragma once

#include <fuse_flow/impl/calibration/coarse/view_agreement.hpp>

#include <algorithm>
#include <utility>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Some cameras in one frame. */
struct PlacedGroup {
  std::vector<std::size_t> members;      ///< in the order in which they were placed
  std::vector<Eigen::Isometry3d> poses;  ///< of all cameras; only those of members count
  double score{0};                       ///< of all pairs of members together
  std::vector<std::size_t> contested;    ///< members that lie elsewhere in a group that scores nearly as much
};

/** \brief Whether two groups have the same members at the same places beside each other.
 *  \param distance metres  \param angle radians: between poses that are two different answers */
inline bool sameGroup(const PlacedGroup& a, const PlacedGroup& b, double distance, double angle) {
  if (a.members.size() != b.members.size()) return false;
  const std::size_t anchor = a.members.front();
  const auto beside = [&](const PlacedGroup& group, std::size_t camera) {
    return group.poses[anchor].inverse() * group.poses[camera];
  };
  return std::all_of(a.members.begin(), a.members.end(), [&](std::size_t i) {
    return std::find(b.members.begin(), b.members.end(), i) != b.members.end() &&
           !distinct(beside(a, i), beside(b, i), distance, angle);
  });
}

/** \brief Of groups that are the same, though they began with other pairs, the one that scores most stays, of equals the first.
 *  Best first; those without members go. */
inline std::vector<PlacedGroup> withoutDuplicates(std::vector<PlacedGroup> groups, double distance, double angle) {
  std::stable_sort(groups.begin(), groups.end(),
                   [](const PlacedGroup& a, const PlacedGroup& b) { return a.score > b.score; });
  std::vector<PlacedGroup> kept;
  for (PlacedGroup& group : groups) {
    const auto same = [&](const PlacedGroup& other) { return sameGroup(group, other, distance, angle); };
    if (!group.members.empty() && std::none_of(kept.begin(), kept.end(), same)) kept.push_back(std::move(group));
  }
  return kept;
}

}  // namespace host
}  // namespace fuse_flow
