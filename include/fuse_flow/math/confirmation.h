#pragma once

#include <fuse_flow/math/adaptive_hash.h>
#include <fuse_flow/math/confidence.h>
#include <fuse_flow/math/vec3.h>

namespace fuse_flow {

/** \brief Whether two neighbouring pixels show one surface. \param here depth of the one, metres  \param there of the other; 0: none
 *  \param jump those that differ by this much, metres, are of different surfaces */
FUSE_FLOW_HD bool isSameSurface(float here, float there, float jump) {
  const float step = here - there;
  return (there > 0) & (step < jump) & (step > -jump);
}

/** \brief The depth of a view between its pixels, metres: 1/z is taken as an affine function of the pixel, as it is on planes. 0
 *  where neither neighbour in a row, or in a column, is of the pixel's surface.
 *  \param x how far the place is from the centre of its pixel along the row, pixels, 0 … ½  \param y the same along the column
 *  \param jump see isSameSurface()  \param here depth of the pixel; 0: none
 *  \param beside of its neighbour on the place's side  \param opposite of the one on the other side, which stands in for it
 *  \param below of the neighbour in the column on the place's side  \param above of the one on the other side */
FUSE_FLOW_HD float depthBetween(float x, float y, float jump, float here, float beside, float opposite, float below,
                                float above) {
  // Without branches, so that loops over it become vector code.
  const bool has_beside = isSameSurface(here, beside, jump), has_below = isSameSurface(here, below, jump);
  const bool has_row = has_beside | isSameSurface(here, opposite, jump);
  const bool has_column = has_below | isSameSurface(here, above, jump);
  const float row = has_beside ? beside : opposite, along = has_beside ? x : -x;
  const float column = has_below ? below : above, down = has_below ? y : -y;
  // here / (1 + x (here − row) / row + y (here − column) / column), with one division
  const float product = row * column;
  const float depth = here * product / (product + (along * (here - row) * column + down * (here - column) * row));
  return (has_row & has_column) ? depth : 0.0f;
}

/** \brief The same of an image. \param du how far right of the centre of its pixel the place is, pixels, −½ … ½
 *  \param dv how far down  \param depth depth(a, b): of the pixel a columns to the right and b rows down; 0: none */
template <typename Depth>
FUSE_FLOW_HD float depthBetween(float du, float dv, float jump, const Depth& depth) {
  const int right = du < 0 ? -1 : 1, down = dv < 0 ? -1 : 1;
  const float here = depth(0, 0), beside = depth(right, 0), below = depth(0, down);
  const float opposite = isSameSurface(here, beside, jump) ? 0.0f : depth(-right, 0);  // seldom looked at
  const float above = isSameSurface(here, below, jump) ? 0.0f : depth(0, -down);
  return depthBetween(du < 0 ? -du : du, dv < 0 ? -dv : dv, jump, here, beside, opposite, below, above);
}

/** \brief Moves the point of a cell to the surface that the refined depth of other views shows. A cell has only the measurements that fell
 *  into it. It misses measurements of the same surface that noise put into the next cell. With e_j = D^r_j − z_j along the ray of view j,
 *  whose centre is c_j, and a_j = (1 − (e_j/r_j)⁴)² inside the reach r_j of squaredReach(), the point moves by
 *
 *    min_j a_j · Σ_j w_j (p − c_j) e_j / z_j / (ω + Σ_j w_j),   w_j = a_j · noiseWeight(noise of view j),
 *
 *  where ω is the weight of its own measurements. If the views disagree about the place of the surface, the first factor keeps the point in
 *  place. A view well inside the reach counts nearly in full: 0.98 at a third of the reach. */
struct Confirmation {
  /** \brief Number of views that are used, of those that measured a surface at the point. The nearest ones are used; more views cost time
   *  and hardly help. */
  static constexpr int kViews = 4;

  Vec3 sum{};          ///< Σ w e / z (p − c), metres
  float total{0};      ///< Σ w
  float agreement{1};  ///< min a

  /** \brief The contribution of one view. */
  struct Share {
    float a;     ///< how well it agrees; [0, 1]
    float w;     ///< its weight; [0, 1]
    float pull;  ///< w e / z
  };

  /** \brief Largest reach divided by the smallest reach, even for noisy views: a good measurement from nearby must not follow a bad
   *  measurement from far away. */
  static constexpr float kWidest = 2.0f;

  /** \brief r² of a view, square metres: r is the larger of least and per_noise · √variance, but at most kWidest · least.
   *  \param least metres; > 0  \param per_noise ≥ 0  \param variance of the view's depth there, see varianceOf() */
  FUSE_FLOW_HD static float squaredReach(float least, float per_noise, float variance) {
    return clampTo(per_noise * per_noise * variance, least * least, kWidest * kWidest * least * least);
  }

  /** \brief Variance of a depth, square metres. \param noise its standard deviation by noise, metres  \param multipath see
   *  residualMultipath(), 1/metres
   *  \param z the depth, metres */
  FUSE_FLOW_HD static float varianceOf(float noise, float multipath, float z) {
    const float late = multipath * z * z;
    return noise * noise + late * late;
  }

  /** \brief The contribution of a view that measured a surface at the point. \param z_J the point's depth in that view, metres
   *  \param refined D^r there, metres; 0: the view is not used
   *  \param noise_weight of its measurement; [0, 1]  \param squared_reach r², square metres; > 0 */
  FUSE_FLOW_HD static Share share(float z_J, float refined, float noise_weight, float squared_reach) {
    // Without branches, because the processor could not predict them.
    const bool known = refined > 0;
    const float e = known ? refined - z_J : 0.0f;
    const float square = e * e / squared_reach;
    const float rest = 1.0f - square * square;
    const float inside = rest > 0 ? rest : 0.0f;
    const float a = inside * inside;
    const float w = known ? a * noise_weight : 0.0f;
    return {a, w, w * e / z_J};
  }

  /** \brief Parameters of the contributions; the same for a whole frame. */
  struct Weighing {
    float reach{0};            ///< AggregationParameters::confirmation_reach, metres; > 0
    float reach_per_noise{0};  ///< AggregationParameters::reach_per_noise; ≥ 0
    float per_half_weight{0};  ///< 1 / FuseFlowParameters::half_weight_noise, 1/metres; 0: noise does not weigh

    /** \brief See Confirmation::share(). \param z_J as there  \param refined as there  \param noise of the view's depth there, metres  \param multipath see residualMultipath()
     *  \param here that depth, metres */
    FUSE_FLOW_HD Share share(float z_J, float refined, float noise, float multipath, float here) const {
      return Confirmation::share(z_J, refined, noiseWeight(noise, per_half_weight),
                                 squaredReach(reach, reach_per_noise, varianceOf(noise, multipath, here)));
    }
  };

  /** \brief Adds a view. \param from_centre p − c_j, world axes, metres \param said result of share() for this view */
  FUSE_FLOW_HD void add(const Vec3& from_centre, const Share& said) {
    agreement = said.a < agreement ? said.a : agreement;
    sum = sum + said.pull * from_centre;
    total += said.w;
  }

  /** \brief The new position of the point. \param p its position from its own measurements  \param weight ω */
  FUSE_FLOW_HD Vec3 moved(const Vec3& p, float weight) const {
    return total > 0 ? p + (agreement / (weight + total)) * sum : p;
  }
};

/** \brief Computed once for each frame. \param half_weight_noise as in FuseFlowParameters, metres */
FUSE_FLOW_HD Confirmation::Weighing confirmationWeighing(const AggregationParameters& p, float half_weight_noise) {
  return {p.confirmation_reach, p.reach_per_noise, half_weight_noise > 0 ? 1.0f / half_weight_noise : 0.0f};
}

}  // namespace fuse_flow
