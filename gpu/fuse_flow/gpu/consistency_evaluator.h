#pragma once

#include <fuse_flow/gpu/device_view.h>
#include <fuse_flow/math/consistency.h>

namespace fuse_flow {
namespace gpu {

/** \brief Eq. 4–7 over the depth maps of a frame. */
struct ConsistencyEvaluator {
  const DeviceView* views;
  const float* z;
  ConsistencyParameters parameters;

  /** \brief What view j says about a point in the world frame; false: nothing. \param address receives where it falls */
  FUSE_FLOW_HD bool ask(const Vec3& p_W, std::uint32_t j, ViewOpinion& said, PixelAddress& address) const {
    const DeviceView& view = views[j];
    address.view = j;
    float depth_of_point = 0;
    if (!view.model.locate(p_W, address.u, address.v, depth_of_point)) return false;
    const float D = z[view.indexOf(address.u, address.v)];
    if (!(D > 0)) return false;
    said = parameters.distance == DistanceForm::Euclidean
               ? viewOpinion(parameters, view.model.T_camera_world * p_W, view.ray(address.u, address.v), D)
               : viewOpinion(parameters, {0, 0, depth_of_point}, {}, D);
    return true;
  }

  /** \brief Calls visit(address, opinion) for up to K − 1 views other than camera i that say something about a point. */
  template <typename Visit>
  FUSE_FLOW_HD void forEachOpinion(const Vec3& p_W, std::uint32_t i, const Visit& visit) const {
    int heard = 0;
    int candidates = 0;
    for (std::uint32_t k = 0; k < views[i].neighbour_count; ++k) {
      const std::uint32_t j = views[i].neighbours[k];
      if (heard >= parameters.max_views - 1 || ++candidates > parameters.max_candidates) break;
      ViewOpinion said;
      PixelAddress address;
      if (!ask(p_W, j, said, address) || said.verdict == ViewOpinion::Hidden) continue;
      visit(address, said);
      ++heard;
    }
  }

  FUSE_FLOW_HD Consistency operator()(const Vec3& p_W, std::uint32_t i) const {
    Consistency result;
    forEachOpinion(p_W, i, [&result](const PixelAddress&, const ViewOpinion& said) { result.add(said); });
    return result;
  }

  /** \brief The same for a point that came from none of the cameras: camera 0 is asked first, then its neighbours. */
  FUSE_FLOW_HD Consistency askAll(const Vec3& p_W) const {
    Consistency result;
    ViewOpinion said;
    PixelAddress address;
    if (views[0].present && ask(p_W, 0, said, address)) result.add(said);
    forEachOpinion(p_W, 0, [&result](const PixelAddress&, const ViewOpinion& other) { result.add(other); });
    return result;
  }

  /** \brief Eq. 7 for a point that a camera measured, asking along the list of another: all points of a coarse cell walk
   *  one list, that of its first point's camera. */
  FUSE_FLOW_HD float alongListOf(std::uint32_t first, const Vec3& p_W, std::uint32_t camera) const {
    Consistency result;
    hear(p_W, first, camera, result);
    int candidates = 0;
    for (std::uint32_t k = 0; k < views[first].neighbour_count; ++k) {
      const std::uint32_t j = views[first].neighbours[k];
      if (result.views() >= parameters.max_views - 1 || ++candidates > parameters.max_candidates) break;
      hear(p_W, j, camera, result);
    }
    return consistency(parameters, result);
  }

 private:
  FUSE_FLOW_HD void hear(const Vec3& p_W, std::uint32_t j, std::uint32_t camera, Consistency& result) const {
    ViewOpinion said;
    PixelAddress address;
    if (j == camera) return;  // in its own camera a point is always right
    if (ask(p_W, j, said, address)) result.add(said);
  }
};

}  // namespace gpu
}  // namespace fuse_flow
