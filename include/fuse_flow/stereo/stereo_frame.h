#pragma once

#include <fuse_flow/math/vec3.h>
#include <fuse_flow/rig_frame.h>

#include <cstddef>
#include <vector>

namespace fuse_flow {

/** \brief The camera of a view's colour image: the camera itself, or its separate colour camera, with its pose in the world. */
inline Camera stereoCamera(const Camera& camera);

/** \brief Standard deviation of the matches whose confidence is over a half, in pixels of the widest baseline: measured, see doc/notes/stereo.md. */
constexpr float kStereoDisparityDeviation = 0.25f;

/** \brief How a view stands to those that it is matched with. */
struct StereoGeometry {
  /** \brief Numbers of the cameras that it is matched with, the best first; empty: none sees the same. */
  std::vector<std::size_t> sources;
  float min_depth{0};  ///< metres; smallest depth that is looked for
  float max_depth{0};  ///< metres; largest
  float baseline{0};   ///< metres to the farthest of these cameras
  float min_angle{0};  ///< degrees between the rays of two cameras at the distance of the scene, smallest
  float max_angle{0};  ///< largest
  /** \brief Whether the baselines to all sources are within 6° of one direction, seen in the image: edges along it then match anywhere, and
   *  depth is several times worse. */
  bool parallel_baselines{false};
};

/** \brief Depth that was found for one view. */
struct StereoView {
  std::vector<float> depth;  ///< metres, row by row; 0: none
  /** \brief The root of the correlation of what the views show, [0, 1]; 0: no other view agrees; at most a half if only one of several that see the place does, or
   *  where the pixel looks as what lies beyond the edge of its surface: windows make surfaces larger. */
  std::vector<float> confidence;
  std::vector<Vec3> normals;  ///< world frame, of length 1, facing the camera; zero where there is no depth
  StereoGeometry geometry;    ///< with whom it was matched
  std::size_t agreeing{0};    ///< pixels with which another view agrees: confidence over 0
};

/** \brief Depth of all views of an instant, with the memory of its images. */
struct StereoFrame {
  StereoFrame() = default;
  StereoFrame(StereoFrame&&) = default;             ///< the views go on pointing to the same images
  StereoFrame& operator=(StereoFrame&&) = default;  ///< the same
  StereoFrame(const StereoFrame&) = delete;         // the views of a copy would point into the original
  StereoFrame& operator=(const StereoFrame&) = delete;

  /** \brief The input of FuseFlow::fuse(), with FuseFlowParameters::estimatedDepth(): depth and confidence are in `views`, colour where it was.
   *  Its cameras are those of the colour images, see stereoCamera(), with the noise of such depth: NoiseModel::stereo() of the focal length,
   *  StereoGeometry::baseline and kStereoDisparityDeviation. */
  RigFrame rig;
  std::vector<StereoView> views;  ///< in the order of the cameras
  double total_ms{0};             ///< time that it took
};

}  // namespace fuse_flow

#include <fuse_flow/impl/stereo/stereo_camera.hpp>
