#pragma once

#include <fuse_flow/calibration/extrinsic_parameters.h>
#include <fuse_flow/recordings/recording.h>

#include <cstddef>
#include <vector>

namespace fuse_flow::io {

/** \brief Over so many the noise of single pixels averages out, and the work stays within seconds. */
inline constexpr std::size_t kFewFrames = 10;

/** \brief At most so many of count frames, evenly spread, the first among them; in their order. */
std::vector<std::size_t> spreadFrames(std::size_t most, std::size_t count);

/** \brief How many frames tell poses well, by the noise that one of them shows: kFewFrames; or, where that of a camera is more than
 *  coarse_above times axialNoise(), that of sensors that match blocks and err over whole regions, forty. */
std::size_t enoughFrames(const RigFrame& frame, const ExtrinsicParameters& parameters);

/** \brief So many of a recording's frames, evenly spread, for where nobody says which. Reads what shows the noise of every camera, which
 *  mostly is the first frame; throws as reading does. */
std::vector<std::size_t> framesForPoses(Recording& recording, const ExtrinsicParameters& parameters);

}  // namespace fuse_flow::io
