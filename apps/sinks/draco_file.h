#pragma once

#include <fuse_flow/stream/streamed_cloud.h>

#include <string>

namespace fuse_flow::io {

/** \brief Whether this program was built with Draco. */
bool hasDraco();

/** \brief Writes a cloud as a file of Draco's, for who has its decoders. Positions stay on the lattice of cloud.step on which they came, so
 *  nothing is lost; normals are kept in 10 bits. The generic attribute "confidence" has 255 for 1, "view_count" is the number of views. The
 *  points are in another order. \throws OutputError: no Draco, no points, no step, or points farther
 *  apart than 2²⁹ steps */
void writeDraco(const std::string& path, const stream::StreamedCloud& cloud);

}  // namespace fuse_flow::io
