#pragma once

#include "simulation/surfaces/ray_scene.h"

#include <fuse_flow/camera.h>
#include <fuse_flow/impl/sensors/rig_geometry.hpp>

#include <limits>
#include <vector>

namespace fuse_flow::simulation {

/** \brief What the cameras of a frame could have measured. */
struct Visibility {
  float min_range{0.1f};
  float max_range{10.0f};
  /** \brief A surface seen at more than this angle from its normal was not seen; radians. */
  float max_incidence{1.4f};
  /** \brief Samples are this far apart, metres. */
  float spacing{0.015f};
};

/** \brief How the cameras of a frame see a place of the true surface. */
struct Sight {
  /** \brief How many see it. */
  int cameras{0};
  /** \brief The smallest angle between a ray to one of them and the normal, radians. */
  float incidence{std::numeric_limits<float>::infinity()};
};

/** \brief The true cameras of a frame. */
class TrueCameras {
 public:
  /** \param present which of them measured in this frame */
  TrueCameras(const std::vector<Camera>& cameras, const std::vector<bool>& present, const Visibility& visibility);
  TrueCameras(const TrueCameras&) = delete;
  TrueCameras& operator=(const TrueCameras&) = delete;

  bool anySees(const RayScene& scene, const SurfacePoint& point) const;
  Sight sightOf(const RayScene& scene, const SurfacePoint& point) const;

 private:
  struct View {
    host::ViewGeometry geometry;
    Eigen::Vector3f centre;
  };

  /** \param cosine of the angle between the ray and the normal */
  bool sees(const RayScene& scene, const View& view, const SurfacePoint& point, float& cosine) const;

  std::vector<View> views_;
  Visibility visibility_;
};

}  // namespace fuse_flow::simulation
