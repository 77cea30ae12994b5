#pragma once

namespace fuse_flow::command_line {

/** \brief Throws InputError if the system does not let this program start that many threads, at which OpenMP would end it with a
 *  message of its own. \param threads 0: one per core */
void requireThreads(unsigned int threads);

}  // namespace fuse_flow::command_line
