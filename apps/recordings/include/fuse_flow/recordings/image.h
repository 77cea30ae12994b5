#pragma once

#include <fuse_flow/depth_view.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fuse_flow::io {

/** \brief An owning image, top row first, rows without padding. */
template <typename Pixel>
struct Image {
  int width{0};             ///< pixels
  int height{0};            ///< rows
  std::vector<Pixel> data;  ///< row by row

  /** \brief Resizes to w times h pixels; the pixel values are unspecified. */
  void resize(int w, int h) {
    width = w;
    height = h;
    data.resize(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
  }
  /** \brief Whether it has no pixel. */
  bool empty() const { return data.empty(); }
  /** \brief The pixel of column u and row v, not checked. */
  Pixel& at(int u, int v) { return data[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + u]; }
  /** \copybrief at() */
  const Pixel& at(int u, int v) const {
    return data[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + u];
  }
  /** \brief A view of this image; null if it is empty. */
  ImageView<Pixel> view() const { return empty() ? ImageView<Pixel>() : ImageView<Pixel>(data.data(), width, height); }
};

/** \brief Depth in steps of DepthView::depth_scale. */
using DepthImage = Image<std::uint16_t>;
/** \brief 8-bit colour. */
using ColorImage = Image<Rgb8>;
/** \brief Depth in metres, or confidence in [0, 1]. */
using FloatImage = Image<float>;

}  // namespace fuse_flow::io
