#pragma once

#include <fuse_flow/math/stereo/inverse_plane.h>

namespace fuse_flow {

/** \brief From the rays of a view to the pixels of another view, by way of a plane: the homography H = K (R + t qᵀ), where q are the
 *  numbers of the InversePlane (Hartley and Zisserman, Multiple View Geometry, 13.1). */
struct ViewWarp {
  Vec3 u;  ///< first row of K R
  Vec3 v;  ///< second row
  Vec3 z;  ///< third row: of R
  Vec3 t;  ///< K t, metres times pixels; t.z metres
};

/** \brief A homography near one pixel: the pixel (du, dv) beside it falls on (u + u_du du + u_dv dv, v + v_du du + v_dv dv). Within a
 *  matching window, what it leaves out is some hundredths of a pixel. */
struct LocalWarp {
  float u;        ///< column where the pixel itself falls, pixels
  float v;        ///< its row
  float u_du;     ///< how u moves with du
  float u_dv;     ///< how u moves with dv
  float v_du;     ///< how v moves with du
  float v_dv;     ///< how v moves with dv
  bool in_front;  ///< whether the plane is in front of the other view there
};

/** \brief \param ray of the pixel  \param pixel_x, pixel_y width and height of a pixel at depth 1: 1/fx and 1/fy of the reference image */
FUSE_FLOW_HD LocalWarp localWarp(const ViewWarp& warp, const InversePlane& plane, const Ray& ray, float pixel_x,
                                 float pixel_y) {
  const Vec3 hx{warp.u.x + warp.t.x * plane.x, warp.v.x + warp.t.y * plane.x, warp.z.x + warp.t.z * plane.x};
  const Vec3 hy{warp.u.y + warp.t.x * plane.y, warp.v.y + warp.t.y * plane.y, warp.z.y + warp.t.z * plane.y};
  const Vec3 hw{warp.u.z + warp.t.x * plane.w, warp.v.z + warp.t.y * plane.w, warp.z.z + warp.t.z * plane.w};
  const Vec3 q = ray.x * hx + ray.y * hy + hw;
  const float inverse_z = 1.0f / q.z;
  const float u = q.x * inverse_z, v = q.y * inverse_z;
  const float across = inverse_z * pixel_x, along = inverse_z * pixel_y;
  return {u,
          v,
          (hx.x - u * hx.z) * across,
          (hy.x - u * hy.z) * along,
          (hx.y - v * hx.z) * across,
          (hy.y - v * hy.z) * along,
          q.z > 0};
}

}  // namespace fuse_flow
