#pragma once

#include <fuse_flow/device.h>
#include <fuse_flow/math/vec3.h>
#include <fuse_flow/one_thread.h>
#include <fuse_flow/rig_frame.h>
#include <fuse_flow/sensors/preprocessing.h>

#include <pcl/filters/filter.h>

#include <limits>

namespace fuse_flow {

/** \brief Eq. 8: converts a depth image and a camera to an organised cloud in the world frame, one point for each pixel.
 *
 *  The depth comes from setView(), or from setInputCloud(). The input cloud must be organised, have the size of the camera's image and be
 *  in the camera frame; its z is the depth. Its other fields are copied, and normals are rotated into the world frame. With setView(), a
 *  confidence field is the confidence of the view, or 1; ConfidenceEstimation replaces it later. Pixels without a measurement become NaN
 *  (or the user filter value); with extract_removed_indices they are the removed indices. setIndices() restricts the output to some of the
 *  pixels; the others become NaN too. The output has the header of the input. Its sensor pose is the pose of the camera; but with
 *  filter(*input), in place, PCL restores the pose of the input.
 *
 *  Only one thread at a time may filter with an object; a second thread gets a pcl::PCLException. Objects share nothing, so each thread may
 *  use its own object. */
template <typename PointT, typename Device = device::Host>
class DepthBackprojection;

/** \brief On the CPU. \copydetails DepthBackprojection */
template <typename PointT>
class DepthBackprojection<PointT, device::Host> : public pcl::Filter<PointT> {
 public:
  ///@{
  /** \brief As in every PCL filter. */
  using PointCloud = typename pcl::Filter<PointT>::PointCloud;
  using Ptr = pcl::shared_ptr<DepthBackprojection>;
  using ConstPtr = pcl::shared_ptr<const DepthBackprojection>;
  ///@}

  /** \param extract_removed_indices whether getRemovedIndices() is filled; this needs memory for a list of indices */
  explicit DepthBackprojection(bool extract_removed_indices = false) : pcl::Filter<PointT>(extract_removed_indices) {
    this->filter_name_ = "DepthBackprojection";
  }

  /** \brief Throws pcl::BadArgumentException if the camera contradicts itself. */
  inline void setCamera(const Camera& camera);
  /** \brief What setCamera() set. */
  const Camera& getCamera() const { return camera_; }

  /** \brief Take depth, and colour if PointT has it, from images instead of a cloud. They must outlive filter(). */
  inline void setView(const DepthView& view);

  /** \brief As pcl::PCLBase; forgets the view. */
  inline void setInputCloud(const typename PointCloud::ConstPtr& cloud) override;

  /** \brief D^r of eq. 8. Throws pcl::BadArgumentException for a value out of range. */
  inline void setParameters(const PreprocessingParameters& parameters);
  /** \brief What setParameters() set, or the defaults. */
  const PreprocessingParameters& getParameters() const { return parameters_; }

  /** \brief Value for the coordinates of pixels without a measurement; default NaN. */
  void setUserFilterValue(float value) { user_filter_value_ = value; }

  /** \brief Threads to use; 0, the default, is one per core. */
  void setNumberOfThreads(unsigned int threads) { threads_ = static_cast<int>(threads); }

 protected:
  using pcl::Filter<PointT>::input_;
  using pcl::Filter<PointT>::indices_;
  using pcl::Filter<PointT>::removed_indices_;

  /** \throws pcl::BadArgumentException if the image or cloud does not have the camera's size */
  inline void applyFilter(PointCloud& output) override;

  /** \brief D^r and eq. 8 for a whole image, row by row. Other devices replace this step. \param view the depth image  \param z metres, 0
   *  where there is no measurement  \param points world frame; unspecified where z is 0 */
  inline virtual void computePoints(const DepthView& view, float* z, Vec3* points);

  Camera camera_;                                                     ///< see setCamera()
  PreprocessingParameters parameters_;                                ///< see setParameters()
  int threads_{0};                                                    ///< see setNumberOfThreads()
  DepthView view_;                                                    ///< see setView()
  float user_filter_value_{std::numeric_limits<float>::quiet_NaN()};  ///< see setUserFilterValue()
  detail::OneThread one_thread_;                                      ///< checked by every call that filters
};

}  // namespace fuse_flow

#include <fuse_flow/impl/filters/depth_backprojection.hpp>
