#pragma once

#include <fuse_flow/impl/host/rotation_candidates.hpp>
#include <fuse_flow/impl/host/translation_vote.hpp>
#include <fuse_flow/impl/host/view_agreement.hpp>

#include <cmath>

namespace fuse_flow {
namespace host {

/** \brief The relative poses of two cameras that their views support best. */
class PoseHypotheses {
 public:
  PoseHypotheses(const AlignmentSystem& system, const CoarseAlignmentParameters& parameters)
      : system_(system), p_(parameters), comparison_(system, parameters) {}

  /** \brief Best first; pose of the second camera in the frame of the first. */
  std::vector<PoseHypothesis> find(std::size_t first, std::size_t second,
                                   const std::vector<Eigen::Vector3d>& directions_first,
                                   const std::vector<Eigen::Vector3d>& directions_second) const {
    std::vector<PoseHypothesis> found;
    TranslationVote vote(p_.cell_size);
    const RotationCandidates candidates(directions_first, directions_second, p_.max_roll);
    for (const Eigen::Matrix3d& R : candidates.rotations())
      for (const Eigen::Vector3d& t : vote.peaks(system_.samples(0, first), system_.samples(0, second), R, kPeaks)) {
        PoseHypothesis h;
        h.T.linear() = R;
        h.T.translation() = t;
        h.score = comparison_.compareRoughly(first, second, h.T, p_.cell_size);
        if (h.score > 0) found.push_back(h);
      }
    found = best(found, kRefined, 1.5 * static_cast<double>(p_.cell_size), 0.1);
    std::vector<Eigen::Isometry3d> poses(system_.cameras(), Eigen::Isometry3d::Identity());
    for (PoseHypothesis& h : found) {
      h.T = comparison_.refine(second, h.T, {first}, poses, {0.25f, 0.25f, 0.2f, 0.15f, 0.1f});
      h.score = comparison_.compareRoughly(first, second, h.T, 0.05f);
    }
    found = best(found, kPolished, 0.1, 0.06);
    for (PoseHypothesis& h : found) {
      h.T = comparison_.refine(second, h.T, {first}, poses, {0.1f, 0.08f, 0.06f, 0.05f, 0.04f, 0.03f, 0.03f});
      const ViewAgreement agreement = comparison_.compare(first, second, h.T);
      h.score = agreement.score();
      h.color_spread = agreement.color_spread;
    }
    return best(found, static_cast<std::size_t>(p_.hypotheses), 0.1, 0.06);
  }

 private:
  /** \brief Those of the highest scores that are distinct. */
  static std::vector<PoseHypothesis> best(std::vector<PoseHypothesis>& all, std::size_t count, double distance,
                                          double angle) {
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
    std::vector<PoseHypothesis> chosen;
    for (const PoseHypothesis& h : all) {
      if (chosen.size() == count) break;
      const bool known = std::any_of(chosen.begin(), chosen.end(),
                                     [&](const PoseHypothesis& c) { return !distinct(c.T, h.T, distance, angle); });
      if (!known) chosen.push_back(h);
    }
    return chosen;
  }

  static constexpr std::size_t kPeaks = 80;     ///< translations of a rotation that are looked at
  static constexpr std::size_t kRefined = 150;  ///< guesses that are refined
  static constexpr std::size_t kPolished = 40;  ///< of these, those that are refined to the end

  const AlignmentSystem& system_;
  const CoarseAlignmentParameters& p_;
  ViewComparison comparison_;
};

}  // namespace host
}  // namespace fuse_flow
