#pragma once

/** \file
 *  \brief ExtrinsicTracking on the GPU: with device::Thrust as its second argument. */

#include <fuse_flow/calibration/extrinsic_tracking.h>
#include <fuse_flow/gpu/calibration/extrinsic_estimation.h>
#include <fuse_flow/impl/calibration/extrinsic_tracking.hpp>  // needed even if the CPU class is compiled in another source
