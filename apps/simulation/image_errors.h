#pragma once

#include "simulation/random.h"

#include <fuse_flow/camera.h>

#include <algorithm>

namespace fuse_flow::simulation {

/** \brief What is wrong with the colour images of a camera, beside the noise that every image has. By default nothing. */
struct ImageErrors {
  /** \brief Factor of the exposure on what the camera should show. */
  float gain{1};
  /** \brief Added to every channel, grey levels. */
  float black_level{0};
  /** \brief Share of the light that is lost at the corners of the image, [0, 1]. */
  float vignetting{0};
  /** \brief Standard deviation of further noise of every channel and pixel, grey levels. */
  float noise{0};

  /** \brief Share of the light that arrives at a pixel: the loss grows with the square of the distance from the middle. */
  float fallOff(const Intrinsics& K, int u, int v) const {
    const float x = static_cast<float>(u) - K.cx, y = static_cast<float>(v) - K.cy;
    const float corner = std::max(K.cx * K.cx + K.cy * K.cy, 0.25f);  // one pixel alone is no corner
    return 1 - vignetting * (x * x + y * y) / corner;
  }
};

/** \brief How far the cameras of a rig differ in their ImageErrors. All 0: not at all, and without errors. */
struct ImageErrorSpread {
  /** \brief Standard deviation of the further noise, grey levels; the same for all cameras. */
  double noise{0};
  /** \brief Gains are uniform in 1 ± this, black levels in ± 20 grey levels times this. */
  double exposure{0};
  /** \brief Vignetting is uniform from 0 to this. */
  double vignetting{0};

  /** \brief Of one camera. What one member draws does not depend on the others. */
  ImageErrors draw(Random random) const {
    constexpr double black_levels = 20;  // of a camera whose exposure is wholly wrong
    ImageErrors errors;
    errors.gain = static_cast<float>(1 + exposure * (2 * random.uniform() - 1));
    errors.black_level = static_cast<float>(black_levels * exposure * (2 * random.uniform() - 1));
    errors.vignetting = static_cast<float>(vignetting * random.uniform());
    errors.noise = static_cast<float>(noise);
    return errors;
  }
};

}  // namespace fuse_flow::simulation
