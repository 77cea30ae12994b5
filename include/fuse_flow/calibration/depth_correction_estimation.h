#pragma once

#include <fuse_flow/calibration/extrinsic_parameters.h>
#include <fuse_flow/one_thread.h>
#include <fuse_flow/precompiled.h>
#include <fuse_flow/rig_frame.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <memory>
#include <vector>

namespace fuse_flow {

namespace host {
class AlignmentSystem;
}

/** \brief How DepthCorrectionEstimation searches for corrections. */
struct DepthCorrectionParameters {
  /** \brief How views are prepared and compared. max_correspondence_distance should be the largest error that poses and corrections cause together. There
   *  are fewer samples than in ExtrinsicEstimation, because a correspondence costs ten times as much. Colour is not used. */
  ExtrinsicParameters views = defaultViews();
  int columns{8};  ///< knots in a row of a correction; 2 … 64
  int rows{6};     ///< rows of knots; 2 … 64
  /** \brief All views come from one sensor that was moved around, so they share one correction. */
  bool shared{false};
  /** \brief Prior: standard deviation of a, and of b in 1/metres, about zero; > 0. */
  float magnitude{0.03f};
  /** \brief Prior: standard deviation of the difference between neighbouring knots, of a, and of b in 1/metres; > 0. */
  float roughness{0.005f};
  /** \brief Prior: standard deviation of the given poses, metres at the scene's radius; > 0. */
  float pose_deviation{0.05f};
  /** \brief Number of correspondences that count as one independent correspondence, because neighbours share their errors; ≥ 1. */
  float redundancy{30.0f};
  /** \brief Largest number of instants of two cameras that count as independent; more instants count only as much as this number; ≥ 1. Many
   *  errors of sensors, at bends, at edges and on small objects, repeat in every frame. Without this limit they would outweigh the
   *  prior. */
  int effective_instants{10};

  /** \brief The defaults of ExtrinsicEstimation, with some differences. */
  static ExtrinsicParameters defaultViews() {
    ExtrinsicParameters p;
    p.samples = 6000;
    p.max_correspondence_distance = 0.15f;
    p.max_iterations = 60;
    p.use_color = false;
    return p;
  }
};

/** \brief Throws pcl::BadArgumentException for a value out of range. */
FUSE_FLOW_INLINE void checkParameters(const DepthCorrectionParameters& parameters);

/** \brief What DepthCorrectionEstimation found. */
struct DepthCorrectionResult {
  std::vector<Camera> cameras;  ///< as given, with new poses and corrections
  /** \brief For each camera, the share of the knots that the views determine better than the prior. A knot that they do not determine
   *  follows its neighbours. */
  std::vector<double> observable;
  double residual_before{
      0};              ///< root mean square point-to-plane distance at the given poses, without corrections, metres
  double residual{0};  ///< the same with the new poses and corrections, metres; both are 0 without correspondences
  std::size_t correspondences{0};  ///< number of correspondences of residual
  /** \brief The same for the poses that estimate() was given for comparison, without corrections, over the same samples. */
  double residual_of_poses{0};
  std::size_t correspondences_of_poses{0};  ///< number of correspondences of residual_of_poses
  bool compared{false};                     ///< whether there were such poses
  int iterations{0};                        ///< until convergence
  bool converged{false};                    ///< before max_iterations

  /** \brief Whether the corrections explain more than poses alone: the views then agree better, or as well at many more places. If not, the
   *  views show no depth distortion, and the corrections only follow noise. There is one answer for the whole rig. False without poses to
   *  compare with. \param gain share of the residual of poses alone that the corrections must remove; [0, 1) */
  bool explainsMore(double gain = 0.05) const {
    const auto own = static_cast<double>(correspondences), of_poses = static_cast<double>(correspondences_of_poses);
    constexpr double as_many = 0.9;  // some fall beside an edge by a hair
    if (!compared || correspondences == 0 || own < as_many * of_poses) return false;
    return of_poses < as_many * own || residual < (1 - gain) * residual_of_poses;
  }
};

/** \brief Estimates the depth corrections and the poses of all cameras of a rig, from surfaces that several cameras see.
 *
 *  Depth distortion bends surfaces. No pose makes bent surfaces agree, and poses that are estimated without corrections are wrong too. The
 *  residuals are the point-to-plane distances of ExtrinsicEstimation, with corrected points and planes. A damped Gauss–Newton search finds
 *  the poses and the knots of all corrections together. It has a prior: corrections are small and smooth, and the poses are near the given
 *  poses. So directions that the data do not determine stay: two cameras in front of one wall each take half of their disagreement. The
 *  scale of the scene is unobservable and stays too: the mean correction over all samples is zero.
 *
 *  Begin with poses that are right to a few centimetres, such as those of ExtrinsicEstimation, and with frames that show different depths
 *  in all parts of the images. A correction belongs to a sensor, not to its pose, so it is valid for other recordings of this sensor.
 *
 *  \code
 *  fuse_flow::DepthCorrectionEstimation estimation;
 *  estimation.addFrame(frame);
 *  frame.cameras = estimation.estimate().cameras;
 *  \endcode
 *
 *  Only one thread at a time may use an object; a second thread gets a pcl::PCLException. Objects share nothing, so each thread may use its
 *  own object. */
class DepthCorrectionEstimation {
 public:
  using Ptr = std::shared_ptr<DepthCorrectionEstimation>;             ///< as in PCL's classes
  using ConstPtr = std::shared_ptr<const DepthCorrectionEstimation>;  ///< as in PCL's classes

  FUSE_FLOW_INLINE DepthCorrectionEstimation();
  FUSE_FLOW_INLINE ~DepthCorrectionEstimation();

  /** \brief Throws pcl::BadArgumentException for a value out of range. */
  FUSE_FLOW_INLINE void setParameters(const DepthCorrectionParameters& parameters);
  /** \brief What setParameters() set, or the defaults. */
  const DepthCorrectionParameters& getParameters() const { return parameters_; }

  /** \brief Threads to use; 0, the default, is one per core. The result does not depend on it. */
  void setNumberOfThreads(unsigned int threads) { threads_ = static_cast<int>(threads); }

  /** \brief Forget all frames. */
  FUSE_FLOW_INLINE void clear();

  /** \brief Adds one instant; the necessary data are copied. Existing corrections of its cameras are ignored. \throws
   *  pcl::BadArgumentException if a camera or a view contradicts itself, or if the cameras differ from the earlier frames in more than
   *  their poses */
  FUSE_FLOW_INLINE void addFrame(const RigFrame& frame);

  /** \brief Begins with the poses of the first frame. \throws pcl::PCLException without a frame */
  FUSE_FLOW_INLINE DepthCorrectionResult estimate();

  /** \brief Begins with other poses, one for each camera. */
  FUSE_FLOW_INLINE DepthCorrectionResult estimate(const std::vector<Eigen::Isometry3d>& initial);

  /** \brief The same, and also compares with poses alone: see DepthCorrectionResult::explainsMore(). \param initial poses, one for
   *  each camera  \param refined poses, one for each
   *  camera, that ExtrinsicEstimation has found from depth without corrections
   *  \throws pcl::BadArgumentException for another number of poses, or one that is not rigid */
  FUSE_FLOW_INLINE DepthCorrectionResult estimate(const std::vector<Eigen::Isometry3d>& initial,
                                                  const std::vector<Eigen::Isometry3d>& refined);

 private:
  DepthCorrectionParameters parameters_;
  int threads_{0};
  std::vector<Camera> cameras_;
  detail::OneThread one_thread_;
  std::unique_ptr<host::AlignmentSystem> system_;
};

}  // namespace fuse_flow

#ifndef FUSE_FLOW_DECLARATIONS_ONLY
#include <fuse_flow/impl/calibration/depth_correction_estimation.hpp>
#endif
