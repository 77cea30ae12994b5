#pragma once

#include <fuse_flow/math/view.h>

namespace fuse_flow {

/** \brief Which measurements need others to agree with them. A depth camera is believed where it alone sees a surface. A network or a
 *  stereo method always answers, and is wrong in patches: what it says counts where other views say the same. */
struct AgreementParameters {
  /** \brief A measurement is dropped if fewer other views than this measure the same; [0, kMaxAgreeingViews], 0: none is dropped. All views
   *  of the frame are asked, the nearest ones first, whatever their confidence, unless it is 0. Where cameras are missing from a frame, fewer can
   *  agree. */
  int min_views{0};
  /** \brief A pixel's point, moved to the depth that another view has there and projected back, comes back at most so far from the pixel,
   *  pixels; > 0. */
  float pixels{1.0f};
  /** \brief And at most this share of the depth nearer or farther; (0, 1]. */
  float relative{0.01f};
};

/** \brief Most that AgreementParameters::min_views may be: rigs of 64 cameras have so many others. */
constexpr int kMaxAgreeingViews = 63;

/** \brief Whether another view measures the same as a pixel, there and back, as multi-view stereo compares views (Schönberger et al.,
 *  Pixelwise View Selection for Unstructured Multi-View Stereo, ECCV 2016): the pixel's point is moved along the other view's ray to the
 *  depth that is measured there, and projected back.
 *  \param view of the pixel  \param pixel its place, integer coordinates  \param z its depth, metres  \param p_W its point, world frame
 *  \param other view  \param z_other depth of the point in the other view, metres, > 0  \param measured what the other view has there,
 *  metres; 0: nothing, which agrees with nothing */
FUSE_FLOW_HD bool agreesThereAndBack(const AgreementParameters& p, const ViewModel& view, const Pixel& pixel, float z,
                                     const Vec3& p_W, const ViewModel& other, float z_other, float measured) {
  if (!(measured > 0)) return false;
  const Vec3& centre = other.T_world_camera.t;
  Vec3 q;
  if (!view.project(centre + (measured / z_other) * (p_W - centre), q)) return false;
  // Compared at the depth q.z, without a division.
  const float du = q.x - pixel.u * q.z, dv = q.y - pixel.v * q.z, reach = p.pixels * q.z;
  return (du * du + dv * dv <= reach * reach) & (std::fabs(q.z - z) <= p.relative * z);
}

/** \brief Whether so many other views agree with a pixel. \param view of the pixel  \param pixel its place, integer coordinates
 *  \param z its depth, metres, > 0  \param p_W its point, world frame  \param others how many other views there are
 *  \param model model(k): the k-th one's ViewModel; null: it is missing  \param depth depth(k, u, v): what it has at a pixel, metres */
FUSE_FLOW_CALLS_ANY
template <typename Model, typename Depth>
FUSE_FLOW_HD bool isAgreed(const AgreementParameters& p, const ViewModel& view, const Pixel& pixel, float z,
                           const Vec3& p_W, int others, const Model& model, const Depth& depth) {
  int wanted = p.min_views;
  for (int k = 0; wanted > 0 && others - k >= wanted; ++k) {
    const ViewModel* other = model(k);
    int u = 0, v = 0;
    float z_other = 0;
    if (other == nullptr || !other->locate(p_W, u, v, z_other)) continue;
    wanted -= agreesThereAndBack(p, view, pixel, z, p_W, *other, z_other, depth(k, u, v)) ? 1 : 0;
  }
  return wanted <= 0;
}

}  // namespace fuse_flow
