#pragma once

#include <fuse_flow/impl/calibration/coarse/rotation_candidates.hpp>
#include <fuse_flow/impl/calibration/coarse/texture_search.hpp>
#include <fuse_flow/impl/calibration/coarse/translation_vote.hpp>
#include <fuse_flow/impl/calibration/coarse/view_agreement.hpp>

#include <algorithm>
#include <cmath>

namespace fuse_flow {
namespace host {

/** \brief The candidate relative poses of two cameras that their views support best, by shape and by patterns on surfaces. Both are
 *  necessary: in rooms, many wrong poses align more surfaces than the right pose, and only patterns find the right one; but not all
 *  surfaces have patterns. */
class PoseHypotheses {
 public:
  PoseHypotheses(const AlignmentSystem& system, const CoarseAlignmentParameters& parameters)
      : system_(system), p_(parameters), comparison_(system, parameters) {}

  /** \brief Pose of the second camera in the frame of the first. First those that shape supports, the best of them first, then
   *  those of paint that are none of them, likewise. */
  std::vector<PoseHypothesis> find(std::size_t first, std::size_t second,
                                   const std::vector<Eigen::Vector3d>& directions_first,
                                   const std::vector<Eigen::Vector3d>& directions_second) const {
    std::vector<PoseHypothesis> found =
        refined(first, second, fromShape(first, second, directions_first, directions_second), &PoseHypothesis::score);
    const std::vector<PoseHypothesis> painted = refined(
        first, second, fromPaint(first, second, directions_first, directions_second), &PoseHypothesis::color_evidence);
    for (const PoseHypothesis& h : painted)
      if (!isKnown(h, found, kApart, kTurned)) found.push_back(h);
    return found;
  }

 private:
  /** \brief What hypotheses are compared by. */
  using Rank = double PoseHypothesis::*;

  /** \brief From normals and points. */
  std::vector<PoseHypothesis> fromShape(std::size_t first, std::size_t second,
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
        h.score = comparison_.compareRoughly(first, second, h.T, p_.cell_size).score;
        if (h.score > 0) found.push_back(h);
      }
    return best(found, kFromShape, 1.5 * static_cast<double>(p_.cell_size), 0.1, &PoseHypothesis::score);
  }

  /** \brief From grey levels on floors; if no floor is known, on the surfaces with the most frequent normal. */
  std::vector<PoseHypothesis> fromPaint(std::size_t first, std::size_t second,
                                        const std::vector<Eigen::Vector3d>& directions_first,
                                        const std::vector<Eigen::Vector3d>& directions_second) const {
    std::vector<TextureMatch> matches;
    TextureSearch search(p_.cell_size, kMatches);
    const LevelDirections level(directions_first, directions_second, p_.max_roll);
    std::vector<PlaneTexture> planes_second;
    for (const Eigen::Vector3d& d : level.second()) {
      const PlaneTextures textures(system_.view(0, second), d);
      planes_second.insert(planes_second.end(), textures.planes().begin(), textures.planes().end());
    }
    if (planes_second.empty()) return {};
    for (const Eigen::Vector3d& d : level.first()) {
      const PlaneTextures textures(system_.view(0, first), d);
      for (const PlaneTexture& a : textures.planes())
        for (const PlaneTexture& b : planes_second) search.search(a, b, matches);
    }
    std::vector<PoseHypothesis> found;
    for (const TextureMatch& match : matches) {
      PoseHypothesis h;
      h.T = match.T;
      h.color_evidence = match.evidence;
      found.push_back(h);
    }
    return best(found, kFromPaint, 1.5 * static_cast<double>(p_.cell_size), 0.1, &PoseHypothesis::color_evidence);
  }

  /** \brief The best of some guesses, where their refinement ends. */
  std::vector<PoseHypothesis> refined(std::size_t first, std::size_t second, std::vector<PoseHypothesis> found,
                                      Rank rank) const {
    const std::vector<Eigen::Isometry3d> poses(system_.cameras(), Eigen::Isometry3d::Identity());
    for (PoseHypothesis& h : found) {
      h.T = comparison_.refine(second, h.T, {first}, poses, {0.25f, 0.25f, 0.2f, 0.15f, 0.1f});
      const auto agreement = comparison_.compareRoughly(first, second, h.T, 0.05f);
      h.score = agreement.score;
      h.color_evidence = agreement.color_evidence;
    }
    found = best(found, kPolished, kApart, kTurned, rank);
    for (PoseHypothesis& h : found) {
      h.T = comparison_.refine(second, h.T, {first}, poses, {0.1f, 0.08f, 0.06f, 0.05f, 0.04f, 0.03f, 0.03f});
      const ViewAgreement agreement = comparison_.compare(first, second, h.T);
      h.score = agreement.score();
      h.color_spread = agreement.color_spread;
      h.color_evidence = agreement.color_evidence;
    }
    found.erase(std::remove_if(found.begin(), found.end(), [](const PoseHypothesis& h) { return !(h.score > 0); }),
                found.end());
    return best(found, static_cast<std::size_t>(p_.hypotheses), kApart, kTurned, rank);
  }

  /** \brief Those of the highest rank that are distinct. */
  static std::vector<PoseHypothesis> best(std::vector<PoseHypothesis>& all, std::size_t count, double distance,
                                          double angle, Rank rank) {
    std::stable_sort(all.begin(), all.end(), [rank](const auto& a, const auto& b) { return a.*rank > b.*rank; });
    std::vector<PoseHypothesis> chosen;
    for (const PoseHypothesis& h : all) {
      if (chosen.size() == count) break;
      if (!isKnown(h, chosen, distance, angle)) chosen.push_back(h);
    }
    return chosen;
  }

  static bool isKnown(const PoseHypothesis& h, const std::vector<PoseHypothesis>& known, double distance,
                      double angle) {
    return std::any_of(known.begin(), known.end(),
                       [&](const PoseHypothesis& k) { return !distinct(k.T, h.T, distance, angle); });
  }

  static constexpr std::size_t kPeaks = 80;       ///< translations of a rotation that are looked at
  static constexpr std::size_t kFromShape = 150;  ///< guesses from shape that are refined
  static constexpr std::size_t kFromPaint = 100;  ///< guesses from paint that are refined
  static constexpr std::size_t kMatches = 4000;   ///< of paint, among which those are chosen
  static constexpr std::size_t kPolished = 40;    ///< of either, those that are refined to the end
  static constexpr double kApart = 0.1;           ///< metres between hypotheses
  static constexpr double kTurned = 0.06;         ///< radians, likewise

  const AlignmentSystem& system_;
  const CoarseAlignmentParameters& p_;
  ViewComparison comparison_;
};

}  // namespace host
}  // namespace fuse_flow
