#pragma once

#include <fuse_flow/impl/calibration/coarse/brightness_correlation.hpp>
#include <fuse_flow/impl/calibration/coarse/texture_map.hpp>
#include <fuse_flow/impl/host/wide_vectors.hpp>

#include <algorithm>
#include <array>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief A pose at which what is painted on a plane of two views agrees. */
struct TextureMatch {
  Eigen::Isometry3d T;  ///< of the second camera in the frame of the first
  double evidence;      ///< of BrightnessCorrelation
};

/** \brief Poses of two cameras by what is painted on a plane that both see: the one's grey levels laid over the other's, at all
 *  turns and shifts. What stands on a floor tells where it is to a hand's width; its paint, where nothing stands. */
class TextureSearch {
 public:
  /** \param cell_size metres  \param most poses that are kept of all searches */
  TextureSearch(float cell_size, std::size_t most) : cell_size_(cell_size), most_(most) {}

  /** \brief Adds all poses that agree better than those beside them, and keeps the best. */
  void search(const PlaneTexture& first, const PlaneTexture& second, std::vector<TextureMatch>& found) {
    a_.assign(first, 0, cell_size_);
    if (a_.empty()) return;
    for (int k = 0; k < kTurns; ++k) {
      const double turn = 2 * kPi * k / kTurns;
      b_.assign(second, turn, cell_size_);
      if (b_.empty()) continue;
      correlate();
      const Eigen::Matrix3d R =
          first.axes * Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix() * second.axes.transpose();
      for (int y = 1; y + 1 < height_; ++y)
        for (int x = 1; x + 1 < width_; ++x) {
          if (!isTop(x, y)) continue;
          TextureMatch match;
          match.T.setIdentity();
          match.T.linear() = R;
          match.T.translation() = first.axes * translation(x, y, first.height - second.height);
          match.evidence = evidence_[index(x, y)];
          found.push_back(match);
        }
      keepBest(found);
    }
  }

 private:
  static constexpr double kPi = 3.14159265358979323846;
  static constexpr int kTurns = 72;
  static constexpr double kLeast = 2;  ///< evidence

  void keepBest(std::vector<TextureMatch>& found) const {
    if (found.size() <= most_) return;
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.evidence > b.evidence; });
    found.resize(most_);
  }

  /** \brief Shifts: at (x, y) cell (u, v) of the second map lies on cell (u + x − (its width − 1), v + y − (its height − 1)) of the
   *  first. */
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  Eigen::Vector3d translation(int x, int y, double height) const {
    const auto cell = static_cast<double>(cell_size_);
    const Eigen::Vector2d corners = (a_.low() - b_.low()).cast<double>();
    return {corners.x() + cell * (x - (b_.width() - 1)), corners.y() + cell * (y - (b_.height() - 1)), height};
  }

  bool isTop(int x, int y) const {
    const double here = evidence_[index(x, y)];
    if (!(here > kLeast)) return false;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if (evidence_[index(x + dx, y + dy)] > here) return false;
    return true;
  }

  /** \brief Evidence of all shifts. */
  void correlate() {
    width_ = a_.width() + b_.width() - 1;
    height_ = a_.height() + b_.height() - 1;
    const std::size_t shifts = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    for (std::vector<double>& sums : sums_) sums.assign(shifts, 0.0);
    // The other way round, so that a step of the shift is a step in memory.
    levels_.assign(b_.levels().rbegin(), b_.levels().rend());
    known_.assign(b_.known().rbegin(), b_.known().rend());
    for (int y = 0; y < a_.height(); ++y)
      for (int x = 0; x < a_.width(); ++x) {
        if (!(a_.known()[a_.index(x, y)] > 0)) continue;
        const auto level = static_cast<double>(a_.levels()[a_.index(x, y)]);
        for (int v = 0; v < b_.height(); ++v) addRow(level, b_.index(0, v), index(x, y + v));
      }
    evidence_.resize(shifts);
    for (std::size_t k = 0; k < shifts; ++k)
      evidence_[k] = BrightnessCorrelation{sums_[0][k], sums_[1][k], sums_[2][k], sums_[3][k], sums_[4][k], sums_[5][k]}
                         .evidence();
  }

  /** \brief One cell of the first map and a row of the second's, each at the shift that brings them together. */
  void addRow(double level, std::size_t row, std::size_t shift) {
    const int width = b_.width();
    const double* known = known_.data() + row;
    const double* levels = levels_.data() + row;
    std::array<double*, 6> sums;
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k] = sums_[k].data() + shift;
    inWideVectors([=] {
      double* __restrict n = sums[0];
      double* __restrict a = sums[1];
      double* __restrict b = sums[2];
      double* __restrict aa = sums[3];
      double* __restrict bb = sums[4];
      double* __restrict ab = sums[5];
      const double square = level * level;
      for (int u = 0; u < width; ++u) {
        n[u] += known[u];
        a[u] += level * known[u];
        b[u] += levels[u];
        aa[u] += square * known[u];
        bb[u] += levels[u] * levels[u];
        ab[u] += level * levels[u];
      }
    });
  }

  float cell_size_;
  std::size_t most_;
  TextureMap a_, b_;
  int width_{0}, height_{0};  ///< of the map of shifts
  // In double: what a long sum of floats loses looks like agreement where nothing is painted.
  std::array<std::vector<double>, 6> sums_;  ///< of BrightnessCorrelation, in the order of its members, shift by shift
  std::vector<double> evidence_;             ///< shift by shift
  std::vector<double> levels_, known_;       ///< of the second map
};

}  // namespace host
}  // namespace fuse_flow
