#pragma once

#include <fuse_flow/math/vec3.h>

namespace fuse_flow {

/** \brief The depth of a view between its pixels, metres: 1/z is taken as an affine function of the pixel, as it is on planes. 0
 *  where neither neighbour in a row, or in a column, is of the pixel's surface.
 *  \param du how far right of the centre of its pixel the place is, pixels, −½ … ½  \param dv how far down
 *  \param jump pixels that differ by this much, metres, are of different surfaces
 *  \param depth depth(a, b): of the pixel a columns to the right and b rows down; 0: none */
template <typename Depth>
FUSE_FLOW_HD float depthBetween(float du, float dv, float jump, const Depth& depth) {
  const float here = depth(0, 0);
  const auto same = [here, jump](float there) {
    const float step = here - there;
    return (there > 0) & (step < jump) & (step > -jump);
  };
  const int right = du < 0 ? -1 : 1, down = dv < 0 ? -1 : 1;
  float x = du < 0 ? -du : du, y = dv < 0 ? -dv : dv;
  float beside = depth(right, 0), below = depth(0, down);
  if (!same(beside)) {  // the pixel on the other side stands in
    beside = depth(-right, 0);
    if (!same(beside)) return 0;
    x = -x;
  }
  if (!same(below)) {
    below = depth(0, -down);
    if (!same(below)) return 0;
    y = -y;
  }
  // here / (1 + x (here − beside) / beside + y (here − below) / below), with one division
  const float product = beside * below;
  return here * product / (product + (x * (here - beside) * below + y * (here - below) * beside));
}

/** \brief Where other views confirm a cell's point, their refined depth says where it lies: a cell has the measurements that
 *  fell into it, and misses those of the same surface that noise put into the next. With e_j = D^r_j − z_j along the ray
 *  of view j, whose centre is c_j, and Tukey's a_j = (1 − (e_j/r)²)² inside the reach r, the point moves by
 *
 *    min_j a_j · Σ_j w_j (p − c_j) e_j / z_j / (ω + Σ_j w_j),   w_j = a_j · noiseWeight(noise of view j),
 *
 *  where ω is what its own measurements weigh. The first factor leaves it alone where the views do not agree where the surface is. */
struct Confirmation {
  /** \brief How many of the views that measured a surface at the point have a say, the nearest ones: more cost time and hardly
   *  help. */
  static constexpr int kViews = 4;

  Vec3 sum{};          ///< Σ w e / z (p − c), metres
  float total{0};      ///< Σ w
  float agreement{1};  ///< min a

  /** \brief One view more, which measured a surface at the point. \param from_centre p − c_j, world axes, metres
   *  \param z_J the point's depth in that view, metres  \param refined D^r there, metres; 0: the view says nothing
   *  \param noise_weight of what it measured; [0, 1]  \param per_reach 1 / r, 1/metres; > 0 */
  FUSE_FLOW_HD void add(const Vec3& from_centre, float z_J, float refined, float noise_weight, float per_reach) {
    // Without branches: which way they would go is anyone's guess.
    const bool known = refined > 0;
    const float e = known ? refined - z_J : 0.0f;
    const float x = e * per_reach;
    const float rest = 1.0f - x * x;
    const float inside = rest > 0 ? rest : 0.0f;
    const float a = inside * inside;
    const float w = known ? a * noise_weight : 0.0f;
    agreement = a < agreement ? a : agreement;
    sum = sum + (w * e / z_J) * from_centre;
    total += w;
  }

  /** \brief Where the point then lies. \param p where its own measurements put it  \param weight ω */
  FUSE_FLOW_HD Vec3 moved(const Vec3& p, float weight) const {
    return total > 0 ? p + (agreement / (weight + total)) * sum : p;
  }
};

}  // namespace fuse_flow
