#pragma once

namespace fuse_flow {

/** \brief Parameters of the steps that compute D^r of eq. 8 from the raw depth. */
struct PreprocessingParameters {
  float min_range{0.1f};   ///< nearest depth that counts as a measurement, metres; ≥ 0
  float max_range{20.0f};  ///< farthest, metres; > min_range, finite
  /** \brief Fill a pixel without measurement when at least this many of its 8 neighbours have one and agree to within
   *  fill_tolerance; 3 … 8, or 0 to fill nothing. */
  int fill_neighbours{0};
  float fill_tolerance{
      0.02f};  ///< largest spread of those neighbours, metres up to 1 m, beyond that times their mean squared; (0, 10]
  /** \brief pcl::FastBilateralFilter over each depth image of more than one row. On the CPU, it is the only step that allocates memory in
   *  each frame. */
  bool bilateral{false};
  float bilateral_sigma_s{3.0f};   ///< its spatial standard deviation, pixels; > 0
  float bilateral_sigma_r{0.03f};  ///< its depth standard deviation, metres; (0, 10]
};

}  // namespace fuse_flow
