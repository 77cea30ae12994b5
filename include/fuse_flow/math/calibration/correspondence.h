#pragma once

#include <fuse_flow/math/calibration/alignment.h>
#include <fuse_flow/math/calibration/block_image.h>
#include <fuse_flow/math/noise_scale.h>

namespace fuse_flow {

/** \brief How grey levels change, grey levels per pixel. */
struct LumaSlope {
  float per_u{0};  ///< to the right
  float per_v{0};  ///< down
};

/** \brief A point for which correspondences in other views are searched; in the frame of its camera. */
struct AlignmentSample {
  Vec3 p;                          ///< metres
  Vec3 n;                          ///< unit normal
  float noise;                     ///< standard deviation along the normal, metres
  float luma[kLumaScales];         ///< grey levels, the finest scale first; negative: none
  LumaSlope slope[kLumaScales]{};  ///< how they change; 0: unknown
  float pixels_per_metre_x{1};     ///< to the right, in the plane z = p.z …
  float pixels_per_metre_y{1};     ///< … and down
  /** \brief Depth as smoothed for normals, over p.z. Its error has little to do with that of p. */
  float smooth_ratio{1};
};

/** \brief About the middle of a block, over the distance that findGreySlope() takes; 0 where that is not known. */
FUSE_FLOW_HD LumaSlope blockLumaSlope(const BlockImage& image, int u, int v, int scale) {
  const GreyLevels grey = image.greyLevels(scale);
  const int step = scale > 0 ? 1 : image.reduction, a = u * step, b = v * step;
  if (a < 1 || b < 1 || a + 1 >= grey.width || b + 1 >= grey.height) return {};
  const float left = grey.at(a - 1, b), right = grey.at(a + 1, b), above = grey.at(a, b - 1), below = grey.at(a, b + 1);
  if (left < 0 || right < 0 || above < 0 || below < 0) return {};
  return {0.5f * (right - left) * grey.per_pixel, 0.5f * (below - above) * grey.per_pixel};
}

/** \brief A block with a normal as a sample. */
FUSE_FLOW_HD AlignmentSample sampleOf(const BlockImage& image, int u, int v) {
  AlignmentSample sample;
  sample.p = image.point(u, v);
  sample.n = image.normal(u, v);
  sample.noise = image.deviation(u, v);
  for (int scale = 0; scale < kLumaScales; ++scale) {
    sample.luma[scale] = image.hasColor() ? image.luma(u, v, scale) : -1.0f;
    sample.slope[scale] = image.hasColor() ? blockLumaSlope(image, u, v, scale) : LumaSlope{};
  }
  sample.pixels_per_metre_x = image.intrinsics.fx / sample.p.z;
  sample.pixels_per_metre_y = image.intrinsics.fy / sample.p.z;
  const float smooth_ratio = image.smoothDepth(u, v) / sample.p.z;
  sample.smooth_ratio = smooth_ratio > 0.8f && smooth_ratio < 1.25f ? smooth_ratio : 1.0f;
  return sample;
}

/** \brief Which correspondences count, and with which weight. */
struct AlignmentGates {
  float distance;       ///< metres …
  float deviations;     ///< … or this many standard deviations, where these are more
  float normal_cosine;  ///< of the largest angle between normals
  float tukey;          ///< c of tukeyWeight(), in standard deviations …
  float reach;  ///< … but at least this, metres, so that aligned points do not reject points that are not yet aligned
  float color_tukey;   ///< the same for colour, grey levels
  bool color;          ///< whether colour is compared …
  std::size_t scale;   ///< … and at which of kLumaScales
  std::size_t stride;  ///< every n-th sample is used
};

/** \brief Error of an exact measurement by rounding to blocks, metres. */
constexpr float kBlockFloor = 0.0005f;
/** \brief Standard deviation of a block's grey level, as two cameras see it. */
constexpr float kGreyNoise = 4.0f;
/** \brief Standard deviation of the registration of colour to depth, pixels. */
constexpr float kColorRegistration = 1.0f;

/** \brief The pose of a camera, in both directions, metres. */
struct CameraPlace {
  RigidTransform to_world;   ///< camera → world
  RigidTransform to_camera;  ///< world → camera
  NoiseModel noise;          ///< of its depth
};

/** \brief A point and its correspondence in another view. */
struct Match {
  Vec3 x;           ///< the point, world
  Vec3 q;           ///< the same, other camera's frame
  Vec3 n;           ///< normal at the counterpart, world
  float r;          ///< residual, metres
  float per_sigma;  ///< over the standard deviation that noise gives it, 1/metres
  float share;      ///< share of its variance by the noise of the point; the rest is by the correspondence
  float depth;      ///< depth of the point by both measurements together, divided by its own depth
  int u;            ///< block of the counterpart, to the right
  int v;            ///< … and down
};

/** \brief Factor on the depth of a point that moves along its ray to a plane beside it; kept near 1 for every ray.
 *  \param shift of the plane from the point, along the plane's normal, metres  \param facing the normal times the point as its
 *  camera sees it, metres */
FUSE_FLOW_HD float depthRatio(float shift, float facing) {
  constexpr float least = 0.8f, most = 1.25f;
  const float ratio = 1.0f + shift / facing;
  return !(ratio > least) ? least : (most < ratio ? most : ratio);
}

/** \brief Whether the block that a sample of camera i falls into in a view of camera j, match.u and match.v, is its counterpart.
 *
 *  Noise grows with depth. If it were computed at the measured depths, it would be smaller where these are too short. Such measurements
 *  would get more weight, and all surfaces would seem nearer, by up to 4 σ²/z. Therefore it is computed at the place that both measurements
 *  together give: the residual is divided between them by their shares of the variance, so the place does not depend on the residual.
 *  \param match x, q, u and v are known */
FUSE_FLOW_HD bool isMatch(const CameraPlace& i, const CameraPlace& j, const BlockImage& other,
                          const AlignmentSample& sample, const AlignmentGates& gates, Match& match) {
  // The depth alone rejects most blocks, before the rest of the block is loaded.
  const float z = other.depth(match.u, match.v);
  if (!(z > 0)) return false;
  const float along = match.q.z - z, axial = other.axialDeviation(z);
  const float measured = sample.noise * sample.noise + kBlockFloor * kBlockFloor,
              near = gates.distance * gates.distance;
  const float per_variance = gates.deviations * gates.deviations;
  constexpr float loose = 2.0f;  // compared with the limit below
  const float noisiest = loose * per_variance * (measured + axial * axial);
  if (!(along * along < (noisiest > near ? noisiest : near))) return false;
  const Vec3& n = other.normal(match.u, match.v);
  if (!(squaredNorm(n) > 0)) return false;
  match.n = rotate(j.to_world, n);
  if (!(dot(match.n, rotate(i.to_world, sample.n)) > gates.normal_cosine)) return false;
  const Vec3 d = other.point(match.u, match.v), e = match.q - d;
  match.r = dot(n, e);
  const float facing = dot(match.n, match.x - i.to_world.t);
  const float share = measured / (measured + axial * axial * n.z * n.z);
  const float own = sample.noise * axialNoise(i.noise, depthRatio(-share * match.r, facing) * sample.p.z) /
                    axialNoise(i.noise, sample.p.z);
  const float others = std::fabs(n.z) * other.axialDeviation(depthRatio((1.0f - share) * match.r, dot(n, d)) * z);
  const float of_point = own * own + kBlockFloor * kBlockFloor, variance = of_point + others * others;
  const float noisy = per_variance * variance;
  if (!(squaredNorm(e) < (noisy > near ? noisy : near))) return false;
  match.per_sigma = 1.0f / std::sqrt(variance);
  match.share = of_point / variance;
  match.depth = depthRatio(-match.share * match.r, facing);
  return true;
}

/** \brief The counterpart of a sample of camera i in a view of camera j; false if it has none. */
FUSE_FLOW_HD bool findMatch(const CameraPlace& i, const CameraPlace& j, const BlockImage& other,
                            const AlignmentSample& sample, const AlignmentGates& gates, Match& match) {
  match.x = i.to_world * sample.p;
  match.q = j.to_camera * match.x;
  return !other.missing() && other.locate(match.q, match.u, match.v) && isMatch(i, j, other, sample, gates, match);
}

/** \brief Bin of a histogram of residuals over their standard deviations; see noiseBin(). */
FUSE_FLOW_HD int residualBin(float r, float per_sigma) { return noiseBin(std::fabs(r) * per_sigma); }

/** \brief The input of addCorrespondence(). */
struct Correspondence {
  Vec3 x;    ///< the point relative to the scene's centre, over its radius
  Vec3 n;    ///< gradient of the residual with respect to the point, world
  float r;   ///< residual
  float w;   ///< weight; ≥ 0
  Vec3 own;  ///< of colour: the same gradient as the point's own image shows it
};

/** \brief Point to plane. */
FUSE_FLOW_HD Correspondence geometryOf(const Match& match, const AlignmentGates& gates, float per_radius) {
  const float standard = gates.tukey / match.per_sigma;
  const float limit = standard < gates.reach ? gates.reach : standard;
  return {per_radius * match.x, match.n, match.r, tukeyWeight(match.r, limit) * match.per_sigma * match.per_sigma, {}};
}

/** \brief The grey level of an image where a point lies, and how it changes as the point moves. */
struct GreySlope {
  float level;    ///< 0 … 255
  Vec3 gradient;  ///< grey levels per metre, frame of the image's camera
  float per_u;    ///< grey levels per pixel, along a row
  float per_v;    ///< the same along a column
};

/** \param q the point, frame of the image's camera  \return false if the point is outside the image, or outside the part that has grey
 *  levels */
FUSE_FLOW_HD bool findGreySlope(const BlockImage& image, int scale, const Vec3& q, GreySlope& slope) {
  int u, v;
  if (!image.hasColor() || !image.locate(q, u, v)) return false;
  const GreyLevels grey = image.greyLevels(scale);
  const Intrinsics& K = image.intrinsics;
  const Pixel pixel = project(K, q);
  const float x_grey = (pixel.u - grey.first) * grey.per_pixel, y_grey = (pixel.v - grey.first) * grey.per_pixel;
  if (!(x_grey > 0.5f && y_grey > 0.5f)) return false;
  u = static_cast<int>(x_grey + 0.5f);
  v = static_cast<int>(y_grey + 0.5f);
  if (u + 1 >= grey.width || v + 1 >= grey.height) return false;
  const float left = grey.at(u - 1, v), right = grey.at(u + 1, v), above = grey.at(u, v - 1), below = grey.at(u, v + 1),
              here = grey.at(u, v);
  if (left < 0 || right < 0 || above < 0 || below < 0 || here < 0) return false;
  const float du = 0.5f * (right - left), dv = 0.5f * (below - above);
  const float a = x_grey - static_cast<float>(u), b = y_grey - static_cast<float>(v);
  slope.level = here + a * du + b * dv;
  slope.per_u = du * grey.per_pixel;
  slope.per_v = dv * grey.per_pixel;
  const float gu = slope.per_u * K.fx / q.z, gv = slope.per_v * K.fy / q.z;
  slope.gradient = {gu, gv, -(gu * q.x + gv * q.y) / q.z};
  return true;
}

/** \brief The gradient that the other image of a match would have if it had the texture of the sample's image; zero if it is not known.
 *  \param i,j cameras of the sample and of the other image  \param scale of the grey levels  \return grey levels per metre, world */
FUSE_FLOW_HD Vec3 ownGradient(const CameraPlace& i, const CameraPlace& j, const AlignmentSample& sample,
                              const Match& match, int scale) {
  const float gx = sample.slope[scale].per_u * sample.pixels_per_metre_x,
              gy = sample.slope[scale].per_v * sample.pixels_per_metre_y;
  const Vec3 seen = rotate(i.to_world, Vec3{gx, gy, -(gx * sample.p.x + gy * sample.p.y) / sample.p.z});
  // Texture changes only along its surface; an image does not change along its rays.
  const Vec3 texture = seen - dot(seen, match.n) * match.n;
  const Vec3 ray = match.x - j.to_world.t;
  return texture - (dot(texture, ray) / dot(match.n, ray)) * match.n;
}

/** \brief Variance of a place that combines two measurements, as a share of the variance of their difference. The variance of the
 *  difference was computed at one depth; the result is for another depth. \param share of the difference's variance by the first
 *  measurement \param own σ of the first measurement at the new depth, divided by σ at the old depth \param others the same for the second
 *  measurement */
FUSE_FLOW_HD float varianceOfBoth(float share, float own, float others) {
  const float a = share * own * own, b = (1.0f - share) * others * others;
  return a * b / (a + b);
}

/** \brief The difference of grey levels at a match, and how it changes as the point moves over the other image; false where
 *  either has none.
 *
 *  The error of the point's depth may be larger than the texture, although the other view measured the surface well. So the point is
 *  searched at the place on its ray that both measurements together give, and it moves along the surface, not through it. The remaining
 *  noise makes grey levels less certain where they change along the ray.
 *
 *  Their uncertainty and their gradient depend on depth. If both were computed at the place where the point is searched, an error of this
 *  place would change the grey levels, the weight and the gradient together: points that seem near would get more weight. Therefore both
 *  are computed at the smoothed depth, which has a different error.
 *  \param x as in Correspondence  \param offset how much brighter the other image is */
FUSE_FLOW_HD bool colorOf(const CameraPlace& i, const CameraPlace& j, const BlockImage& other,
                          const AlignmentSample& sample, const Match& match, const Vec3& x, float offset,
                          const AlignmentGates& gates, Correspondence& color) {
  if (!other.hasColor() || sample.luma[0] < 0) return false;
  const Vec3 ray = match.x - i.to_world.t;
  const float facing = dot(match.n, ray);
  constexpr float glance = 0.1f;  // cosine of the largest angle to the normal at which colour is compared
  if (!(facing * facing > glance * glance * squaredNorm(ray))) return false;
  const Vec3 q = j.to_camera * (i.to_world.t + match.depth * ray);
  const int scale = static_cast<int>(gates.scale);
  GreySlope grey;
  if (!findGreySlope(other, scale, q, grey)) return false;
  const float r = grey.level - sample.luma[scale] - offset;
  const float smooth_z = (j.to_camera * (i.to_world.t + sample.smooth_ratio * ray)).z;
  const float z = smooth_z > 0.5f * q.z ? smooth_z : q.z;
  const Vec3 gradient = (q.z / z) * rotate(j.to_world, grey.gradient);
  // Change of grey level per metre of error along the normal.
  const float along_ray = dot(gradient, ray) / facing;
  const float noise = along_ray / match.per_sigma;
  const float own_noise =
      axialNoise(i.noise, sample.smooth_ratio * sample.p.z) / axialNoise(i.noise, match.depth * sample.p.z);
  const float others_noise = axialNoise(other.noise, z) / axialNoise(other.noise, q.z);
  const LumaSlope& own_slope = sample.slope[scale];
  // The registration error of colour to depth, in both images.
  const float beside = kColorRegistration * kColorRegistration *
                       (grey.per_u * grey.per_u + grey.per_v * grey.per_v + own_slope.per_u * own_slope.per_u +
                        own_slope.per_v * own_slope.per_v);
  const float variance =
      kGreyNoise * kGreyNoise + beside + varianceOfBoth(match.share, own_noise, others_noise) * noise * noise;
  const Vec3 own = ownGradient(i, j, sample, match, scale);
  color = {x, gradient - match.share * along_ray * match.n, r, tukeyWeight(r, gates.color_tukey) / variance,
           own - match.share * (dot(own, ray) / facing) * match.n};
  return true;
}

}  // namespace fuse_flow
