#pragma once

#include <fuse_flow/impl/fusion/cell_confirmations.hpp>
#include <fuse_flow/impl/fusion/cell_opinions.hpp>
#include <fuse_flow/impl/sensors/depth_map.hpp>
#include <fuse_flow/impl/sensors/rig_geometry.hpp>
#include <fuse_flow/math/adaptive_hash.h>
#include <fuse_flow/math/confirmation.h>
#include <fuse_flow/math/consistency.h>
#include <fuse_flow/math/multipath.h>

#include <algorithm>

namespace fuse_flow {
namespace host {

/** \brief The noise of cameras that have a model of their own (Camera::noise), for filters that measure none; of the others none. */
inline std::vector<ViewNoise> givenNoise(const RigGeometry& rig) {
  std::vector<ViewNoise> noise;
  for (std::size_t i = 0; i < rig.size(); ++i)
    noise.push_back(rig[i].noise ? ViewNoise{*rig[i].noise, 1.0f, 1.0f} : ViewNoise{{}, 0.0f, 1.0f});
  return noise;
}

/** \brief Eq. 4–7 over the depth maps of a frame. */
class ConsistencyEvaluator {
 public:
  ConsistencyEvaluator(const ConsistencyParameters& parameters, const RigGeometry& rig,
                       const std::vector<DepthMap>& depths)
      : parameters_(parameters), rig_(&rig), depths_(&depths) {}

  /** \brief Where the noise of the views is known. \param noise of each view */
  void setNoise(const std::vector<ViewNoise>& noise) { noise_ = &noise; }

  /** \brief Where D^r of eq. 8 is known: evaluate() then finds what the views confirm. \param refined of each view
   *  \param half_weight_noise as in FuseFlowParameters */
  void setRefined(const std::vector<DepthMap>& refined, const AggregationParameters& aggregation,
                  float half_weight_noise) {
    refined_ = &refined;
    confirmation_ = confirmationWeighing(aggregation, half_weight_noise);
  }

  /** \brief Where views have a confidence of their own, for weigh_contradictions. \param views of the frame; null: none has */
  void setConfidence(const std::vector<DepthView>* views) {
    views_ = parameters_.weigh_contradictions ? views : nullptr;
  }

  bool knowsRefinedDepth() const { return refined_ != nullptr; }

  /** \brief Whether it matters where the surface of a point faces. */
  bool asksForNormals() const { return fuse_flow::asksForNormals(parameters_); }

  /** \brief Calls visit(j, pixel u, pixel v, opinion) for up to K − 1 views other than camera i that say something
   *  about a point in the world frame. \param normal of its surface; zero: not known */
  template <typename Visit>
  void forEachOpinion(const Vec3& p_W, const Vec3& normal, std::size_t i, const Visit& visit) const {
    int views = 0;
    int candidates = 0;
    for (const std::uint32_t j : (*rig_)[i].neighbours) {
      if ((*depths_)[j].empty()) continue;
      if (views >= parameters_.max_views - 1 || ++candidates > parameters_.max_candidates) break;
      views += ask(p_W, normal, j, visit) ? 1 : 0;
    }
  }

  Consistency operator()(const Vec3& p_W, const Vec3& normal, std::size_t i) const {
    Consistency result;
    forEachOpinion(p_W, normal, i,
                   [&](std::uint32_t, int, int, const ViewOpinion& opinion) { result.add(parameters_, opinion); });
    return result;
  }

  /** \brief The same for a point of no camera, of whose normal nobody knows the sign: all views are asked, camera 0 first, then its
   *  neighbours. */
  Consistency askAll(const Vec3& p_W) const {
    Consistency result;
    const auto add = [&](std::uint32_t, int, int, const ViewOpinion& opinion) { result.add(parameters_, opinion); };
    if (!(*depths_)[0].empty()) ask(p_W, {}, 0, add);
    forEachOpinion(p_W, {}, 0, add);
    return result;
  }

  /** \brief Eq. 7 for the points of one coarse cell: V[k] of p[k], which camera[k] measured. All of them walk one list, that
   *  of the first point's camera, view by view: neighbouring points fall on neighbouring pixels, so that each view's
   *  matrix and its few pixels stay at hand. \param normals see CellOpinions::assign()  \param opinions is overwritten */
  void evaluate(const Bounds& cell, const Vec3* p, const CellNormals* normals, const std::uint32_t* camera,
                std::size_t n, CellOpinions& opinions, float* V) const {
    opinions.assign(p, normals, n);
    const std::uint32_t first = camera[0];
    std::size_t located = 0, asked = 0;
    bool open = true;
    const auto locate = [&](std::uint32_t j) {
      opinions.locate(parameters_, (*rig_)[j], j, camera, (*depths_)[j], located++);
    };
    const auto ask = [&] { open = askAbout(p, asked++, opinions); };
    if (!(*depths_)[first].empty()) locate(first);
    int candidates = 0;
    for (const std::uint32_t j : (*rig_)[first].neighbours) {
      if ((*depths_)[j].empty()) continue;
      if (!open || ++candidates > parameters_.max_candidates) break;
      if (!(*rig_)[j].frustum.mayShow(cell)) continue;
      locate(j);
      if (located - asked == kAhead) ask();
    }
    while (open && asked < located) ask();
    for (std::size_t k = 0; k < n; ++k) V[k] = consistency(parameters_, opinions[k]);
  }

  /** \brief Sends for the refined depth that confirmed() will look at. */
  void prefetchConfirmed(const CellOpinions& opinions, std::size_t k) const {
#if defined(__GNUC__)
    const int n = std::min(opinions[k].agreeing, Confirmation::kViews);
    for (int a = 0; a < n; ++a) {
      const CellOpinions::Sight sight = opinions.sight(k, a);
      __builtin_prefetch((*refined_)[sight.view].row(static_cast<int>(sight.y)) + static_cast<int>(sight.x));
    }
#endif
  }

  /** \brief Reads the refined depth where views agreed with a point in evaluate(). \param k its number there */
  void readConfirmed(const CellOpinions& opinions, std::size_t k, CellConfirmations& confirmations) const {
    const int n = std::min(opinions[k].agreeing, Confirmation::kViews);
    for (int a = 0; a < n; ++a) {
      const CellOpinions::Sight sight = opinions.sight(k, a);
      confirmations.add((*refined_)[sight.view], sight.x, sight.y, sight.z, noiseOf(sight.view),
                        residualMultipath((*rig_)[sight.view].multipath, kResidualMultipath));
    }
  }

  /** \brief After the last readConfirmed(). */
  void weighConfirmed(CellConfirmations& confirmations) const { confirmations.weigh(confirmation_); }

  /** \brief Where a point of weight ω lies by what the views confirm. \param first of its shares; moved on to the next point's */
  Vec3 confirmed(const Vec3& p_W, float weight, const CellOpinions& opinions, std::size_t k,
                 const CellConfirmations& confirmations, std::size_t& first) const {
    Confirmation confirmation;
    const int n = std::min(opinions[k].agreeing, Confirmation::kViews);
    for (int a = 0; a < n; ++a)
      confirmation.add(p_W - (*rig_)[opinions.sight(k, a).view].T_world_camera.t, confirmations[first++]);
    return confirmation.moved(p_W, weight);
  }

 private:
  /** \brief So many views have the points located in them before the first of these is asked. */
  static constexpr std::size_t kAhead = 2;

  /** \brief Asks a view, in which the points have been located, about all that still want to know; returns whether any does afterwards.
   *  \param place number of the view among those that are asked */
  bool askAbout(const Vec3* p, std::size_t place, CellOpinions& points) const {
    const std::uint32_t j = points.viewOf(place);
    const int enough = parameters_.max_views - 1, before = static_cast<int>(place);
    points.read((*depths_)[j], place, enough, before);
    if (refined_ != nullptr) points.remember(place);
    if (parameters_.distance == DistanceForm::AlongRay) {
      points.addAlongRay(parameters_, noiseOf(j), (*depths_)[j], confidenceOf(j), place);
    } else {
      points.add(
          parameters_, [&](std::size_t k, int u, int v, float z, float D) { return opinion(j, p[k], u, v, z, D); },
          place);
    }
    return before + 1 < enough || points.anyBelow(enough);
  }

  /** \brief Of a view; none where it is not known. */
  ViewNoise noiseOf(std::uint32_t j) const { return noise_ != nullptr ? (*noise_)[j] : ViewNoise{{}, 0.0f, 1.0f}; }

  /** \brief The confidence image of a view; none where each pixel's is 1. */
  ImageView<float> confidenceOf(std::uint32_t j) const {
    return views_ != nullptr ? (*views_)[j].confidence : ImageView<float>();
  }

  ViewOpinion opinion(std::uint32_t j, const Vec3& p_W, int u, int v, float z, float D) const {
    const ViewGeometry& view = (*rig_)[j];
    const float noise = noiseOf(j).at(D);
    const ViewOpinion said = parameters_.distance == DistanceForm::Euclidean
                                 ? viewOpinion(parameters_, view.T_camera_world * p_W, view.ray(u, v), D, noise)
                                 : viewOpinion(parameters_, {0, 0, z}, {}, D, noise);
    if (said.verdict != ViewOpinion::SeenThrough) return said;
    const bool beside = isBesideSilhouette(parameters_, z, DepthsAround((*depths_)[j], u, v));
    return beside ? ViewOpinion{} : ViewOpinion{said.verdict, 0.0f, confidenceAt(confidenceOf(j), u, v)};
  }

  template <typename Visit>
  bool ask(const Vec3& p_W, const Vec3& normal, std::uint32_t j, const Visit& visit) const {
    const ViewGeometry& view = (*rig_)[j];
    if (!isAsked(parameters_, normal, view.T_world_camera.t - p_W)) return false;
    int u = 0, v = 0;
    float z = 0;
    if (!view.locate(p_W, u, v, z)) return false;
    const float D = (*depths_)[j].row(v)[u];
    if (!(D > 0)) return false;
    const ViewOpinion said = opinion(j, p_W, u, v, z, D);
    if (said.verdict == ViewOpinion::Hidden) return false;
    visit(j, u, v, said);
    return true;
  }

  ConsistencyParameters parameters_;
  const RigGeometry* rig_;
  const std::vector<DepthMap>* depths_;
  const std::vector<ViewNoise>* noise_{nullptr};
  const std::vector<DepthMap>* refined_{nullptr};
  const std::vector<DepthView>* views_{nullptr};
  Confirmation::Weighing confirmation_;
};

}  // namespace host
}  // namespace fuse_flow
