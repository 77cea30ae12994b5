#pragma once

#include <fuse_flow/fusion/parameters.h>
#include <fuse_flow/impl/parameters.hpp>

namespace fuse_flow {

inline FuseFlowParameters FuseFlowParameters::published() {
  FuseFlowParameters p;
  p.smoothing.passes = 0;
  p.adapt_noise = false;
  p.half_weight_noise = 0;
  p.gate_noise = 0;
  p.max_noise = 0;
  p.min_support = 0;
  p.confidence.form = ConfidenceForm::Published;
  p.confidence.threshold = 0.4f;
  p.consistency.occlusion = OcclusionForm::Published;
  p.consistency.distance = DistanceForm::Euclidean;
  p.consistency.sigma_per_noise = 0;
  p.aggregation.representatives = Representatives::HighestConfidence;
  p.aggregation.consistency_at = ConsistencyAt::Representatives;
  p.aggregation.min_weight = 0;
  p.aggregation.weak_weight = 0;
  p.aggregation.confirmation_reach = 0;
  return p;
}

inline FuseFlowParameters FuseFlowParameters::estimatedDepth() {
  FuseFlowParameters p;
  p.preprocessing.max_range = 1000;  // the unit of photographs may be any
  p.gate_noise = 0;
  p.max_noise = 0;
  p.agreement.min_views = 2;
  p.adapt_noise = false;
  p.smoothing.tolerance = 4;
  p.smoothing.wide_above = 0;
  p.consistency.weigh_contradictions = true;
  p.consistency.margin = 2;
  p.consistency.max_views = 16;
  p.consistency.max_candidates = 16;
  p.aggregation.confirmation_reach = 0.04f;
  return p;
}

inline void checkParameters(const FuseFlowParameters& p) {
  checkParameters(p.preprocessing);
  checkParameters(p.smoothing);
  checkParameters(p.confidence);
  checkParameters(p.consistency);
  checkParameters(p.aggregation);
  detail::checkLengthOrNone("fuse_flow::FuseFlow", "half_weight_noise", p.half_weight_noise);
  detail::checkLengthOrNone("fuse_flow::FuseFlow", "gate_noise", p.gate_noise);
  detail::checkLengthOrNone("fuse_flow::FuseFlow", "max_noise", p.max_noise);
  detail::checkRange("fuse_flow::FuseFlow", "min_support", p.min_support, 0, 8);
  detail::checkRange("fuse_flow::FuseFlow", "min_confidence", p.min_confidence, 0.0f, 1.0f);
  detail::checkRange("fuse_flow::FuseFlow", "agreement.min_views", p.agreement.min_views, 0, kMaxAgreeingViews);
  detail::checkPositive("fuse_flow::FuseFlow", "agreement.pixels", p.agreement.pixels);
  detail::checkPositive("fuse_flow::FuseFlow", "agreement.relative", p.agreement.relative);
  detail::checkRange("fuse_flow::FuseFlow", "agreement.relative", p.agreement.relative, 0.0f, 1.0f);
  if (p.crop_box && (p.crop_box->isEmpty() || !p.crop_box->min().allFinite() || !p.crop_box->max().allFinite()))
    detail::throwBadArgument("fuse_flow::FuseFlow: crop_box is empty or not finite");
}

}  // namespace fuse_flow
