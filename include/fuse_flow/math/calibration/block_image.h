#pragma once

#include <fuse_flow/math/confidence.h>
#include <fuse_flow/math/pinhole.h>

#include <cstddef>

namespace fuse_flow {

/** \brief Scales at which grey levels are compared; each blurred twice as far as the one before. */
constexpr int kLumaScales = 5;

/** \brief Grey levels of squares of pixels, of equal size and at even distances. A non-owning pointer, on the CPU or on the GPU. */
struct GreyLevels {
  const float* levels{nullptr};  ///< 0 … 255; negative: none
  std::ptrdiff_t pitch{0};       ///< from row to row
  int width{0};                  ///< squares in a row
  int height{0};                 ///< rows
  float first{0};                ///< middle of the first square, pixels, each way
  float per_pixel{1};            ///< squares from one to the next pixel

  /** \brief The level of a square. \param u its column  \param v its row */
  FUSE_FLOW_HD float at(int u, int v) const { return levels[v * pitch + u]; }
};

/** \brief Depth of blocks of pixels, and the rays through their centres. Non-owning pointers, on the CPU or on the GPU. */
struct BlockMap {
  const float* z{nullptr};    ///< metres, 0 where there is none; null: no image
  const Ray* rays{nullptr};   ///< block by block
  std::ptrdiff_t z_pitch{0};  ///< from row to row of z
  std::ptrdiff_t pitch{0};    ///< from row to row of everything else
  int width{0};               ///< blocks in a row
  int height{0};              ///< rows

  /** \brief Of block (u, v), in everything but z, which may have a border. */
  FUSE_FLOW_HD std::ptrdiff_t index(int u, int v) const { return v * pitch + u; }
  /** \brief Metres; 0: none. */
  FUSE_FLOW_HD float depth(int u, int v) const { return z[v * z_pitch + u]; }
  /** \brief Camera frame, metres. */
  FUSE_FLOW_HD Vec3 point(int u, int v) const { return pointOnRay(rays[index(u, v)], depth(u, v)); }
};

/** \brief A view as the alignment uses it: averaged blocks of pixels, each with a normal. All values are in the camera frame, so that poses
 *  may change. */
struct BlockImage : BlockMap {
  Intrinsics intrinsics;              ///< of the image before blocks of it were averaged
  bool ideal{true};                   ///< without distortion
  float max_squared_radius{0};        ///< as in ViewModel
  int reduction{1};                   ///< pixels of a block, each way
  const Vec3* normals{nullptr};       ///< block by block
  const float* smooth_z{nullptr};     ///< depth as it is smoothed for normals, laid out as z; null: none
  const float* lumas[kLumaScales]{};  ///< grey levels, the finest scale first; null: no colour
  /** \brief Grey levels of the finest scale: for every pixel, the mean of the square that begins there and is as large as a block. Blocks
   *  alone are too coarse for the comparison: between two blocks, textures change by more than a slope can describe, and the estimated
   *  poses are then off by a tenth of a block. */
  const float* squares{nullptr};
  std::ptrdiff_t squares_pitch{0};  ///< from row to row of squares
  NoiseModel noise;                 ///< of the sensor …
  float noise_scale{1};             ///< … and the factor on it
  float residual_multipath{0};      ///< see residualMultipath()

  /** \brief Whether there is no image. */
  FUSE_FLOW_HD bool missing() const { return z == nullptr; }
  /** \brief Whether there are grey levels. */
  FUSE_FLOW_HD bool hasColor() const { return lumas[0] != nullptr; }

  /** \brief Where a point of the camera's frame projects to: block (u, v) reaches from a = u and b = v to u + 1 and v + 1. */
  FUSE_FLOW_HD Pixel project(const Vec3& q) const {
    const Pixel pixel = fuse_flow::project(intrinsics, q);
    const float per_block = 1.0f / static_cast<float>(reduction);
    return {(pixel.u + 0.5f) * per_block, (pixel.v + 0.5f) * per_block};
  }
  /** \brief The block that a point of the camera's frame projects into. False where the image does not reach. */
  FUSE_FLOW_HD bool locate(const Vec3& q, int& u, int& v) const {
    if (!(q.z > 0)) return false;
    if (!ideal && q.x * q.x + q.y * q.y > 1.02f * max_squared_radius * q.z * q.z) return false;
    const Pixel place = project(q);
    if (!((place.u >= 0) & (place.u < static_cast<float>(width)) & (place.v >= 0) &
          (place.v < static_cast<float>(height))))
      return false;
    u = static_cast<int>(place.u);
    v = static_cast<int>(place.v);
    return true;
  }

  /** \brief Unit, facing the camera; zero where the surface is not smooth. */
  FUSE_FLOW_HD const Vec3& normal(int u, int v) const { return normals[index(u, v)]; }
  /** \brief Depth as smoothed for normals, metres: z where it is not smoothed. */
  FUSE_FLOW_HD float smoothDepth(int u, int v) const {
    const float smooth = smooth_z ? smooth_z[v * z_pitch + u] : 0.0f;
    return smooth > 0 ? smooth : depth(u, v);
  }
  /** \brief Standard deviation of a measurement of this true depth, metres: by noise, and by remaining multipath interference. */
  FUSE_FLOW_HD float axialDeviation(float true_z) const {
    const float noisy = noise_scale * axialNoise(noise, true_z);
    if (!(residual_multipath > 0)) return noisy;
    const float late = residual_multipath * true_z * true_z;
    return std::sqrt(noisy * noisy + late * late);
  }
  /** \brief Standard deviation of a block's depth along its normal, metres. */
  FUSE_FLOW_HD float deviation(int u, int v) const { return axialDeviation(depth(u, v)) * std::fabs(normal(u, v).z); }
  /** \brief 0 … 255; negative where there is none. */
  FUSE_FLOW_HD float luma(int u, int v, int scale) const { return lumas[scale][index(u, v)]; }
  /** \brief The grey levels to compare with those of another view's blocks, at one of kLumaScales. */
  FUSE_FLOW_HD GreyLevels greyLevels(int scale) const {
    const float middle = 0.5f * static_cast<float>(reduction - 1);
    if (scale > 0) return {lumas[scale], pitch, width, height, middle, 1.0f / static_cast<float>(reduction)};
    const int last = reduction - 1;
    return {squares, squares_pitch, width * reduction - last, height * reduction - last, middle, 1.0f};
  }
};

}  // namespace fuse_flow
