#pragma once

#include "viewer/fusion_controls.h"
#include "viewer/playback.h"

#include <string>

namespace fuse_flow::viewing {

/** \brief How fast it goes, measured over the last second or so. */
struct Rates {
  double clouds{0};    ///< new clouds a second
  double pictures{0};  ///< pictures a second that the window could draw
};

/** \brief The overlay: playback, rates, components, and each cloud's figures. */
std::string statusText(const Playback& playback, const Rates& rates, const FusionControls& controls,
                       const FusedFrame& shown);

/** \brief How far the poses went from those given, the largest first, and which cameras have moved: a line "left by 12.3 mm, 0.80
 *  deg, right by …", and one "camera 'left' has moved by …" for each. */
std::string refinementText(const RefinedExtrinsics& refined, const std::vector<Camera>& cameras);

/** \brief One cloud's: "FUSE-Flow: 85321 points, E_MC 4.1 mm (2+ views 6.3 mm), covers 97 %", and the times of its stages. */
std::string cloudText(const FusedCloud& cloud);

}  // namespace fuse_flow::viewing
