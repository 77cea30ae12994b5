#pragma once

#include <fuse_flow/distributed/message.h>
#include <fuse_flow/impl/calibration/rig_correspondences.hpp>

#include <cmath>
#include <cstring>

namespace fuse_flow {
namespace distributed {

/** \brief What ranks that search for poses believe of each other. All of it is added up, and projected: numbers that are none, or far too large,
 *  would go on into poses. */
class AlignmentMessages {
 public:
  /** \brief Whether all are numbers, and none is larger. */
  template <typename... Numbers>
  static bool areBelow(float limit, const Numbers&... numbers) {
    return ((std::abs(numbers) <= limit) && ...);  // NaN is not
  }
  /** \brief Whether a view can have such a point. */
  static bool canBe(const AlignmentSample& sample) {
    constexpr float limit = 1e6f;
    const auto is_small = [](const Vec3& x) { return areBelow(limit, x.x, x.y, x.z); };
    for (int scale = 0; scale < kLumaScales; ++scale)
      if (!areBelow(limit, sample.luma[scale], sample.slope[scale].per_u, sample.slope[scale].per_v)) return false;
    return is_small(sample.p) && is_small(sample.n) && sample.p.z > 0 && sample.noise > 0 &&
           areBelow(limit, sample.noise, sample.smooth_ratio) &&
           areBelow(1e9f, sample.pixels_per_metre_x, sample.pixels_per_metre_y);
  }

  /** \brief \throws RankError for what cannot be */
  static AlignmentGates getGates(MessageReader& in) {
    AlignmentGates gates;
    std::memcpy(static_cast<void*>(&gates), in.take(1, sizeof gates), sizeof gates);
    unsigned char color = 0;  // what is no bool may not be read as one
    std::memcpy(&color, &gates.color, 1);
    const bool can_be = gates.scale < static_cast<std::size_t>(kLumaScales) && gates.stride > 0 &&
                        gates.stride <= host::kClusterSamples && color <= 1 &&
                        areBelow(1e10f, gates.distance, gates.deviations, gates.normal_cosine, gates.tukey, gates.reach,
                                 gates.color_tukey);
    if (!can_be) in.fail("gates that cannot be");
    return gates;
  }
  /** \brief \throws RankError for what cannot be */
  static AlignmentSums getSums(MessageReader& in) {
    static_assert(sizeof(AlignmentSums) % sizeof(double) == 0, "numbers alone");
    const auto sums = in.get<AlignmentSums>();
    double numbers[sizeof(AlignmentSums) / sizeof(double)];
    std::memcpy(numbers, &sums, sizeof sums);
    for (const double number : numbers)
      if (!areBelow(1e30f, number)) in.fail("sums that cannot be");
    if (sums.count < 0) in.fail("sums that cannot be");
    return sums;
  }
};

}  // namespace distributed
}  // namespace fuse_flow
