#pragma once

#include <fuse_flow/math/pinhole.h>
#include <fuse_flow/math/vec3.h>

#include <cmath>

namespace fuse_flow {

/** \brief A plane before a camera, as the inverse depth that it has on each ray: 1/z = x · ray.x + y · ray.y + w. For the plane n · X = d,
 *  (x, y, w) is n/d. It is linear in the ray, so it is the same plane for every pixel and for every size of the image. In 1/m. */
struct InversePlane {
  float x;  ///< by how much 1/z grows per unit of ray.x
  float y;  ///< the same of ray.y
  float w;  ///< 1/z on the optical axis
};

/** \brief 1/z of the plane on a ray; not positive where the ray does not meet it in front of the camera. */
FUSE_FLOW_HD float inverseDepth(const InversePlane& plane, const Ray& ray) {
  return plane.x * ray.x + plane.y * ray.y + plane.w;
}

/** \brief The plane that has an inverse depth on a ray. \param x, y its slopes */
FUSE_FLOW_HD InversePlane planeThrough(const Ray& ray, float inverse_depth, float x, float y) {
  return {x, y, inverse_depth - x * ray.x - y * ray.y};
}

/** \brief Cosine of the angle between a ray and the normal of a plane that it meets at this inverse depth. */
FUSE_FLOW_HD float incidenceCosine(const InversePlane& plane, const Ray& ray, float inverse_depth) {
  const float normal = plane.x * plane.x + plane.y * plane.y + plane.w * plane.w;
  const float length = ray.x * ray.x + ray.y * ray.y + 1;
  return inverse_depth / std::sqrt(normal * length);
}

/** \brief Unit normal of a plane, in the camera's frame, facing the camera. */
FUSE_FLOW_HD Vec3 normalOf(const InversePlane& plane) {
  const float norm = std::sqrt(plane.x * plane.x + plane.y * plane.y + plane.w * plane.w);
  return norm > 0 ? (-1.0f / norm) * Vec3{plane.x, plane.y, plane.w} : Vec3{};
}

/** \brief Whether a surface ends between a pixel and another one: that one is farther than the surface would be if it went on as it comes from
 *  the opposite pixel, at the same distance. Depth is inverse, so that planes go on straight; 1/metres. Where the opposite pixel is of another
 *  surface, too (a twentieth nearer or farther), as on thin things, it is not known. \param step share of the depth by which it must be farther */
FUSE_FLOW_HD bool surfaceEnds(float here, float there, float opposite, float step) {
  constexpr float kSame = 0.05f;
  return (2 * here - opposite - there > step * here) & (there < (1 - step) * here) & (opposite - here < kSame * here) &
         (here - opposite < kSame * here);
}

}  // namespace fuse_flow
