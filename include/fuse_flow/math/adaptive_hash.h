#pragma once

namespace fuse_flow {

/** \brief Which measurements stand for a cell in eq. 11. */
enum class Representatives {
  /** \brief As published: the three of highest C, whichever cameras they come from. */
  HighestConfidence,
  /** \brief The most confident one of each camera, of the three cameras whose best is highest. */
  DifferentCameras,
  /** \brief The confidence-weighted mean of each camera's points, of the three cameras with the most weight. */
  CameraMeans
};

/** \brief Where V of eq. 7 is measured for a cell. */
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
  /** \brief Smallest side of a refined cell, metres; (0, 1], or up to cell_size where that is more. Cells are cell_size / 2^L with L ≤ 5, and none is refined to less than this: from
   *  cell_size upwards, none is refined at all. */
  float min_cell_size{0.008f};
  /** \brief Points wanted in a refined cell; > 0. */
  float points_per_cell{1.0f};
  /** \brief Which measurements stand for a cell. */
  Representatives representatives{Representatives::CameraMeans};
  /** \brief Where V is measured. */
  ConsistencyAt consistency_at{ConsistencyAt::CellMean};
  /** \brief A fused point of smaller ω is dropped, whatever surrounds it; [0, 1]. */
  float min_weight{0.0051f};
  /** \brief A fused point of ω under this is weak: it is kept only if none of the 26 cells around it in the same coarse
   *  cell keeps a better one. Where views disagree the measurements that agree stay, and a surface that only doubtful
   *  measurements show thins out instead of vanishing; [0, 1], 0 keeps all. */
  float weak_weight{0.15f};
  /** \brief The reach r of Confirmation, metres: a fused point moves towards the refined depth of the other views that see a surface within
   *  so many metres of it, by less than 0.46 of that on the optical axes of those views, and off them by as much more as their rays are
   *  longer than their depth; twice as far where the views are noisy, see reach_per_noise. It may leave its cell or the crop box by as
   *  much. Where neighbouring pixels of a view differ by more than this, the view says nothing. [0, 10], 0: points stay where their own
   *  measurements put them. Only with ConsistencyAt::CellMean, and only in the frame pipeline: the filters know no refined depth. */
  float confirmation_reach{0.025f};
  /** \brief The reach is at least this times the axial noise of the view that sees the surface (Camera::noise or
   *  ConfidenceParameters::noise, times what FuseFlowParameters::adapt_noise finds), together with what multipath interference that no view explains leaves (kResidualMultipath; of
   *  cameras with a modulation frequency), up to twice confirmation_reach; ≥ 0. Else views would hardly confirm
   *  far surfaces, whose measurements noise scatters wider than that. */
  float reach_per_noise{2.1f};
};

}  // namespace fuse_flow
