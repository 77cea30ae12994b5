#pragma once

#include <fuse_flow/math/adaptive_hash.h>
#include <fuse_flow/math/agreement.h>
#include <fuse_flow/math/confidence.h>
#include <fuse_flow/math/consistency.h>
#include <fuse_flow/math/smoothing.h>
#include <fuse_flow/sensors/preprocessing.h>

#include <Eigen/Geometry>

#include <optional>

namespace fuse_flow {

/** \brief Everything that decides what a frame is fused into. The defaults are what measured best; see
 *  doc/notes/defaults.md. */
struct FuseFlowParameters {
  PreprocessingParameters preprocessing;  ///< raw depth to metres
  /** \brief D^r of eq. 8. The confidence of eq. 3 and the distances of eq. 6 are taken from the measured depth, points,
   *  colours and normals from the refined one. */
  SmoothingParameters smoothing;
  ConfidenceParameters confidence;    ///< eq. 3 and 9
  ConsistencyParameters consistency;  ///< eq. 4–7
  AggregationParameters aggregation;  ///< section 5
  /** \brief Measure how noisy each view is, and scale the noise model of its camera by it, frame by frame (Camera::noise, or else
   *  ConfidenceParameters::noise); off: each is as noisy as its model says. */
  bool adapt_noise{true};
  /** \brief Axial noise at which a measurement weighs half as much as an exact one, metres; [0, 10], 0: noise does not weigh.
   *  See noiseWeight(); C of eq. 10 is multiplied by it after the gate of eq. 9. */
  float half_weight_noise{0.025f};
  /** \brief The gate of eq. 9 asks for C > τ only where the axial noise is more than this, metres; [0, 10], 0: everywhere. C is low on noisy
   *  measurements, and on the rims of curved surfaces: an exact sensor measures these rims well, and without them people lose the sides of
   *  arms and hands. The axial noise is Camera::noise or ConfidenceParameters::noise, times the noise scale of adapt_noise. Of views that give
   *  a confidence of their own, C > τ is asked everywhere: their depth may be estimated, and smooth where it is wrong. */
  float gate_noise{0.02f};
  /** \brief Measurements with more axial noise than this are dropped, metres; [0, 10], 0: none is. Smoothing cannot bring them
   *  near to the surface: they are what a noisy sensor leaves beside it. */
  float max_noise{0.07f};
  /** \brief Of the eight pixels around a measurement so many must pass the gate of eq. 9 too and continue its surface, see
   *  surfaceSupport(), or it is dropped: what sensors measure beside an edge, between one surface and another, lies alone; 0 … 8, 0: none must. Up to 3 the
   *  corners of surfaces stay. Without measurement confidence none must. */
  int min_support{3};
  /** \brief Measurements to which DepthView::confidence gives less than this are dropped; [0, 1], 0: only those to which it gives none. The
   *  gate of eq. 9 looks at C of eq. 3 alone; what passes both weighs C times the given confidence. With ConfidenceForm::Given that is C
   *  itself: the gate looks at it, and it weighs once. */
  float min_confidence{0.5f};
  /** \brief Measurements that too few other views confirm are dropped, for depth that was estimated. Its refined depth is compared. Does not
   *  depend on use_distance_consistency. */
  AgreementParameters agreement;
  /** \brief MF of the paper's ablation; off: C = 1 wherever there is a measurement, whatever its noise and what is around it, times the view's own
   *  confidence. */
  bool use_measurement_confidence{true};
  /** \brief DC; off: V = 1. */
  bool use_distance_consistency{true};
  /** \brief SA; off: point-wise fusion, one output point for each pixel that passes the gate. */
  bool use_spatial_hash{true};
  /** \brief Points outside are dropped, before the fusion and, where other views confirm that they lie outside, after it: no fused point
   *  lies outside; world frame, metres. */
  std::optional<Eigen::AlignedBox3f> crop_box;

  /** \brief The forms of eq. 3, 6, 7 and of the representatives as the paper prints them; doc/reference/parameters.md says how what it leaves open is
   *  settled. */
  static FuseFlowParameters published();

  /** \brief For depth that a network or multi-view stereo estimated from colour images, at least three cameras. Two other views must measure the
   *  same (AgreementParameters), the confidence of contradicting pixels counts, and noise is not measured in the frame: errors of such depth are
   *  smooth patches, in which neighbouring pixels differ by a quarter of the error. Neither range nor noise drops depth, since the unit of length of photographs may be
   *  any. Fused points move up to 40 mm to what views confirm. Give the
   *  confidence that came with the depth as DepthView::confidence. doc/notes/estimated_depth.md says how it was chosen. */
  static FuseFlowParameters estimatedDepth();
};

/** \brief Throws pcl::BadArgumentException naming the parameter and its value if one is out of its range. */
inline void checkParameters(const FuseFlowParameters& parameters);

}  // namespace fuse_flow

#include <fuse_flow/impl/fusion/parameters.hpp>
