#pragma once

/** \file
 *  \brief CUDA's runtime with calls that fail when a test says so. The program that links failing_cuda.cpp has these functions in place of those
 *  of CUDA's shared library, which they call. */

#include <string>

namespace failing_cuda {

/** \brief What becomes of the calls after the one that fails. */
enum class After {
  Success,    ///< as if nothing had been
  SameError,  ///< as if the device were lost; also what frees memory and destroys streams then says so
};

/** \brief Counts calls from now on, and lets one fail: cudaMalloc(), launches, copies, events, graphs, and what asks the driver for anything.
 *  \param call its number, from 1 on; 0: none  \param error a cudaError_t */
void failAt(long call, int error, After after = After::Success);
/** \brief Blocks of device and pinned memory that have been asked for and not been freed, on all threads. */
long blocksHeld();
/** \brief The function that failed; empty: none has. */
std::string failedFunction();

}  // namespace failing_cuda
