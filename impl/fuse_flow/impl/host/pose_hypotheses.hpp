#pragma once

#include <fuse_flow/impl/host/surface_directions.hpp>
#include <fuse_flow/impl/host/translation_vote.hpp>
#include <fuse_flow/impl/host/view_agreement.hpp>

#include <array>
#include <cmath>

namespace fuse_flow {
namespace host {

/** \brief Rotations of the second camera's frame into that of the first that bring surface directions of both together. */
inline std::vector<Eigen::Matrix3d> candidateRotations(const std::vector<Eigen::Vector3d>& first,
                                                       const std::vector<Eigen::Vector3d>& second) {
  constexpr double alike = 0.14, least = 0.35, apart = 0.1;  // radians
  constexpr double pi = 3.14159265358979323846;
  std::vector<Eigen::Matrix3d> result;
  const auto add = [&](const Eigen::Matrix3d& R) {
    for (const Eigen::Matrix3d& other : result)
      if ((other.transpose() * R).trace() > 1 + 2 * std::cos(apart)) return;
    result.push_back(R);
  };
  const auto frame = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    Eigen::Matrix3d F;  // between the two, so that the errors of both count alike
    F << (a + b).normalized(), (a - b).normalized(), a.cross(b).normalized();
    return F;
  };
  const auto angle = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::acos(std::max(-1.0, std::min(1.0, a.dot(b))));
  };
  for (std::size_t a = 0; a < first.size(); ++a)
    for (std::size_t b = a + 1; b < first.size(); ++b) {
      const double between = angle(first[a], first[b]);
      if (between < least || between > pi - least) continue;
      for (std::size_t c = 0; c < second.size(); ++c)
        for (std::size_t d = 0; d < second.size(); ++d)
          if (c != d && std::fabs(angle(second[c], second[d]) - between) < alike)
            add(frame(first[a], first[b]) * frame(second[c], second[d]).transpose());
    }
  // Of a floor alone the turn about its normal is not known.
  constexpr std::size_t strongest = 2;
  constexpr int turns = 36;
  for (std::size_t a = 0; a < std::min(strongest, first.size()); ++a)
    for (std::size_t c = 0; c < std::min(strongest, second.size()); ++c) {
      const Eigen::Matrix3d R = Eigen::Quaterniond::FromTwoVectors(second[c], first[a]).toRotationMatrix();
      for (int k = 0; k < turns; ++k) add(Eigen::AngleAxisd(2 * pi * k / turns, first[a]).toRotationMatrix() * R);
    }
  return result;
}

/** \brief The relative poses of two cameras that their views support best. */
class PoseHypotheses {
 public:
  PoseHypotheses(const AlignmentSystem& system, const CoarseAlignmentParameters& parameters)
      : system_(system), p_(parameters), comparison_(system, parameters) {}

  /** \brief Best first; pose of the second camera in the frame of the first. */
  std::vector<PoseHypothesis> find(std::size_t first, std::size_t second, const std::vector<Eigen::Vector3d>& directions_first,
                                   const std::vector<Eigen::Vector3d>& directions_second) const {
    std::vector<PoseHypothesis> found;
    TranslationVote vote(p_.cell_size);
    for (const Eigen::Matrix3d& R : candidateRotations(directions_first, directions_second))
      for (const Eigen::Vector3d& t : vote.peaks(system_.samples(0, first), system_.samples(0, second), R, kPeaks)) {
        PoseHypothesis h;
        h.T.linear() = R;
        h.T.translation() = t;
        h.score = comparison_.compare(first, second, h.T, p_.cell_size, kStride).score();
        if (h.score > 0) found.push_back(h);
      }
    found = best(found, kRefined, 1.5 * static_cast<double>(p_.cell_size), 0.1);
    std::vector<Eigen::Isometry3d> poses(system_.cameras(), Eigen::Isometry3d::Identity());
    for (PoseHypothesis& h : found) {
      h.T = comparison_.refine(second, h.T, {first}, poses, {0.3f, 0.3f, 0.25f, 0.2f, 0.15f, 0.12f, 0.1f, 0.08f, 0.06f, 0.06f});
      h.score = comparison_.compare(first, second, h.T, 0).score();
    }
    return best(found, static_cast<std::size_t>(p_.hypotheses), 0.1, 0.06);
  }

 private:
  /** \brief Those of the highest scores that are distinct. */
  static std::vector<PoseHypothesis> best(std::vector<PoseHypothesis>& all, std::size_t count, double distance, double angle) {
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
    std::vector<PoseHypothesis> chosen;
    for (const PoseHypothesis& h : all) {
      if (chosen.size() == count) break;
      const bool known = std::any_of(chosen.begin(), chosen.end(),
                                     [&](const PoseHypothesis& c) { return !distinct(c.T, h.T, distance, angle); });
      if (!known && h.score > 0) chosen.push_back(h);
    }
    return chosen;
  }

  static constexpr std::size_t kPeaks = 80;     ///< translations of a rotation that are looked at
  static constexpr std::size_t kStride = 2;     ///< every so many-th point judges a first guess
  static constexpr std::size_t kRefined = 150;  ///< guesses that are refined

  const AlignmentSystem& system_;
  const CoarseAlignmentParameters& p_;
  ViewComparison comparison_;
};

}  // namespace host
}  // namespace fuse_flow
