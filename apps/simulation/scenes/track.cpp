#include "simulation/scenes/track.h"

#include <algorithm>
#include <cmath>

namespace fuse_flow::simulation {

double Track::at(double time) const {
  const double period = keys_.back().time, t = time - period * std::floor(time / period);
  const auto next =
      std::upper_bound(keys_.begin() + 1, keys_.end() - 1, t, [](double at, const Key& key) { return at < key.time; });
  const Key &a = *(next - 1), &b = *next;
  const double h = b.time - a.time, s = (t - a.time) / h;
  // Value, velocity and acceleration of both ends, in units of h.
  const double by = b.value - a.value, va = h * a.velocity, vb = h * b.velocity, aa = h * h * a.acceleration,
               ab = h * h * b.acceleration;
  const double cubic = 10 * by - 6 * va - 4 * vb - 1.5 * aa + 0.5 * ab;
  const double quartic = -15 * by + 8 * va + 7 * vb + 1.5 * aa - ab;
  const double quintic = 6 * by - 3 * va - 3 * vb - 0.5 * aa + 0.5 * ab;
  return a.value + s * (va + s * (0.5 * aa + s * (cubic + s * (quartic + s * quintic))));
}

}  // namespace fuse_flow::simulation
