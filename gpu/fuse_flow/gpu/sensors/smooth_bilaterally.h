#pragma once

#include <fuse_flow/gpu/sensors/frame_views.h>
#include <fuse_flow/sensors/preprocessing.h>

#include <cmath>
#include <cstring>

namespace fuse_flow {
namespace gpu {

/** \brief Sum of depths, and how many. */
struct BilateralCell {
  float sum, weight;
};

/** \brief The bilateral grid of pcl::FastBilateralFilter over one depth map: space and depth, coarsely. Sums are taken in that
 *  filter's order, so that the result is its result, bit by bit. */
struct BilateralGrid {
  static constexpr std::uint32_t kPadding = 2;

  std::uint32_t width, height, depth;
  float sigma_s, sigma_r;
  /** \brief Least and largest depth, metres. */
  float least, largest;

  FUSE_FLOW_HD std::uint32_t place(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return (x * height + y) * depth + z;
  }
  FUSE_FLOW_HD std::uint32_t cellOfPixel(int u) const {
    return static_cast<std::uint32_t>(static_cast<float>(u) / sigma_s + 0.5f) + kPadding;
  }
  FUSE_FLOW_HD std::uint32_t cellOfDepth(float z) const {
    return static_cast<std::uint32_t>((z - least) / sigma_r + 0.5f) + kPadding;
  }
  /** \brief A first, or last, pixel that may belong to a cell. */
  FUSE_FLOW_HD int pixelBefore(std::uint32_t cell, float half, int size) const {
    const float center = static_cast<float>(cell) - static_cast<float>(kPadding);
    return static_cast<int>(
        clampTo((center + half) * sigma_s + (half < 0 ? -2.0f : 2.0f), 0.0f, static_cast<float>(size - 1)));
  }
};

/** \brief Least and largest depth of a view, as the bits of floats ≥ 0, whose order is that of the floats; the largest
 *  inverted. */
struct DepthBounds {
  const float* z;
  std::uint32_t* least;
  std::uint32_t* inverted_largest;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    if (!(z[k] > 0)) return;
    std::uint32_t bits;
    memcpy(&bits, &z[k], sizeof(bits));
    atomicMinTo(least, bits);
    atomicMinTo(inverted_largest, ~bits);
  }
};

/** \brief One column of the grid: the depths of its pixels. Pixels without a measurement count as the largest depth, as in
 *  PCL. */
struct FillBilateralColumn {
  BilateralGrid grid;
  const DeviceView* view;
  const float* z;
  BilateralCell* cells;

  FUSE_FLOW_HD void operator()(std::uint32_t column) const {
    const std::uint32_t x = column / grid.height, y = column - x * grid.height;
    const Intrinsics& K = view->model.intrinsics;
    const int u_end = grid.pixelBefore(x, 0.5f, K.width), v_end = grid.pixelBefore(y, 0.5f, K.height);
    for (int u = grid.pixelBefore(x, -0.5f, K.width); u <= u_end; ++u) {
      if (grid.cellOfPixel(u) != x) continue;
      for (int v = grid.pixelBefore(y, -0.5f, K.height); v <= v_end; ++v) {
        if (grid.cellOfPixel(v) != y) continue;
        const float measured = z[view->indexOf(u, v)];
        const float depth = measured > 0 ? measured : grid.largest;
        BilateralCell& cell = cells[grid.place(x, y, grid.cellOfDepth(depth))];
        cell.sum += depth;
        cell.weight += 1.0f;
      }
    }
  }
};

/** \brief (1 2 1) / 4 along one axis; the grid's border stays zero. */
struct BlurBilateralGrid {
  BilateralGrid grid;
  std::uint32_t step;
  const BilateralCell* from;
  BilateralCell* to;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const std::uint32_t z = k % grid.depth, column = k / grid.depth;
    const std::uint32_t x = column / grid.height, y = column - x * grid.height;
    if (x == 0 || y == 0 || z == 0 || x + 1 == grid.width || y + 1 == grid.height || z + 1 == grid.depth) return;
    const BilateralCell a = from[k - step], b = from[k + step], here = from[k];
    to[k] = {(a.sum + b.sum + 2.0f * here.sum) / 4.0f, (a.weight + b.weight + 2.0f * here.weight) / 4.0f};
  }
};

/** \brief Reads the grid at each pixel of the view, between its cells. */
struct ReadBilateralGrid {
  BilateralGrid grid;
  const DeviceView* view;
  const BilateralCell* cells;
  float* z;

  FUSE_FLOW_HD void operator()(std::uint32_t local) const {
    const int u = static_cast<int>(local % view->pitch), v = static_cast<int>(local / view->pitch);
    float& depth = z[view->offset + local];
    if (u >= view->model.intrinsics.width || !(depth > 0)) return;
    const float padding = static_cast<float>(BilateralGrid::kPadding);
    const float smoothed =
        at(static_cast<float>(u) / grid.sigma_s + padding, static_cast<float>(v) / grid.sigma_s + padding,
           (depth - grid.least) / grid.sigma_r + padding);
    if (std::isfinite(smoothed) && smoothed > 0) depth = smoothed;
  }

 private:
  FUSE_FLOW_HD float at(float x, float y, float d) const {
    const std::uint32_t i = lower(x, grid.width), j = lower(y, grid.height), k = lower(d, grid.depth);
    const float a = x - static_cast<float>(i), b = y - static_cast<float>(j), c = d - static_cast<float>(k);
    const float weights[8] = {(1.0f - a) * (1.0f - b) * (1.0f - c),
                              a * (1.0f - b) * (1.0f - c),
                              (1.0f - a) * b * (1.0f - c),
                              a * b * (1.0f - c),
                              (1.0f - a) * (1.0f - b) * c,
                              a * (1.0f - b) * c,
                              (1.0f - a) * b * c,
                              a * b * c};
    float sum = 0, weight = 0;
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
      const BilateralCell& cell = cells[grid.place(
          upper(i, corner & 1, grid.width), upper(j, corner >> 1 & 1, grid.height), upper(k, corner >> 2, grid.depth))];
      sum += weights[corner] * cell.sum;
      weight += weights[corner] * cell.weight;
    }
    return sum / weight;
  }
  FUSE_FLOW_HD static std::uint32_t lower(float value, std::uint32_t size) {
    const std::uint32_t floor = static_cast<std::uint32_t>(value);
    return floor < size ? floor : size - 1;
  }
  FUSE_FLOW_HD static std::uint32_t upper(std::uint32_t cell, std::uint32_t step, std::uint32_t size) {
    return cell + step < size ? cell + step : size - 1;
  }
};

/** \brief 1/z of each pixel, 0 where there is none. */
struct InvertDepth {
  const float* z;
  float* q;
  FUSE_FLOW_HD void operator()(std::uint32_t k) const { q[k] = z[k] > 0 ? 1.0f / z[k] : 0.0f; }
};

/** \brief The bilateral filter over depth maps on the device, view after view. The host waits for each: the size of the grid
 *  follows from the depths. */
class BilateralSmoothing {
 public:
  /** \brief Returns the bytes that its passes read and write. \param z metres of all views, changed in place */
  double smooth(Execution& run, FrameViews& views, const PreprocessingParameters& p, float* z) {
    bounds_.resize(2);
    host_bounds_.resize(2);
    double moved = 0;
    for (std::size_t i = 0; i < views.rig().size(); ++i)
      if (views.hostView(i).present) moved += smooth(run, views.hostView(i), views.grid().views + i, p, z);
    return moved;
  }

  std::size_t bytes() const { return bounds_.bytes() + cells_[0].bytes() + cells_[1].bytes(); }

 private:
  double smooth(Execution& run, const DeviceView& view, const DeviceView* on_device, const PreprocessingParameters& p,
                float* z) {
    const Intrinsics& K = view.model.intrinsics;
    if (K.height < 2) return 0;  // PCL's filter is for images of more than one row
    const std::size_t pixels = std::size_t{view.pitch} * static_cast<std::size_t>(K.height);
    run.fill(bounds_.data(), 2, 0xff);
    run.forEach(pixels, DepthBounds{z + view.offset, bounds_.data(), bounds_.data() + 1});
    run.copySmall(host_bounds_.data(), std::as_const(bounds_).data(), 2);
    run.wait();
    if (host_bounds_.data()[0] == 0xffffffffu) return 4.0 * static_cast<double>(pixels);  // nothing measured
    const BilateralGrid grid = gridOf(K, p);
    const std::size_t cells = cellCount(grid);
    for (DeviceBuffer<BilateralCell>& buffer : cells_) {
      buffer.resize(cells);
      run.fill(buffer.data(), cells, 0);
    }
    run.forEach(std::size_t{grid.width} * grid.height, FillBilateralColumn{grid, on_device, z, cells_[0].data()});
    for (const std::uint32_t step : {grid.place(1, 0, 0), grid.place(0, 1, 0), grid.place(0, 0, 1)})
      for (int pass = 0; pass < 2; ++pass) {
        run.forEach(cells, BlurBilateralGrid{grid, step, cells_[0].data(), cells_[1].data()});
        std::swap(cells_[0], cells_[1]);
      }
    run.forEach(pixels, ReadBilateralGrid{grid, on_device, cells_[0].data(), z});
    // Depths for the bounds, for the columns, and to and fro at last; the grid's cells: two clears, columns, six passes, the end.
    return 4.0 * 4 * static_cast<double>(pixels) +
           (2 + 1 + 6 * 2 + 1) * static_cast<double>(sizeof(BilateralCell) * cells);
  }

  BilateralGrid gridOf(const Intrinsics& K, const PreprocessingParameters& p) const {
    BilateralGrid grid{};
    grid.sigma_s = p.bilateral_sigma_s;
    grid.sigma_r = p.bilateral_sigma_r;
    const std::uint32_t largest = ~host_bounds_.data()[1];
    std::memcpy(&grid.least, host_bounds_.data(), sizeof(float));
    std::memcpy(&grid.largest, &largest, sizeof(float));
    const auto size = [](float extent, float sigma) {
      return static_cast<std::uint32_t>(std::min(extent / sigma, 4e9f)) + 1 + 2 * BilateralGrid::kPadding;
    };
    grid.width = size(static_cast<float>(K.width - 1), grid.sigma_s);
    grid.height = size(static_cast<float>(K.height - 1), grid.sigma_s);
    grid.depth = size(grid.largest - grid.least, grid.sigma_r);
    return grid;
  }

  static std::size_t cellCount(const BilateralGrid& grid) {
    const double count = static_cast<double>(grid.width) * grid.height * grid.depth;
    if (count >= 4294967295.0)
      throw pcl::PCLException(
          "fuse_flow::gpu: the bilateral filter's grid has more than 2^32 cells; raise bilateral_sigma_s or "
          "bilateral_sigma_r");
    return std::size_t{grid.width} * grid.height * grid.depth;
  }

  DeviceBuffer<std::uint32_t> bounds_;
  PinnedBuffer<std::uint32_t> host_bounds_;
  DeviceBuffer<BilateralCell> cells_[2];
};

}  // namespace gpu
}  // namespace fuse_flow
