#pragma once

#include <fuse_flow/impl/calibration/coarse/view_agreement.hpp>

#include <algorithm>
#include <limits>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Poses of all pairs of cameras that their two views support; pairs (i, j), i < j. */
class HypothesisTable {
 public:
  explicit HypothesisTable(std::size_t cameras) : cameras_(cameras), table_(cameras * cameras) {}
  std::size_t cameras() const { return cameras_; }
  /** \brief How much views of the same differ in brightness in this rig, grey levels. Of neighbours one of the poses that score
   *  most is right: the one at which their views differ least. Of cameras that share nothing none is: so of all pairs the lower
   *  quartile. */
  double colorNoise() const {
    constexpr double least = 1.2;  // of cameras without noise, at poses that are some centimetres off
    std::vector<double> spreads;
    for (const std::vector<PoseHypothesis>& hypotheses : table_) {
      double smallest = 0, highest = 0;
      for (const PoseHypothesis& h : hypotheses) highest = std::max(highest, h.score);
      for (const PoseHypothesis& h : hypotheses)
        if (h.score > std::max(kPlausible, 0.5 * highest) && h.color_spread > 0 &&
            (smallest == 0 || h.color_spread < smallest))
          smallest = h.color_spread;
      if (smallest > 0) spreads.push_back(smallest);
    }
    if (spreads.empty()) return std::numeric_limits<double>::infinity();
    const auto quartile = spreads.begin() + static_cast<std::ptrdiff_t>(spreads.size() / 4);
    std::nth_element(spreads.begin(), quartile, spreads.end());
    return std::max(least, *quartile);
  }
  std::vector<PoseHypothesis>& operator()(std::size_t i, std::size_t j) { return table_[i * cameras_ + j]; }
  /** \brief Where the camera could be, beside another that is at T; in the order of PoseHypotheses::find(). */
  void append(std::size_t camera, std::size_t beside, const Eigen::Isometry3d& T,
              std::vector<Eigen::Isometry3d>& poses) const {
    for (const PoseHypothesis& h : table_[std::min(camera, beside) * cameras_ + std::max(camera, beside)])
      poses.push_back(beside < camera ? T * h.T : T * h.T.inverse());
  }

 private:
  static constexpr double kPlausible = 20;  ///< score

  std::size_t cameras_;
  std::vector<std::vector<PoseHypothesis>> table_;
};

}  // namespace host
}  // namespace fuse_flow
