#include "evaluation/truth_sight.h"

#include "simulation/portable_math.h"

#include <algorithm>

namespace fuse_flow::simulation {

TrueCameras::TrueCameras(const std::vector<Camera>& cameras, const std::vector<bool>& present,
                         const Visibility& visibility)
    : visibility_(visibility) {
  views_.reserve(cameras.size());
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    if (!present[k]) continue;
    views_.push_back({{}, cameras[k].T_world_camera.translation().cast<float>()});
    views_.back().geometry.assign(cameras[k]);
  }
}

bool TrueCameras::sees(const RayScene& scene, const View& view, const SurfacePoint& point, float& cosine) const {
  int u = 0, v = 0;
  float z = 0;
  const Eigen::Vector3f& p = point.position;
  if (!view.geometry.locate({p.x(), p.y(), p.z()}, u, v, z)) return false;
  if (z < visibility_.min_range || z > visibility_.max_range) return false;
  cosine = point.normal.dot((view.centre - p).normalized());
  return cosine > portable::cos(visibility_.max_incidence) && !scene.occluded(view.centre, p, 2e-3f);
}

bool TrueCameras::anySees(const RayScene& scene, const SurfacePoint& point) const {
  float cosine = 0;
  return std::any_of(views_.begin(), views_.end(), [&](const View& view) { return sees(scene, view, point, cosine); });
}

Sight TrueCameras::sightOf(const RayScene& scene, const SurfacePoint& point) const {
  Sight sight;
  float best = -1;
  for (const View& view : views_) {
    float cosine = 0;
    if (!sees(scene, view, point, cosine)) continue;
    ++sight.cameras;
    best = std::max(best, cosine);
  }
  if (sight.cameras > 0) sight.incidence = portable::acos(std::min(best, 1.0f));
  return sight;
}

}  // namespace fuse_flow::simulation
