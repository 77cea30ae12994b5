#pragma once

#include <fuse_flow/impl/calibration/coarse/hypothesis_table.hpp>
#include <fuse_flow/impl/calibration/coarse/placed_group.hpp>
#include <fuse_flow/impl/host/parallel.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Places cameras one by one, each where it agrees best with all that are placed. Begins anew from several pairs, since
 *  what two views alone make of each other may be wrong, and keeps what agrees best as a whole. */
class RigPlacement {
 public:
  RigPlacement(const AlignmentSystem& system, const CoarseAlignmentParameters& parameters, const HypothesisTable& table)
      : p_(parameters), table_(table), comparison_(system, parameters) {
    comparison_.setColorNoise(table.colorNoise());
  }

  /** \brief The largest score that the cameras reach together; without members if no two belong together. */
  PlacedGroup place(const std::vector<std::size_t>& cameras, int threads) const {
    const std::vector<Seed> seeds = findSeeds(cameras);
    std::vector<PlacedGroup> groups(seeds.size());
    parallelFor(threads, seeds.size(), [&](std::size_t k, int) { groups[k] = grow(seeds[k], cameras); });
    groups = withoutDuplicates(std::move(groups), kApart, kTurned);
    parallelFor(threads, groups.size(), [&](std::size_t k, int) { settle(groups[k]); });
    std::size_t best = 0;
    for (std::size_t k = 1; k < groups.size(); ++k)
      if (groups[k].score > groups[best].score) best = k;
    if (groups.empty() || !(groups[best].score > 0)) return {};
    for (const PlacedGroup& group : groups)
      if (group.score > static_cast<double>(p_.max_ambiguity) * groups[best].score) markContested(group, groups[best]);
    return std::move(groups[best]);
  }

  /** \brief Every member once more where it agrees best with all others. */
  void settle(PlacedGroup& group) const {
    for (int sweep = 0; sweep < kSweeps; ++sweep)
      for (const std::size_t camera : group.members) {
        const std::vector<std::size_t> others = without(group, camera);
        Eigen::Isometry3d T = group.poses[camera];
        double score = jointScore(camera, T, others, group.poses);
        const PoseHypothesis other = bestAlternative(camera, T, others, group.poses);
        if (other.score > score) T = other.T;
        score = std::max(score, other.score);
        const Eigen::Isometry3d refined = comparison_.refine(camera, T, others, group.poses, gates_);
        group.poses[camera] = jointScore(camera, refined, others, group.poses) > score ? refined : T;
      }
    group.score = 0;
    for (std::size_t i = 0; i < group.members.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        group.score += agreement(group.members[i], group.members[j], group.poses).score();
  }

  /** \brief Of a group that stands: counts of points that agree are as good some centimetres beside the right pose as at it; sums
   *  of squares are not. */
  void polish(PlacedGroup& group) const {
    for (int sweep = 0; sweep < kSweeps; ++sweep)
      for (const std::size_t camera : group.members) {
        const std::vector<std::size_t> others = without(group, camera);
        const Eigen::Isometry3d& T = group.poses[camera];
        const Eigen::Isometry3d next = comparison_.leastSquares(camera, T, others, group.poses, gates_);
        if (jointScore(camera, next, others, group.poses) > kAsGood * jointScore(camera, T, others, group.poses))
          group.poses[camera] = next;
      }
  }

  /** \brief How well the best other pose of a member explains what it shares with the others, over how well its own does; 1 if paint
   *  repeats itself. */
  double ambiguity(const PlacedGroup& group, std::size_t camera) const {
    const std::vector<std::size_t> others = without(group, camera);
    const Eigen::Isometry3d& T = group.poses[camera];
    const double score = jointScore(camera, T, others, group.poses);
    if (!(score >= static_cast<double>(p_.min_score))) return std::numeric_limits<double>::infinity();
    const JointPaint paint = jointPaint(camera, T, others, group.poses);
    double worst = 0;
    for (const PoseHypothesis& other : alternatives(camera, T, others, group.poses)) {
      worst = std::max(worst, other.score / score);
      if (other.score > kRepeats * score && jointPaint(camera, other.T, others, group.poses).repeats(paint))
        worst = std::max(worst, 1.0);
    }
    return worst;
  }

  ViewAgreement agreement(std::size_t i, std::size_t j, const std::vector<Eigen::Isometry3d>& poses) const {
    return comparison_.compare(i, j, poses[i].inverse() * poses[j]);
  }

 private:
  static constexpr double kAsGood = 0.9;   ///< share of a score that is as good
  static constexpr double kRepeats = 0.5;  ///< share of it that a pose has at which only paint repeats itself

  struct Seed {
    std::size_t first, second;
    PoseHypothesis hypothesis;
  };
  struct Candidate {
    std::size_t camera;
    Eigen::Isometry3d T;
    double score;
  };

  static constexpr std::size_t kSeeds = 16;
  static constexpr int kSweeps = 2;
  static constexpr std::size_t kRefined = 8;       ///< candidates for the next place
  static constexpr std::size_t kAlternatives = 6;  ///< to a place, that are refined
  static constexpr double kApart = 0.15;           ///< metres between poses that are two different answers
  static constexpr double kTurned = 0.1;           ///< radians, likewise

  std::vector<Seed> findSeeds(const std::vector<std::size_t>& cameras) const {
    std::vector<Seed> seeds;
    for (const std::size_t i : cameras)
      for (const std::size_t j : cameras) {
        if (i >= j) continue;
        std::vector<Eigen::Isometry3d> poses;
        table_.append(j, i, Eigen::Isometry3d::Identity(), poses);
        std::vector<Seed> of_pair;  // by shape and by paint: which of them is better, only now both are asked
        for (const Eigen::Isometry3d& T : poses) of_pair.push_back({i, j, {T, comparison_.compare(i, j, T).score()}});
        keepBest(of_pair, kSeeds / 4);
        seeds.insert(seeds.end(), of_pair.begin(), of_pair.end());
      }
    keepBest(seeds, kSeeds);
    return seeds;
  }

  static void keepBest(std::vector<Seed>& seeds, std::size_t most) {
    std::stable_sort(seeds.begin(), seeds.end(),
                     [](const Seed& a, const Seed& b) { return a.hypothesis.score > b.hypothesis.score; });
    if (seeds.size() > most) seeds.resize(most);
  }

  PlacedGroup grow(const Seed& seed, const std::vector<std::size_t>& cameras) const {
    PlacedGroup group;
    group.poses.assign(table_.cameras(), Eigen::Isometry3d::Identity());
    group.members = {seed.first};
    std::vector<std::size_t> left;
    for (const std::size_t camera : cameras)
      if (camera != seed.first) left.push_back(camera);
    std::vector<Candidate> candidates;
    Candidate next{seed.second, seed.hypothesis.T, seed.hypothesis.score};
    while (next.score >= static_cast<double>(p_.min_score)) {
      for (Candidate& c : candidates)
        c.score += comparison_.compare(next.camera, c.camera, next.T.inverse() * c.T).score();
      group.poses[next.camera] = next.T;
      group.score += next.score;
      const bool seeding = group.members.size() == 1;
      group.members.push_back(next.camera);
      left.erase(std::find(left.begin(), left.end(), next.camera));
      candidates.erase(std::remove_if(candidates.begin(), candidates.end(),
                                      [&](const Candidate& c) { return c.camera == next.camera; }),
                       candidates.end());
      if (seeding) addCandidates(seed.first, left, group, candidates);
      addCandidates(next.camera, left, group, candidates);
      if (candidates.empty()) break;
      next = bestRefined(candidates, group);
    }
    if (group.members.size() < 2) group.members.clear();
    return group;
  }

  /** \brief Of the candidates that score most, the one that does when refined. */
  Candidate bestRefined(std::vector<Candidate>& candidates, const PlacedGroup& group) const {
    const std::size_t count = std::min(kRefined, candidates.size());
    const auto more = [](const Candidate& a, const Candidate& b) { return a.score > b.score; };
    std::stable_sort(candidates.begin(), candidates.end(), more);
    std::vector<Candidate> refined(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(count));
    for (Candidate& c : refined) {
      c.T = comparison_.refine(c.camera, c.T, group.members, group.poses, gates_);
      c.score = jointScore(c.camera, c.T, group.members, group.poses);
    }
    return *std::min_element(refined.begin(), refined.end(), more);
  }

  void addCandidates(std::size_t beside, const std::vector<std::size_t>& cameras, const PlacedGroup& group,
                     std::vector<Candidate>& candidates) const {
    for (const std::size_t camera : cameras) {
      std::vector<Eigen::Isometry3d> poses;
      table_.append(camera, beside, group.poses[beside], poses);
      for (const Eigen::Isometry3d& T : poses)
        candidates.push_back({camera, T, jointScore(camera, T, group.members, group.poses)});
    }
  }

  double score(std::size_t camera, const Eigen::Isometry3d& T, std::size_t other,
               const std::vector<Eigen::Isometry3d>& poses) const {
    return comparison_.compare(other, camera, poses[other].inverse() * T).score();
  }

  double jointScore(std::size_t camera, const Eigen::Isometry3d& T, const std::vector<std::size_t>& others,
                    const std::vector<Eigen::Isometry3d>& poses) const {
    double sum = 0;
    for (const std::size_t other : others) sum += score(camera, T, other, poses);
    return sum;
  }

  /** \brief What paint says about a camera beside others. */
  struct JointPaint {
    double points{0};    ///< at which views confirm each other
    double strength{0};  ///< mean of artanh(r) over those, r the correlation of brightness

    /** \brief Whether it agrees as well as at another pose, on less of it: tiles that are shifted by one overlap less, and no
     *  worse. */
    bool repeats(const JointPaint& other) const {
      constexpr double as_well = 0.9, enough = 0.4;
      return other.strength > 0 && strength > as_well * other.strength && points > enough * other.points;
    }
  };

  JointPaint jointPaint(std::size_t camera, const Eigen::Isometry3d& T, const std::vector<std::size_t>& others,
                        const std::vector<Eigen::Isometry3d>& poses) const {
    JointPaint sum;
    for (const std::size_t other : others) {
      const ViewAgreement a = comparison_.compare(other, camera, poses[other].inverse() * T);
      sum.points += a.confirmed;
      sum.strength += a.color_evidence * std::sqrt(a.confirmed);
    }
    if (sum.points > 0) sum.strength /= sum.points;
    return sum;
  }

  /** \brief Puts the two groups together so that most cameras agree; the others are contested. */
  static void markContested(const PlacedGroup& other, PlacedGroup& group) {
    std::vector<std::size_t> fewest = group.members;
    for (const std::size_t anchor : group.members) {
      if (std::find(other.members.begin(), other.members.end(), anchor) == other.members.end()) continue;
      const Eigen::Isometry3d T = group.poses[anchor] * other.poses[anchor].inverse();
      std::vector<std::size_t> elsewhere;
      for (const std::size_t i : group.members)
        if (std::find(other.members.begin(), other.members.end(), i) != other.members.end() &&
            distinct(T * other.poses[i], group.poses[i], kApart, kTurned))
          elsewhere.push_back(i);
      if (elsewhere.size() < fewest.size()) fewest = elsewhere;
    }
    if (fewest.size() < group.members.size())
      group.contested.insert(group.contested.end(), fewest.begin(), fewest.end());
  }

  /** \brief The best pose of a camera that is not the one given. */
  PoseHypothesis bestAlternative(std::size_t camera, const Eigen::Isometry3d& T, const std::vector<std::size_t>& others,
                                 const std::vector<Eigen::Isometry3d>& poses) const {
    PoseHypothesis best;
    for (const PoseHypothesis& other : alternatives(camera, T, others, poses))
      if (other.score > best.score) best = other;
    return best;
  }

  /** \brief The best poses of a camera that are not the one given, refined. */
  std::vector<PoseHypothesis> alternatives(std::size_t camera, const Eigen::Isometry3d& T,
                                           const std::vector<std::size_t>& others,
                                           const std::vector<Eigen::Isometry3d>& poses) const {
    std::vector<Eigen::Isometry3d> all;
    for (const std::size_t other : others) table_.append(camera, other, poses[other], all);
    std::vector<PoseHypothesis> scored;
    for (const Eigen::Isometry3d& A : all)
      if (distinct(A, T, kApart, kTurned)) scored.push_back({A, jointScore(camera, A, others, poses)});
    std::stable_sort(scored.begin(), scored.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
    std::vector<PoseHypothesis> found;
    for (std::size_t k = 0; k < std::min(kAlternatives, scored.size()); ++k) {
      const Eigen::Isometry3d A = comparison_.refine(camera, scored[k].T, others, poses, gates_);
      if (!distinct(A, T, kApart, kTurned)) continue;
      // What comes back to it when looked at from farther is where a refinement stopped, not another answer.
      if (!distinct(comparison_.refine(camera, A, others, poses, wide_gates_), T, kApart, kTurned)) continue;
      found.push_back({A, jointScore(camera, A, others, poses)});
    }
    return found;
  }

  static std::vector<std::size_t> without(const PlacedGroup& group, std::size_t camera) {
    std::vector<std::size_t> others = group.members;
    others.erase(std::find(others.begin(), others.end(), camera));
    return others;
  }

  const CoarseAlignmentParameters& p_;
  const HypothesisTable& table_;
  ViewComparison comparison_;
  const std::vector<float> gates_{0.1f, 0.08f, 0.06f, 0.04f, 0.03f};  ///< of refinements, metres
  /** \brief … of what may be another answer: from as far off as hypotheses are. */
  const std::vector<float> wide_gates_{0.25f, 0.2f, 0.15f, 0.1f, 0.08f, 0.06f, 0.04f, 0.03f};
};

}  // namespace host
}  // namespace fuse_flow
