#pragma once

#include <fuse_flow/math/pinhole.h>

#include <cstddef>
#include <vector>

namespace fuse_flow::io {

/** \brief The ray of a pixel, x/z and y/z, as points on it tell. */
struct PixelRay {
  double u{0}, v{0};  ///< pixels
  double x{0}, y{0};
};

/** \brief A lens, and how well it maps rays to their pixels. */
struct LensFit {
  Intrinsics intrinsics;
  double rms{0};    ///< pixels
  double worst{0};  ///< pixels
};

/** \brief How well a lens maps rays, at least one, to their pixels. */
LensFit measureLens(const Intrinsics& K, const std::vector<PixelRay>& rays);

/** \brief The simplest lens that maps rays to their pixels with least squares: a pinhole; with k1, k2, p1, p2, k3; or with all eight
 *  coefficients of Distortion. A lens with more coefficients is chosen only if it fits much better. A flat scene is sufficient too, because
 *  points in the camera frame determine rays for any surface.
 *  \param rays of a few thousand pixels, all over the image  \param width of the image, pixels  \param height rows */
LensFit fitLens(const std::vector<PixelRay>& rays, int width, int height);

}  // namespace fuse_flow::io
