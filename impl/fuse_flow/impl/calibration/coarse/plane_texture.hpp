#pragma once

#include <fuse_flow/impl/calibration/alignment_view.hpp>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief What is painted on one plane of a view. */
struct PlaneTexture {
  struct Point {
    float x, y;  ///< along the plane, metres
    float luma;  ///< grey levels
  };
  Eigen::Matrix3d axes;       ///< x and y along the plane, z its normal; camera's frame
  double height;              ///< along the normal, metres
  std::vector<Point> points;  ///< block by block
};

/** \brief The largest planes of one direction in a view that has colour: a floor, what stands on it, a shelf. */
class PlaneTextures {
 public:
  /** \param normal of the planes, unit, camera's frame */
  PlaneTextures(const AlignmentView& view, const Eigen::Vector3d& normal) {
    std::vector<Block> left = facing(view, normal);
    while (planes_.size() < kMost && left.size() >= kSmallest) {
      PlaneTexture plane;
      plane.axes << normal.unitOrthogonal(), normal.cross(normal.unitOrthogonal()), normal;
      plane.height = densestHeight(left);
      std::vector<Block> beside;
      for (const Block& block : left) {
        const double off = std::fabs(block.height - plane.height);
        const Eigen::Vector3d p = plane.axes.transpose() * block.p;
        if (off < kThickness)
          plane.points.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), block.luma});
        if (off > 2 * kThickness) beside.push_back(block);
      }
      left.swap(beside);
      if (plane.points.size() >= kSmallest) planes_.push_back(std::move(plane));
    }
  }

  const std::vector<PlaneTexture>& planes() const { return planes_; }

 private:
  struct Block {
    Eigen::Vector3d p;
    double height;
    float luma;
  };

  static std::vector<Block> facing(const AlignmentView& view, const Eigen::Vector3d& normal) {
    std::vector<Block> blocks;
    if (view.missing() || !view.hasColor()) return blocks;
    for (int v = 0; v < view.height(); ++v)
      for (int u = 0; u < view.width(); ++u) {
        const Vec3& n = view.normal(u, v);
        const float luma = view.luma(u, v);
        if (!(Eigen::Vector3d(n.x, n.y, n.z).dot(normal) > kAlike) || luma < 0) continue;
        const Vec3 p = view.point(u, v);
        const Eigen::Vector3d x(p.x, p.y, p.z);
        if (!(x.norm() < kFarthest)) continue;
        blocks.push_back({x, x.dot(normal), luma});
      }
    return blocks;
  }

  /** \brief Mean of those around the fullest bin of a histogram. */
  static double densestHeight(const std::vector<Block>& blocks) {
    const auto lower = [](const Block& a, const Block& b) { return a.height < b.height; };
    const auto range = std::minmax_element(blocks.begin(), blocks.end(), lower);
    const double low = range.first->height - kThickness;  // an empty bin at either end
    std::vector<std::size_t> counts(static_cast<std::size_t>((range.second->height - low) / kThickness) + 2, 0);
    for (const Block& block : blocks) ++counts[static_cast<std::size_t>((block.height - low) / kThickness)];
    const auto around = [&](std::size_t k) { return counts[k - 1] + 2 * counts[k] + counts[k + 1]; };
    std::size_t fullest = 1;
    for (std::size_t k = 1; k + 1 < counts.size(); ++k)
      if (around(k) > around(fullest)) fullest = k;
    const double middle = low + kThickness * (static_cast<double>(fullest) + 0.5);
    double sum = 0, count = 0;
    for (const Block& block : blocks)
      if (std::fabs(block.height - middle) < 1.5 * kThickness) {
        sum += block.height;
        count += 1;
      }
    return sum / count;
  }

  static constexpr std::size_t kMost = 3;
  static constexpr std::size_t kSmallest = 300;  ///< blocks
  static constexpr double kAlike = 0.94;         ///< cosine of the largest angle to the normal
  static constexpr double kThickness = 0.05;     ///< metres either side
  static constexpr double kFarthest = 20;        ///< metres; farther on, blocks lie too far apart to tell paint

  std::vector<PlaneTexture> planes_;
};

}  // namespace host
}  // namespace fuse_flow
