#pragma once

#include <fuse_flow/math/pinhole.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief A lens with its distortion, by the names and coefficients of calibration tools:
 *
 *  | model | coefficients |
 *  |---|---|
 *  | none, plumb_bob, rational_polynomial, brown_conrady, opencv, radtan | 4, 5 or 8: k1 k2 p1 p2 k3 k4 k5 k6; 12 or 14 with OpenCV's thin prism and tilt |
 *  | equidistant, fisheye, kannala_brandt | 4: k1 k2 k3 k4 of the angle from the axis |
 *  | inverse_brown_conrady, modified_brown_conrady | 5: k1 k2 p1 p2 k3, as RealSense has them |
 *  | ftheta | 1: the angle w |
 *
 *  The first are taken as they are. Of the others, and of OpenCV's with thin prism or tilt, the result is the Brown–Conrady lens that is nearest over the whole image, and a line says how near, if it is not within 0.01 pixels. Upper
 *  and lower case, spaces and underscores do not matter. Throws InputError, beginning with owner, for an unknown model, for another number of coefficients, and where no such lens is within half a
 *  pixel.
 *  \param K with the image's size, and without distortion  \param warnings gets that line */
Intrinsics withDistortion(const std::string& owner, const Intrinsics& K, const std::string& model,
                          const std::vector<double>& coefficients, std::vector<std::string>& warnings);

}  // namespace fuse_flow::io
