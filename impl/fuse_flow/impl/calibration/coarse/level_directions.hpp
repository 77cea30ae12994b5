#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief The directions of two views that floors can have; where either has none, those of most surfaces. */
class LevelDirections {
 public:
  /** \param first, second of SurfaceDirections  \param max_roll how far a camera may be turned about its optical axis, radians; π or
   *  more: nothing is known about floors */
  LevelDirections(const std::vector<Eigen::Vector3d>& first, const std::vector<Eigen::Vector3d>& second,
                  double max_roll)
      : first_(upward(first, max_roll)), second_(upward(second, max_roll)) {
    floors_ = !first_.empty() && !second_.empty();
    if (floors_) return;
    first_.assign(first.begin(), first.begin() + static_cast<std::ptrdiff_t>(std::min(kStrongest, first.size())));
    second_.assign(second.begin(), second.begin() + static_cast<std::ptrdiff_t>(std::min(kStrongest, second.size())));
  }

  /** \brief Whether both views may see the floor. */
  bool floors() const { return floors_; }
  const std::vector<Eigen::Vector3d>& first() const { return first_; }
  const std::vector<Eigen::Vector3d>& second() const { return second_; }

 private:
  static constexpr double kPi = 3.14159265358979323846;
  /** \brief Cosine of the largest angle between the image's upright and a floor's normal. */
  static constexpr double kUpward = 0.5;
  static constexpr std::size_t kStrongest = 2;  ///< directions that are taken for level where no floor is

  static std::vector<Eigen::Vector3d> upward(const std::vector<Eigen::Vector3d>& directions, double max_roll) {
    std::vector<Eigen::Vector3d> result;
    for (const Eigen::Vector3d& d : directions)
      if (max_roll < kPi && -d.y() > kUpward && std::fabs(std::atan2(d.x(), -d.y())) <= max_roll) result.push_back(d);
    return result;
  }

  std::vector<Eigen::Vector3d> first_, second_;
  bool floors_;
};

}  // namespace host
}  // namespace fuse_flow
