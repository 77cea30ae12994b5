#pragma once

#include <fuse_flow/math/noise_model.h>
#include <fuse_flow/math/pinhole.h>
#include <fuse_flow/sensors/depth_correction.h>
#include <fuse_flow/sensors/multipath.h>

#include <Eigen/Geometry>

#include <optional>
#include <string>

namespace fuse_flow {

/** \brief A separate colour camera, for depth cameras whose colour is not registered to depth. */
struct ColorCamera {
  Intrinsics intrinsics;  ///< of the colour image
  /** \brief T̂ from the colour camera's frame to the depth camera's frame, metres. */
  Eigen::Isometry3d T_depth_color = Eigen::Isometry3d::Identity();  // not in braces, which CUDA 12.0 loses
};

/** \brief A calibrated depth camera. Axes: x right, y down, z forward. Thread safety: many threads may read it while none writes. */
struct Camera {
  /** \brief The name of the camera in messages. */
  std::string name;
  /** \brief Intrinsics of the depth image. */
  Intrinsics intrinsics;
  /** \brief Metres per unit of its 16-bit depth images, DepthView::depth16; > 0. Depth in float is in metres. */
  float depth_scale{0.001f};
  /** \brief Camera frame → world frame, metres; the inverse of the paper's T̂. */
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  /** \brief Absent: the colour image has the depth image's size and viewpoint. */
  std::optional<ColorCamera> color;
  /** \brief Correction of the measured depth; none unless given. Ranges in metres, as in PreprocessingParameters, apply to the measured
   *  depth before the correction. */
  DepthCorrection depth_correction;
  /** \brief Correction of multipath interference for time-of-flight cameras; none unless a modulation frequency is given. It is applied
   *  after depth_correction. */
  Multipath multipath;
  /** \brief Noise model of its depth, so that a rig may mix sensors. Absent: ConfidenceParameters::noise is used. The noise scale that is
   *  measured in each frame (FuseFlowParameters::adapt_noise) multiplies it. */
  std::optional<NoiseModel> noise;
};

/** \brief Throws pcl::BadArgumentException, naming the camera and the value, unless sizes, focal lengths and
 *  depth_scale are positive, all numbers finite, depth_correction, multipath and noise within their ranges, and the poses rigid (rotation orthonormal to 1e-3, determinant +1). */
inline void checkCamera(const Camera& camera);

/** \brief An Eigen pose as the plain numbers that the per-pixel maths uses. */
inline RigidTransform toRigidTransform(const Eigen::Isometry3d& T);

/** \brief Whether everything that a frame's geometry depends on is the same. */
inline bool sameCalibration(const Camera& a, const Camera& b);

}  // namespace fuse_flow

#include <fuse_flow/impl/camera.hpp>
