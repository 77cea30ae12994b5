#pragma once

/** \file
 *  \brief Marks the per-pixel functions that the CPU and the GPU share. */

/** \brief Before a function: inline, and compiled by nvcc for the GPU as well. */
#if defined(__CUDACC__)
#define FUSE_FLOW_HD __host__ __device__ inline
/** \brief Before the template <…> of such a function, if it may call functions of its arguments that are only for the host. */
#define FUSE_FLOW_CALLS_ANY _Pragma("nv_exec_check_disable")
#else
#define FUSE_FLOW_HD inline
/** \brief Nothing, where nvcc does not compile. */
#define FUSE_FLOW_CALLS_ANY
#endif
