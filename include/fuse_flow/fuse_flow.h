#pragma once

#include <fuse_flow/device.h>
#include <fuse_flow/fusion/parameters.h>
#include <fuse_flow/fusion/statistics.h>
#include <fuse_flow/one_thread.h>
#include <fuse_flow/rig_frame.h>

#include <pcl/point_cloud.h>

#include <memory>

namespace fuse_flow {

/** \brief The frame pipeline: it fuses the views of one instant into one cloud. From frame to frame it keeps memory buffers, but no data.
 *
 *  \code
 *  fuse_flow::FuseFlow<fuse_flow::PointFused> fusion;
 *  pcl::PointCloud<fuse_flow::PointFused> cloud;
 *  fusion.fuse(frame, cloud);
 *  \endcode
 *
 *  The fields that PointT has are filled: rgb or rgba with the fused colour, intensity with the luminance of this colour, confidence with
 *  ω, view_count with the number of cameras that contributed to the point, and camera_mask with the bits of these cameras (see
 *  PointCameras; without cells, the cameras whose points were averaged). After setComputeNormals(true), the normal is the mean normal and
 *  faces the cameras. Where no normal is known, it is NaN, and the cloud is not dense. The same frame gives the same bytes for any number
 *  of threads.
 *
 *  Only one thread at a time may use an object; a second thread gets a pcl::PCLException. Objects share only helper threads, so each thread
 *  may use its own object. */
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
  /** \brief Moves the memory too. A moved-from object can only be assigned to. */
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

  /** \brief Fuse one frame. Of the cloud's header only the stamp is set. A missing camera is skipped, and the statistics name it. A frame
   *  without any view gives an empty cloud. \throws pcl::BadArgumentException if a camera or a view contradicts itself
   *  \throws pcl::PCLException if a point is too far out for the lattice of cells
   *  \throws std::bad_alloc if there is not enough memory. All buffers are then released, and later frames are fused as by a new object */
  inline void fuse(const RigFrame& frame, PointCloud& output);

  /** \brief Statistics of the last fuse(). */
  inline const FrameStatistics& getStatistics() const;

 private:
  inline void fuseFrame(const RigFrame& frame, PointCloud& output);
  /** \brief Releases all buffers after std::bad_alloc: a partly allocated buffer would look complete. */
  inline void forgetMemory();

  detail::OneThread one_thread_;
  std::unique_ptr<host::FramePipeline> pipeline_;
  std::unique_ptr<host::PointWriter<PointT>> writer_;
  bool compute_normals_{false};
};

}  // namespace fuse_flow

#include <fuse_flow/impl/fuse_flow.hpp>
