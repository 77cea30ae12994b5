#pragma once

/** \file
 *  \brief Multipath interference: light that another surface reflects first, and its effect on the depth of a time-of-flight camera.
 *
 *  The light source is at the camera. It sends the same light through every pixel of the same solid angle Ω. A block of pixels sees the
 *  patch y, which reflects reflectance · Ω / π into each direction, times the cosine to its normal. A patch x at the distance d receives,
 *  relative to its direct light (cos θ / r² at distance r, incidence θ), with the angles α between the normals and the line from y to x,
 *
 *    w = reflectance Ω / π · cos α_x cos α_y / d² · r_x² / cos θ_x.
 *
 *  Its path is (r_y + d − r_x) / 2 longer than the measured depth, and its phase is shifted by this length divided by the period c / 2f.
 *  The sum of all phases, plus 1 for the direct light, gives the phase that the sensor measures. */

#include <fuse_flow/math/pinhole.h>
#include <fuse_flow/math/vec3.h>
#include <fuse_flow/sensors/multipath.h>

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace fuse_flow {

constexpr int kPatchPixels = 8;        ///< side of the block of pixels that is one patch
constexpr int kPatchesAcrossTile = 4;  ///< a tile is 4 × 4 patches
constexpr int kTilePatches = kPatchesAcrossTile * kPatchesAcrossTile;  ///< patches of a tile
constexpr int kTilePixels = kPatchPixels * kPatchesAcrossTile;         ///< side of a tile, pixels
/** \brief On one surface, depth differs from the plane and from the neighbouring pixels by less than this share. */
constexpr float kSameSurface = 0.03f;

/** \brief A small piece of surface that a camera sees; its frame, metres. */
struct SurfacePatch {
  Vec3 p{};        ///< its middle
  Vec3 n{};        ///< unit normal, towards the camera
  float power{0};  ///< share of the light through a solid angle of 1 that it sends on, over π; 0: there is no surface
  float area{0};   ///< m²
  float distance{0};  ///< of p from the camera
};

/** \brief Period of the depth: c / 2f, after which the phase repeats, metres. \param frequency Hz, > 0 */
FUSE_FLOW_HD float multipathPeriod(float frequency) { return 0.5f * 299792458.0f / frequency; }

/** \brief Default share of indirect light from surfaces that no view measured: see ExtrinsicParameters::residual_multipath, 1/m². */
constexpr float kResidualMultipath = 0.035f;

/** \brief Standard deviation of the bias that is left of multipath interference by surfaces that no view measured, at a depth of one metre,
 *  metres. Direct light decreases with the square of the distance, but light from all around does not: the bias grows with the square of
 *  depth.
 *  \param multipath of the camera
 *  \param share of such light, see ExtrinsicParameters::residual_multipath  \return 0 without a modulation frequency */
FUSE_FLOW_HD float residualMultipath(const Multipath& multipath, float share) {
  if (!(multipath.modulation_frequency > 0)) return 0.0f;
  constexpr float per_turn = 0.159154943f;  // 1 / 2π
  return share * multipath.reflectance * per_turn * multipathPeriod(multipath.modulation_frequency);
}

/** \brief Fits 1/z = a x + b y + c over rays (x, y) beside a middle: planes are linear in inverse depth. */
class InverseDepthFit {
 public:
  /** \param x of the ray, less the middle's  \param y the same  \param inverse_z 1/z along it, 1/metres */
  FUSE_FLOW_HD void add(float x, float y, float inverse_z) {
    n_ += 1;
    x_ += x;
    y_ += y;
    xx_ += x * x;
    xy_ += x * y;
    yy_ += y * y;
    q_ += inverse_z;
    xq_ += x * inverse_z;
    yq_ += y * inverse_z;
  }

  /** \brief (a, b, c); c = 0 where too little was added to tell. */
  FUSE_FLOW_HD Vec3 solve() const {
    if (n_ < 6) return {0, 0, 0};
    const float mx = x_ / n_, my = y_ / n_, mq = q_ / n_;
    const float xx = xx_ / n_ - mx * mx, xy = xy_ / n_ - mx * my, yy = yy_ / n_ - my * my;
    const float determinant = xx * yy - xy * xy;
    if (!(determinant > 0.05f * xx * yy)) return {0, 0, 0};
    const float xq = xq_ / n_ - mx * mq, yq = yq_ / n_ - my * mq;
    const float a = (yy * xq - xy * yq) / determinant, b = (xx * yq - xy * xq) / determinant;
    return {a, b, mq - a * mx - b * my};
  }

 private:
  float n_{0}, x_{0}, y_{0}, xx_{0}, xy_{0}, yy_{0}, q_{0}, xq_{0}, yq_{0};
};

/** \brief The patch that the block of pixels from (u, v) on sees. \param map depth(u, v), 0 where there is none or no image, and
 *  ray(u, v) of pixels within  \param K size and focal lengths  \param u its first column
 *  \param v its first row  \param reflectance see Multipath */
FUSE_FLOW_CALLS_ANY
template <typename Map>
FUSE_FLOW_HD SurfacePatch makeSurfacePatch(const Map& map, const Intrinsics& K, int u, int v, float reflectance) {
  // The measurement nearest to the block's middle, and how many there are.
  int middle_u = -1, middle_v = -1, nearest = 1 << 20, count = 0;
  for (int b = 0; b < kPatchPixels; ++b)
    for (int a = 0; a < kPatchPixels; ++a) {
      if (u + a >= K.width || v + b >= K.height || !(map.depth(u + a, v + b) > 0)) continue;
      ++count;
      const int du = 2 * a - kPatchPixels + 1, dv = 2 * b - kPatchPixels + 1;
      if (du * du + dv * dv >= nearest) continue;
      nearest = du * du + dv * dv;
      middle_u = u + a;
      middle_v = v + b;
    }
  SurfacePatch patch;
  if (count < kPatchPixels * kPatchPixels / 4) return patch;
  const float z = map.depth(middle_u, middle_v);
  const Ray middle = map.ray(middle_u, middle_v);
  InverseDepthFit fit;
  for (int dv = -kPatchPixels / 2; dv <= kPatchPixels / 2; dv += 2)
    for (int du = -kPatchPixels / 2; du <= kPatchPixels / 2; du += 2) {
      const int a = middle_u + du, b = middle_v + dv;
      const bool inside = (a >= 0) & (b >= 0) & (a < K.width) & (b < K.height);
      const float other = inside ? map.depth(a, b) : 0.0f;
      if (!(std::fabs(other - z) <= kSameSurface * z)) continue;
      const Ray ray = map.ray(a, b);
      fit.add(ray.x - middle.x, ray.y - middle.y, 1.0f / other);
    }
  const Vec3 plane = fit.solve();
  if (!(plane.z > 0)) return patch;
  const Vec3 away{plane.x, plane.y, plane.z - plane.x * middle.x - plane.y * middle.y};  // away · p = 1 on the plane
  patch.n = (-1.0f / std::sqrt(squaredNorm(away))) * away;
  const float fitted_z = 1.0f / plane.z;
  patch.p = {middle.x * fitted_z, middle.y * fitted_z, fitted_z};
  patch.distance = std::sqrt(squaredNorm(patch.p));
  const float cosine = fitted_z / patch.distance;
  const float solid_angle = static_cast<float>(count) * cosine * cosine * cosine / (K.fx * K.fy);
  patch.power = reflectance * solid_angle * 0.318309886f;
  const float incidence = -dot(patch.n, patch.p) / patch.distance;
  patch.area = solid_angle * patch.distance * patch.distance / (incidence > 0.1f ? incidence : 0.1f);
  return patch;
}

/** \brief Merges all patches of a tile into one. The result has no area if it would represent them badly: if they are not of one surface,
 *  or some are missing. \param patches kTilePatches of them */
FUSE_FLOW_HD SurfacePatch mergeSurfacePatches(const SurfacePatch* patches) {
  SurfacePatch whole;
  for (int k = 0; k < kTilePatches; ++k) {
    const SurfacePatch& patch = patches[k];
    if (!(patch.power > 0)) return {};
    whole.p = whole.p + patch.power * patch.p;
    whole.n = whole.n + patch.power * patch.n;
    whole.power += patch.power;
    whole.area += patch.area;
  }
  whole.p = (1 / whole.power) * whole.p;
  whole.distance = std::sqrt(squaredNorm(whole.p));
  const float length = std::sqrt(squaredNorm(whole.n));
  if (length < 0.95f * whole.power) return {};
  whole.n = (1 / length) * whole.n;
  for (int k = 0; k < kTilePatches; ++k)
    if (squaredNorm(patches[k].p - whole.p) > 2.5f * whole.area) return {};
  return whole;
}

/** \brief Whether the patches of a tile, as one, send the same light to a place. \param tile its middle  \param area of its surface; 0: it is none  \param p the place */
FUSE_FLOW_HD bool farFrom(const Vec3& tile, float area, const Vec3& p) {
  return (area > 0) & (squaredNorm(p - tile) > 9.0f * area);
}

/** \brief Indirect light, as a share of the direct light: in phase with it, and a quarter of a period behind. */
struct IndirectLight {
  float in_phase{0};  ///< with the direct light
  float behind{0};    ///< by a quarter of a period
};

/** \brief sin(2π t) to 1.1e-3, by parabolas: sums and products alone, the same on the CPU and on a GPU. \param t |t| < 2^22 */
FUSE_FLOW_HD float sineOfTurns(float t) {
  t -= std::floor(t + 0.5f);
  const float s = t * (8 - 16 * std::fabs(t));
  return 0.225f * (s * std::fabs(s) - s) + s;
}

/** \brief A patch that receives light, with the values that do not depend on the source of the light. */
struct IndirectReceiver {
  Vec3 p;                 ///< its middle, metres
  Vec3 n;                 ///< where it faces, of length 1
  float distance;         ///< r, of its middle from the camera, metres
  float scale;            ///< r² / cos θ
  float turns_per_metre;  ///< of a path's length, there and back: f / c

  /** \param x the patch  \param period see multipathPeriod() */
  FUSE_FLOW_HD IndirectReceiver(const SurfacePatch& x, float period)
      : p(x.p), n(x.n), distance(x.distance), turns_per_metre(0.5f / period) {
    const float cosine = -dot(n, p) / distance;
    scale = distance * distance / (cosine > 0.1f ? cosine : 0.1f);
  }

  /** \brief The light that a patch sends to it. */
  FUSE_FLOW_HD IndirectLight from(const Vec3& source, const Vec3& normal, float power, float area,
                                  float source_distance) const {
    const Vec3 between = p - source;
    const float sent = dot(normal, between), received = -dot(n, between);
    const float squared = squaredNorm(between) + 1e-9f;
    const bool face = (sent > 0) & (received > 0);  // each other
    // A patch is not a point: at distances below its own size, light does not grow with 1/d².
    const float w = power * scale * sent * received / (squared * (squared + 0.318309886f * area));
    const float turns = (source_distance + std::sqrt(squared) - distance) * turns_per_metre;
    const float arriving = face ? w : 0.0f;
    return {arriving * sineOfTurns(turns + 0.25f), arriving * sineOfTurns(turns)};
  }
  /** \brief The same, of a whole patch. */
  FUSE_FLOW_HD IndirectLight from(const SurfacePatch& y) const { return from(y.p, y.n, y.power, y.area, y.distance); }
};

/** \brief Sums of light are computed in this many lanes, which are then added. So vector code and a GPU give the same bits. */
constexpr std::uint32_t kIndirectLanes = 8;

/** \brief Sum of the lanes. */
FUSE_FLOW_HD IndirectLight sumLanes(const IndirectLight* lanes) {
  IndirectLight sum;
  for (std::uint32_t lane = 0; lane < kIndirectLanes; ++lane) {
    sum.in_phase += lanes[lane].in_phase;
    sum.behind += lanes[lane].behind;
  }
  return sum;
}

/** \brief One lane of the light of all other patches that comes to one: of tiles that are far, then of the patches of those that are near.
 *  \param x the one that receives  \param tiles mergeSurfacePatches() of the patches of each  \param patches tile by tile
 *  \param count of tiles  \param lane < kIndirectLanes */
FUSE_FLOW_HD IndirectLight sumIndirectOfLane(const IndirectReceiver& x, const SurfacePatch* tiles,
                                             const SurfacePatch* patches, std::uint32_t count, std::uint32_t lane) {
  IndirectLight sum;
  const auto add = [&](const SurfacePatch& source) {
    const IndirectLight light = x.from(source);
    sum.in_phase += light.in_phase;
    sum.behind += light.behind;
  };
  for (std::uint32_t tile = lane; tile < count; tile += kIndirectLanes)
    if (farFrom(tiles[tile].p, tiles[tile].area, x.p)) add(tiles[tile]);
  for (std::uint32_t tile = 0; tile < count; ++tile) {
    if (farFrom(tiles[tile].p, tiles[tile].area, x.p)) continue;
    const SurfacePatch* near = patches + static_cast<std::size_t>(tile) * kTilePatches;
    for (std::uint32_t k = lane; k < kTilePatches; k += kIndirectLanes) add(near[k]);
  }
  return sum;
}

/** \brief Angle of (x, y) as a fraction of a full turn, −0.5 … 0.5, with an error below 2e-6; 0 at the origin. Only sums, products and a
 *  division, so the CPU and a GPU give the same result. */
FUSE_FLOW_HD float turnsOf(float y, float x) {
  const float ax = std::fabs(x), ay = std::fabs(y);
  const float larger = ax > ay ? ax : ay, smaller = ax > ay ? ay : ax;
  const float t = larger > 0 ? smaller / larger : 0.0f, tt = t * t;
  // A minimax polynomial of the arctangent, for 0 … 1, to 1e-5.
  float turns = 0.159154943f * t *
                (0.99997726f + tt * (-0.33262347f +
                                     tt * (0.19354346f + tt * (-0.11643287f + tt * (0.05265332f - tt * 0.01172120f)))));
  turns = ay > ax ? 0.25f - turns : turns;
  turns = x < 0 ? 0.5f - turns : turns;
  return y < 0 ? -turns : turns;
}

/** \brief Excess depth of a patch by indirect light, metres along the optical axis; in ± period / 2. */
FUSE_FLOW_HD float multipathBias(const IndirectLight& light, float period, const SurfacePatch& x) {
  return period * turnsOf(light.behind, 1 + light.in_phase) * x.p.z / x.distance;
}

/** \brief The data that a pixel needs of the patches around it: their planes, and their excess depth. */
struct LatePatch {
  Vec3 away{};    ///< away · p = 1 on the plane; zero: there is no surface
  float late{0};  ///< multipathBias(), metres

  LatePatch() = default;
  /** \param x the patch  \param l its multipathBias() */
  FUSE_FLOW_HD LatePatch(const SurfacePatch& x, float l) : away((1 / dot(x.n, x.p)) * x.n), late(l) {}
};

/** \brief Position of a pixel's column, or row, between the centres of patches. */
struct PatchPlace {
  int first;    ///< patch, such that there is a next one
  float share;  ///< of the next one; 0 … 1

  /** \param pixel its column, or row  \param patches in a row, or a column; at least 2 */
  FUSE_FLOW_HD PatchPlace(int pixel, int patches)
      : first(clampTo(static_cast<int>(std::floor(middles(pixel))), 0, patches - 2)),
        share(shareOfNext(pixel, first)) {}
  /** \brief The share, where the first is given. */
  FUSE_FLOW_HD static float shareOfNext(int pixel, int first) {
    return clampTo(middles(pixel) - static_cast<float>(first), 0.0f, 1.0f);
  }

 private:
  /** \brief In patches, from the middle of the first. */
  FUSE_FLOW_HD static float middles(int pixel) {
    return (static_cast<float>(pixel) - 0.5f * (kPatchPixels - 1)) * (1.0f / kPatchPixels);
  }
};

/** \brief Depth without multipath bias: the excess is interpolated between those of the four surrounding patches on whose surface the pixel
 *  lies. \param p00 the upper left one of them  \param p10 the one to its right  \param p01 the one below it  \param p11 the fourth
 *  \param a place between the left ones and the right ones, 0 … 1  \param b the same, downwards  \param ray of the pixel
 *  \param z as measured  \return z if the pixel lies on none of them, 0 if no depth would remain */
FUSE_FLOW_HD float withoutMultipath(const LatePatch& p00, const LatePatch& p10, const LatePatch& p01,
                                    const LatePatch& p11, float a, float b, const Ray& ray, float z) {
  float weight = 0, late = 0;
  const auto add = [&](const LatePatch& patch, float w) {
    const float on_plane = (patch.away.x * ray.x + patch.away.y * ray.y + patch.away.z) * z;
    const float counts = std::fabs(on_plane - 1) < kSameSurface ? w + 1e-3f : 0.0f;
    weight += counts;
    late += counts * patch.late;
  };
  add(p00, (1 - a) * (1 - b));
  add(p10, a * (1 - b));
  add(p01, (1 - a) * b);
  add(p11, a * b);
  const float corrected = z - late / (weight > 0 ? weight : 1.0f);
  return corrected > 0 ? corrected : 0.0f;
}

}  // namespace fuse_flow
