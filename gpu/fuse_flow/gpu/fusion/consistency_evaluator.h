#pragma once

#include <fuse_flow/gpu/sensors/device_view.h>
#include <fuse_flow/math/confirmation.h>
#include <fuse_flow/math/consistency.h>
#include <fuse_flow/math/multipath.h>
#include <fuse_flow/math/representatives.h>

namespace fuse_flow {
namespace gpu {

/** \brief Eq. 4–7 over the depth maps of a frame. */
struct ConsistencyEvaluator {
  const DeviceView* views{nullptr};
  const float* z{nullptr};
  ConsistencyParameters parameters{};
  /** \brief D^r of eq. 8, for alongListOf() to find what the views confirm; null: not known. */
  const float* refined{nullptr};
  /** \brief How much what they confirm counts. */
  Confirmation::Weighing weighing{};
  /** \brief D^r, for normalAt(); null: no normal is known. */
  const float* surface{nullptr};
  /** \brief What has made it. */
  SmoothingParameters smoothing{};

  static constexpr std::uint32_t kNoCamera = 0xffffffffu;

  /** \brief Whether normalAt() says anything. */
  FUSE_FLOW_HD bool knowsNormals() const { return surface != nullptr && asksForNormals(parameters); }

  /** \brief Where the surface faces at a point that a camera measured, any length; zero: not known, or it does not matter. \param index number of the
   *  point's pixel */
  FUSE_FLOW_HD Vec3 normalAt(std::uint32_t camera, std::uint32_t index) const {
    if (!knowsNormals()) return {};
    const DeviceView& view = views[camera];
    const std::uint32_t local = index - view.offset, v = local / view.pitch;
    return surfaceDirection(view.model, DepthMapOfView{&view, surface}, static_cast<int>(local - v * view.pitch),
                            static_cast<int>(v), normalSpacing(smoothing, view.noise.level()));
  }

  /** \brief What view j says about a point in the world frame; false: nothing. \param normal of its surface; zero: not known
   *  \param address receives where it falls */
  FUSE_FLOW_HD bool ask(const Vec3& p_W, const Vec3& normal, std::uint32_t j, ViewOpinion& said,
                        PixelAddress& address) const {
    const Sight sight = look(p_W, normal, j, kNoCamera);
    address = sight.address;
    if (!(sight.depth > 0)) return false;
    said = judge(p_W, sight);
    return true;
  }

  /** \brief Calls visit(address, opinion) for up to K − 1 views other than camera i that say something about a point. */
  template <typename Visit>
  FUSE_FLOW_HD void forEachOpinion(const Vec3& p_W, const Vec3& normal, std::uint32_t i, const Visit& visit) const {
    int heard = 0;
    int candidates = 0;
    for (std::uint32_t k = 0; k < views[i].neighbour_count; ++k) {
      const std::uint32_t j = views[i].neighbours[k];
      if (heard >= parameters.max_views - 1 || ++candidates > parameters.max_candidates) break;
      ViewOpinion said;
      PixelAddress address;
      if (!ask(p_W, normal, j, said, address) || said.verdict == ViewOpinion::Hidden) continue;
      visit(address, said);
      ++heard;
    }
  }

  FUSE_FLOW_HD Consistency operator()(const Vec3& p_W, const Vec3& normal, std::uint32_t i) const {
    Consistency result;
    forEachOpinion(p_W, normal, i,
                   [&result, this](const PixelAddress&, const ViewOpinion& said) { result.add(parameters, said); });
    return result;
  }

  /** \brief The same for a point that came from none of the cameras: camera 0 is asked first, then its neighbours. */
  FUSE_FLOW_HD Consistency askAll(const Vec3& p_W) const {
    Consistency result;
    ViewOpinion said;
    PixelAddress address;
    if (views[0].present && ask(p_W, {}, 0, said, address)) result.add(parameters, said);
    forEachOpinion(p_W, {}, 0,
                   [&result, this](const PixelAddress&, const ViewOpinion& other) { result.add(parameters, other); });
    return result;
  }

  /** \brief Eq. 7 for a point that a camera measured, asking along the list of another: all points of a coarse cell walk
   *  one list, that of its first point's camera. What the next view measured is on its way from memory while the last one is
   *  judged. */
  FUSE_FLOW_HD float alongListOf(std::uint32_t first, const Vec3& p_W, const Vec3& normal, std::uint32_t camera) const {
    PointCameraCount from;
    return alongListOf(first, p_W, normal, camera, from);
  }

  /** \brief The same. \param from is given the cameras that agree */
  template <typename Cameras>
  FUSE_FLOW_HD float alongListOf(std::uint32_t first, const Vec3& p_W, const Vec3& normal, std::uint32_t camera,
                                 Cameras& from) const {
    Confirmation confirmation;
    return alongListOf(first, p_W, normal, camera, nullptr, confirmation, from);
  }

  /** \brief The same, and where D^r is given what the views confirm. \param refined_z null: not asked for */
  template <typename Cameras>
  FUSE_FLOW_HD float alongListOf(std::uint32_t first, const Vec3& p_W, const Vec3& normal, std::uint32_t camera,
                                 const float* refined_z, Confirmation& confirmation, Cameras& from) const {
    const DeviceView& owner = views[first];
    const std::uint32_t most = static_cast<std::uint32_t>(parameters.max_candidates);
    const std::uint32_t candidates = owner.neighbour_count < most ? owner.neighbour_count : most;
    Consistency result;
    Sight sight = look(p_W, normal, first, camera);
    for (std::uint32_t k = 0;; ++k) {
      const Sight next = k < candidates ? look(p_W, normal, owner.neighbours[k], camera) : Sight{};
      if (sight.depth > 0) {
        const ViewOpinion said = judge(p_W, sight);
        if (refined_z != nullptr && said.verdict == ViewOpinion::Distance && result.agreeing < Confirmation::kViews)
          confirm(p_W, sight, refined_z, confirmation);
        if (agrees(said)) from.addAgreeing(sight.address.view);
        result.add(parameters, said);
      }
      if (k == candidates || result.views() >= parameters.max_views - 1) return consistency(parameters, result);
      sight = next;
    }
  }

 private:
  /** \brief Where a point falls in a view, and what that measured there; depth 0: nothing. */
  struct Sight {
    PixelAddress address;
    float depth_of_point;
    float depth{0};
    float x, y;
  };

  /** \brief Nothing in the camera that measured the point: there it is always right. Nothing where its surface faces away. */
  FUSE_FLOW_HD Sight look(const Vec3& p_W, const Vec3& normal, std::uint32_t j, std::uint32_t camera) const {
    const DeviceView& view = views[j];
    Sight sight;
    sight.address.view = j;
    if (j != camera && isAsked(parameters, normal, view.model.T_world_camera.t - p_W) &&
        view.model.locate(p_W, sight.x, sight.y, sight.depth_of_point)) {
      sight.address.u = static_cast<int>(sight.x);
      sight.address.v = static_cast<int>(sight.y);
      sight.depth = z[view.indexOf(sight.address.u, sight.address.v)];
    }
    return sight;
  }

  /** \brief Depths of the pixels around one. */
  struct DepthsAround {
    const DepthMapOfView& map;
    int u, v;
    FUSE_FLOW_HD float operator()(int a, int b) const { return map.depth(u + a, v + b); }
  };

  FUSE_FLOW_HD void confirm(const Vec3& p_W, const Sight& sight, const float* refined_z,
                            Confirmation& confirmation) const {
    const DeviceView& view = views[sight.address.view];
    const DepthMapOfView map{&view, refined_z};
    const int u = sight.address.u, v = sight.address.v;
    const float here = map.depth(u, v);
    const float du = sight.x - 0.5f - static_cast<float>(u), dv = sight.y - 0.5f - static_cast<float>(v);
    const float refined_depth = depthBetween(du, dv, weighing.reach, DepthsAround{map, u, v});
    confirmation.add(p_W - view.model.T_world_camera.t,
                     weighing.share(sight.depth_of_point, refined_depth, view.noise.at(here),
                                    residualMultipath(view.model.multipath, kResidualMultipath), here));
  }

  FUSE_FLOW_HD ViewOpinion judge(const Vec3& p_W, const Sight& sight) const {
    const DeviceView& view = views[sight.address.view];
    const float noise = view.noise.at(sight.depth);
    const ViewOpinion said = parameters.distance == DistanceForm::Euclidean
                                 ? viewOpinion(parameters, view.model.T_camera_world * p_W,
                                               view.ray(sight.address.u, sight.address.v), sight.depth, noise)
                                 : viewOpinion(parameters, {0, 0, sight.depth_of_point}, {}, sight.depth, noise);
    if (said.verdict != ViewOpinion::SeenThrough) return said;
    const DepthMapOfView map{&view, z};
    const bool beside =
        isBesideSilhouette(parameters, sight.depth_of_point, DepthsAround{map, sight.address.u, sight.address.v});
    if (beside) return {};
    const bool weighs = parameters.weigh_contradictions;
    return {said.verdict, 0.0f, weighs ? confidenceAt(view.confidence, sight.address.u, sight.address.v) : 1.0f};
  }
};

}  // namespace gpu
}  // namespace fuse_flow
