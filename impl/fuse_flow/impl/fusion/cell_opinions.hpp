#pragma once

#include <fuse_flow/impl/fusion/cell_normals.hpp>
#include <fuse_flow/impl/host/wide_vectors.hpp>
#include <fuse_flow/impl/sensors/depth_map.hpp>
#include <fuse_flow/math/confidence.h>
#include <fuse_flow/math/confirmation.h>
#include <fuse_flow/math/consistency.h>
#include <fuse_flow/math/view.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief What the views say about the points of one coarse cell, while one view after the other is asked about all of them.
 *  Arrays and loops without branches, which compilers vectorise: which points a view sees, and what it says, is anyone's
 *  guess. */
class CellOpinions {
 public:
  /** \brief Where a point falls in a view. */
  struct Sight {
    std::uint32_t view;
    float x, y, z;  ///< of ViewModel::locate()
  };

  /** \brief Begins with points of which nothing has been said. \param normals of their surfaces, which stay as they are until the
   *  views have been asked; null: every view is asked, wherever a surface faces */
  void assign(const Vec3* p, const CellNormals* normals, std::size_t n) {
    reserve(n, places_.size());
    n_ = n;
    located_ = 0;
    normals_ = normals;
    for (std::size_t k = 0; k < n; ++k) {
      X_[k] = p[k].x;
      Y_[k] = p[k].y;
      Z_[k] = p[k].z;
      sum_[k] = 0;
      free_space_[k] = 1;
      agreeing_[k] = seeing_through_[k] = 0;
    }
  }

  /** \brief Room for so many points. */
  std::size_t capacity() const { return X_.size(); }
  /** \brief Room for so many views. */
  std::size_t views() const { return places_.size(); }
  /** \brief Room for n points and a number of views; never less than before. */
  void reserve(std::size_t n, std::size_t views) {
    if (n <= capacity() && views <= places_.size()) return;
    n = std::max(n, capacity());
    for (std::vector<float>* a : {&X_, &Y_, &Z_, &depth_, &sum_, &free_space_}) a->resize(n);
    for (std::vector<std::int32_t>* a : {&agreeing_, &seeing_through_, &seems_through_}) a->resize(n);
    places_.resize(std::max(views, places_.size()));
    for (Places& at : places_) {
      for (std::vector<float>* a : {&at.x, &at.y, &at.z}) a->resize(n);
      at.pixel.resize(n);
    }
    confirming_.resize(n * kConfirming);
    near_.resize(n * ((places_.size() + kPlacesPerWord - 1) / kPlacesPerWord));
  }

  /** \brief Projects the points into view j, and sends for what it measured there: that is on its way from memory while
   *  the view before it is asked. \param camera the camera of each point, which is not asked
   *  \param depth of the view, with a border of zeros  \param place number of the view among those that are asked, from 0 on without a gap */
  void locate(const ConsistencyParameters& p, const ViewModel& view, std::uint32_t j, const std::uint32_t* camera,
              const DepthMap& depth, std::size_t place) {
    if (place >= places_.size()) reserve(n_, place + 1);
    Places& to = places_[place];
    to.view = j;
    located_ = place + 1;
    if (place % kPlacesPerWord == 0) std::fill_n(nearWords(place), n_, 0u);
    if (view.ideal) {
      inWideVectors([&] {
        locateIdeal(n_, view.P, view.intrinsics, X_.data(), Y_.data(), Z_.data(), to.x.data(), to.y.data(), to.z.data(),
                    to.pixel.data());
      });
    } else {
      for (std::size_t k = 0; k < n_; ++k) {
        const bool inside = view.locate({X_[k], Y_[k], Z_[k]}, to.x[k], to.y[k], to.z[k]);
        if (!inside) to.x[k] = to.y[k] = 0;
        to.pixel[k] = inside ? 0 : kNowhere;
      }
    }
    if (normals_ != nullptr)
      inWideVectors([&] {
        leaveOutAverted(n_, p, view.T_world_camera.t, X_.data(), Y_.data(), Z_.data(), normals_->x(), normals_->y(),
                        normals_->z(), to.pixel.data());
      });
    const int stride = depth.stride();
    for (std::size_t k = 0; k < n_; ++k) {
      const std::int32_t there = static_cast<std::int32_t>(to.y[k]) * stride + static_cast<std::int32_t>(to.x[k]);
      const bool wanted = (to.pixel[k] == 0) & (camera[k] != j);
      to.pixel[k] = wanted ? there : kNowhere;
    }
#if defined(__GNUC__)
    const float* first = depth.row(0);
    for (std::size_t k = 0; k < n_; ++k) __builtin_prefetch(first + to.pixel[k]);
#endif
  }

  /** \brief What the view at a place measured where the points fall. \param views points that so many views have said something
   *  about ask no more  \param before views that were asked before */
  void read(const DepthMap& depth, std::size_t place, int views, int before) {
    const Places& at = places_[place];
    const float* first = depth.row(0);
    for (std::size_t k = 0; k < n_; ++k) depth_[k] = first[at.pixel[k]];
    if (before < views) return;
    for (std::size_t k = 0; k < n_; ++k) depth_[k] = agreeing_[k] + seeing_through_[k] < views ? depth_[k] : 0.0f;
  }

  /** \brief The view of a place. */
  std::uint32_t viewOf(std::size_t place) const { return places_[place].view; }

  /** \brief Remembers the view of a place for the points that it agrees with; call before the opinions are added. */
  void remember(std::size_t place) {
    // Always, and on top of the last one if that did not agree.
    for (std::size_t k = 0; k < n_; ++k)
      confirming_[k * kConfirming + static_cast<std::size_t>(std::min(agreeing_[k], Confirmation::kViews))] =
          static_cast<std::uint32_t>(place);
  }

  /** \brief Eq. 5–6, with d along the ray. \param noise of the view; of scale 0 where it is not known  \param depth of the view
   *  \param confidence of its pixels; none: 1 */
  void addAlongRay(const ConsistencyParameters& p, const ViewNoise& noise, const DepthMap& depth,
                   const ImageView<float>& confidence, std::size_t place) {
    inWideVectors([&] {
      addAlongRay(n_, p, noise, places_[place].z.data(), depth_.data(), nearBit(place), sum_.data(), agreeing_.data(),
                  seems_through_.data(), nearWords(place));
    });
    addSeeingThrough(p, depth, confidence, places_[place]);
  }

  /** \brief The same with any opinion(number of the point, pixel u, pixel v, its depth in the view, measured depth). */
  template <typename Opinion>
  void add(const ConsistencyParameters& p, const Opinion& opinion, std::size_t place) {
    const Places& at = places_[place];
    for (std::size_t k = 0; k < n_; ++k) {
      if (!(depth_[k] > 0)) continue;
      Consistency sum = (*this)[k];
      const ViewOpinion said = opinion(k, static_cast<int>(at.x[k]), static_cast<int>(at.y[k]), at.z[k], depth_[k]);
      sum.add(p, said);
      if (agrees(said)) nearWords(place)[k] |= nearBit(place);
      sum_[k] = sum.sum_squared_distance;
      agreeing_[k] = sum.agreeing;
      seeing_through_[k] = sum.seeing_through;
      free_space_[k] = sum.free_space;
    }
  }

  /** \brief Whether any point has heard fewer views than that. */
  bool anyBelow(int views) const {
    bool any = false;
    for (std::size_t k = 0; k < n_; ++k) any |= agreeing_[k] + seeing_through_[k] < views;
    return any;
  }

  /** \brief All that was said about a point. */
  Consistency operator[](std::size_t k) const { return {sum_[k], agreeing_[k], seeing_through_[k], free_space_[k]}; }

  /** \brief Calls visit(view) for each that agrees() with a point. */
  template <typename Visit>
  void forEachNear(std::size_t k, const Visit& visit) const {
    for (std::size_t first = 0; first < located_; first += kPlacesPerWord) {
      std::uint32_t bits = near_[first / kPlacesPerWord * capacity() + k];
      for (std::size_t place = first; bits != 0; ++place, bits >>= 1)
        if (bits & 1u) visit(places_[place].view);
    }
  }

  /** \brief Where a point falls in the a-th view that measured a surface there; a < Confirmation::kViews. */
  Sight sight(std::size_t k, int a) const {
    const Places& at = places_[confirming_[k * kConfirming + static_cast<std::size_t>(a)]];
    return {at.view, at.x[k], at.y[k], at.z[k]};
  }

 private:
  /** \brief Where the points fall in a view. */
  struct Places {
    std::uint32_t view{0};
    std::vector<float> x, y, z;
    std::vector<std::int32_t> pixel;  ///< of its depth map, or kNowhere
  };
  /** \brief In the border of every depth map, left of its first pixel: 0. */
  static constexpr std::int32_t kNowhere = -1;
  static constexpr std::size_t kConfirming = Confirmation::kViews + 1;  ///< and one that is not kept
  static constexpr std::size_t kPlacesPerWord = 32;

  std::uint32_t* nearWords(std::size_t place) { return near_.data() + place / kPlacesPerWord * capacity(); }
  static std::uint32_t nearBit(std::size_t place) { return 1u << place % kPlacesPerWord; }

  static void locateIdeal(std::size_t n, ProjectionMatrix P, Intrinsics K, const float* __restrict X,
                          const float* __restrict Y, const float* __restrict Z, float* __restrict x,
                          float* __restrict y, float* __restrict z, std::int32_t* __restrict pixel) {
    for (std::size_t k = 0; k < n; ++k) {
      const Vec3 q = P * Vec3{X[k], Y[k], Z[k]};
      float column, row;
      const bool inside = ViewModel::place(q, K, column, row);
      x[k] = inside ? column : 0.0f;
      y[k] = inside ? row : 0.0f;
      z[k] = q.z;
      pixel[k] = inside ? 0 : kNowhere;
    }
  }

  /** \brief Eq. 6 along the ray for many points at a time: what viewOpinion() is for one. */
  static void addAlongRay(std::size_t n, ConsistencyParameters p, ViewNoise noise, const float* __restrict z,
                          const float* __restrict depth, std::uint32_t near_bit, float* __restrict sum,
                          std::int32_t* __restrict agreeing, std::int32_t* __restrict seems_through,
                          std::uint32_t* __restrict near) {
    const float margin = occlusionMargin(p);
    for (std::size_t k = 0; k < n; ++k) {
      const float D = depth[k];
      const float behind = (z[k] - D) * (1.0f / consistencySigma(p, noise.at(D)));
      const bool agrees = (D > 0) & (behind <= margin) & (behind >= -margin);
      const float square = behind * behind;
      sum[k] += agrees ? square : 0.0f;
      agreeing[k] += agrees;
      near[k] |= (agrees & (square <= 1.0f)) ? near_bit : 0u;
      seems_through[k] = (D > 0) & (behind < -margin);
    }
  }

  /** \brief Does not ask a view about surface that faces away from it; see isAsked(). */
  static void leaveOutAverted(std::size_t n, ConsistencyParameters p, Vec3 centre, const float* __restrict X,
                              const float* __restrict Y, const float* __restrict Z, const float* __restrict normal_x,
                              const float* __restrict normal_y, const float* __restrict normal_z,
                              std::int32_t* __restrict pixel) {
    for (std::size_t k = 0; k < n; ++k) {
      const bool asked = isAsked(p, {normal_x[k], normal_y[k], normal_z[k]}, centre - Vec3{X[k], Y[k], Z[k]});
      pixel[k] = asked ? pixel[k] : kNowhere;
    }
  }

  /** \brief Few points are seen through: each is looked at by itself. */
  void addSeeingThrough(const ConsistencyParameters& p, const DepthMap& depth, const ImageView<float>& confidence,
                        const Places& at) {
    for (std::size_t k = 0; k < n_; ++k) {
      if (seems_through_[k] == 0) continue;
      if (isBesideSilhouette(p, at.z[k], DepthsAround(depth, std::ptrdiff_t{at.pixel[k]}))) continue;
      ++seeing_through_[k];
      const float of_pixel = confidenceAt(confidence, static_cast<int>(at.x[k]), static_cast<int>(at.y[k]));
      free_space_[k] *= freeSpaceFactor(p, of_pixel);
    }
  }

  std::size_t n_{0};
  std::size_t located_{0};  ///< places, from 0 on
  const CellNormals* normals_{nullptr};
  std::vector<float> X_, Y_, Z_;  // world, metres
  std::vector<Places> places_;    ///< view by view, as they are asked
  std::vector<float> depth_;
  std::vector<float> sum_;
  std::vector<float> free_space_;  ///< see Consistency
  std::vector<std::int32_t> agreeing_, seeing_through_;
  std::vector<std::int32_t> seems_through_;  ///< whether the pixel where the point falls measured well behind it
  std::vector<std::uint32_t> confirming_;    ///< of each point the places of the first views that agreed
  std::vector<std::uint32_t> near_;          ///< of each point a bit for each place whose view agrees()
};

}  // namespace host
}  // namespace fuse_flow
