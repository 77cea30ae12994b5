#pragma once

#include "simulation/random.h"

#include <fuse_flow/sensors/depth_correction.h>

#include <cmath>

namespace fuse_flow::simulation {

/** \brief What a sensor that needs a correction measures: the z for which z (1 + a + b z) is the truth, metres. */
inline double mismeasured(double truth, const DepthCorrectionTerms& terms) {
  const double a = 1 + static_cast<double>(terms.relative), b = static_cast<double>(terms.per_metre);
  return 2 * truth / (a + std::sqrt(a * a + 4 * b * truth));
}

/** \brief The correction of a sensor whose disparity is off by a polynomial of the image: by this at 2 m, standard deviation of each of
 *  its terms at the image's border, metres. */
inline DepthCorrection randomCorrection(double metres, Random& random) {
  constexpr int columns = 8, rows = 6;
  DepthCorrection correction{columns, rows, std::vector<float>(columns * rows, 0.0f), {}};
  double c[5];
  for (double& term : c) term = metres / 4 * random.gaussian();
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const double right = 2.0 * x / (columns - 1) - 1, down = 2.0 * y / (rows - 1) - 1;
      correction.per_metre.push_back(static_cast<float>(c[0] * right + c[1] * down + c[2] * right * down +
                                                        c[3] * (right * right - 1.0 / 3) +
                                                        c[4] * (down * down - 1.0 / 3)));
    }
  return correction;
}

}  // namespace fuse_flow::simulation
