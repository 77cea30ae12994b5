#pragma once

#include <fuse_flow/impl/host/depth_map.hpp>
#include <fuse_flow/impl/host/rig_geometry.hpp>
#include <fuse_flow/math/consistency.h>

namespace fuse_flow {
namespace host {

/** \brief Eq. 4–7 over the depth maps of a frame. */
class ConsistencyEvaluator {
 public:
  ConsistencyEvaluator(const ConsistencyParameters& parameters, const RigGeometry& rig, const std::vector<DepthMap>& depths)
      : parameters_(parameters), rig_(&rig), depths_(&depths) {}

  /** \brief Calls visit(j, pixel u, pixel v, opinion) for up to K − 1 views other than camera i that say something about a
   *  point in the world frame. */
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

  /** \brief Eq. 7. */
  float V(const Vec3& p_W, std::size_t i) const { return consistency(parameters_, (*this)(p_W, i)); }

 private:
  template <typename Visit>
  bool ask(const Vec3& p_W, std::uint32_t j, const Visit& visit) const {
    const ViewGeometry& view = (*rig_)[j];
    const DepthMap& depth = (*depths_)[j];
    const Vec3 p_J = view.T_camera_world * p_W;
    if (!(p_J.z > 0) || !view.insideLens(p_J)) return false;
    const Pixel pixel = project(view.intrinsics, p_J);
    // The nearest pixel; compared as floats first, so that a far-off projection never overflows the integer.
    if (!(pixel.u >= -0.5f && pixel.u < static_cast<float>(depth.width()) - 0.5f && pixel.v >= -0.5f &&
          pixel.v < static_cast<float>(depth.height()) - 0.5f))
      return false;
    const int u = static_cast<int>(pixel.u + 0.5f);
    const int v = static_cast<int>(pixel.v + 0.5f);
    const float D = depth.row(v)[u];
    if (!(D > 0)) return false;
    const Ray ray = parameters_.distance == DistanceForm::Euclidean ? view.ray(u, v) : Ray{};
    const ViewOpinion opinion = viewOpinion(parameters_, p_J, ray, D);
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
