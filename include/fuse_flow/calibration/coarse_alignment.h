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

/** \brief How CoarseAlignment looks for poses, and when it believes them. */
struct CoarseAlignmentParameters {
  PreprocessingParameters preprocessing;  ///< raw depth to metres
  NoiseModel noise;                       ///< of the cameras that have no model of their own, see Camera::noise
  /** \brief Oriented points of a view, chosen evenly over the directions of their normals; ≥ 100. The cost is quadratic in
   *  this. */
  int samples{600};
  /** \brief Side of the cells in which translations are voted for, and in which paint on floors is compared, whose time grows with its
   *  inverse to the fourth; metres; 0.01 … 10. */
  float cell_size{0.1f};
  /** \brief Distance from a surface within which a point agrees with it, beyond the noise of both, metres; (0, 10]. */
  float tolerance{0.03f};
  /** \brief Farthest that a camera is turned about its optical axis, radians; ≥ 0. A surface that looks like a floor then is one
   *  in all views; π or more: nothing is known about the floor. */
  float max_roll{0.35f};
  /** \brief Use colour, where both views have it. */
  bool use_color{true};
  /** \brief Poses of each pair of cameras that are kept until the other cameras decide: so many of shape, and so many of paint; ≥ 2. */
  int hypotheses{12};
  /** \brief Least ViewAgreement::score() of a camera, summed over those placed before it; (0, 100). Of one of them, shape comes
   *  to 100 at most, and paint to 275 with the default samples. */
  float min_score{24.0f};
  /** \brief A pose is ambiguous if another one scores more than this share of its score; (0, 1). */
  float max_ambiguity{0.8f};
};

/** \brief What two views say about each other at one relative pose, on average over the instants. */
struct ViewAgreement {
  /** \brief Points that lie on the surface that the other view measured. */
  double confirmed{0};
  /** \brief Points that lie on it, where it faces elsewhere or has another colour. */
  double unlike{0};
  /** \brief Points where the other view saw through. */
  double contradicted{0};
  /** \brief How much the brightness of both views differs from point to point where they confirm each other, standard deviation,
   *  grey levels; that one is brighter than the other as a whole does not count. 0: too few points with colour. */
  double color_spread{0};
  /** \brief How certain it is that both see the same paint there: artanh(r) √n, r the correlation of their brightness at n points, at most
   *  0.99; neighbours are not independent, so it is no standard score. ≥ 0; 0 for fewer than 30 points, without colour, and where
   *  nothing is painted. */
  double color_evidence{0};
  /** \brief How well the spread fits two views of the same, given how views of this rig differ; (0, 1]. 1 without colour. */
  double likeness{1};
  /** \brief What a pose is judged by. Confirmations are worth less the more there are: of a wall, many are one; what is painted on
   *  it counts beside them. A few contradictions in a hundred are noise. */
  double score() const {
    constexpr double many = 100, paint = 3, noise = 0.04, weight = 3;
    const double alike = std::max(0.0, confirmed - unlike);
    return likeness * (many * (1 - std::exp(-alike / many)) + paint * color_evidence) -
           weight * std::max(0.0, contradicted - noise * confirmed);
  }
};

/** \brief Two cameras that were placed beside each other and see the same surfaces. */
struct CoarseOverlap {
  std::size_t first{0};     ///< number of a camera
  std::size_t second{0};    ///< of another, larger
  ViewAgreement agreement;  ///< at the poses found
};

/** \brief Why a camera has the pose that it has. */
enum class Placement {
  Missing,    ///< it measured nothing
  Alone,      ///< no other view shares enough with its own
  Ambiguous,  ///< others may, but several poses explain what they share
  Placed      ///< relative to the other cameras of its group
};

/** \brief What CoarseAlignment found. */
struct CoarseAlignmentResult {
  /** \brief Camera by camera; the frame of each group is that of its first camera. The identity where not placed. */
  std::vector<Eigen::Isometry3d> T_world_camera;
  std::vector<Placement> placements;  ///< camera by camera
  /** \brief The first camera of the group that a camera is placed in: those that are connected by overlaps. Its own number
   *  where it is not placed. */
  std::vector<std::size_t> groups;
  std::vector<CoarseOverlap> overlaps;  ///< within the groups

  /** \brief Whether all cameras are placed in one group. */
  FUSE_FLOW_INLINE bool complete() const;
};

/** \brief Camera poses of a rig of which nothing is known, from what its depth cameras see at one or more instants: where
 *  ExtrinsicEstimation begins. Intrinsics are taken from the cameras, poses are not.
 *
 *  Rotations that bring the dominant surface directions of two views together; for each, translations by a vote among points
 *  of like normals. Where there is colour, also poses at which what is painted on a floor, or what stands on it, agrees, by
 *  correlation over all turns and shifts. The first instant proposes poses, all of them judge: each view is projected into the
 *  other's depth image, where what the other camera saw through counts against a pose, and brightness that agrees for it. Then the
 *  cameras are placed one by one, the least ambiguous first, each where it agrees best with all that are placed.
 *
 *  Neighbours need to share furniture or corners, or a floor whose paint does not repeat itself; not only one wall. Of a room that after
 *  half a turn has the same shape but for small things, colour tells which way round it is. Without colour it may be taken for its
 *  turned self, and that is not always noticed: look at the result.
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

  /** \brief One instant more; what is needed of it is copied.
   *  \throws pcl::BadArgumentException if a camera or a view contradicts itself, or there are more or fewer cameras than in
   *  the frames before */
  FUSE_FLOW_INLINE void addFrame(const RigFrame& frame);

  /** \brief Poses, as far as the frames tell them. \throws pcl::PCLException without a frame */
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
