#pragma once

#include <fuse_flow/math/calibration/block_image.h>
#include <fuse_flow/math/view.h>

#include <cfloat>

namespace fuse_flow {

// How a depth image becomes the blocks that alignment works on. Only the normals come from smoothed depth. Smoothing moves curved surfaces
// back, away from the camera, and so would move the cameras apart.

/** \brief 2 tan of the largest angle at which a surface is seen that a block may still lie on. */
inline float steepestBlock() { return 2.0f * std::tan(1.3f); }

/** \brief The measurements of one block of pixels. */
struct BlockDepth {
  float least{FLT_MAX};  ///< metres
  float most{0};         ///< metres
  float sum{0};          ///< of inverse depths, 1/metres
  int count{0};          ///< of measurements

  /** \brief Adds a pixel; 0: not measured. */
  FUSE_FLOW_HD void add(float z) {
    if (!(z > 0)) return;
    least = z < least ? z : least;
    most = most < z ? z : most;
    sum += 1.0f / z;
    ++count;
  }
  /** \brief Of the mean inverse depth; 0 if the block spans a jump or is mostly holes. \param K of the image  \param reduction pixels
   *  of a block, each way  \param steepest steepestBlock()  \param noise the sensor's  \param noise_scale noiseScale() of the
   *  view */
  FUSE_FLOW_HD float mean(const Intrinsics& K, int reduction, float steepest, const NoiseModel& noise,
                          float noise_scale) const {
    const float step = steepest / K.fx * static_cast<float>(reduction);
    const bool whole = count >= (reduction * reduction + 1) / 2 &&
                       most - least < step * least + 6 * noise_scale * axialNoise(noise, most);
    return whole ? static_cast<float>(count) / sum : 0.0f;
  }
};

/** \brief Through the middle of a block. */
FUSE_FLOW_HD Ray blockRay(const Intrinsics& K, int reduction, int u, int v) {
  const float middle = 0.5f * static_cast<float>(reduction - 1);
  return unproject(K, {static_cast<float>(u * reduction) + middle, static_cast<float>(v * reduction) + middle});
}

/** \brief Corrected inverse depth of a block that sticks out of its surface on all sides. Smoothing does not change a block with which no
 *  neighbour agrees. With normal noise, this is one block in a hundred. The normals beside such blocks were so wrong (up to a tenth of a
 *  radian, where the median error is two thousandths) that slides along a wall seemed observable. The mean of each pair of opposite
 *  neighbours is a candidate for the surface. If all candidates are on one side of the block, the block is moved to the nearest one. On
 *  every plane the means are equal to the block itself. Pairs across a jump, and holes, do not count; at least two pairs must remain.
 *  \param q inverse depths of 3×3 blocks, row by row, 1/metres, 0 for holes; the block itself, q[4], is none
 *  \param bound largest difference that is corrected, 1/metres */
FUSE_FLOW_HD float despeckledInverseDepth(const float (&q)[9], float bound) {
  float least = FLT_MAX, most = -FLT_MAX, pairs = 0;
  const auto add = [&](float before, float after) {
    const float mean = 0.5f * (before + after);
    const bool there = (before > 0) & (after > 0) & (std::fabs(mean - q[4]) < bound);
    const float low = there ? mean : FLT_MAX, high = there ? mean : -FLT_MAX;
    least = low < least ? low : least;
    most = most < high ? high : most;
    pairs += there ? 1.0f : 0.0f;
  };
  add(q[3], q[5]);
  add(q[1], q[7]);
  add(q[0], q[8]);
  add(q[2], q[6]);
  const float raised = q[4] < least ? least : q[4];
  const float within = most < raised ? most : raised;
  return pairs >= 2 ? within : q[4];
}

/** \brief Largest difference that counts as a speckle, 1/metres. \param largest ExtrinsicParameters::max_speckle  \param noise the sensor's
 *  \param noise_scale of the view  \param q inverse depth of the block */
FUSE_FLOW_HD float speckleBound(float largest, const NoiseModel& noise, float noise_scale, float q) {
  return largest * noise_scale * inverseDepthNoise(noise, q);
}

/** \brief Distance of the blocks that a normal is taken from, each way. */
constexpr int kNormalSpacing = 2;

/** \brief Unit normal of a block from its neighbours kNormalSpacing away, which must lie on one smooth surface with it; zero if
 *  they do not. \param smooth the view's smoothed depth  \param p_C the block's point as measured  \param noise the sensor's
 *  \param tolerance of second differences, in standard deviations of inverse depth */
FUSE_FLOW_HD Vec3 blockNormal(const BlockMap& smooth, int u, int v, const Vec3& p_C, const NoiseModel& noise,
                              float tolerance) {
  constexpr int step = kNormalSpacing;
  const float here = smooth.depth(u, v);
  if (!(here > 0)) return {};
  const float q = 1.0f / here;
  const float bound = tolerance * inverseDepthNoise(noise, q);
  const float left = smooth.depth(u - step, v), right = smooth.depth(u + step, v);
  if (!(left > 0 && right > 0 && std::fabs(1.0f / left - 2 * q + 1.0f / right) < bound)) return {};
  const float above = smooth.depth(u, v - step), below = smooth.depth(u, v + step);
  if (!(above > 0 && below > 0 && std::fabs(1.0f / above - 2 * q + 1.0f / below) < bound)) return {};
  const Vec3 along_u = smooth.point(u + step, v) - smooth.point(u - step, v);
  const Vec3 along_v = smooth.point(u, v + step) - smooth.point(u, v - step);
  const Vec3 n = cross(along_v, along_u);
  const float norm = std::sqrt(squaredNorm(n));
  if (!(norm > 0)) return {};
  const Vec3 unit = (1.0f / norm) * n;
  // Surfaces seen at a grazing angle are measured badly, and their depth changes a lot from pixel to pixel.
  return -dot(unit, p_C) > 0.2f * std::sqrt(squaredNorm(p_C)) ? unit : Vec3{};
}

/** \brief Distance of two normals whose noise is compared. At this distance, smoothing and differences share no pixels. */
constexpr int kNormalsApart = 12;
/** \brief Every n-th block in both directions is used. */
constexpr int kNormalStride = 2;

/** \brief Squared sine of the angle between two unit normals of one surface; negative if they are not of one. */
FUSE_FLOW_HD float squaredSine(const Vec3& a, const Vec3& b) {
  return squaredNorm(a) > 0 && squaredNorm(b) > 0 && dot(a, b) > 0.9f ? squaredNorm(cross(a, b)) : -1.0f;
}

/** \brief Standard deviation of normals, radians. \param count of squared sines  \param median of them, the upper one of two */
inline float normalNoise(std::size_t count, float median) {
  if (count < 50) return 0.05f;
  const float noise = std::sqrt(0.5f * median);
  return noise < 0.003f ? 0.003f : (0.15f < noise ? 0.15f : noise);
}

/** \brief Of a colour with channels 0 … 255. */
FUSE_FLOW_HD float greyLevel(const Vec3& rgb) { return 0.299f * rgb.x + 0.587f * rgb.y + 0.114f * rgb.z; }

/** \brief Grey level of a pixel; negative where the view has no depth or no colour. \param z depth of the pixel's
 *  block, metres */
FUSE_FLOW_HD float pixelLuma(const ViewModel& view, const ImageView<Rgb8>& image, int u, int v, const Ray& ray,
                             float z) {
  if (!(z > 0)) return -1.0f;
  const ViewColor color = viewColor(view, image, {}, u, v, ray, z);
  return color.known ? greyLevel(color.rgb) : -1.0f;
}

/** \brief Mean grey level of a square of pixels; negative where one has none. \param grey of the square's first pixel  \param pitch from row
 *  to row of them  \param side pixels */
FUSE_FLOW_HD float squareLuma(const float* grey, std::ptrdiff_t pitch, int side) {
  float sum = 0, least = 0;
  for (int dv = 0; dv < side; ++dv)
    for (int du = 0; du < side; ++du) {
      const float level = grey[dv * pitch + du];
      sum += level;
      least = level < least ? level : least;
    }
  return least < 0 ? -1.0f : sum / static_cast<float>(side * side);
}

/** \brief A step of a blur at one block, over five blocks along a row or a column. Only over the same surface, because each view sees
 *  another part of the background beside it. */
struct LumaBlur {
  float sum{0};       ///< of grey levels
  float weights{0};   ///< of those
  float z;            ///< depth of the block, metres
  bool known{false};  ///< whether the block itself has a grey level

  /** \param depth of the block, metres */
  FUSE_FLOW_HD explicit LumaBlur(float depth) : z(depth) {}
  /** \brief The block k blocks on, one after the other. \param k −2 … 2  \param depth of it; 0: none  \param luma its grey level; negative: none */
  FUSE_FLOW_HD void add(int k, float depth, float luma) {
    constexpr float same_surface = 0.05f;  // share of its depth by which it may differ within the reach of a blur
    const float weight = k == 0 ? 6.0f : (k == 1 || k == -1 ? 4.0f : 1.0f);
    const bool same = (std::fabs(depth - z) < same_surface * z) & (luma >= 0);
    known = known | ((k == 0) & same);
    sum += same ? weight * luma : 0.0f;
    weights += same ? weight : 0.0f;
  }
  /** \brief Negative where there is no depth, or no grey level. */
  FUSE_FLOW_HD float mean() const {
    const float mean = sum / weights;
    return known ? mean : -1.0f;
  }
};

/** \brief The same in one call. \param from grey levels  \param du, dv from block to block */
FUSE_FLOW_HD float blurredLuma(const BlockMap& map, const float* from, int u, int v, int du, int dv) {
  LumaBlur blur(map.depth(u, v));
  if (!(blur.z > 0)) return -1.0f;
  for (int k = -2; k <= 2; ++k) {
    const int a = u + k * du, b = v + k * dv;
    if (a < 0 || b < 0 || a >= map.width || b >= map.height) continue;
    blur.add(k, map.depth(a, b), from[map.index(a, b)]);
  }
  return blur.mean();
}

}  // namespace fuse_flow
