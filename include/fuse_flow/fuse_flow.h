#pragma once

#include <fuse_flow/device.h>
#include <fuse_flow/fusion/parameters.h>
#include <fuse_flow/fusion/statistics.h>
#include <fuse_flow/one_thread.h>
#include <fuse_flow/rig_frame.h>

#include <pcl/point_cloud.h>

#include <memory>

namespace fuse_flow {

/** \brief The frame pipeline: the views of one instant to one fused cloud, with no state from frame to frame but
 *  memory.
 *
 *  \code
 *  fuse_flow::FuseFlow<fuse_flow::PointFused> fusion;
 *  pcl::PointCloud<fuse_flow::PointFused> cloud;
 *  fusion.fuse(frame, cloud);
 *  \endcode
 *
 *  What PointT has a field for is filled in: rgb or rgba with the fused colour, intensity with its luminance, confidence with ω,
 *  view_count with the number of cameras that the point is from and camera_mask with their bits (see PointCameras; point-wise those
 *  whose points were averaged), and after setComputeNormals(true) the normal with the mean normal, facing the cameras, or NaN where none is
 *  known: the cloud is then not dense. The same frame gives the same bytes for any number of threads.
 *
 *  One object is for one thread at a time, which is checked: a second one gets a pcl::PCLException. Objects share nothing but helper threads: several may be used at once, by a thread each. */
template <typename PointT, typename Device = device::Host>
class FuseFlow;

namespace host {
class FramePipeline;
template <typename PointT>
class PointWriter;
}  // namespace host

/** \brief On the CPU. \copydetails FuseFlow */
template <typename PointT>
class FuseFlow<PointT, device::Host> {
 public:
  ///@{
  /** \brief As in PCL's filters. */
  using PointCloud = pcl::PointCloud<PointT>;
  using Ptr = std::shared_ptr<FuseFlow>;
  using ConstPtr = std::shared_ptr<const FuseFlow>;
  ///@}

  inline FuseFlow();
  inline ~FuseFlow();
  ///@{
  /** \brief Moves the memory along; what was moved from can only be assigned to. */
  FuseFlow(FuseFlow&&) noexcept = default;
  FuseFlow& operator=(FuseFlow&&) noexcept = default;
  ///@}

  /** \brief Throws pcl::BadArgumentException for a value out of range. */
  inline void setParameters(const FuseFlowParameters& parameters);
  /** \brief What setParameters() set, or the defaults. */
  inline const FuseFlowParameters& getParameters() const;

  /** \brief Threads to use; 0, the default, is one per core. */
  inline void setNumberOfThreads(unsigned int threads);

  /** \brief Fill PointT's normal, if it has one, from the depth images; default off. */
  inline void setComputeNormals(bool compute);

  /** \brief Write ω into PointT's intensity, if it has one, in place of the luminance; default off. */
  inline void setWeightInIntensity(bool weight);

  /** \brief Fuse one frame. Of the cloud's header only the stamp is set. A missing camera is left out and named in the statistics; a frame without any view gives an
   *  empty cloud. \throws pcl::BadArgumentException if a camera or a view contradicts itself
   *  \throws pcl::PCLException if a point is too far out for the lattice of cells
   *  \throws std::bad_alloc if there is not enough memory; what was kept from frame to frame is then given back, and frames after it are fused
   *  as by a new object */
  inline void fuse(const RigFrame& frame, PointCloud& output);

  /** \brief Of the last fuse(). */
  inline const FrameStatistics& getStatistics() const;

 private:
  inline void fuseFrame(const RigFrame& frame, PointCloud& output);
  /** \brief After there was not enough: what is half laid out would be taken for whole. */
  inline void forgetMemory();

  detail::OneThread one_thread_;
  std::unique_ptr<host::FramePipeline> pipeline_;
  std::unique_ptr<host::PointWriter<PointT>> writer_;
  bool compute_normals_{false};
};

}  // namespace fuse_flow

#include <fuse_flow/impl/fuse_flow.hpp>
