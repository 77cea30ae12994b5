#pragma once

#include <fuse_flow/gpu/fusion/fuse_children.h>
#include <fuse_flow/math/representatives.h>

namespace fuse_flow {
namespace gpu {

/** \brief Whether a pixel's point has passed the gate. */
struct HasPoint {
  const WeightedPoint* points;
  FUSE_FLOW_HD bool operator()(std::uint32_t index) const { return points[index].C > 0; }
};

/** \brief The ablation's point-wise fusion: a gated point with the points that other views have in its place. */
struct FusePointWise {
  PixelGrid grid;
  ConsistencyEvaluator evaluator;
  const WeightedPoint* points;
  const std::uint32_t* gated;
  float min_weight;
  bool use_consistency;
  FusedPoint* fused;
  float* weights;
  std::uint8_t* states;
  std::uint32_t* view_counts;
  /** \brief Null, or receives PointCameras::mask(). */
  std::uint64_t* masks;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const std::uint32_t index = gated[k];
    const WeightedPoint own = points[index];
    PointWiseFusion fusion(own.p);
    const std::uint32_t i = grid.viewOf(index);
    std::uint64_t mask = cameraBit(i);
    if (use_consistency) {
      const Vec3 normal = evaluator.normalAt(i, index);
      fusion.add(index, own.p, own.C * consistency(evaluator.parameters, evaluator(own.p, normal, i)));
      const FusePointWise& self = *this;
      evaluator.forEachOpinion(own.p, normal, i,
                               [&fusion, &self, &mask](const PixelAddress& a, const ViewOpinion& said) {
                                 const std::uint32_t other = self.grid.views[a.view].indexOf(a.u, a.v);
                                 const WeightedPoint theirs = self.points[other];
                                 if (!(theirs.C > 0) || said.verdict != ViewOpinion::Distance) return;
                                 mask |= cameraBit(a.view);
                                 fusion.add(other, theirs.p, theirs.C * expOfNegative(-said.squared_distance));
                               });
    } else {
      fusion.add(index, own.p, own.C);
    }
    const FusedPoint point = fusion.finish();
    fused[k] = point;
    view_counts[k] = point.views;
    if (masks != nullptr) masks[k] = mask;
    weights[k] = point.weight;
    states[k] = point.weight > 0 && !(point.weight < min_weight) ? Kept : Dropped;
  }
};

}  // namespace gpu
}  // namespace fuse_flow
