#pragma once

namespace fuse_flow::command_line {

/** \brief Throws InputError if the system does not let this program start that many threads: it would go on with fewer, and
 *  nobody would know. \param threads 0: one per core */
void requireThreads(unsigned int threads);

}  // namespace fuse_flow::command_line
