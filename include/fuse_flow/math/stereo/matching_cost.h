#pragma once

#include <fuse_flow/math/exponential.h>
#include <fuse_flow/math/stereo/view_warp.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace fuse_flow {

/** \brief Samples of a matching window: 5 × 5 without the middle one, so that eight lanes have three each. */
constexpr int kWindowSamples = 24;
/** \brief Sums are kept in so many lanes: vector code on the CPU, and the same bits on every device. */
constexpr int kWindowLanes = 8;
/** \brief From its middle to its border, in samples. */
constexpr int kWindowRadius = 2;
/** \brief Cost of a pixel that falls beside the other image, or of no match at all: that of images of opposite sign. */
constexpr float kWorstCost = 2.0f;

#if !defined(__CUDA_ARCH__)
/** \brief Columns of the samples of a window, see windowColumn(). */
constexpr float kWindowColumns[kWindowSamples] = {-2, -1, 0,  1,  2, -2, -1, 0,  1,  2, -2, -1,
                                                  1,  2,  -2, -1, 0, 1,  2,  -2, -1, 0, 1,  2};
/** \brief Their rows. */
constexpr float kWindowRows[kWindowSamples] = {-2, -2, -2, -2, -2, -1, -1, -1, -1, -1, 0, 0,
                                               0,  0,  1,  1,  1,  1,  1,  2,  2,  2,  2, 2};
#endif

/** \brief Column of sample k of the window, −2 … 2. */
FUSE_FLOW_HD float windowColumn(int k) { return static_cast<float>((k + (k >= 12 ? 1 : 0)) % 5 - 2); }

/** \brief Row of sample k of the window, −2 … 2. */
FUSE_FLOW_HD float windowRow(int k) {
  const int row = (k + (k >= 12 ? 1 : 0)) / 5;
  return static_cast<float>(row - 2);
}

/** \brief An image of grey levels. */
struct GreyImage {
  const std::uint8_t* pixels;  ///< rows without padding
  /** \brief Of each pixel the 2 × 2 pixels from it on, in the four bytes of a word: one load for a value between pixels. */
  const std::uint32_t* quads;
  int width;   ///< pixels
  int height;  ///< rows
};

/** \brief The word of GreyImage::quads. The last column and row are repeated. */
FUSE_FLOW_HD std::uint32_t quadOf(const std::uint8_t* pixels, int width, int height, int u, int v) {
  const std::uint8_t* row = pixels + static_cast<std::size_t>(v) * static_cast<std::size_t>(width);
  const std::uint8_t* next = v + 1 < height ? row + width : row;
  const int right = u + 1 < width ? u + 1 : u;
  return static_cast<std::uint32_t>(row[u]) | static_cast<std::uint32_t>(row[right]) << 8 |
         static_cast<std::uint32_t>(next[u]) << 16 | static_cast<std::uint32_t>(next[right]) << 24;
}

/** \brief Luminance of a colour (Rec. 601), rounded. */
FUSE_FLOW_HD std::uint8_t greyOf(int r, int g, int b) {
  return static_cast<std::uint8_t>((77 * r + 150 * g + 29 * b + 128) >> 8);
}

/** \brief Sum of the grey levels of the 3 × 3 pixels around one; those beside the image are its border's. */
FUSE_FLOW_HD int greyAround(const GreyImage& image, int u, int v) {
  const auto within = [](int k, int size) { return k < 0 ? 0 : k < size ? k : size - 1; };
  int sum = 0;
  for (int b = v - 1; b <= v + 1; ++b)
    for (int a = u - 1; a <= u + 1; ++a)
      sum += image.pixels[static_cast<std::size_t>(within(b, image.height)) * static_cast<std::size_t>(image.width) +
                          static_cast<std::size_t>(within(a, image.width))];
  return sum;
}

/** \brief Grey levels from one byte of a quad. */
FUSE_FLOW_HD float quadByte(std::uint32_t quad, int byte) {
  return static_cast<float>(static_cast<int>((quad >> (8 * byte)) & 255u));
}

/** \brief A matching window in the reference image: what does not depend on the plane that is tried. */
struct ReferenceWindow {
  float levels[kWindowSamples];   ///< grey levels, less that of the middle
  float weights[kWindowSamples];  ///< bilateral, of a sum of 1
  float middle;                   ///< grey level of the pixel itself
  float mean;                     ///< weighted mean of levels
  float variance;                 ///< weighted variance of levels
};

/** \brief What decides how windows are compared. */
struct WindowForm {
  int spacing;         ///< between samples, pixels
  float level_sigma;   ///< of bilateral weights, grey levels
  float min_variance;  ///< added to both variances: what images without texture show is noise
};

/** \brief The window around a pixel. Its weights fall with the distance and with the difference of grey levels, so that a window at an
 *  edge compares one side of it. Samples beside the image count nothing. */
FUSE_FLOW_HD ReferenceWindow referenceWindow(const GreyImage& image, int u, int v, const WindowForm& form) {
  ReferenceWindow window;
  const auto at = [&](int a, int b) {
    return static_cast<float>(
        static_cast<int>(image.pixels[static_cast<std::size_t>(b) * static_cast<std::size_t>(image.width) +
                                      static_cast<std::size_t>(a)]));
  };
  window.middle = at(u, v);
  const float by_level = -0.5f / (form.level_sigma * form.level_sigma);
  constexpr float by_distance = -0.5f / 4;  // a standard deviation of two samples
  float total = 0, sum = 0;
  for (int k = 0; k < kWindowSamples; ++k) {
    const float column = windowColumn(k), row = windowRow(k);
    const int a = u + form.spacing * static_cast<int>(column), b = v + form.spacing * static_cast<int>(row);
    const bool inside = a >= 0 && a < image.width && b >= 0 && b < image.height;
    const float level = inside ? at(a, b) - window.middle : 0.0f;
    const float weight =
        inside ? expOfNegative(level * level * by_level + (column * column + row * row) * by_distance) : 0.0f;
    window.levels[k] = level;
    window.weights[k] = weight;
    total += weight;
    sum += weight * level;
  }
  const float scale = total > 0 ? 1.0f / total : 0.0f;
  window.mean = sum * scale;
  float squares = 0;
  for (int k = 0; k < kWindowSamples; ++k) {
    window.weights[k] *= scale;
    const float d = window.levels[k] - window.mean;
    squares += window.weights[k] * d * d;
  }
  window.variance = squares;
  return window;
}

/** \brief What a window shows in another image, in sums weighted by the window's weights. */
struct WindowSums {
  float levels;    ///< Σ w l, of the levels there less the middle one of the window
  float squares;   ///< Σ w l²
  float products;  ///< Σ w l r, with the levels of the window
};

/** \brief The sum of all lanes, always in this order. */
FUSE_FLOW_HD float sumOfLanes(const float* s) {
  return ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
}

#if defined(__GNUC__) && !defined(__CUDACC__)
#define FUSE_FLOW_WINDOW_VECTORS 1
namespace detail {

// Written as vectors, since compilers make none of a loop that reads from computed addresses.
using FloatLanes = float __attribute__((vector_size(4 * kWindowLanes)));
using IntLanes = std::int32_t __attribute__((vector_size(4 * kWindowLanes)));

inline void loadLanes(const float* from, FloatLanes& to) { std::memcpy(&to, from, sizeof(to)); }

}  // namespace detail

/** \brief The same bits as without vectors. \param warp per sample */
inline WindowSums windowSums(const ReferenceWindow& window, const LocalWarp& warp, const GreyImage& other) {
  using detail::FloatLanes;
  using detail::IntLanes;
  const float right = static_cast<float>(other.width - 1), low = static_cast<float>(other.height - 1);
  FloatLanes sums{}, squares{}, products{};
  for (int first = 0; first < kWindowSamples; first += kWindowLanes) {
    FloatLanes column, row, weight, reference;
    detail::loadLanes(kWindowColumns + first, column);
    detail::loadLanes(kWindowRows + first, row);
    detail::loadLanes(window.weights + first, weight);
    detail::loadLanes(window.levels + first, reference);
    FloatLanes x = warp.u + (column * warp.u_du + row * warp.u_dv);
    FloatLanes y = warp.v + (column * warp.v_du + row * warp.v_dv);
    x = x > 0.0f ? x : FloatLanes{};
    y = y > 0.0f ? y : FloatLanes{};
    x = x < right ? x : FloatLanes{} + right;
    y = y < low ? y : FloatLanes{} + low;
    const IntLanes a = __builtin_convertvector(x, IntLanes), b = __builtin_convertvector(y, IntLanes);
    const FloatLanes across = x - __builtin_convertvector(a, FloatLanes);
    const FloatLanes along = y - __builtin_convertvector(b, FloatLanes);
    const IntLanes place = b * other.width + a;
    IntLanes quads;
    for (int lane = 0; lane < kWindowLanes; ++lane) quads[lane] = static_cast<std::int32_t>(other.quads[place[lane]]);
    const FloatLanes top_left = __builtin_convertvector(quads & 255, FloatLanes);
    const FloatLanes top_right = __builtin_convertvector((quads >> 8) & 255, FloatLanes);
    const FloatLanes bottom_left = __builtin_convertvector((quads >> 16) & 255, FloatLanes);
    const FloatLanes bottom_right = __builtin_convertvector((quads >> 24) & 255, FloatLanes);
    const FloatLanes top = top_left + across * (top_right - top_left);
    const FloatLanes bottom = bottom_left + across * (bottom_right - bottom_left);
    const FloatLanes level = top + along * (bottom - top) - window.middle;
    const FloatLanes weighted = weight * level;
    sums += weighted;
    squares += weighted * level;
    products += weighted * reference;
  }
  float lanes[3][kWindowLanes];
  std::memcpy(lanes[0], &sums, sizeof(sums));
  std::memcpy(lanes[1], &squares, sizeof(squares));
  std::memcpy(lanes[2], &products, sizeof(products));
  return {sumOfLanes(lanes[0]), sumOfLanes(lanes[1]), sumOfLanes(lanes[2])};
}
#else
#define FUSE_FLOW_WINDOW_VECTORS 0
/** \brief A coordinate from 0 to 2²² as a whole number and a rest. */
struct SplitCoordinate {
  std::uint32_t whole;  ///< rounded down
  float rest;           ///< [0, 1)

  /** \param x the coordinate */
  FUSE_FLOW_HD explicit SplitCoordinate(float x) {
#if defined(__CUDA_ARCH__)
    // 2²³ + x rounded down has the whole part in its lowest bits: additions, where conversions take twice as long.
    constexpr float shift = 8388608.0f;
    const float shifted = __fadd_rd(x, shift);
    whole = __float_as_uint(shifted) - 0x4b000000u;
    rest = x - (shifted - shift);
#else
    whole = static_cast<std::uint32_t>(x);
    rest = x - static_cast<float>(whole);
#endif
  }
};

/** \brief The sums over all samples. \param warp per sample */
FUSE_FLOW_HD WindowSums windowSums(const ReferenceWindow& window, const LocalWarp& warp, const GreyImage& other) {
  const float right = static_cast<float>(other.width - 1), low = static_cast<float>(other.height - 1);
  float sums[kWindowLanes] = {}, squares[kWindowLanes] = {}, products[kWindowLanes] = {};
#if defined(__CUDA_ARCH__)
#pragma unroll
#endif
  for (int k = 0; k < kWindowSamples; ++k) {
    const int lane = k % kWindowLanes;
    const float column = windowColumn(k), row = windowRow(k);
    float x = warp.u + (column * warp.u_du + row * warp.u_dv);
    float y = warp.v + (column * warp.v_du + row * warp.v_dv);
    x = std::fmin(std::fmax(x, 0.0f), right);
    y = std::fmin(std::fmax(y, 0.0f), low);
    const SplitCoordinate a(x), b(y);
    const float across = a.rest, along = b.rest;
    const std::uint32_t quad = other.quads[b.whole * static_cast<std::uint32_t>(other.width) + a.whole];
    const float top_left = quadByte(quad, 0), bottom_left = quadByte(quad, 2);
    const float top = top_left + across * (quadByte(quad, 1) - top_left);
    const float bottom = bottom_left + across * (quadByte(quad, 3) - bottom_left);
    const float level = top + along * (bottom - top) - window.middle;
    const float weighted = window.weights[k] * level;
    sums[lane] += weighted;
    squares[lane] += weighted * level;
    products[lane] += weighted * window.levels[k];
  }
  return {sumOfLanes(sums), sumOfLanes(squares), sumOfLanes(products)};
}
#endif

/** \brief 1 − the weighted, zero-mean normalised cross-correlation of a window with what another image shows where the plane takes it
 *  (Schönberger et al., ECCV 2016, eq. 4); 0: the same, 1: unrelated, 2: opposite, or beside the image. Gain and offset of either image do not
 *  matter. */
FUSE_FLOW_HD float matchingCost(const ReferenceWindow& window, const WindowForm& form, const LocalWarp& warp,
                                const GreyImage& other) {
  const float right = static_cast<float>(other.width - 1), low = static_cast<float>(other.height - 1);
  if (!(warp.in_front && warp.u >= 0 && warp.v >= 0 && warp.u <= right && warp.v <= low)) return kWorstCost;
  const float spacing = static_cast<float>(form.spacing);
  const LocalWarp of_sample{
      warp.u, warp.v, spacing * warp.u_du, spacing * warp.u_dv, spacing * warp.v_du, spacing * warp.v_dv, true};
  const WindowSums sums = windowSums(window, of_sample, other);
  const float mean = sums.levels;
  const float variance = sums.squares - mean * mean;
  const float covariance = sums.products - window.mean * mean;
  const float product = (window.variance + form.min_variance) * ((variance > 0 ? variance : 0.0f) + form.min_variance);
  return 1.0f - covariance / std::sqrt(product);
}

/** \brief Most of the views whose costs are averaged. */
constexpr int kMaxBestViews = 4;

/** \brief The smallest costs of a pixel in several views: views that do not see it, because something hides it, do not count. */
struct BestCosts {
  float costs[kMaxBestViews] = {kWorstCost, kWorstCost, kWorstCost, kWorstCost};  ///< ascending

  /** \brief One more view's. */
  FUSE_FLOW_HD void add(float cost) {
    for (int k = 0; k < kMaxBestViews; ++k) {
      const float smaller = cost < costs[k] ? cost : costs[k];
      cost = cost < costs[k] ? costs[k] : cost;
      costs[k] = smaller;
    }
  }
  /** \brief Of the n smallest, 1 … kMaxBestViews. */
  FUSE_FLOW_HD float mean(int n) const {
    float sum = 0;
    for (int k = 0; k < kMaxBestViews; ++k) sum += k < n ? costs[k] : 0.0f;
    return sum / static_cast<float>(n);
  }
};

}  // namespace fuse_flow
