#pragma once

#include <fuse_flow/depth_view.h>
#include <fuse_flow/math/confidence.h>
#include <fuse_flow/math/exponential.h>
#include <fuse_flow/math/pinhole.h>

#include <cmath>

namespace fuse_flow {

/** \brief What a view in which the point is hidden, or in which there is free space at the point, says about it. */
enum class OcclusionForm {
  /** \brief As published: every view that the point projects into counts with its d². */
  Published,
  /** \brief A view is skipped that cannot see the point: it measured something nearer by more than the margin, or the
   *  point's surface faces away from it (min_facing). One that measured well behind the point, and has not measured it
   *  beside (silhouette_radius), has seen through it: that multiplies V by free_space_penalty, and is not averaged away by
   *  views that agree. */
  OcclusionAware
};

/** \brief How d_ij of eq. 6 is measured. */
enum class DistanceForm {
  /** \brief As published: ‖P − Q‖, the distance between the points; includes up to half a pixel sideways. */
  Euclidean,
  /** \brief |z − D| along the other camera's ray. */
  AlongRay
};

/** \brief Most that ConsistencyParameters::silhouette_radius may be, pixels. */
constexpr int kMaxSilhouetteRadius = 8;

/** \brief Parameters of eq. 4–7. */
struct ConsistencyParameters {
  /** \brief What hidden points and free space say. */
  OcclusionForm occlusion{OcclusionForm::OcclusionAware};
  /** \brief How d_ij is measured. */
  DistanceForm distance{DistanceForm::AlongRay};
  /** \brief σ, metres; (0, 10]. */
  float sigma{0.02f};
  /** \brief σ is at least so many standard deviations of the axial noise of the view that is asked, at the depth that it
   *  measured; ≥ 0, 0 is the published constant. The frame pipeline measures that noise (FuseFlowParameters::adapt_noise);
   *  the filters know it of cameras that have a model of their own (Camera::noise) alone. */
  float sigma_per_noise{1.0f};
  /** \brief Beyond this many σ a nearer measurement hides the point and a farther one has seen through it; > 0. */
  float margin{2.5f};
  /** \brief What each view that has seen through a point multiplies its V by; (0, 1]. */
  float free_space_penalty{0.03f};
  /** \brief Whether a view that has seen through a point counts by the confidence c of the pixel that says so (DepthView::confidence; 1
   *  without one): it multiplies V by c · free_space_penalty + 1 − c. For depth that was estimated. */
  bool weigh_contradictions{false};
  /** \brief Least cosine of the angle between a surface's normal and the direction to a view that is asked about it; [−1, 1],
   *  −1: views are asked wherever the surface faces. From behind, a limb that is thinner than the margin looks as if its front
   *  contradicted its back. Points whose normal is not known are asked about everywhere. Only with OcclusionAware. */
  float min_facing{0.05f};
  /** \brief A view sees through a point only if no pixel up to so many columns and rows from where the point falls has measured
   *  a surface within margin · sigma of the point's depth, and more than that before what is measured where it falls; pixels,
   *  [0, kMaxSilhouetteRadius], 0: the pixel where it falls decides alone. Poses are a few millimetres off, so points near the
   *  edge of an object fall beside it. Only with OcclusionAware. */
  int silhouette_radius{2};
  /** \brief K: a point is compared with at most K − 1 other views; ≥ 2. */
  int max_views{8};
  /** \brief A point looks into at most this many other views to find those K − 1; ≥ max_views − 1. */
  int max_candidates{12};
};

/** \brief σ of eq. 7. \param noise the axial noise of the measurement that is compared with, metres; 0: not known */
FUSE_FLOW_HD float consistencySigma(const ConsistencyParameters& p, float noise) {
  const float least = p.sigma_per_noise * noise;
  return p.sigma > least ? p.sigma : least;
}

/** \brief What one other view says about a point. */
struct ViewOpinion {
  /** \brief Nothing, because something nearer hides the point; how far apart they are; or that it cannot be there. */
  enum Verdict { Hidden, Distance, SeenThrough };
  Verdict verdict{Hidden};  ///< which of the three
  /** \brief d² / σ² of eq. 7, if the verdict is Distance. */
  float squared_distance{0};
  /** \brief Of the pixel that has seen through the point, [0, 1]. */
  float confidence{1.0f};
};

/** \brief Whether the view's own measurement stands for the point too: it is no farther from it than σ. */
FUSE_FLOW_HD bool agrees(const ViewOpinion& opinion) {
  return opinion.verdict == ViewOpinion::Distance && opinion.squared_distance <= 1.0f;
}

/** \brief How far a measurement may lie from a point along the ray and still be of its surface, in σ: nearer it hides the point,
 *  farther it has seen through it. Infinite where occlusion does not matter. */
FUSE_FLOW_HD float occlusionMargin(const ConsistencyParameters& p) {
  return p.occlusion == OcclusionForm::OcclusionAware ? p.margin : INFINITY;
}

/** \brief Whether it matters where the surface of a point faces. */
FUSE_FLOW_HD bool asksForNormals(const ConsistencyParameters& p) {
  return p.occlusion == OcclusionForm::OcclusionAware && p.min_facing > -1.0f;
}

/** \brief A normal as isAsked() takes it. \param normal of any length; zero or not finite: not known
 *  \param to_camera from the point to the camera that measured it, any unit: of a normal that points away from it, the other side
 *  is meant \returns zero: not known */
FUSE_FLOW_HD Vec3 facingNormal(const Vec3& normal, const Vec3& to_camera) {
  if (!isFinite(normal)) return {};
  return dot(normal, to_camera) < 0 ? -1.0f * normal : normal;
}

/** \brief Whether a view is asked about a point, where asksForNormals(). \param normal of the point's surface, of any length under
 *  10¹⁸; zero: not known  \param to_view from the point to the view's centre, same axes, any unit */
FUSE_FLOW_HD bool isAsked(const ConsistencyParameters& p, const Vec3& normal, const Vec3& to_view) {
  // Without branches, so that loops over it become vector code.
  const float square = squaredNorm(normal);
  return !((square > 0) & (square < INFINITY)) |
         (dot(normal, to_view) >= p.min_facing * std::sqrt(square * squaredNorm(to_view)));
}

/** \brief Whether a view that measured well behind a point has measured the point's surface beside it: then it says nothing. Between
 *  the two lies an edge: on a floor seen at a small angle, pixels beside it are nearer too, but show the same floor. The reach
 *  does not grow with the noise: among many noisy pixels, one always comes near. \param z the point's depth in the
 *  view, metres  \param depth depth(a, b): of the pixel a columns to the right and b rows down from where the point falls,
 *  metres; 0: none */
template <typename Depth>
FUSE_FLOW_HD bool isBesideSilhouette(const ConsistencyParameters& p, float z, const Depth& depth) {
  const int r = p.silhouette_radius;
  const float reach = p.margin * p.sigma;
  const float behind = depth(0, 0);
  for (int b = -r; b <= r; ++b)
    for (int a = -r; a <= r; ++a) {
      const float D = depth(a, b);
      if ((D > 0) & (D >= z - reach) & (D <= z + reach) & (behind - D > reach)) return true;
    }
  return false;
}

/** \brief Eq. 5–6 in camera j's own frame, where no transformation of Q is needed: rigid motions keep distances.
 *  \param p parameters  \param p_J the point in camera j's frame, metres
 *  \param ray_J the ray of the pixel it falls on  \param depth D_j there, metres; > 0
 *  \param noise its axial noise, metres; 0: not known */
FUSE_FLOW_HD ViewOpinion viewOpinion(const ConsistencyParameters& p, const Vec3& p_J, const Ray& ray_J, float depth,
                                     float noise = 0.0f) {
  const float inverse_sigma = 1.0f / consistencySigma(p, noise);
  const float behind = (p_J.z - depth) * inverse_sigma;
  const float margin = occlusionMargin(p);
  if (behind > margin) return {ViewOpinion::Hidden, 0.0f};
  if (behind < -margin) return {ViewOpinion::SeenThrough, 0.0f};
  if (p.distance == DistanceForm::AlongRay) return {ViewOpinion::Distance, behind * behind};
  return {ViewOpinion::Distance, squaredNorm(p_J - pointOnRay(ray_J, depth)) * inverse_sigma * inverse_sigma};
}

/** \brief What a view's own confidence says about a pixel, [0, 1]; 1 where it has none. */
FUSE_FLOW_HD float confidenceAt(const ImageView<float>& confidence, int u, int v) {
  return confidence ? givenConfidence(confidence.row(v)[u]) : 1.0f;
}

/** \brief What a view that has seen through a point multiplies V by, with weigh_contradictions. \param confidence of its pixel, [0, 1] */
FUSE_FLOW_HD float freeSpaceFactor(const ConsistencyParameters& p, float confidence) {
  return confidence * p.free_space_penalty + (1.0f - confidence);
}

/** \brief The opinions of other views on one point, summed up. */
struct Consistency {
  float sum_squared_distance{0};  ///< Σ d²/σ² over the views whose verdict is Distance
  int agreeing{0};                ///< number of those views
  int seeing_through{0};          ///< number of views that measured well behind the point
  /** \brief With weigh_contradictions: what those views multiply V by. */
  float free_space{1.0f};

  /** \brief Views that had a say. */
  FUSE_FLOW_HD int views() const { return agreeing + seeing_through; }
  /** \brief One more view. */
  FUSE_FLOW_HD void add(const ConsistencyParameters& p, const ViewOpinion& opinion) {
    sum_squared_distance += opinion.squared_distance;
    if (opinion.verdict == ViewOpinion::SeenThrough) free_space *= freeSpaceFactor(p, opinion.confidence);
    agreeing += opinion.verdict == ViewOpinion::Distance ? 1 : 0;
    seeing_through += opinion.verdict == ViewOpinion::SeenThrough ? 1 : 0;
  }
};

/** \brief Eq. 7: V = exp(−mean d²/σ²), times the penalty for each view that sees through. A point that no other view
 *  can judge has V = 1. */
FUSE_FLOW_HD float consistency(const ConsistencyParameters& p, const Consistency& c) {
  float V = c.agreeing > 0 ? expOfNegative(-c.sum_squared_distance / static_cast<float>(c.agreeing)) : 1.0f;
  if (p.weigh_contradictions) return V * c.free_space;
  for (int k = 0; k < c.seeing_through; ++k) V *= p.free_space_penalty;
  return V;
}

}  // namespace fuse_flow
