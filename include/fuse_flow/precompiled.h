#pragma once

#include <Eigen/Core>

/** \file
 *  \brief Header-only is the default. The frame pipeline takes some seconds to compile, though, and the classes that find poses, which
 *  are made of large Eigen expressions, half a minute. FuseFlow::compiled is a library of them: a program that links it, and so is
 *  compiled with FUSE_FLOW_PRECOMPILED, finds declarations in these headers. The pipeline goes with any point type;
 *  ExtrinsicEstimation and ExtrinsicTracking are there for PointFused and pcl::PointXYZ. For other point types, without the library,
 *  define FUSE_FLOW_PRECOMPILED for all sources and compile the classes once:
 *
 *  \code
 *  #define FUSE_FLOW_PRECOMPILING  // in this source alone
 *  #include <fuse_flow/calibration/coarse_alignment.h>
 *  #include <fuse_flow/calibration/extrinsic_tracking.h>
 *  #include <fuse_flow/fuse_flow.h>  // if the program fuses
 *  template class fuse_flow::ExtrinsicEstimation<MyPoint>;
 *  template class fuse_flow::ExtrinsicTracking<MyPoint>;
 *  \endcode
 *
 *  What is linked together must be compiled for one alignment of Eigen's (so either all of it with -march=native, -mavx and the like,
 *  or nothing), as with PCL's libraries; else it does not link: compiledForEigenAlignment<…> is missing. */

#if defined(FUSE_FLOW_PRECOMPILED) && !defined(FUSE_FLOW_PRECOMPILING)
/** \brief Whether a header of these classes leaves out its definitions. */
#define FUSE_FLOW_DECLARATIONS_ONLY
#endif

#if defined(FUSE_FLOW_PRECOMPILED)
/** \brief What functions that are no templates are declared as. */
#define FUSE_FLOW_INLINE
#else
/** \brief What functions that are no templates are declared as. */
#define FUSE_FLOW_INLINE inline
#endif

#if defined(FUSE_FLOW_PRECOMPILED)
namespace fuse_flow {
namespace detail {

/** \brief Is there for the alignment with which the definitions were compiled, and for no other: Camera and others hold fixed-size
 *  matrices of Eigen's, which lie elsewhere in memory with another one. */
template <int EigenAlignment>
bool compiledForEigenAlignment();

#if defined(FUSE_FLOW_PRECOMPILING)
template <>
[[gnu::used]] inline bool compiledForEigenAlignment<EIGEN_MAX_STATIC_ALIGN_BYTES>() {
  return true;
}
#else
inline const bool compiled_for_eigen_alignment = compiledForEigenAlignment<EIGEN_MAX_STATIC_ALIGN_BYTES>();
#endif

}  // namespace detail
}  // namespace fuse_flow
#endif
