#pragma once

#include <fuse_flow/math/confidence.h>
#include <fuse_flow/one_thread.h>
#include <fuse_flow/precompiled.h>
#include <fuse_flow/rig_frame.h>
#include <fuse_flow/sensors/preprocessing.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

namespace fuse_flow {

namespace host {
class AlignmentSystem;
class RigPlacement;
struct PlacedGroup;
}  // namespace host

/** \brief How CoarseAlignment searches for poses, and when it accepts them. */
struct CoarseAlignmentParameters {
  PreprocessingParameters preprocessing;  ///< raw depth to metres
  NoiseModel noise;                       ///< of the cameras without their own model, see Camera::noise
  /** \brief Number of oriented points of a view, chosen evenly over the directions of their normals; ≥ 100. The cost is quadratic in
   *  this. */
  int samples{600};
  /** \brief Side of the cells in which points vote for translations and in which floor patterns are compared, metres; 0.01 … 10. The time
   *  of the comparison grows with the fourth power of its inverse. */
  float cell_size{0.1f};
  /** \brief Largest distance from a surface at which a point agrees with it, in addition to the noise of both, metres; (0, 10]. */
  float tolerance{0.03f};
  /** \brief Largest roll of a camera about its optical axis, radians; ≥ 0. A surface that looks like a floor in one view is then a floor in
   *  all views. π or more: nothing is known about the floor. */
  float max_roll{0.35f};
  /** \brief Use colour, where both views have it. */
  bool use_color{true};
  /** \brief Number of candidate poses of each pair of cameras, for shape and for floor patterns separately; ≥ 2. They are kept until the
   *  other cameras decide between them. */
  int hypotheses{12};
  /** \brief Smallest ViewAgreement::score() of a placed camera, summed over the cameras placed before it; (0, 100). For one of these
   *  cameras, shape gives at most 100, and patterns give at most 275 with the default samples. */
  float min_score{24.0f};
  /** \brief A pose is ambiguous if another one scores more than this share of its score; (0, 1). */
  float max_ambiguity{0.8f};
};

/** \brief How well two views agree at one relative pose, averaged over the instants. */
struct ViewAgreement {
  /** \brief Points that lie on the surface that the other view measured. */
  double confirmed{0};
  /** \brief Points that lie on this surface, but where its normal or its colour differs. */
  double unlike{0};
  /** \brief Points in space that the other view saw as free. */
  double contradicted{0};
  /** \brief Standard deviation of the difference in brightness of the two views, over the points that they confirm, grey levels. A constant
   *  difference does not count. 0: too few points with colour. */
  double color_spread{0};
  /** \brief Evidence that both views see the same pattern: artanh(r) √n, where r is the correlation of their brightness at n points, at
   *  most 0.99. Neighbours are not independent, so this is not a standard score. ≥ 0; 0 for fewer than 30 points, without colour, and
   *  without a pattern. */
  double color_evidence{0};
  /** \brief How well the spread fits two views of the same surface, compared with the usual difference between views of this rig; (0, 1]. 1
   *  without colour. */
  double likeness{1};
  /** \brief The score of a pose. More confirmations add less and less, because the many points of a wall are one piece of evidence. A
   *  pattern on the wall counts separately. A few contradictions in a hundred are noise. */
  double score() const {
    constexpr double many = 100, paint = 3, noise = 0.04, weight = 3;
    const double alike = std::max(0.0, confirmed - unlike);
    return likeness * (many * (1 - std::exp(-alike / many)) + paint * color_evidence) -
           weight * std::max(0.0, contradicted - noise * confirmed);
  }
};

/** \brief Two placed cameras that see the same surfaces. */
struct CoarseOverlap {
  std::size_t first{0};     ///< number of a camera
  std::size_t second{0};    ///< of another, larger
  ViewAgreement agreement;  ///< at the poses found
};

/** \brief Why a camera has the pose that it has. */
enum class Placement {
  Missing,    ///< it measured nothing
  Alone,      ///< no other view shares enough with its own
  Ambiguous,  ///< other views may share enough, but several poses explain what they share
  Placed      ///< relative to the other cameras of its group
};

/** \brief What CoarseAlignment found. */
struct CoarseAlignmentResult {
  /** \brief Camera by camera. The frame of each group is that of its first camera. The identity for a camera that is not placed. */
  std::vector<Eigen::Isometry3d> T_world_camera;
  std::vector<Placement> placements;  ///< camera by camera
  /** \brief For each camera, the first camera of its group. A group is a set of cameras that overlaps connect. For a camera that is not
   *  placed, its own number. */
  std::vector<std::size_t> groups;
  std::vector<CoarseOverlap> overlaps;  ///< within the groups

  /** \brief Whether all cameras are placed in one group. */
  FUSE_FLOW_INLINE bool complete() const;
};

/** \brief Estimates the camera poses of a rig without initial poses, from the views of one or more instants. The result is the initial
 *  value for ExtrinsicEstimation. It uses the intrinsics of the cameras, but not their poses.
 *
 *  Candidate rotations align the dominant surface directions of two views. For each rotation, points with similar normals vote for the
 *  translation. If there is colour, further candidates come from floor patterns: their grey levels are correlated over all rotations and
 *  translations. The candidates come from the first instant. All instants score them: each view is projected into the depth image of the
 *  other view. Points in space that the other camera saw as free lower the score; similar brightness raises it. Then the cameras are placed
 *  one by one, the least ambiguous first. Each camera gets the pose that agrees best with all cameras that are already placed.
 *
 *  Neighbouring cameras must share furniture or corners, or a floor with a pattern that does not repeat itself; one wall is not enough. If
 *  a room has nearly the same shape after half a turn, colour resolves the ambiguity. Without colour, the result may be turned by half a
 *  turn, and this is not always detected: look at the result.
 *
 *  \code
 *  fuse_flow::CoarseAlignment alignment;
 *  alignment.addFrame(frame);
 *  const fuse_flow::CoarseAlignmentResult coarse = alignment.estimate();
 *  \endcode
 *
 *  Only one thread at a time may use an object; a second thread gets a pcl::PCLException. Objects share nothing, so each thread may use its
 *  own object. */
class CoarseAlignment {
 public:
  FUSE_FLOW_INLINE CoarseAlignment();
  FUSE_FLOW_INLINE ~CoarseAlignment();

  /** \brief Throws pcl::BadArgumentException for a value out of range. */
  FUSE_FLOW_INLINE void setParameters(const CoarseAlignmentParameters& parameters);
  /** \brief What setParameters() set, or the defaults. */
  FUSE_FLOW_INLINE const CoarseAlignmentParameters& getParameters() const;

  /** \brief Threads to use; 0, the default, is one per core. The result is the same for any number. */
  FUSE_FLOW_INLINE void setNumberOfThreads(unsigned int threads);

  /** \brief Forget all frames. */
  FUSE_FLOW_INLINE void clear();

  /** \brief Adds one instant; the necessary data are copied. \throws pcl::BadArgumentException if a camera or a view contradicts itself, or
   *  if the number of cameras differs from the earlier frames */
  FUSE_FLOW_INLINE void addFrame(const RigFrame& frame);

  /** \brief Estimates the poses, as far as the frames determine them. \throws pcl::PCLException without a frame */
  FUSE_FLOW_INLINE CoarseAlignmentResult estimate();

 private:
  FUSE_FLOW_INLINE void dropAmbiguous(const host::RigPlacement& placement, host::PlacedGroup& group, int threads,
                                      CoarseAlignmentResult& result) const;
  FUSE_FLOW_INLINE void accept(const host::RigPlacement& placement, const host::PlacedGroup& group,
                               CoarseAlignmentResult& result) const;

  CoarseAlignmentParameters parameters_;
  int threads_{0};
  std::size_t cameras_{0};
  detail::OneThread one_thread_;
  std::unique_ptr<host::AlignmentSystem> system_;
};

}  // namespace fuse_flow

#ifndef FUSE_FLOW_DECLARATIONS_ONLY
#include <fuse_flow/impl/calibration/coarse_alignment.hpp>
#endif
