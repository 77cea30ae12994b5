#pragma once

#include <fuse_flow/depth_view.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief An owning image, top row first, rows without padding. */
template <typename Pixel>
struct Image {
  int width{0};
  int height{0};
  std::vector<Pixel> data;

  void resize(int w, int h) {
    width = w;
    height = h;
    data.resize(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
  }
  bool empty() const { return data.empty(); }
  Pixel& at(int u, int v) { return data[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + u]; }
  const Pixel& at(int u, int v) const {
    return data[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + u];
  }
  /** \brief Points into this image; null when empty. */
  ImageView<Pixel> view() const { return empty() ? ImageView<Pixel>() : ImageView<Pixel>(data.data(), width, height); }
};

using DepthImage = Image<std::uint16_t>;
using ColorImage = Image<Rgb8>;
/** \brief Depth in metres, or confidence in [0, 1]. */
using FloatImage = Image<float>;

/** \brief Is told the width and height that a file claims, pixels, before memory is taken for them; throws where they are wrong. */
using SizeCheck = std::function<void(int width, int height)>;

/** \brief Reads a 16-bit grey PNG into image, whose buffer is reused. Throws InputError if the file is missing,
 *  damaged, cut short, or of another type. */
void readDepthPng(const std::string& path, DepthImage& image, const SizeCheck& check = {});

/** \brief Reads an 8-bit PNG or JPEG, chosen by content; grey is spread over the three channels, alpha dropped. Throws
 *  InputError. */
void readColor(const std::string& path, ColorImage& image, const SizeCheck& check = {});

/** \brief Reads an 8-bit or 16-bit grey PNG. Throws InputError.
 *  \param scale confidence per step; absent: the largest value of the file's type, 255 or 65535, is 1
 *  \returns the confidence per step */
float readConfidencePng(const std::string& path, FloatImage& image, std::optional<float> scale = {},
                        const SizeCheck& check = {});

/** \brief Writes a 16-bit grey PNG. Throws OutputError. */
void writeDepthPng(const std::string& path, const DepthImage& image);

/** \brief Writes an 8-bit RGB PNG. Throws OutputError. */
void writeColorPng(const std::string& path, const ColorImage& image);

}  // namespace fuse_flow::io
