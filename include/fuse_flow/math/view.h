#pragma once

#include <fuse_flow/depth_view.h>
#include <fuse_flow/math/color_depth.h>
#include <fuse_flow/math/pinhole.h>
#include <fuse_flow/sensors/multipath.h>

#include <cfloat>

namespace fuse_flow {

/** \brief The data of one calibrated view that the per-pixel maths needs. */
struct ViewModel {
  Intrinsics intrinsics;          ///< of the depth camera
  RigidTransform T_world_camera;  ///< camera to world, metres
  RigidTransform T_camera_world;  ///< its inverse
  /** \brief Of the ideal lens; see locate(). */
  ProjectionMatrix P;
  bool ideal{true};  ///< without distortion
  /** \brief Of the rays of a lens with distortion: the largest x² + y². */
  float max_squared_radius{0};
  /** \brief The colour camera, where it is not the depth camera. */
  bool own_color_camera{false};
  Intrinsics color_intrinsics;   ///< of that camera
  RigidTransform T_color_depth;  ///< depth camera to colour camera, metres
  /** \brief Of the rays of the colour camera, where its lens has distortion: the largest x² + y². */
  float color_max_squared_radius{0};
  Multipath multipath;  ///< of the depth camera

  /** \brief The pixel nearest to a point in the world frame, and the point's depth. False where the image does not
   *  reach. */
  FUSE_FLOW_HD bool locate(const Vec3& p_W, int& u, int& v, float& z) const {
    float x = 0, y = 0;
    if (!locate(p_W, x, y, z)) return false;
    u = static_cast<int>(x);
    v = static_cast<int>(y);
    return true;
  }

  /** \brief The same with where in the image the point falls: pixel (u, v) reaches from x = u and y = v to u + 1 and v + 1. */
  FUSE_FLOW_HD bool locate(const Vec3& p_W, float& x, float& y, float& z) const {
    Vec3 q;
    const bool before = project(p_W, q);
    z = q.z;
    if (!before) return false;
    return place(q, intrinsics, x, y);
  }

  /** \brief Where a point in the world frame falls, inside the image or not. False behind the camera, or where the lens shows nothing.
   *  \param p_W the point, metres
   *  \param q (u z, v z, z): pixel coordinates times the depth, and the depth, metres */
  FUSE_FLOW_HD bool project(const Vec3& p_W, Vec3& q) const {
    q = P * p_W;
    if (!(q.z > 0)) return false;
    if (ideal) return true;
    const float z = q.z;
    const Vec3 p_C = T_camera_world * p_W;
    if (foldsBack(p_C, max_squared_radius)) return false;
    const Pixel pixel = fuse_flow::project(intrinsics, p_C);
    q = {pixel.u * z, pixel.v * z, z};
    return true;
  }

  /** \brief The last step of locate(), without branches, so that loops over it become vector code. \param q (u z, v z, z)
   *  \param K of the image  \param x where the point falls, as in locate()  \param y the same */
  FUSE_FLOW_HD static bool place(const Vec3& q, const Intrinsics& K, float& x, float& y) {
    const float inverse_z = 1.0f / q.z;
    x = q.x * inverse_z + 0.5f;
    y = q.y * inverse_z + 0.5f;
    // Compared as floats, so that a far-off projection never overflows an integer.
    return (q.z > 0) & (x >= 0) & (x < static_cast<float>(K.width)) & (y >= 0) & (y < static_cast<float>(K.height));
  }

  /** \brief Far outside the field of view the polynomial of a lens folds back into the image. \param p_C in the camera's frame;
   *  z > 0  \param max_squared_radius of the rays of the image */
  FUSE_FLOW_HD static bool foldsBack(const Vec3& p_C, float max_squared_radius) {
    return p_C.x * p_C.x + p_C.y * p_C.y > 1.02f * max_squared_radius * p_C.z * p_C.z;
  }
};

/** \brief The colour of a point in a view's colour image. */
struct ViewColor {
  Vec3 rgb{};         ///< channels 0 … 255; black where it is not known
  bool known{false};  ///< whether the image shows the point at all
};

/** \brief The mean of the colours that are known. */
struct ColorMean {
  Vec3 sum{};      ///< Σ share · colour, channels 0 … 255
  float total{0};  ///< Σ share

  /** \brief One more. \param share its weight  \param color counts only where it is known */
  FUSE_FLOW_HD void add(float share, const ViewColor& color) {
    if (!color.known) return;
    sum = sum + share * color.rgb;
    total += share;
  }
  /** \brief Channels 0 … 255; black where none was known. */
  FUSE_FLOW_HD Vec3 mean() const { return total > 0 ? (1.0f / total) * sum : Vec3{}; }
};

/** \brief The mean of the normals that are known. */
struct NormalMean {
  Vec3 sum{};  ///< Σ share · normal

  /** \brief One more. \param share its weight  \param normal of any length; zero or not finite: not known */
  FUSE_FLOW_HD void add(float share, const Vec3& normal) {
    if (isFinite(normal)) sum = sum + share * normal;
  }
  /** \brief Whether there is a mean. */
  FUSE_FLOW_HD bool known() const { return squaredNorm(sum) > 0; }
  /** \brief Of length 1; zero where none was known. */
  FUSE_FLOW_HD Vec3 mean() const {
    const float norm = std::sqrt(squaredNorm(sum));
    return norm > 0 ? (1.0f / norm) * sum : Vec3{};
  }
  /** \brief Of length 1; NaN where none was known, as in PCL's clouds. */
  FUSE_FLOW_HD Vec3 meanOrNan() const { return known() ? mean() : Vec3{NAN, NAN, NAN}; }
};

/** \brief The mean of the intensities that are known. */
struct IntensityMean {
  float sum{0};    ///< Σ share · intensity
  float total{0};  ///< Σ share

  /** \brief One more. \param share its weight  \param intensity not finite: not known */
  FUSE_FLOW_HD void add(float share, float intensity) {
    if (!(std::fabs(intensity) <= FLT_MAX)) return;
    sum += share * intensity;
    total += share;
  }
  /** \brief NaN where none was known. */
  FUSE_FLOW_HD float mean() const { return total > 0 ? sum / total : NAN; }
};

/** \brief How bright a colour is, as pcl::PointXYZRGBtoXYZI() has it (Rec. 601). \param rgb channels 0 … 255 \returns 0 … 255 */
FUSE_FLOW_HD float luminance(const Vec3& rgb) { return 0.299f * rgb.x + 0.587f * rgb.y + 0.114f * rgb.z; }

/** \brief The colour of a pixel. */
FUSE_FLOW_HD ViewColor pixelColor(const ImageView<Rgb8>& image, int u, int v) {
  if (!image) return {};
  const Rgb8 c = image.row(v)[u];
  return {{static_cast<float>(c.r), static_cast<float>(c.g), static_cast<float>(c.b)}, true};
}

/** \brief The place of a point in the image of a separate colour camera. */
struct ColorPixel {
  Pixel pixel;        ///< may lie beside the image
  float z{0};         ///< depth along the colour camera's axis, metres
  bool known{false};  ///< whether the point is in front of the camera, and within the field of its lens model
};

/** \brief Of the point at depth z on a ray of the depth camera. */
FUSE_FLOW_HD ColorPixel colorPixel(const ViewModel& view, const Ray& ray, float z) {
  const Vec3 p_C = view.T_color_depth * pointOnRay(ray, z);
  if (!(p_C.z > 0)) return {};
  const bool ideal = isIdeal(view.color_intrinsics.distortion);
  if (!ideal && ViewModel::foldsBack(p_C, view.color_max_squared_radius)) return {};
  return {project(view.color_intrinsics, p_C), p_C.z, true};
}

/** \brief Colour of the depth pixel (u, v) with depth z on its ray: that of the same pixel, pixelColor(), where depth and colour are
 *  registered. With a separate colour camera, the point is projected into its image. If it misses the image by less than a pixel, the
 *  colour of the border is used. The colour is not known if a nearer surface hides the point from the colour camera. \param nearest of that
 *  camera */
FUSE_FLOW_HD ViewColor viewColor(const ViewModel& view, const ImageView<Rgb8>& image, const ColorDepth& nearest, int u,
                                 int v, const Ray& ray, float z) {
  if (!image) return {};
  if (view.own_color_camera) {
    const ColorPixel at = colorPixel(view, ray, z);
    if (!at.known) return {};
    const float x = at.pixel.u + 0.5f, y = at.pixel.v + 0.5f;
    const auto width = static_cast<float>(image.width), height = static_cast<float>(image.height);
    if (!(x > -1 && y > -1 && x < width + 1 && y < height + 1) || nearest.hides(at.pixel, at.z)) return {};
    u = static_cast<int>(clampTo(x, 0.0f, width - 1));
    v = static_cast<int>(clampTo(y, 0.0f, height - 1));
  }
  return pixelColor(image, u, v);
}

/** \brief Whether a neighbouring depth belongs to the surface whose normal is taken at a pixel. \param z the neighbour's, metres
 *  \param centre the pixel's, metres */
FUSE_FLOW_HD bool continues(float z, float centre) { return (z > 0) & (std::fabs(z - centre) < 0.05f * z); }

/** \brief Unit normal of the depth surface at a pixel, world frame, facing its camera; zero where neighbours are
 *  missing. \param surface has depth(u, v), 0 beyond the image's border, and ray(u, v) */
template <typename Surface>
FUSE_FLOW_HD Vec3 surfaceNormal(const ViewModel& view, const Surface& surface, int u, int v) {
  const float centre = surface.depth(u, v);
  const auto at = [&](int a, int b) {
    const float z = surface.depth(a, b);
    return continues(z, centre) ? pointOnRay(surface.ray(a, b), z) : pointOnRay(surface.ray(u, v), centre);
  };
  const Vec3 along_u = at(u + 1, v) - at(u - 1, v);
  const Vec3 along_v = at(u, v + 1) - at(u, v - 1);
  const Vec3 n = cross(along_v, along_u);  // v × u points back at the camera: x right, y down, z forward
  const float norm = std::sqrt(squaredNorm(n));
  return norm > 0 ? rotate(view.T_world_camera, (1.0f / norm) * n) : Vec3{};
}

/** \brief Depths of a pixel and of those around it at a spacing, metres. */
struct DepthCross {
  float here;         ///< of the pixel
  float left, right;  ///< beside it in its row
  float up, down;     ///< beside it in its column
};

/** \brief surfaceNormal() before an ideal lens, in the frame of the camera, but of any length: with differences (a/fx, b/fy, c) along the
 *  row and the column, fx fy times their cross product needs no division. Without branches, so that loops over it become vector
 *  code. \param column of the pixel, from the principal point  \param row the same  \param fx of the lens, pixels  \param fy the same
 *  \param spacing to the neighbours, pixels */
FUSE_FLOW_HD Vec3 idealNormal(const DepthCross& z, float column, float row, float fx, float fy, float spacing) {
  const bool has_left = continues(z.left, z.here), has_right = continues(z.right, z.here);
  const bool has_up = continues(z.up, z.here), has_down = continues(z.down, z.here);
  const float z_left = has_left ? z.left : z.here, x_left = has_left ? column - spacing : column;
  const float z_right = has_right ? z.right : z.here, x_right = has_right ? column + spacing : column;
  const float z_up = has_up ? z.up : z.here, y_up = has_up ? row - spacing : row;
  const float z_down = has_down ? z.down : z.here, y_down = has_down ? row + spacing : row;
  const float across = z_right - z_left, along = z_down - z_up;
  const Vec3 along_u{x_right * z_right - x_left * z_left, row * across, across};
  const Vec3 along_v{column * along, y_down * z_down - y_up * z_up, along};
  const Vec3 normal = cross(along_v, along_u);
  return {fx * normal.x, fy * normal.y, normal.z};
}

/** \brief The rays of these pixels; of those whose depth does not continue the surface, any. */
struct RayCross {
  Ray here;         ///< of the pixel
  Ray left, right;  ///< beside it in its row
  Ray up, down;     ///< beside it in its column
};

/** \brief The same before any lens. */
FUSE_FLOW_HD Vec3 normalOfAnyLens(const DepthCross& z, const RayCross& rays) {
  const Vec3 here = pointOnRay(rays.here, z.here);
  const Vec3 left = continues(z.left, z.here) ? pointOnRay(rays.left, z.left) : here;
  const Vec3 right = continues(z.right, z.here) ? pointOnRay(rays.right, z.right) : here;
  const Vec3 up = continues(z.up, z.here) ? pointOnRay(rays.up, z.up) : here;
  const Vec3 down = continues(z.down, z.here) ? pointOnRay(rays.down, z.down) : here;
  return cross(down - up, right - left);
}

/** \brief Where the surface at a pixel faces: surfaceNormal(), but of any length, which takes less time. \param surface as there
 *  \param spacing to the neighbours, pixels */
FUSE_FLOW_CALLS_ANY
template <typename Surface>
FUSE_FLOW_HD Vec3 surfaceDirection(const ViewModel& view, const Surface& surface, int u, int v, int spacing) {
  const DepthCross z{surface.depth(u, v), surface.depth(u - spacing, v), surface.depth(u + spacing, v),
                     surface.depth(u, v - spacing), surface.depth(u, v + spacing)};
  const Intrinsics& K = view.intrinsics;
  if (view.ideal)
    return rotate(view.T_world_camera, idealNormal(z, static_cast<float>(u) - K.cx, static_cast<float>(v) - K.cy, K.fx,
                                                   K.fy, static_cast<float>(spacing)));
  RayCross rays{};
  rays.here = surface.ray(u, v);
  if (continues(z.left, z.here)) rays.left = surface.ray(u - spacing, v);
  if (continues(z.right, z.here)) rays.right = surface.ray(u + spacing, v);
  if (continues(z.up, z.here)) rays.up = surface.ray(u, v - spacing);
  if (continues(z.down, z.here)) rays.down = surface.ray(u, v + spacing);
  return rotate(view.T_world_camera, normalOfAnyLens(z, rays));
}

}  // namespace fuse_flow
