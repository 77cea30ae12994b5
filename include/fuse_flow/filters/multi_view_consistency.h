#pragma once

#include <fuse_flow/device.h>
#include <fuse_flow/math/consistency.h>
#include <fuse_flow/one_thread.h>
#include <fuse_flow/rig_frame.h>
#include <fuse_flow/sensors/preprocessing.h>

#include <pcl/filters/filter_indices.h>

#include <vector>

namespace fuse_flow {

/** \brief Eq. 4–7: how well each point of a cloud in the world frame agrees with the depth images of a frame; keeps the
 *  points with V ≥ the threshold.
 *
 *  If the cloud is of one camera (setFrame()) and PointT has a normal, in the world frame, that is not zero or NaN, views that
 *  the surface faces away from are not asked (ConsistencyParameters::min_facing). Either sign will do: the surface faces its camera. In
 *  clouds of several cameras nobody knows which sign is right: all views are asked.
 *
 *  If PointT has a confidence field, the filtered cloud carries confidence · V, ω of eq. 10, in it. Points that are not
 *  finite are removed whether setNegative() or not.
 *
 *  Filtering is for one thread at a time, which is checked: a second one gets a pcl::PCLException. Objects share nothing: several may be used at once, by a thread each. */
template <typename PointT, typename Device = device::Host>
class MultiViewConsistency;

/** \brief On the CPU. \copydetails MultiViewConsistency */
template <typename PointT>
class MultiViewConsistency<PointT, device::Host> : public pcl::FilterIndices<PointT> {
 public:
  ///@{
  /** \brief As in every PCL filter. */
  using PointCloud = typename pcl::FilterIndices<PointT>::PointCloud;
  using Ptr = pcl::shared_ptr<MultiViewConsistency>;
  using ConstPtr = pcl::shared_ptr<const MultiViewConsistency>;
  ///@}

  /** \param extract_removed_indices whether getRemovedIndices() is filled; costs a list of indices */
  explicit MultiViewConsistency(bool extract_removed_indices = false)
      : pcl::FilterIndices<PointT>(extract_removed_indices) {
    this->filter_name_ = "MultiViewConsistency";
  }

  /** \brief The views to compare with. The frame is copied, its images are not: they must outlive filter().
   *  \param frame what each camera measured, and where it stood in the world
   *  \param source_camera number of the camera that the input cloud came from, which is not asked about its own points;
   *  −1: none, all views are asked, nearest to the rig's first camera first */
  inline void setFrame(const RigFrame& frame, int source_camera = -1);

  /** \brief Copied. \throws pcl::BadArgumentException for a value out of range, naming it; nothing is then changed */
  inline void setParameters(const ConsistencyParameters& parameters);
  /** \brief What setParameters() set, or the defaults. */
  const ConsistencyParameters& getParameters() const { return parameters_; }

  /** \brief D^r of the other views. \throws pcl::BadArgumentException for a value out of range */
  inline void setPreprocessing(const PreprocessingParameters& parameters);

  /** \brief Least V that is kept; [0, 1], default 0.1. \throws pcl::BadArgumentException outside */
  inline void setThreshold(float threshold);
  /** \brief Least V that is kept. */
  float getThreshold() const { return threshold_; }

  /** \brief Threads to use; 0, the default, is one per core. */
  void setNumberOfThreads(unsigned int threads) { threads_ = static_cast<int>(threads); }

  /** \brief V of every point of the input of the last filter() call; 0 for points that were not asked about. */
  const std::vector<float>& getConsistency() const { return consistency_; }
  /** \brief How many other views had a say about each point. 0: V = 1, because in no other view it can be judged: it lies outside, is
   *  hidden or beside an edge, or its surface faces away. */
  const std::vector<int>& getViewCounts() const { return view_counts_; }

 protected:
  using pcl::FilterIndices<PointT>::input_;
  using pcl::FilterIndices<PointT>::indices_;
  using pcl::FilterIndices<PointT>::removed_indices_;

  /** \throws pcl::BadArgumentException if there is no frame, or it contradicts itself */
  inline void applyFilter(pcl::Indices& indices) override;
  /** \copydoc applyFilter(pcl::Indices&) */
  inline void applyFilter(PointCloud& output) override;

  /** \brief V and the number of views that had a say, for each of some finite points in the world frame: the step that
   *  another device replaces. \param points the points  \param normals of each, of any length, zero: not known; or none at all
   *  \param V of each, to be written  \param views the numbers, to be written */
  inline virtual void computeConsistency(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, float* V,
                                         int* views);

  /** \brief From a point to the source camera, which there must be. */
  Vec3 toSource(const Vec3& p_W) const {
    return toRigidTransform(frame_.cameras[static_cast<std::size_t>(source_camera_)].T_world_camera).t - p_W;
  }

  RigFrame frame_;                         ///< see setFrame()
  int source_camera_{-1};                  ///< see setFrame()
  ConsistencyParameters parameters_;       ///< see setParameters()
  PreprocessingParameters preprocessing_;  ///< see setPreprocessing()
  int threads_{0};                         ///< see setNumberOfThreads()
  detail::OneThread one_thread_;           ///< who filters asks it

 private:
  float threshold_{0.1f};
  std::vector<float> consistency_;
  std::vector<int> view_counts_;
};

}  // namespace fuse_flow

#include <fuse_flow/impl/filters/multi_view_consistency.hpp>
