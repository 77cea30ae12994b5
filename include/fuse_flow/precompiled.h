#pragma once

#include <Eigen/Core>

/** \file
 *  \brief Header-only is the default. But the frame pipeline takes some seconds to compile, and the classes that find poses take half a
 *  minute, because they consist of large Eigen expressions. The library FuseFlow::compiled contains them, and multi-view stereo. A program that links it is
 *  compiled with FUSE_FLOW_PRECOMPILED; these headers then have only declarations. The compiled pipeline works with any point type.
 *  ExtrinsicEstimation and ExtrinsicTracking are compiled for PointFused and pcl::PointXYZ. To use other point types without the library,
 *  define FUSE_FLOW_PRECOMPILED for all sources and compile the classes once:
 *
 *  \code
 *  #define FUSE_FLOW_PRECOMPILING  // in this source alone
 *  #include <fuse_flow/calibration/coarse_alignment.h>
 *  #include <fuse_flow/calibration/extrinsic_tracking.h>
 *  #include <fuse_flow/fuse_flow.h>                  // if the program fuses
 *  #include <fuse_flow/stereo/multi_view_stereo.h>  // if it has stereo
 *  template class fuse_flow::ExtrinsicEstimation<MyPoint>;
 *  template class fuse_flow::ExtrinsicTracking<MyPoint>;
 *  \endcode
 *
 *  All objects that are linked together must be compiled for the same Eigen alignment, as with PCL's libraries: either all with
 *  -march=native, -mavx and the like, or none. Otherwise the program does not link, because compiledForEigenAlignment is missing. */

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

/** \brief Defined only for the Eigen alignment with which the definitions were compiled. Camera and other classes hold fixed-size Eigen
 *  matrices, whose place in memory depends on the alignment. */
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
