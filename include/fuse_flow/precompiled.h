#pragma once

/** \file
 *  \brief Header-only is the default. The classes that find poses are made of large Eigen expressions, though, and take
 *  half a minute to compile, and the frame pipeline takes some seconds. A program that includes them in several sources may define
 *  FUSE_FLOW_PRECOMPILED for all of them, and compile the classes once, for its own point types:
 *
 *  \code
 *  #define FUSE_FLOW_PRECOMPILING  // in this source alone
 *  #include <fuse_flow/coarse_alignment.h>
 *  #include <fuse_flow/extrinsic_tracking.h>
 *  #include <fuse_flow/fuse_flow.h>  // if the program fuses
 *  template class fuse_flow::ExtrinsicEstimation<MyPoint>;
 *  template class fuse_flow::ExtrinsicTracking<MyPoint>;
 *  \endcode */

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
