#pragma once

#include <fuse_flow/impl/calibration/coarse/level_directions.hpp>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Rotations of a second camera's frame into that of a first that bring surface directions of both together. */
class RotationCandidates {
 public:
  /** \param max_roll of LevelDirections */
  RotationCandidates(const std::vector<Eigen::Vector3d>& first, const std::vector<Eigen::Vector3d>& second,
                     double max_roll)
      : level_(first, second, max_roll) {
    addFromPairs(first, second);
    // A floor alone leaves the turn about its normal open.
    addFromTurns(level_.first(), level_.second());
  }

  const std::vector<Eigen::Matrix3d>& rotations() const { return rotations_; }

 private:
  static constexpr double kPi = 3.14159265358979323846;
  static constexpr double kAlike = 0.14;        ///< radians between what may be the same
  static constexpr double kLeast = 0.35;        ///< radians between two directions that tell a rotation
  static constexpr double kApart = 0.1;         ///< radians between rotations worth trying both
  static constexpr std::size_t kStrongest = 2;  ///< directions about which all turns are tried
  static constexpr int kTurns = 36;

  static double angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::acos(std::max(-1.0, std::min(1.0, a.dot(b))));
  }

  /** \brief The smallest rotation that brings one unit vector onto another. Not Eigen's FromTwoVectors(), whose singular
   *  value decomposition takes seconds to compile. */
  static Eigen::Matrix3d shortestTurn(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const double cosine = from.dot(to);
    const Eigen::Vector3d axis = from.cross(to);
    if (cosine < -1 + 1e-12) {  // half a turn about anything across
      const Eigen::Vector3d across = from.unitOrthogonal();
      return 2 * across * across.transpose() - Eigen::Matrix3d::Identity();
    }
    Eigen::Matrix3d K;
    K << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
    return Eigen::Matrix3d::Identity() + K + K * K / (1 + cosine);
  }

  /** \brief Between the two directions, so that the errors of both count alike. */
  static Eigen::Matrix3d frame(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    Eigen::Matrix3d F;
    F << (a + b).normalized(), (a - b).normalized(), a.cross(b).normalized();
    return F;
  }

  void addFromPairs(const std::vector<Eigen::Vector3d>& first, const std::vector<Eigen::Vector3d>& second) {
    for (std::size_t a = 0; a < first.size(); ++a)
      for (std::size_t b = a + 1; b < first.size(); ++b) {
        const double between = angle(first[a], first[b]);
        if (between < kLeast || between > kPi - kLeast) continue;
        for (std::size_t c = 0; c < second.size(); ++c)
          for (std::size_t d = 0; d < second.size(); ++d)
            if (c != d && std::fabs(angle(second[c], second[d]) - between) < kAlike)
              add(frame(first[a], first[b]) * frame(second[c], second[d]).transpose());
      }
  }

  void addFromTurns(const std::vector<Eigen::Vector3d>& first, const std::vector<Eigen::Vector3d>& second) {
    for (std::size_t a = 0; a < std::min(kStrongest, first.size()); ++a)
      for (std::size_t c = 0; c < std::min(kStrongest, second.size()); ++c) {
        const Eigen::Matrix3d R = shortestTurn(second[c], first[a]);
        for (int k = 0; k < kTurns; ++k) add(Eigen::AngleAxisd(2 * kPi * k / kTurns, first[a]).toRotationMatrix() * R);
      }
  }

  void add(const Eigen::Matrix3d& R) {
    if (!floorsMeet(R)) return;
    for (const Eigen::Matrix3d& other : rotations_)
      if ((other.transpose() * R).trace() > 1 + 2 * std::cos(kApart)) return;
    rotations_.push_back(R);
  }

  bool floorsMeet(const Eigen::Matrix3d& R) const {
    if (!level_.floors()) return true;
    for (const Eigen::Vector3d& a : level_.first())
      for (const Eigen::Vector3d& b : level_.second())
        if (angle(a, R * b) < kAlike) return true;
    return false;
  }

  LevelDirections level_;
  std::vector<Eigen::Matrix3d> rotations_;
};

}  // namespace host
}  // namespace fuse_flow
