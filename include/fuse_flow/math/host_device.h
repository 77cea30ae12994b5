#pragma once

/** \file
 *  \brief Marks the per-pixel functions that the CPU and the GPU share. */

/** \brief Before a function: inline, and compiled by nvcc for the GPU as well. */
#if defined(__CUDACC__)
#define FUSE_FLOW_HD __host__ __device__ inline
#else
#define FUSE_FLOW_HD inline
#endif
