#pragma once

#include "calibration/live_extrinsics.h"

#include <fuse_flow/distributed/communicator.h>

#include <cstdint>

namespace fuse_flow::io {

/** \brief Poses of a rig whose cameras hang on several ranks, which all ranks find together, on their CPUs, whatever the device.
 *  \param communicator must outlive what it makes  \param threads of this rank; 0: one per core
 *  \param min_interval shortest time between two frames that poses are searched in, microseconds: the frames wait meanwhile */
PoseMakers makersOfSharedPoses(distributed::Communicator& communicator, unsigned int threads,
                               std::uint64_t min_interval);

}  // namespace fuse_flow::io
