#pragma once

/** \file
 *  \brief Marks the per-pixel functions that the CPU and the GPU share. */

#if defined(__CUDACC__)
#define FUSE_FLOW_HD __host__ __device__ inline
#else
#define FUSE_FLOW_HD inline
#endif
