#pragma once

#include <fuse_flow/math/host_device.h>
#include <fuse_flow/math/pinhole.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace fuse_flow {

/** \brief A z-buffer of coarse cells over the image of a colour camera that stands beside its depth camera. A nearer surface can hide a
 *  point of the depth camera from the colour camera. The point must not get the colour of that surface.
 *
 *  A cell is as large as a pixel of depth is in the colour image, so that measurements leave no gaps. Each measurement counts in the four
 *  cells nearest to it. Owns nothing. */
struct ColorDepth {
  /** \brief For each cell, row by row, the smallest depth along the colour camera's axis, metres, as the bits of a float: the bits of
   *  positive floats have the same order as the floats. Null: nothing is hidden. */
  const std::uint32_t* nearest{nullptr};
  int columns{0};            ///< cells in a row
  int rows{0};               ///< rows of cells
  float cells_per_pixel{1};  ///< of the colour image
  /** \brief A surface hides a point only if it is nearer by at least this share of the point's depth. This is more than the step of an
   *  inclined surface from cell to cell. */
  float margin{0};

  /** \brief Bits of an empty cell: a float beyond all depths, whose four bytes are equal. */
  static constexpr std::uint32_t kNothing = 0x7f7f7f7f;

  /** \brief The cells of a colour camera, without memory. \param color of the colour image  \param depth of the depth image */
  FUSE_FLOW_HD static ColorDepth of(const Intrinsics& color, const Intrinsics& depth) {
    ColorDepth cells;
    const float pixels = color.fx / depth.fx;  // of colour, across a pixel of depth
    cells.cells_per_pixel = pixels > 1 ? 1 / pixels : 1.0f;
    cells.columns = static_cast<int>(static_cast<float>(color.width) * cells.cells_per_pixel) + 1;
    cells.rows = static_cast<int>(static_cast<float>(color.height) * cells.cells_per_pixel) + 1;
    cells.margin = 0.01f + 6 / depth.fx;  // the step over one and a half cells at an incidence of 75 degrees, and noise
    return cells;
  }

  /** \brief Number of cells. */
  FUSE_FLOW_HD std::size_t size() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }

  /** \brief Calls put(number of a cell, bits of z) for the four cells nearest to a measurement. \param pixel of the colour image
   *  \param z along the colour camera's axis, metres; > 0  \param put the function */
  FUSE_FLOW_CALLS_ANY
  template <typename Put>
  FUSE_FLOW_HD void add(const Pixel& pixel, float z, const Put& put) const {
    const float x = (pixel.u + 0.5f) * cells_per_pixel - 0.5f, y = (pixel.v + 0.5f) * cells_per_pixel - 0.5f;
    // Compared as floats, so that a far-off projection never overflows an integer.
    if (!(x > -1 && y > -1 && x < static_cast<float>(columns) && y < static_cast<float>(rows))) return;
    const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
    const std::uint32_t bits = bitsOf(z);
    for (int row = top; row <= top + 1; ++row)
      for (int column = left; column <= left + 1; ++column)
        if ((row >= 0) & (column >= 0) & (row < rows) & (column < columns))
          put(static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column),
              bits);
  }

  /** \brief Whether a nearer surface hides a point. \param pixel of the colour image, where the point falls  \param z its depth there,
   *  metres */
  FUSE_FLOW_HD bool hides(const Pixel& pixel, float z) const {
    if (nearest == nullptr) return false;
    const float x = (pixel.u + 0.5f) * cells_per_pixel, y = (pixel.v + 0.5f) * cells_per_pixel;
    if (!(x >= 0 && y >= 0 && x < static_cast<float>(columns) && y < static_cast<float>(rows))) return false;
    const std::size_t cell =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x);
    return fromBits(nearest[cell]) < z - margin * z;
  }

  /** \brief Of a float. */
  FUSE_FLOW_HD static std::uint32_t bitsOf(float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    return bits;
  }
  /** \brief The float of these bits. */
  FUSE_FLOW_HD static float fromBits(std::uint32_t bits) {
    float value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
};

}  // namespace fuse_flow
