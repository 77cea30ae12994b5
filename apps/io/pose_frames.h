#pragma once

#include "io/recording.h"

#include <fuse_flow/extrinsic_parameters.h>

#include <cstddef>
#include <vector>

namespace fuse_flow::io {

/** \brief At most so many of count frames, evenly spread, the first among them; in their order. */
std::vector<std::size_t> spreadFrames(std::size_t most, std::size_t count);

/** \brief Frames that tell poses well where nobody says which, evenly spread: ten, over which noise of single pixels averages out; or,
 *  where the noise of a camera is more than coarse_above times axialNoise(), that of sensors that match blocks and err over whole
 *  regions, forty. Reads what shows the noise, which mostly is the first frame; throws as reading does. */
std::vector<std::size_t> framesForPoses(Recording& recording, const ExtrinsicParameters& parameters);

}  // namespace fuse_flow::io
