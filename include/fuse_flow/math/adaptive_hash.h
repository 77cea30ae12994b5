#pragma once

namespace fuse_flow {

/** \brief Which measurements represent a cell in eq. 11. */
enum class Representatives {
  /** \brief As published: the three measurements of highest C, from any cameras. */
  HighestConfidence,
  /** \brief The measurement of highest C of each camera, for the three cameras with the highest of these values. */
  DifferentCameras,
  /** \brief The confidence-weighted mean of the points of each camera, for the three cameras with the most weight. */
  CameraMeans
};

/** \brief Where V of eq. 7 is computed for a cell. */
enum class ConsistencyAt {
  /** \brief As published: at each representative. */
  Representatives,
  /** \brief Once, at their confidence-weighted mean: within a cell much smaller than σ all have nearly the same V. */
  CellMean
};

/** \brief Parameters of section 5. */
struct AggregationParameters {
  /** \brief Side of a coarse cell, metres; (0, 10]. */
  float cell_size{0.064f};
  /** \brief Smallest side of a refined cell, metres; (0, 1], or up to cell_size if that is more. The side of a cell is cell_size / 2^L with
   *  L ≤ 5, and never less than this. If this is cell_size or more, no cell is refined. */
  float min_cell_size{0.008f};
  /** \brief Target number of points in a refined cell; > 0. */
  float points_per_cell{1.0f};
  /** \brief Which measurements represent a cell. */
  Representatives representatives{Representatives::CameraMeans};
  /** \brief Where V is computed. */
  ConsistencyAt consistency_at{ConsistencyAt::CellMean};
  /** \brief A fused point of smaller ω is always dropped; [0, 1]. */
  float min_weight{0.0051f};
  /** \brief A fused point of ω under this is weak. It is kept only if none of the 26 cells around it, in the same coarse cell, keeps a
   *  better point. So where views disagree, the measurements that agree stay. A surface that only doubtful measurements show becomes
   *  thinner, but does not vanish; [0, 1], 0 keeps all points. */
  float weak_weight{0.15f};
  /** \brief The reach r of Confirmation, metres: a fused point moves towards the refined depth of the other views that see a surface within
   *  this distance of it. On the optical axes of these views it moves by less than 0.46 of this; off the axes it may move farther, because
   *  a ray is longer than its depth. For noisy views the reach is up to twice as large, see reach_per_noise. A point may leave its cell; a
   *  point that leaves the crop box is dropped. Where neighbouring pixels of a view differ by more than this, the view is not used. [0,
   *  10], 0: points do not move. Only with ConsistencyAt::CellMean, and only in the frame pipeline, because the filters have no refined
   *  depth. */
  float confirmation_reach{0.025f};
  /** \brief The reach is at least this times the axial noise of the view that sees the surface, up to twice confirmation_reach; ≥ 0. The
   *  axial noise is Camera::noise or ConfidenceParameters::noise, times the noise scale of FuseFlowParameters::adapt_noise. For cameras
   *  with a modulation frequency it includes the remaining multipath interference (kResidualMultipath). Without this, views would hardly
   *  confirm far surfaces, whose noise is larger than confirmation_reach. */
  float reach_per_noise{2.1f};
};

}  // namespace fuse_flow
