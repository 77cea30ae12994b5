#pragma once

#include <fuse_flow/device.h>
#include <fuse_flow/math/adaptive_hash.h>
#include <fuse_flow/math/consistency.h>
#include <fuse_flow/math/representatives.h>
#include <fuse_flow/one_thread.h>
#include <fuse_flow/rig_frame.h>
#include <fuse_flow/sensors/preprocessing.h>

#include <pcl/filters/filter.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace fuse_flow {

/** \brief Section 5: adaptive cells, representatives and eq. 11, for a cloud in the world frame. It can replace pcl::VoxelGrid. Its cells
 *  are fixed to the world, their indices cannot overflow, and their size follows the local density.
 *
 *  If PointT has a confidence field, C is this field, at most 1; otherwise C is 1. Points with C ≤ 0, and points that are not finite, are
 *  ignored. With setCameraIndices(), the filter knows the camera of each point. With setFrame(), V weights the representatives. Colours,
 *  intensities and normals are averaged with the shares of eq. 11; values that are not finite are skipped. The confidence of an output
 *  point is ω, its view_count is the number of cameras that contributed to it, and its camera_mask has their bits (see PointCameras). All
 *  other fields are those of the representative with the largest share; so are normals, if no normal is known. With
 *  extract_removed_indices, the removed indices are the points that represent no output point.
 *
 *  Only one thread at a time may filter with an object; a second thread gets a pcl::PCLException. Objects share nothing, so each thread may
 *  use its own object. */
template <typename PointT, typename Device = device::Host>
class AdaptiveHashFusion;

/** \brief On the CPU. \copydetails AdaptiveHashFusion */
template <typename PointT>
class AdaptiveHashFusion<PointT, device::Host> : public pcl::Filter<PointT> {
 public:
  ///@{
  /** \brief As in every PCL filter. */
  using PointCloud = typename pcl::Filter<PointT>::PointCloud;
  using Ptr = pcl::shared_ptr<AdaptiveHashFusion>;
  using ConstPtr = pcl::shared_ptr<const AdaptiveHashFusion>;
  ///@}

  /** \param extract_removed_indices whether getRemovedIndices() is filled; this needs memory for a list of indices */
  explicit AdaptiveHashFusion(bool extract_removed_indices = false) : pcl::Filter<PointT>(extract_removed_indices) {
    this->filter_name_ = "AdaptiveHashFusion";
  }

  /** \brief Copied. \throws pcl::BadArgumentException for a value out of range, naming it; nothing is then changed */
  inline void setParameters(const AggregationParameters& parameters);
  /** \brief What setParameters() set, or the defaults. */
  const AggregationParameters& getParameters() const { return parameters_; }

  /** \brief The camera of each point of the input cloud, one index for each point. Empty, the default: all points are from camera 0.
   *  Copied. */
  void setCameraIndices(const std::vector<std::uint32_t>& cameras) { cameras_ = cameras; }

  /** \brief Weights points with V, computed over this frame. setCameraIndices() refers to its cameras. The frame is copied, but its images
   *  are not: they must outlive filter(). If this is never called, or called with a frame without cameras, V = 1.
   *  All views are asked: the filter does not look at normals, so min_facing has no effect.
   *  \throws pcl::BadArgumentException for a parameter out of range, or a frame that contradicts itself */
  inline void setFrame(const RigFrame& frame, const ConsistencyParameters& parameters = {});

  /** \brief Which depths of that frame count as measurements. \throws pcl::BadArgumentException for a value out of range */
  inline void setPreprocessing(const PreprocessingParameters& parameters);

  /** \brief Write ω into PointT's intensity, if it has one, in place of the mean intensity; default off. */
  void setWeightInIntensity(bool weight) { weight_in_intensity_ = weight; }

  /** \brief Threads to use; 0, the default, is one per core. */
  void setNumberOfThreads(unsigned int threads) { threads_ = static_cast<int>(threads); }

 protected:
  using pcl::Filter<PointT>::input_;
  using pcl::Filter<PointT>::indices_;
  using pcl::Filter<PointT>::removed_indices_;

  /** \throws pcl::PCLException for a point more than 2^20 cells from the origin
   *  \throws pcl::BadArgumentException if the camera indices do not fit the cloud or the frame */
  inline void applyFilter(PointCloud& output) override;

  /** \brief Section 5 for points in the world frame, camera after camera. Other devices replace this step. \param points positions and C
   *  \param cameras the camera of each point \param agreeing receives for each fused point cameraBit() of the cameras that agree with it,
   *  whether or not they have a representative; may stay empty if no view is used \return fused points, whose sources are numbers of
   *  points */
  inline virtual std::vector<FusedPoint> fusePoints(const std::vector<WeightedPoint>& points,
                                                    const std::vector<std::uint32_t>& cameras,
                                                    std::vector<std::uint64_t>& agreeing);

  AggregationParameters parameters_;       ///< see setParameters()
  std::optional<RigFrame> frame_;          ///< see setFrame()
  ConsistencyParameters consistency_;      ///< see setFrame()
  PreprocessingParameters preprocessing_;  ///< see setPreprocessing()
  int threads_{0};                         ///< see setNumberOfThreads()
  bool weight_in_intensity_{false};        ///< see setWeightInIntensity()
  detail::OneThread one_thread_;           ///< checked by every call that filters

 private:
  std::vector<std::uint32_t> cameras_;
};

}  // namespace fuse_flow

#include <fuse_flow/impl/filters/adaptive_hash_fusion.hpp>
