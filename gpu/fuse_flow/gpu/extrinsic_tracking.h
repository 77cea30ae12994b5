#pragma once

/** \file
 *  \brief ExtrinsicTracking on the GPU: with device::Thrust as its second argument. */

#include <fuse_flow/extrinsic_tracking.h>
#include <fuse_flow/gpu/extrinsic_estimation.h>
#include <fuse_flow/impl/extrinsic_tracking.hpp>  // whoever compiles the CPU's elsewhere does not have this one there
