#pragma once

#include "simulation/surfaces/mesh.h"

namespace fuse_flow::simulation {

/** \file
 *  \brief Small things that stand on z = 0; metres. */

/** \brief Half a hollow ball with a flat foot. */
TriangleMesh bowl(float radius, float wall);

/** \brief Hollow, with a handle towards x. */
TriangleMesh cup(float radius, float height, float wall);

TriangleMesh bottle(float radius, float height);

/** \brief Lying flat. */
TriangleMesh gear(float radius, float height, int teeth);

/** \brief A bath toy of a length, looking along x: round, without a crease. */
TriangleMesh duck(float length);

}  // namespace fuse_flow::simulation
