#pragma once

#include <fuse_flow/impl/sensors/view_frustum.hpp>
#include <fuse_flow/math/view.h>
#include <fuse_flow/rig_frame.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Rays of the pixels of one row, number by number: what copies a struct is no vector code. Here of an ideal lens. */
struct IdealRays {
  const float* columns;
  float row;
  float x(std::size_t u) const { return columns[u]; }
  float y(std::size_t) const { return row; }
};

/** \brief The same of a lens with distortion. */
struct TabledRays {
  const Ray* rays;
  float x(std::size_t u) const { return rays[u].x; }
  float y(std::size_t u) const { return rays[u].y; }
};

/** \brief The ray of a pixel, if there is one: beyond the place where a lens model folds over there is none, or one that no lens has. */
class RayFinder {
 public:
  explicit RayFinder(const Intrinsics& K) : K_(K), squared_fold_radius_(std::pow(foldRadius(K.distortion), 2.0f)) {}

  struct Found {
    Ray ray;  ///< the nearest, where there is none
    bool found;
  };
  Found operator()(float u, float v) const {
    const Ray ray = unproject(K_, {u, v});
    return {ray, reaches(K_, ray, {u, v}) && ray.x * ray.x + ray.y * ray.y <= squared_fold_radius_};
  }
  /** \brief Infinite: the model does not fold over. */
  float squaredFoldRadius() const { return squared_fold_radius_; }

 private:
  Intrinsics K_;
  float squared_fold_radius_;
};

/** \brief What follows from one camera's calibration alone. */
struct ViewGeometry : ViewModel {
  /** \brief The other cameras, nearest first: the order in which a point asks them (section 5 (2) b). */
  std::vector<std::uint32_t> neighbours;
  ViewFrustum frustum;
  float depth_scale{0};             ///< metres per unit of 16-bit depth
  std::optional<NoiseModel> noise;  ///< where the camera has a model of its own

  /** \brief Null where the camera has none. */
  const NoiseModel* ownNoise() const { return noise ? &*noise : nullptr; }

  /** \param with_tables of every pixel; false: for a camera that is missing, none of whose pixels anyone asks for */
  void assign(const Camera& camera, bool with_tables = true) {
    const bool same_lens = !column_x_.empty() && detail::sameIntrinsics(intrinsics, camera.intrinsics);
    const bool same_correction = same_lens && depth_correction_ == camera.depth_correction;
    if (!same_correction) has_tables_ = false;
    intrinsics = camera.intrinsics;
    depth_scale = camera.depth_scale;
    noise = camera.noise;
    T_world_camera = toRigidTransform(camera.T_world_camera);
    T_camera_world = toRigidTransform(camera.T_world_camera.inverse());
    multipath = camera.multipath;
    own_color_camera = camera.color.has_value();
    if (camera.color) {
      if (!detail::sameIntrinsics(color_intrinsics, camera.color->intrinsics))
        color_max_squared_radius = largestSquaredRadius(camera.color->intrinsics);
      color_intrinsics = camera.color->intrinsics;
      T_color_depth = toRigidTransform(camera.color->T_depth_color.inverse());
    }
    P = projectionMatrix(intrinsics, T_camera_world);
    if (!same_lens) tabulateColumns();
    if (with_tables && !has_tables_) {
      if (rays_.empty()) tabulateRays();
      tabulateCorrection(camera.depth_correction);
      has_tables_ = true;
    }
    frustum = ViewFrustum(*this);
  }
  bool hasTables() const { return has_tables_; }

  /** \brief unproject() of an integer pixel, from a table. */
  Ray ray(int u, int v) const {
    if (ideal) return {column_x_[static_cast<std::size_t>(u)], (static_cast<float>(v) - intrinsics.cy) / intrinsics.fy};
    return rays_[static_cast<std::size_t>(v) * static_cast<std::size_t>(intrinsics.width) +
                 static_cast<std::size_t>(u)];
  }

  /** \brief The table of a lens with distortion, row by row, and kScrap more; empty for an ideal one. */
  const std::vector<Ray>& rays() const { return rays_; }

  /** \brief Calls use(rays of row v from pixel u on), of either kind. Behind an image's last ray kScrap more can be read. */
  template <typename Use>
  void withRays(int u, int v, const Use& use) const {
    if (ideal) {
      use(IdealRays{column_x_.data() + u, ray(0, v).y});
    } else {
      use(TabledRays{rays_.data() + static_cast<std::ptrdiff_t>(v) * intrinsics.width + u});
    }
  }
  static constexpr std::size_t kScrap = 8;

  /** \brief Of the camera's depth, row by row; empty where it is right. */
  const std::vector<DepthCorrectionTerms>& corrections() const { return corrections_; }
  /** \brief Of row v; null where the camera's depth is right. */
  const DepthCorrectionTerms* corrections(int v) const {
    return corrections_.empty() ? nullptr : corrections_.data() + static_cast<std::ptrdiff_t>(v) * intrinsics.width;
  }

 private:
  void tabulateColumns() {
    ideal = isIdeal(intrinsics.distortion);
    const auto w = static_cast<std::size_t>(intrinsics.width);
    column_x_.assign(w + kScrap, 0.0f);
    for (std::size_t u = 0; u < w; ++u) column_x_[u] = (static_cast<float>(u) - intrinsics.cx) / intrinsics.fx;
    rays_.clear();
    max_squared_radius = 0;
  }

  void tabulateRays() {
    const auto w = static_cast<std::size_t>(intrinsics.width);
    const auto h = static_cast<std::size_t>(intrinsics.height);
    rays_.assign(ideal ? 0 : w * h + kScrap, Ray{});
    without_ray_.clear();
    if (ideal) return;
    const RayFinder find(intrinsics);
    for (std::size_t v = 0; v < h; ++v)
      for (std::size_t u = 0; u < w; ++u) {
        const std::size_t pixel = v * w + u;
        const auto [ray, found] = find(static_cast<float>(u), static_cast<float>(v));
        rays_[pixel] = ray;
        if (found) {
          max_squared_radius = std::max(max_squared_radius, ray.x * ray.x + ray.y * ray.y);
        } else {
          without_ray_.push_back(pixel);
        }
      }
  }

  void tabulateCorrection(const DepthCorrection& correction) {
    depth_correction_ = correction;
    corrections_.clear();
    if (correction.empty() && without_ray_.empty()) return;
    for (int v = 0; v < intrinsics.height; ++v)
      for (int u = 0; u < intrinsics.width; ++u)
        corrections_.push_back(correction.at(u, v, intrinsics.width, intrinsics.height));
    for (const std::size_t pixel : without_ray_) corrections_[pixel] = {-1, 0};  // leaves no measurement
  }

  /** \brief Of the rays of an image's border, which are the outermost, or of where the lens model folds over; 0 for an ideal lens. */
  static float largestSquaredRadius(const Intrinsics& K) {
    if (isIdeal(K.distortion)) return 0;
    const RayFinder find(K);
    float largest = 0;
    const auto see = [&](int u, int v) {
      const auto [r, found] = find(static_cast<float>(u), static_cast<float>(v));
      const float squared = r.x * r.x + r.y * r.y, fold = find.squaredFoldRadius();
      largest = std::max(largest, found || std::isinf(fold) ? squared : fold);
    };
    for (int u = 0; u < K.width; ++u) {
      see(u, 0);
      see(u, K.height - 1);
    }
    for (int v = 0; v < K.height; ++v) {
      see(0, v);
      see(K.width - 1, v);
    }
    return largest;
  }

  bool has_tables_{false};
  std::vector<float> column_x_;
  std::vector<Ray> rays_;
  std::vector<std::size_t> without_ray_;  ///< pixels, row by row
  DepthCorrection depth_correction_;
  std::vector<DepthCorrectionTerms> corrections_;
};

/** \brief The geometry of all cameras of a rig; recomputed only when the calibration changes. */
class RigGeometry {
 public:
  /** \brief Whether anything changed. Tables of pixels are made once a camera has a view: one that never has may claim any size. */
  bool update(const RigFrame& frame) {
    const std::vector<Camera>& cameras = frame.cameras;
    const bool same = cameras.size() == cameras_.size() &&
                      std::equal(cameras.begin(), cameras.end(), cameras_.begin(), sameCalibration);
    bool changed = !same;
    if (!same) {
      cameras_ = cameras;
      views_.resize(cameras.size());
    }
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      const bool is_there = !frame.views[i].missing();
      if (same && (views_[i].hasTables() || !is_there)) continue;
      views_[i].assign(cameras[i], is_there);
      if (!same) rankNeighbours(i);
      changed = true;
    }
    return changed;
  }

  /** \brief Of a camera that has a view elsewhere: its tables, if they are not there. */
  void tabulate(std::size_t i) {
    if (!views_[i].hasTables()) views_[i].assign(cameras_[i]);
  }

  std::size_t size() const { return views_.size(); }
  const ViewGeometry& operator[](std::size_t i) const { return views_[i]; }

 private:
  /** \brief By distance between the centres plus the angle between the optical axes, one radian as one metre; ties by
   *  number. The whole list costs N² log N once per calibration: 64 cameras, well under a millisecond. */
  void rankNeighbours(std::size_t i) {
    std::vector<std::pair<double, std::uint32_t>> ranked;
    const Eigen::Isometry3d& T_i = cameras_[i].T_world_camera;
    for (std::size_t j = 0; j < cameras_.size(); ++j) {
      if (j == i) continue;
      const Eigen::Isometry3d& T_j = cameras_[j].T_world_camera;
      const double cosine = T_i.linear().col(2).dot(T_j.linear().col(2));
      const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
      ranked.emplace_back((T_i.translation() - T_j.translation()).norm() + angle, static_cast<std::uint32_t>(j));
    }
    std::sort(ranked.begin(), ranked.end());
    views_[i].neighbours.clear();
    for (const auto& [score, j] : ranked) views_[i].neighbours.push_back(j);
  }

  std::vector<Camera> cameras_;
  std::vector<ViewGeometry> views_;
};

}  // namespace host
}  // namespace fuse_flow
