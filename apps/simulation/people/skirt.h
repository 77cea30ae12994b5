#pragma once

#include "simulation/surfaces/mesh.h"

namespace fuse_flow::simulation {

/** \brief A skirt that flies about somebody who is twisting(): a sheet 2 mm thick and closed, of the same triangles at every time.
 *  It follows the waist the later, the further down, and waves run around it. */
Object skirt(double time);

}  // namespace fuse_flow::simulation
