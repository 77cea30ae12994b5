#pragma once

#include <fuse_flow/impl/host/depth_map.hpp>
#include <fuse_flow/impl/host/rig_geometry.hpp>
#include <fuse_flow/math/consistency.h>

namespace fuse_flow {
namespace host {

/** \brief Eq. 4–7 over the depth maps of a frame. */
class ConsistencyEvaluator {
 public:
  ConsistencyEvaluator(const ConsistencyParameters& parameters, const RigGeometry& rig,
                       const std::vector<DepthMap>& depths)
      : parameters_(parameters), rig_(&rig), depths_(&depths) {}

  /** \brief Calls visit(j, pixel u, pixel v, opinion) for up to K − 1 views other than camera i that say something
   *  about a point in the world frame. */
  template <typename Visit>
  void forEachOpinion(const Vec3& p_W, std::size_t i, const Visit& visit) const {
    int views = 0;
    int candidates = 0;
    for (const std::uint32_t j : (*rig_)[i].neighbours) {
      if ((*depths_)[j].empty()) continue;
      if (views >= parameters_.max_views - 1 || ++candidates > parameters_.max_candidates) break;
      views += ask(p_W, j, visit) ? 1 : 0;
    }
  }

  Consistency operator()(const Vec3& p_W, std::size_t i) const {
    Consistency result;
    forEachOpinion(p_W, i, [&](std::uint32_t, int, int, const ViewOpinion& opinion) { result.add(opinion); });
    return result;
  }

  /** \brief The same for a point that came from none of the cameras: camera 0 is asked first, then its neighbours. */
  Consistency askAll(const Vec3& p_W) const {
    Consistency result;
    const auto add = [&](std::uint32_t, int, int, const ViewOpinion& opinion) { result.add(opinion); };
    if (!(*depths_)[0].empty()) ask(p_W, 0, add);
    forEachOpinion(p_W, 0, add);
    return result;
  }

  /** \brief Eq. 7. */
  float V(const Vec3& p_W, std::size_t i) const { return consistency(parameters_, (*this)(p_W, i)); }

 private:
  template <typename Visit>
  bool ask(const Vec3& p_W, std::uint32_t j, const Visit& visit) const {
    const ViewGeometry& view = (*rig_)[j];
    int u = 0, v = 0;
    float z = 0;
    if (!view.locate(p_W, u, v, z)) return false;
    const float D = (*depths_)[j].row(v)[u];
    if (!(D > 0)) return false;
    const bool euclidean = parameters_.distance == DistanceForm::Euclidean;
    const ViewOpinion opinion = euclidean ? viewOpinion(parameters_, view.T_camera_world * p_W, view.ray(u, v), D)
                                          : viewOpinion(parameters_, {0, 0, z}, {}, D);
    if (opinion.verdict == ViewOpinion::Hidden) return false;
    visit(j, u, v, opinion);
    return true;
  }

  ConsistencyParameters parameters_;
  const RigGeometry* rig_;
  const std::vector<DepthMap>* depths_;
};

}  // namespace host
}  // namespace fuse_flow
