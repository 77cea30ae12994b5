#pragma once

#include <fuse_flow/impl/camera.hpp>
#include <fuse_flow/impl/stereo/ideal_image.hpp>
#include <fuse_flow/stereo/parameters.h>
#include <fuse_flow/stereo/stereo_frame.h>

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace fuse_flow {
namespace detail {

/** \brief What follows from the calibration of the colour cameras alone: images without distortion, who is matched with whom, and from what
 *  depth to what depth. Views without an image take part in nothing. */
class StereoRig {
 public:
  /** \brief \param present whether a view has an image */
  void assign(const std::vector<Camera>& cameras, const std::vector<bool>& present,
              const StereoParameters& parameters) {
    cameras_ = cameras;
    present_ = present;
    ideal_.clear();
    for (const Camera& camera : cameras_) ideal_.push_back(idealIntrinsics(camera.intrinsics));
    const Eigen::Vector3d centre = meetingPoint();
    geometry_.assign(cameras_.size(), {});
    for (std::size_t k = 0; k < cameras_.size(); ++k)
      if (present_[k]) geometry_[k] = geometryOf(k, centre, parameters);
    result_cameras_ = cameras_;
    for (std::size_t k = 0; k < cameras_.size(); ++k)
      if (!geometry_[k].sources.empty())
        result_cameras_[k].noise =
            NoiseModel::stereo(cameras_[k].intrinsics.fx, geometry_[k].baseline, kStereoDisparityDeviation);
  }

  const std::vector<Camera>& cameras() const { return cameras_; }
  /** \brief The same with the noise of the depth that is found. */
  const std::vector<Camera>& resultCameras() const { return result_cameras_; }
  /** \brief Of the image without distortion that a view is matched in. */
  const Intrinsics& ideal(std::size_t view) const { return ideal_[view]; }
  const StereoGeometry& geometry(std::size_t view) const { return geometry_[view]; }

 private:
  using Vector3d = Eigen::Vector3d;

  Vector3d centreOf(std::size_t k) const { return cameras_[k].T_world_camera.translation(); }
  Vector3d axisOf(std::size_t k) const { return cameras_[k].T_world_camera.linear().col(2); }

  /** \brief Distance from a camera to the nearest other one; 0: there is none. */
  double nearestBaseline(std::size_t k) const {
    double nearest = 0;
    for (std::size_t j = 0; j < cameras_.size(); ++j) {
      const double baseline = (centreOf(j) - centreOf(k)).norm();
      if (j != k && present_[j] && baseline > 0 && (nearest == 0 || baseline < nearest)) nearest = baseline;
    }
    return nearest;
  }

  /** \brief The point nearest to all optical axes, in the sense of least squares; not finite if they are parallel. */
  Vector3d meetingPoint() const {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Vector3d b = Vector3d::Zero();
    double views = 0;
    for (std::size_t k = 0; k < cameras_.size(); ++k) {
      if (!present_[k]) continue;
      const Vector3d axis = axisOf(k);
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
      A += across;
      b += across * centreOf(k);
      views += 1;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(A);
    if (!(solver.eigenvalues().x() > 1e-3 * views)) return Vector3d::Constant(NAN);
    return solver.eigenvectors() * (solver.eigenvectors().transpose() * b).cwiseQuotient(solver.eigenvalues());
  }

  /** \brief How far what a view looks at is, about: where the axes meet, if that is in front of it, else ten baselines. */
  double sceneDistance(std::size_t k, const Vector3d& centre) const {
    const double baseline = nearestBaseline(k);
    const double ahead = axisOf(k).dot(centre - centreOf(k));
    return std::isfinite(ahead) && ahead > 2 * baseline ? ahead : 10 * baseline;
  }

  /** \brief Angle between the rays of two cameras to a point, degrees. */
  double angleAt(const Vector3d& point, std::size_t a, std::size_t b) const {
    const Vector3d to_a = centreOf(a) - point, to_b = centreOf(b) - point;
    return std::atan2(to_a.cross(to_b).norm(), to_a.dot(to_b)) * 180 / 3.14159265358979323846;
  }

  bool sees(std::size_t k, const Vector3d& point) const {
    const Vector3d p = cameras_[k].T_world_camera.inverse() * point;
    const Intrinsics& K = ideal_[k];
    if (!(p.z() > 0)) return false;
    const double u = K.fx * p.x() / p.z() + K.cx, v = K.fy * p.y() / p.z() + K.cy;
    return u >= 0 && v >= 0 && u <= K.width - 1 && v <= K.height - 1;
  }

  /** \brief Calls use(point) for points at a depth, spread over the image of a view. */
  template <typename Use>
  void forPointsAt(std::size_t k, double depth, const Use& use) const {
    const Intrinsics& K = ideal_[k];
    constexpr int across = 5;
    for (int row = 0; row < across; ++row)
      for (int column = 0; column < across; ++column) {
        const double u = (column + 0.5) / across * K.width - 0.5, v = (row + 0.5) / across * K.height - 0.5;
        use(cameras_[k].T_world_camera * Vector3d((u - K.cx) / K.fx * depth, (v - K.cy) / K.fy * depth, depth));
      }
  }

  /** \brief How well a view can be matched with another one: over points about the scene that both see, how good their angle is.
   *  Smaller angles lose precision fast, larger ones likeness slowly. */
  double matchability(std::size_t k, std::size_t other, double distance) const {
    constexpr double best = 10, below = 4, above = 10;  // degrees
    double sum = 0;
    for (const double factor : {0.4, 0.6, 0.8, 1.0, 1.4, 2.0, 3.0})
      forPointsAt(k, factor * distance, [&](const Vector3d& point) {
        if (!sees(other, point)) return;
        const double angle = angleAt(point, k, other);
        const double off = (angle - best) / (angle < best ? below : above);
        sum += std::exp(-0.5 * off * off);
      });
    return sum;
  }

  /** \brief Smallest depth from which on a quarter of a view's image is seen by one of its sources, at less than 45°. */
  double nearestDepth(std::size_t k, const std::vector<std::size_t>& sources, double distance) const {
    for (double depth = 0.02 * distance; depth < distance; depth *= 1.1) {
      int seen = 0, all = 0;
      forPointsAt(k, depth, [&](const Vector3d& point) {
        ++all;
        seen += std::any_of(sources.begin(), sources.end(),
                            [&](std::size_t s) { return sees(s, point) && angleAt(point, k, s) < 45; });
      });
      if (4 * seen >= all) return depth;
    }
    return distance;
  }

  StereoGeometry geometryOf(std::size_t k, const Vector3d& centre, const StereoParameters& parameters) const {
    StereoGeometry geometry;
    const double distance = sceneDistance(k, centre);
    if (!(distance > 0)) return geometry;
    std::vector<std::pair<double, std::size_t>> others;
    for (std::size_t j = 0; j < cameras_.size(); ++j) {
      if (j == k || !present_[j]) continue;
      const double score = matchability(k, j, distance);
      if (score > 0.5) others.emplace_back(-score, j);
    }
    std::sort(others.begin(), others.end());
    others.resize(std::min(others.size(), static_cast<std::size_t>(parameters.max_sources)));
    if (others.empty()) return geometry;
    double widest = 0;
    const Vector3d middle = cameras_[k].T_world_camera * Vector3d(0, 0, distance);
    for (const auto& [score, j] : others) {
      geometry.sources.push_back(j);
      const double baseline = (centreOf(j) - centreOf(k)).norm();
      widest = std::max(widest, static_cast<double>(ideal_[j].fx) * baseline);
      geometry.baseline = std::max(geometry.baseline, static_cast<float>(baseline));
      const auto angle = static_cast<float>(angleAt(middle, k, j));
      geometry.min_angle = geometry.sources.size() == 1 ? angle : std::min(geometry.min_angle, angle);
      geometry.max_angle = std::max(geometry.max_angle, angle);
    }
    geometry.parallel_baselines = baselinesAreParallel(k, geometry.sources);
    geometry.min_depth = parameters.min_depth > 0 ? parameters.min_depth
                                                  : static_cast<float>(nearestDepth(k, geometry.sources, distance));
    geometry.max_depth =
        parameters.max_depth > 0 ? parameters.max_depth : static_cast<float>(std::max(widest / 2, 4 * distance));
    if (!(geometry.max_depth > geometry.min_depth)) geometry.sources.clear();
    return geometry;
  }

  bool baselinesAreParallel(std::size_t k, const std::vector<std::size_t>& sources) const {
    // Of directions in the image, regardless of sign: the mean of their doubled angles is as long as they agree.
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    std::vector<Eigen::Vector2d> doubled;
    for (const std::size_t s : sources) {
      const Eigen::Vector2d d =
          (cameras_[k].T_world_camera.linear().transpose() * (centreOf(s) - centreOf(k))).head<2>();
      const double angle = 2 * std::atan2(d.y(), d.x());
      doubled.emplace_back(std::cos(angle), std::sin(angle));
      mean += doubled.back();
    }
    mean.normalize();
    constexpr double cosine = 0.978;  // of twice 6°
    return std::all_of(doubled.begin(), doubled.end(), [&](const Eigen::Vector2d& d) { return d.dot(mean) > cosine; });
  }

  std::vector<Camera> cameras_, result_cameras_;
  std::vector<bool> present_;
  std::vector<Intrinsics> ideal_;
  std::vector<StereoGeometry> geometry_;
};

}  // namespace detail
}  // namespace fuse_flow
