#pragma once

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <vector>

namespace fuse_flow::tables {

/** \brief How far a cloud's points are from the true surface, place by place: each cube of a grid counts as much as any other, however many points
 *  are in it. So clouds compare that are dense in different places, as those with a point for every pixel are near the cameras. */
class PlaceMeans {
 public:
  /** \param positions metres  \param distances one a point, any unit  \param side of the cubes, metres; > 0 */
  PlaceMeans(const std::vector<Eigen::Vector3f>& positions, const std::vector<float>& distances, float side) {
    for (std::size_t k = 0; k < positions.size(); ++k) {
      const Eigen::Vector3f place = positions[k] / side;
      if (!place.allFinite()) continue;  // is nowhere
      Sum& sum = sums_[{std::floor(place.x()), std::floor(place.y()), std::floor(place.z())}];
      sum.distance += static_cast<double>(distances[k]);
      sum.count += 1;
    }
  }

  /** \brief The mean of the cubes' means over that of another cloud, of those cubes alone in which both have points; NaN if there are none. */
  double ratioTo(const PlaceMeans& other) const {
    double own = 0, others = 0;
    for (const auto& [place, sum] : sums_) {
      const auto there = other.sums_.find(place);
      if (there == other.sums_.end()) continue;
      own += sum.mean();
      others += there->second.mean();
    }
    return own / others;
  }

 private:
  struct Sum {
    double distance{0};
    double count{0};
    double mean() const { return distance / count; }
  };
  std::map<std::array<float, 3>, Sum> sums_;
};

}  // namespace fuse_flow::tables
