#pragma once

#include "viewer/controls/fusion_controls.h"
#include "viewer/playback.h"

#include <string>

namespace fuse_flow::viewing {

/** \brief How fast it goes, or went before it paused, measured over the last second or so. */
struct Rates {
  double clouds{0};    ///< new clouds a second
  double pictures{0};  ///< pictures a second that the window could draw
};

/** \brief The overlay: playback, rates, and of what is shown the components and each cloud's figures. \param awaited something else
 *  was asked for, and is not there yet */
std::string statusText(const Playback& playback, const Rates& rates, const FusedFrame& shown, bool awaited);

/** \brief What heads a view: its setting where two are compared, and what would be taken for a fault if it were not said. */
std::string headingOf(const FusedCloud& cloud, ColorBy color_by, bool comparing);

/** \brief How far the poses went from those given, the largest first, and which cameras have moved: a line "left by 12.3 mm, 0.80
 *  deg, right by …", and one "camera 'left' has moved by …" for each. */
std::string refinementText(const RefinedExtrinsics& refined, const std::vector<Camera>& cameras);

/** \brief One cloud's: "FUSE-Flow: 85321 points, 2.5 mm off truth, noise 3.1 mm, … E_MC 4.1 mm", and the times of its stages. */
std::string cloudText(const FusedCloud& cloud);

}  // namespace fuse_flow::viewing
