#pragma once

#include "io/image_io.h"

#include <fuse_flow/camera.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief The synthetic recording: four cameras look at a furnished room corner in which a ball moves. */
struct DemoOptions {
  int frames{6};
  int width{640};
  int height{480};
  /** \brief The same seed gives the same recording on every platform. */
  std::uint32_t seed{1};
  /** \brief Standard deviation of the error of each calibrated camera position, metres; a rig's usual residual. */
  double pose_noise{0.002};
  /** \brief And of its orientation, degrees. */
  double pose_noise_deg{0.1};
  /** \brief False: exact depth, rounded to a millimetre, without holes and flying pixels. */
  bool sensor_noise{true};
};

/** \brief What the four cameras measured, and what they should have measured. */
struct DemoRecording {
  /** \brief As calibrated: with the pose error. */
  std::vector<Camera> cameras;
  /** \brief Where the cameras really were. */
  std::vector<Camera> true_cameras;
  /** \brief Metres per depth unit. */
  float depth_scale{0.001f};
  /** \brief [frame][camera]. */
  std::vector<std::vector<DepthImage>> depth;
  std::vector<std::vector<ColorImage>> color;
};

DemoRecording makeDemoRecording(const DemoOptions& options = {});

/** \brief Distance in metres of a world point to the nearest true surface at a frame. World axes: z up, floor at z = 0.
 */
double demoSurfaceDistance(const Eigen::Vector3d& p_W, std::size_t frame);

/** \brief Writes a rig recording: rig.json and NAME/{depth,color}/NNNNNN.png. Throws OutputError. */
void writeDemoRecording(const std::string& folder, const DemoRecording& recording);

}  // namespace fuse_flow::io
