#pragma once

#include <fuse_flow/impl/fusion/coarse_grid.hpp>
#include <fuse_flow/impl/host/wide_vectors.hpp>
#include <fuse_flow/impl/sensors/rig_geometry.hpp>
#include <fuse_flow/math/box.h>
#include <fuse_flow/math/cell.h>
#include <fuse_flow/math/confidence.h>

#include <cstdint>
#include <cstring>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief What the points of one row of a view weigh (eq. 8 and 9), and where they go from one coarse cell into another: loops without
 *  branches over arrays, which compilers vectorise, and a look at the few pixels where something changes. One a thread, with the
 *  memory it keeps. */
class PointRow {
 public:
  /** \brief Rows are at most so wide from now on. */
  void reserve(std::size_t width) {
    if (width < x_.size()) return;
    border_.resize(width + kAhead);
    for (std::vector<float>* along : {&x_, &y_, &z_}) along->resize(width);
    for (std::vector<std::int32_t>* along : {&cell_x_, &cell_y_, &cell_z_}) along->resize(width);
  }

  /** \brief Eq. 9: what the measurements of the row weigh. \param z metres, 0 where there is no measurement
   *  \param weights the pixels' confidence, becomes their weight \returns how many measurements there are */
  static std::size_t weigh(const MeasurementGate& gate, const float* z, int width, float* weights) {
    std::int32_t measured = 0;
    inWideVectors([&] {
      const MeasurementGate g = gate;  // copies: the compiler then knows that nothing overwrites them
      const int n = width;
      const float* __restrict depth = z;
      float* __restrict weight = weights;
      std::int32_t count = 0;
      for (int u = 0; u < n; ++u) {
        const bool there = depth[u] > 0;
        const float w = g.weight(weight[u], depth[u]);
        weight[u] = there ? w : 0.0f;
        count += there;
      }
      measured = count;
    });
    return static_cast<std::size_t>(measured);
  }

  /** \brief Eq. 8, and the coarse cell of each point. \param u of the first pixel  \param crop_box what is outside weighs nothing  \param z as of weigh()
   *  \param weights of weigh(), kept \returns how many weigh something */
  std::size_t place(const ViewGeometry& view, int u, int v, const Box& crop_box, float cell_size, const float* z,
                    int width, float* weights) {
    width_ = width;
    weight_ = weights;
    std::size_t gated = 0;
    view.withRays(u, v, [&](const auto& ray) {
      inWideVectors([&, this] {
        gated = placeAll(width_, ray, view.T_world_camera, crop_box, 1.0f / cell_size, z, weight_, x_.data(), y_.data(),
                         z_.data(), cell_x_.data(), cell_y_.data(), cell_z_.data());
      });
    });
    return gated;
  }

  /** \brief Hands the row's points on, run by run. \param first number of the row's first */
  void addTo(RunBuilder& builder, std::uint32_t first) {
    findBorders();
    int begin = 0;
    for (int u = nextBorder(0); u < width_; u = nextBorder(u + 1)) {
      hand(builder, first, begin, u);
      begin = u;
    }
    hand(builder, first, begin, width_);
  }

 private:
  // Functions, whose arguments compilers believe to be of different arrays.
  template <typename RayOf>
  static std::size_t placeAll(int width, RayOf ray, RigidTransform T_world_camera, Box crop_box,
                              float inverse_cell_size, const float* __restrict depth, float* __restrict weight,
                              float* __restrict x, float* __restrict y, float* __restrict z,
                              std::int32_t* __restrict cell_x, std::int32_t* __restrict cell_y,
                              std::int32_t* __restrict cell_z) {
    std::int32_t gated = 0;
    for (std::size_t u = 0; u < static_cast<std::size_t>(width); ++u) {
      const Vec3 p = T_world_camera * pointOnRay({ray.x(u), ray.y(u)}, depth[u]);
      const float w = crop_box.contains(p) ? weight[u] : 0.0f;
      weight[u] = w;
      x[u] = p.x;
      y[u] = p.y;
      z[u] = p.z;
      cell_x[u] = cellAlong(inverse_cell_size, p.x);
      cell_y[u] = cellAlong(inverse_cell_size, p.y);
      cell_z[u] = cellAlong(inverse_cell_size, p.z);
      gated += w > 0;
    }
    return static_cast<std::size_t>(gated);
  }

  /** \brief The coarse cell that a coordinate falls into. Beyond the cells that have a key lies one more, for all of space. */
  static std::int32_t cellAlong(float inverse_cell_size, float metres) {
    constexpr float limit = static_cast<float>(kMaxCellCoordinate + 1);
    const float cells = inverse_cell_size * metres;
    const float low = cells > -limit ? cells : -limit;  // what is not a number too
    return floorToInt(low < limit ? low : limit);
  }

  /** \brief Pixels that begin something else than their left neighbours: a point after none, none after a point, another cell. */
  void findBorders() {
    inWideVectors([this] {
      const std::int32_t* __restrict x = cell_x_.data(), * __restrict y = cell_y_.data(), * __restrict z = cell_z_.data();
      const float* __restrict weight = weight_;
      std::uint8_t* __restrict border = border_.data();
      const int width = width_;
      for (int u = 1; u < width; ++u) {
        const bool here = weight[u] > 0, before = weight[u - 1] > 0;
        const bool moved = (x[u] != x[u - 1]) | (y[u] != y[u - 1]) | (z[u] != z[u - 1]);
        border[u] = (here != before) | (here & moved);
      }
    });
    border_[0] = 0;
    std::memset(border_.data() + width_, 1, kAhead);  // stops the search
  }

  /** \brief The first border from a pixel on, eight at a time; the row's end if there is none. */
  int nextBorder(int u) const {
    for (;; u += kAhead) {
      std::uint64_t eight;
      std::memcpy(&eight, border_.data() + u, sizeof eight);
      if (eight == 0) continue;
      while (border_[static_cast<std::size_t>(u)] == 0) ++u;
      return u;
    }
  }

  /** \brief Pixels of one cell, or of none. */
  void hand(RunBuilder& builder, std::uint32_t first, int begin, int end) const {
    const auto k = static_cast<std::size_t>(begin);
    if (begin < end && weight_[k] > 0)
      builder.add(first + static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end - begin),
                  {x_[k], y_[k], z_[k]});
  }

  static constexpr int kAhead = 8;

  int width_{0};
  float* weight_{nullptr};
  std::vector<float> x_, y_, z_;  // world frame, metres
  std::vector<std::int32_t> cell_x_, cell_y_, cell_z_;
  std::vector<std::uint8_t> border_;
};

}  // namespace host
}  // namespace fuse_flow
