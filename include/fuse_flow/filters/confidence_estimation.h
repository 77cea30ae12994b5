#pragma once

#include <fuse_flow/device.h>
#include <fuse_flow/math/confidence.h>
#include <fuse_flow/one_thread.h>

#include <pcl/filters/filter_indices.h>

#include <vector>

namespace fuse_flow {

/** \brief Eq. 2, 3 and 9: computes the measurement confidence C of each pixel of an organised cloud, and keeps the points with C > τ.
 *
 *  The depth of a point is its distance along the optical axis of the sensor pose in the cloud's header
 *  (sensor_origin_, sensor_orientation_). As in PCL's NormalEstimation, this pose is in the frame of the points. A cloud in the camera
 *  frame has the default pose, the identity.
 *
 *  If PointT has a confidence field, the filter overwrites it with C in the filtered cloud. Points that are not finite, or not in front of
 *  the sensor, have no measurement: C = 0, and they are always removed, also with setNegative().
 *
 *  Only one thread at a time may filter with an object; a second thread gets a pcl::PCLException. Objects share nothing, so each thread may
 *  use its own object. */
template <typename PointT, typename Device = device::Host>
class ConfidenceEstimation;

namespace host {
class DepthMap;
}

/** \brief On the CPU. \copydetails ConfidenceEstimation */
template <typename PointT>
class ConfidenceEstimation<PointT, device::Host> : public pcl::FilterIndices<PointT> {
 public:
  ///@{
  /** \brief As in every PCL filter. */
  using PointCloud = typename pcl::FilterIndices<PointT>::PointCloud;
  using Ptr = pcl::shared_ptr<ConfidenceEstimation>;
  using ConstPtr = pcl::shared_ptr<const ConfidenceEstimation>;
  ///@}

  /** \param extract_removed_indices whether getRemovedIndices() is filled; this needs memory for a list of indices */
  explicit ConfidenceEstimation(bool extract_removed_indices = false)
      : pcl::FilterIndices<PointT>(extract_removed_indices) {
    this->filter_name_ = "ConfidenceEstimation";
  }

  /** \brief Copied. \throws pcl::BadArgumentException for a value out of range, naming it; nothing is then changed */
  inline void setParameters(const ConfidenceParameters& parameters);
  /** \brief What setParameters() set, or the defaults. */
  const ConfidenceParameters& getParameters() const { return parameters_; }

  /** \brief Focal length of the camera, pixels, > 0; default 525. The slope-compensated form needs it to compute the angle between
   *  neighbouring pixels. \throws pcl::BadArgumentException for a value that is not > 0 and finite */
  inline void setFocalLength(float pixels);
  /** \brief The focal length, pixels. */
  float getFocalLength() const { return focal_length_; }

  /** \brief Threads to use; 0, the default, is one per core. */
  void setNumberOfThreads(unsigned int threads) { threads_ = static_cast<int>(threads); }

  /** \brief C of every pixel of the input of the last filter() call, row by row; 0 where there is no measurement. */
  const std::vector<float>& getConfidence() const { return confidence_; }

 protected:
  using pcl::FilterIndices<PointT>::input_;
  using pcl::FilterIndices<PointT>::indices_;
  using pcl::FilterIndices<PointT>::removed_indices_;

  /** \throws pcl::UnorganizedPointCloudException for a cloud that is not organised */
  inline void applyFilter(pcl::Indices& indices) override;
  /** \copydoc applyFilter(pcl::Indices&) */
  inline void applyFilter(PointCloud& output) override;

  /** \brief Eq. 3 for a whole depth map. Other devices replace this step. \param depth metres, 0 where there is no
   *  measurement  \param C receives the confidence, row by row */
  inline virtual void computeConfidence(const host::DepthMap& depth, float* C);

  /** \brief \throws pcl::UnorganizedPointCloudException for a cloud, on whichever device, that is neither organised nor
   *  empty */
  template <typename Cloud>
  inline static void checkOrganized(const Cloud& cloud);

  int threads_{0};                ///< see setNumberOfThreads()
  detail::OneThread one_thread_;  ///< checked by every call that filters

 private:
  ConfidenceParameters parameters_;
  float focal_length_{525.0f};
  std::vector<float> confidence_;
};

}  // namespace fuse_flow

#include <fuse_flow/impl/filters/confidence_estimation.hpp>
