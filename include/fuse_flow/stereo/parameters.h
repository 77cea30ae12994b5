#pragma once

#include <cstdint>

namespace fuse_flow {

/** \brief Most views that one view is matched with. */
constexpr int kMaxStereoSources = 8;
/** \brief Most sizes of the images. */
constexpr int kMaxStereoLevels = 5;

/** \brief Everything that decides what depth MultiViewStereo finds. The defaults are what measured best for its time; see doc/notes/stereo.md. */
struct StereoParameters {
  /** \brief Each view is matched with so many others, the ones that see the same and stand at a good angle; 1 … kMaxStereoSources. */
  int max_sources{4};
  /** \brief The cost of a depth is the mean over so many of them, those that match best: the others may not see the surface; 1 … 4. */
  int best_sources{2};
  /** \brief Smallest depth that is looked for, metres; 0: from the cameras, the depth from which on two views see the same at less than 45°. */
  float min_depth{0};
  /** \brief Largest depth that is looked for, metres; what lies beyond has no confidence; 0: from the cameras, that at which the widest baseline shifts the image by two
   *  pixels. */
  float max_depth{0};
  /** \brief Sizes of the images, each half of the one before: coarse to fine; 1 … kMaxStereoLevels. */
  int levels{3};
  /** \brief Step of the plane sweep at the coarsest level, pixels of the widest baseline; (0, 8]. */
  float sweep_step{1.25f};
  /** \brief Most planes of the sweep; 2 … 1024. If the step would need more, it is larger. */
  int max_planes{256};
  /** \brief Passes over each level but the finest; 1 … 16. */
  int coarse_passes{2};
  /** \brief Passes over the finest level; 0 … 16, 0: depth has the details of the level before. */
  int fine_passes{1};
  /** \brief Between the 5 × 5 samples of a matching window, pixels; 1 … 8. */
  int window_spacing{2};
  /** \brief Of the window's bilateral weights, grey levels; > 0. */
  float level_sigma{30};
  /** \brief Variance, in squared grey levels, that is taken for noise where images have no texture; > 0. */
  float min_variance{3};
  /** \brief Geometric consistency: how much a pixel costs by which another view's depth disagrees with it, there and back; >= 0, 0: it is not
   *  asked. */
  float geometric_weight{0.1f};
  /** \brief More pixels than this cost no more; > 0. */
  float geometric_limit{3};
  /** \brief Smallest cosine of the angle between a ray and the normal of the surface; [0, 1). */
  float min_incidence{0.15f};
  /** \brief Share of the depth, but at least a pixel of the widest baseline, by which a surface must end before what lies behind it, for pixels
   *  up to half a window beside that edge to be doubted that look more as what lies beyond the edge than as the surface: windows there find the
   *  nearer surface, and surfaces grow. Their confidence is halved. [0, 1), 0: edges are not looked for. Less is more exact, but hands and other
   *  small things lose points. */
  float edge_step{0.015f};
  /** \brief How far other depths are looked for that match as well as the one found, because a pattern repeats itself; pixels of the widest
   *  baseline, 0 … 256, 0: they are not looked for. The confidence of such pixels is halved. */
  int repetition_reach{32};
  /** \brief Of the random numbers. */
  std::uint32_t seed{1};
};

/** \brief Throws pcl::BadArgumentException naming the parameter and its value if one is out of its range. */
inline void checkParameters(const StereoParameters& parameters);

}  // namespace fuse_flow

#include <fuse_flow/impl/stereo/parameters.hpp>
