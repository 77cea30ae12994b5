#pragma once

#include <fuse_flow/impl/calibration/alignment_system.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Where a view could lie beside another when its rotation is known: every pair of points with like normals votes for
 *  the translation that brings one onto the other. Parallel walls vote for a layer of cells, three of them for the cell where
 *  their layers meet. */
class TranslationVote {
 public:
  explicit TranslationVote(float cell_size) : cell_size_(cell_size) {}

  /** \brief The centres of the cells with most votes, none beside one with more. */
  std::vector<Eigen::Vector3d> peaks(const std::vector<AlignmentSample>& first,
                                     const std::vector<AlignmentSample>& second, const Eigen::Matrix3d& R,
                                     std::size_t count) {
    collect(first, second, R);
    std::vector<Eigen::Vector3d> result;
    if (translations_.empty()) return result;
    fill();
    std::vector<std::pair<std::uint32_t, std::size_t>> tops;
    for (int z = 1; z + 1 < size_[2]; ++z)
      for (int y = 1; y + 1 < size_[1]; ++y)
        for (int x = 1; x + 1 < size_[0]; ++x) {
          const std::size_t k = index(x, y, z);
          if (votes_[k] >= kFewest && isTop(k)) tops.emplace_back(votes_[k], k);
        }
    const auto more = [](const auto& a, const auto& b) {
      return a.first != b.first ? a.first > b.first : a.second < b.second;
    };
    const auto end = tops.begin() + static_cast<std::ptrdiff_t>(std::min(count, tops.size()));
    std::partial_sort(tops.begin(), end, tops.end(), more);
    for (auto top = tops.begin(); top != end; ++top) {
      const auto k = static_cast<int>(top->second);
      const Eigen::Vector3i cell(k % size_[0], k / size_[0] % size_[1], k / size_[0] / size_[1]);
      const Eigen::Vector3d middle = cell.cast<double>() + Eigen::Vector3d::Constant(0.5);
      result.push_back(low_.cast<double>() + static_cast<double>(cell_size_) * middle);
    }
    return result;
  }

 private:
  static constexpr float kNormalCosine = 0.94f;  ///< 20°
  static constexpr std::uint32_t kFewest = 8;    ///< votes of a cell that count

  void collect(const std::vector<AlignmentSample>& first, const std::vector<AlignmentSample>& second,
               const Eigen::Matrix3d& R) {
    RigidTransform rotation;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) rotation.r[3 * row + column] = static_cast<float>(R(row, column));
    translations_.clear();
    for (const AlignmentSample& s : second) {
      const Vec3 q = rotate(rotation, s.p), n = rotate(rotation, s.n);
      for (const AlignmentSample& f : first)
        if (dot(f.n, n) > kNormalCosine) translations_.push_back(f.p - q);
    }
  }

  void fill() {
    Eigen::AlignedBox3f box;
    for (const Vec3& t : translations_) box.extend(Eigen::Vector3f(t.x, t.y, t.z));
    low_ = box.min() - Eigen::Vector3f::Constant(cell_size_);  // an empty layer all around
    for (int k = 0; k < 3; ++k) size_[k] = static_cast<int>((box.max()[k] - low_[k]) / cell_size_) + 2;
    votes_.assign(
        static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(size_[2]),
        0);
    const float per_cell = 1 / cell_size_;
    for (const Vec3& t : translations_)
      ++votes_[index(static_cast<int>((t.x - low_.x()) * per_cell), static_cast<int>((t.y - low_.y()) * per_cell),
                     static_cast<int>((t.z - low_.z()) * per_cell))];
  }

  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size_[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size_[0]) +
           static_cast<std::size_t>(x);
  }

  bool isTop(std::size_t k) const {
    const std::size_t row = static_cast<std::size_t>(size_[0]), layer = row * static_cast<std::size_t>(size_[1]);
    for (const std::size_t step : {std::size_t{1}, row, layer})
      if (votes_[k - step] > votes_[k] || votes_[k + step] > votes_[k]) return false;
    return true;
  }

  float cell_size_;
  std::vector<Vec3> translations_;
  std::vector<std::uint32_t> votes_;
  Eigen::Vector3f low_{0, 0, 0};
  int size_[3]{0, 0, 0};
};

}  // namespace host
}  // namespace fuse_flow
