#pragma once

#include "viewer/fusing/fusion_job.h"

#include <string>

namespace fuse_flow::viewing {

/** \brief Why a frame gave no point: "no point passes tau = 1". The setting is found by fusing again without it, once for each that
 *  can drop points. */
std::string whyEmpty(const FusionSetting& setting, const RigFrame& frame);

}  // namespace fuse_flow::viewing
