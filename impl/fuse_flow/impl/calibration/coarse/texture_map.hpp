#pragma once

#include <fuse_flow/impl/calibration/coarse/plane_texture.hpp>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Grey levels of a plane, cell by cell: of those cells that hold several blocks, and what lies between them. */
class TextureMap {
 public:
  /** \brief Empty where there is no such cell. \param turn of the plane about its normal, radians  \param cell_size metres */
  void assign(const PlaneTexture& plane, double turn, float cell_size) {
    addBlocks(plane, turn, cell_size);
    Eigen::AlignedBox2i box;
    for (int y = 0; y < 2 * kReach; ++y)
      for (int x = 0; x < 2 * kReach; ++x)
        if (cells_[cellAt(x, y)].blocks >= kFewest) box.extend(Eigen::Vector2i(x, y));
    width_ = box.isEmpty() ? 0 : box.sizes().x() + 1;
    height_ = box.isEmpty() ? 0 : box.sizes().y() + 1;
    levels_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0.0f);
    known_.assign(levels_.size(), 0.0f);
    if (empty()) return;
    low_ = cell_size * (box.min().array() - kReach).cast<float>();
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const Cell& cell = cells_[cellAt(box.min().x() + x, box.min().y() + y)];
        if (cell.blocks < kFewest) continue;
        levels_[index(x, y)] = cell.sum / static_cast<float>(cell.blocks);
        known_[index(x, y)] = 1;
      }
    subtractMean();
  }

  bool empty() const { return levels_.empty(); }
  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  /** \brief Of the corner where cell (0, 0) begins, metres. */
  const Eigen::Vector2f& low() const { return low_; }
  /** \brief Relative to their mean; 0 where nothing is known. */
  const std::vector<float>& levels() const { return levels_; }
  /** \brief 1 where there is a level, else 0. */
  const std::vector<float>& known() const { return known_; }

 private:
  /** \brief Blocks that a cell needs. */
  static constexpr int kFewest = 2;
  /** \brief Cells from the camera on in each direction, beyond which none is looked at: memory and time stay bounded. */
  static constexpr int kReach = 100;

  struct Cell {
    float sum;  ///< of grey levels
    int blocks;
  };

  static std::size_t cellAt(int x, int y) {
    return static_cast<std::size_t>(y) * 2 * kReach + static_cast<std::size_t>(x);
  }

  void addBlocks(const PlaneTexture& plane, double turn, float cell_size) {
    const auto cosine = static_cast<float>(std::cos(turn)), sine = static_cast<float>(std::sin(turn));
    constexpr auto reach = static_cast<float>(kReach);
    cells_.assign(cellAt(0, 2 * kReach), Cell{0, 0});
    for (const PlaneTexture::Point& p : plane.points) {
      const float x = (cosine * p.x - sine * p.y) / cell_size + reach,
                  y = (sine * p.x + cosine * p.y) / cell_size + reach;
      if (!(x >= 0 && y >= 0 && x < 2 * reach && y < 2 * reach)) continue;
      Cell& cell = cells_[cellAt(static_cast<int>(x), static_cast<int>(y))];
      cell.sum += p.luma;
      ++cell.blocks;
    }
  }

  void subtractMean() {
    double sum = 0, count = 0;
    for (std::size_t k = 0; k < levels_.size(); ++k) {
      sum += static_cast<double>(levels_[k]);
      count += static_cast<double>(known_[k]);
    }
    const auto mean = static_cast<float>(sum / std::max(1.0, count));
    for (std::size_t k = 0; k < levels_.size(); ++k) levels_[k] = known_[k] * (levels_[k] - mean);
  }

  Eigen::Vector2f low_{0, 0};
  int width_{0}, height_{0};
  std::vector<float> levels_, known_;
  std::vector<Cell> cells_;
};

}  // namespace host
}  // namespace fuse_flow
