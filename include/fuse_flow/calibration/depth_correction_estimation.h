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

/** \brief How DepthCorrectionEstimation looks for corrections. */
struct DepthCorrectionParameters {
  /** \brief How views are prepared and compared. Of the gates, max_distance should be what poses and corrections may be off together;
   *  iterations and samples are less than there, since a correspondence costs ten times as much. Colour is not used. */
  ExtrinsicParameters views = defaultViews();
  int columns{8};  ///< knots in a row of a correction; 2 … 64
  int rows{6};     ///< rows of knots; 2 … 64
  /** \brief All views come from one sensor, which was carried around: they have one correction. */
  bool shared{false};
  /** \brief How far corrections are believed to be from none, standard deviation of a, and of b in 1/metres; > 0. */
  float magnitude{0.03f};
  /** \brief How much neighbouring knots are believed to differ, standard deviation of a, and of b in 1/metres; > 0. */
  float roughness{0.005f};
  /** \brief How far poses are believed to be off, standard deviation, metres at the scene's radius; > 0. */
  float pose_deviation{0.05f};
  /** \brief Correspondences that tell as much as one whose error no other one shares; ≥ 1. */
  float redundancy{30.0f};
  /** \brief Instants at which two cameras both measured, and which tell as much as if each erred in its own way; more of them tell together as
   *  much as so many. Of what sensors get wrong beside a bend, at edges, in small things, much comes again in every frame, and would outweigh
   *  what is believed; ≥ 1. */
  int effective_instants{10};

  /** \brief Those of ExtrinsicEstimation, with what differs. */
  static ExtrinsicParameters defaultViews() {
    ExtrinsicParameters p;
    p.samples = 6000;
    p.max_distance = 0.15f;
    p.max_iterations = 60;
    p.use_color = false;
    return p;
  }
};

/** \brief Throws pcl::BadArgumentException for a value out of range. */
FUSE_FLOW_INLINE void checkParameters(const DepthCorrectionParameters& parameters);

/** \brief What DepthCorrectionEstimation found. */
struct DepthCorrectionResult {
  std::vector<Camera> cameras;  ///< as given, with other poses and corrections
  /** \brief Of each camera, the share of its knots about which views say more than what is believed without them; a knot that they
   *  say nothing about follows its neighbours. */
  std::vector<double> observable;
  double residual_before{
      0};                  ///< root mean square point-to-plane distance at the given poses, without corrections, metres
  double residual{0};      ///< with what was found, metres; 0 where nothing corresponds, as before
  std::size_t matches{0};  ///< correspondences that residual is over
  /** \brief The same of the poses that estimate() was given to compare with, without corrections, over the same samples. */
  double residual_of_poses{0};
  std::size_t matches_of_poses{0};  ///< correspondences that residual_of_poses is over
  bool compared{false};             ///< whether there were such poses
  int iterations{0};                ///< until nothing changed any more
  bool converged{false};            ///< before max_iterations

  /** \brief Whether corrections explain what poses alone do not: views then agree better, or as well in far more places. Where they do not, the
   *  sensors bend nothing that these views can tell, and corrections only follow noise. One answer for the whole rig. False without poses
   *  to compare with. \param gain share of the residual of poses alone that corrections must take away; [0, 1) */
  bool explainsMore(double gain = 0.05) const {
    const auto own = static_cast<double>(matches), of_poses = static_cast<double>(matches_of_poses);
    constexpr double as_many = 0.9;  // some fall beside an edge by a hair
    if (!compared || matches == 0 || own < as_many * of_poses) return false;
    return of_poses < as_many * own || residual < (1 - gain) * residual_of_poses;
  }
};

/** \brief Depth corrections of all cameras of a rig, and their poses, from what they see of the same surfaces.
 *
 *  A sensor that measures wrong bends what it sees: no pose makes bent surfaces agree, and poses found without it are wrong too. The
 *  residuals are those of ExtrinsicEstimation, point to plane, of points and planes that are both corrected. One damped
 *  Gauss–Newton finds the poses and the knots of all corrections together, with a prior: corrections are small and smooth, poses not far
 *  from those given. So what the data leave open stays: of two cameras before one wall each takes half of what they disagree
 *  by. The scale of the scene, which no view tells, stays too: over all samples corrections are none on average.
 *
 *  Begin with poses that are right to some centimetres, as ExtrinsicEstimation finds them, and frames that show different depths in all
 *  parts of the images. A correction belongs to a sensor, not to where it stands: found once, it holds for other recordings.
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

  /** \brief One instant more; what is needed of it is copied. Corrections that its cameras have are left out: new ones are found.
   *  \throws pcl::BadArgumentException if a camera or a view contradicts itself, or the cameras are not those of the frames
   *  before, poses aside */
  FUSE_FLOW_INLINE void addFrame(const RigFrame& frame);

  /** \brief From the poses of the first frame. \throws pcl::PCLException without a frame */
  FUSE_FLOW_INLINE DepthCorrectionResult estimate();

  /** \brief From other poses, one a camera. */
  FUSE_FLOW_INLINE DepthCorrectionResult estimate(const std::vector<Eigen::Isometry3d>& initial);

  /** \brief The same, and beside it what poses alone explain: see DepthCorrectionResult::explainsMore(). \param refined poses, one a
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
