#pragma once

#include <fuse_flow/math/vec3.h>

namespace fuse_flow {

/** \brief The depth of a view between its pixels, metres: 1/z is taken as an affine function of the pixel, as it is on planes. 0
 *  where neither neighbour in a row, or in a column, is of the pixel's surface.
 *  \param du how far right of the centre of its pixel the place is, pixels, −½ … ½  \param dv how far down
 *  \param jump pixels that differ by this much, metres, are of different surfaces
 *  \param depth depth(a, b): of the pixel a columns to the right and b rows down; 0: none; of the pixel itself > 0 */
template <typename Depth>
FUSE_FLOW_HD float depthBetween(float du, float dv, float jump, const Depth& depth) {
  constexpr float kUnknown = -2.0f;  // 1/z does not fall below zero: none is smaller than −1
  const float here = depth(0, 0);
  // By how much of itself 1/z grows in one step; kUnknown: not known. The pixel on the other side stands in for the nearer one.
  const auto growth = [here, jump](float there) {
    const float step = here - there;
    return (there > 0) & (step < jump) & (step > -jump) ? step / there : kUnknown;
  };
  const int right = du < 0 ? -1 : 1, down = dv < 0 ? -1 : 1;
  float x = du < 0 ? -du : du, y = dv < 0 ? -dv : dv;
  float in_row = growth(depth(right, 0)), in_column = growth(depth(0, down));
  if (in_row == kUnknown) {
    in_row = growth(depth(-right, 0));
    x = -x;
  }
  if (in_column == kUnknown) {
    in_column = growth(depth(0, -down));
    y = -y;
  }
  return (in_row == kUnknown) | (in_column == kUnknown) ? 0.0f : here / (1.0f + (x * in_row + y * in_column));
}

/** \brief Where other views confirm a cell's point, their refined depth says where it lies: a cell has the measurements that
 *  fell into it, and misses those of the same surface that noise put into the next. With e_j = D^r_j − z_j along the ray
 *  of view j, whose centre is c_j, and Tukey's a_j = (1 − (e_j/r)²)² inside the reach r, the point moves by
 *
 *    min_j a_j · Σ_j w_j (p − c_j) e_j / z_j / (ω + Σ_j w_j),   w_j = a_j · noiseWeight(noise of view j),
 *
 *  where ω is its own weight. The first factor leaves it alone where the views do not agree where the surface is. */
class Confirmation {
 public:
  /** \brief One view more, which measured a surface at the point. \param from_centre p − c_j, world axes, metres
   *  \param z_J the point's depth in that view, metres  \param refined D^r there, metres; 0: the view says nothing
   *  \param noise_weight of what it measured; [0, 1]  \param reach r, metres; > 0 */
  FUSE_FLOW_HD void add(const Vec3& from_centre, float z_J, float refined, float noise_weight, float reach) {
    if (!(refined > 0)) return;
    const float e = refined - z_J;
    const float x = e / reach;
    const float inside = 1.0f - x * x;
    const float a = inside > 0 ? inside * inside : 0.0f;
    if (a < agreement_) agreement_ = a;
    if (!(a > 0)) return;
    const float w = a * noise_weight;
    sum_ = sum_ + (w * e / z_J) * from_centre;
    total_ += w;
  }

  /** \brief Where the point then lies. \param p where its own measurements put it  \param weight ω */
  FUSE_FLOW_HD Vec3 moved(const Vec3& p, float weight) const {
    return total_ > 0 ? p + (agreement_ / (weight + total_)) * sum_ : p;
  }

 private:
  Vec3 sum_{};
  float total_{0};
  float agreement_{1};
};

}  // namespace fuse_flow
