#pragma once

#include <fuse_flow/device.h>
#include <fuse_flow/one_thread.h>
#include <fuse_flow/precompiled.h>
#include <fuse_flow/rig_frame.h>
#include <fuse_flow/stereo/parameters.h>
#include <fuse_flow/stereo/stereo_frame.h>

#include <memory>

namespace fuse_flow {

/** \brief Depth, confidence and normals of each view of one instant, from its colour images and calibration alone: multi-view stereo by PatchMatch
 *  with slanted windows. A plane sweep over small images finds where to begin. Then, coarse to fine, each pixel tries the planes of its
 *  neighbours and random changes of its own; a plane costs what the windows of other views differ by (matchingCost()) and how far the depth of
 *  other views is from it (Bleyer et al., PatchMatch Stereo, BMVC 2011; Galliani et al., Massively Parallel Multiview Stereopsis by
 *  Surface Normal Diffusion, ICCV 2015; Xu and Tao, Multi-Scale Geometric Consistency Guided Multi-View Stereo, CVPR 2019).
 *
 *  \code
 *  fuse_flow::MultiViewStereo<> stereo;
 *  fuse_flow::StereoFrame found;
 *  stereo.estimate(frame, found);       // frame.views have colour
 *  fusion.setParameters(fuse_flow::FuseFlowParameters::estimatedDepth());
 *  fusion.fuse(found.rig, cloud);
 *  \endcode
 *
 *  The same frame gives the same bytes, for any number of threads. No state is kept from frame to frame but memory and what depends on the
 *  calibration alone. Only one thread at a time may use an object; a second thread gets a pcl::PCLException. Objects share only helper
 *  threads, so each thread may use its own object. */
template <typename Device = device::Host>
class MultiViewStereo;

namespace host {
class StereoBackend;
}
namespace detail {
template <typename Backend>
class StereoPipeline;
}

/** \brief On the CPU. \copydetails MultiViewStereo */
template <>
class MultiViewStereo<device::Host> {
 public:
  FUSE_FLOW_INLINE MultiViewStereo();
  FUSE_FLOW_INLINE ~MultiViewStereo();
  ///@{
  /** \brief Moves the memory too. A moved-from object can only be assigned to. */
  FUSE_FLOW_INLINE MultiViewStereo(MultiViewStereo&&) noexcept;
  FUSE_FLOW_INLINE MultiViewStereo& operator=(MultiViewStereo&&) noexcept;
  ///@}

  /** \brief Throws pcl::BadArgumentException for a value out of range. */
  FUSE_FLOW_INLINE void setParameters(const StereoParameters& parameters);
  /** \brief What setParameters() set, or the defaults. */
  FUSE_FLOW_INLINE const StereoParameters& getParameters() const;

  /** \brief Threads to use; 0, the default, is one per core. */
  FUSE_FLOW_INLINE void setNumberOfThreads(unsigned int threads);

  /** \brief Whether results have normals; default true. Without, StereoView::normals are empty, and a GPU has less to bring to the host. */
  FUSE_FLOW_INLINE void setNormals(bool normals);

  /** \brief Finds the depth of each view that has a colour image. Views without one are missing from the result, and views that no other view
   *  overlaps have no depth; StereoView::geometry tells. Depth images of the frame are not looked at.
   *  \param frame colour images of the size of the colour camera; they must outlive the result, which points to them
   *  \param result its memory is used again
   *  \throws pcl::BadArgumentException if a camera or a view contradicts itself, or fewer than two views have a colour image
   *  \throws std::bad_alloc if there is not enough memory */
  FUSE_FLOW_INLINE void estimate(const RigFrame& frame, StereoFrame& result);

 private:
  detail::OneThread one_thread_;
  std::unique_ptr<detail::StereoPipeline<host::StereoBackend>> pipeline_;
  bool normals_{true};
};

}  // namespace fuse_flow

#ifndef FUSE_FLOW_DECLARATIONS_ONLY
#include <fuse_flow/impl/stereo/multi_view_stereo.hpp>
#endif
