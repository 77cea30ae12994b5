#pragma once

#include <fuse_flow/device.h>
#include <fuse_flow/math/vec3.h>
#include <fuse_flow/one_thread.h>
#include <fuse_flow/rig_frame.h>
#include <fuse_flow/sensors/preprocessing.h>

#include <pcl/filters/filter.h>

#include <limits>

namespace fuse_flow {

/** \brief Eq. 8: a depth image and a camera to an organised cloud in the world frame, one point a pixel.
 *
 *  The depth comes from setView(), or from setInputCloud() as the z of an organised cloud of the camera's image size and in
 *  its frame, whose other fields are then carried over, normals turned into the world frame. From a view, a confidence field is the
 *  view's own confidence, or 1; what ConfidenceEstimation finds takes its place. Pixels without a measurement become NaN
 *  (or the user filter value), and with extract_removed_indices are the removed indices; setIndices() restricts the output to
 *  some of the pixels, and the others become NaN too. The header is the input's. The output's sensor pose is the camera's; in place,
 *  filter(*input), PCL puts the input's back.
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

  /** \param extract_removed_indices whether getRemovedIndices() is filled; costs a list of indices */
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

  /** \brief What the coordinates of a pixel without a measurement become; default NaN. */
  void setUserFilterValue(float value) { user_filter_value_ = value; }

  /** \brief Threads to use; 0, the default, is one per core. */
  void setNumberOfThreads(unsigned int threads) { threads_ = static_cast<int>(threads); }

 protected:
  using pcl::Filter<PointT>::input_;
  using pcl::Filter<PointT>::indices_;
  using pcl::Filter<PointT>::removed_indices_;

  /** \throws pcl::BadArgumentException if the image or cloud does not have the camera's size */
  inline void applyFilter(PointCloud& output) override;

  /** \brief D^r and eq. 8 for a whole image, row by row: the step that another device replaces. \param view the depth image  \param z metres, 0 where
   *  there is no measurement  \param points world frame; unspecified where z is 0 */
  inline virtual void computePoints(const DepthView& view, float* z, Vec3* points);

  Camera camera_;                                                     ///< see setCamera()
  PreprocessingParameters parameters_;                                ///< see setParameters()
  int threads_{0};                                                    ///< see setNumberOfThreads()
  DepthView view_;                                                    ///< see setView()
  float user_filter_value_{std::numeric_limits<float>::quiet_NaN()};  ///< see setUserFilterValue()
  detail::OneThread one_thread_;                                      ///< who filters asks it
};

}  // namespace fuse_flow

#include <fuse_flow/impl/filters/depth_backprojection.hpp>
