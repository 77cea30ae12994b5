#include "calibration/marker_rig.h"

#include <fuse_flow/impl/calibration/dense_algebra.hpp>

#include <Eigen/LU>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

namespace fuse_flow::io {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/** \brief A marker as the camera that took the colour image sees it. */
struct Look {
  std::size_t eye{0};
  std::size_t marker{0};
  std::vector<Vector3d> points;  ///< in the marker's frame: x to the right, y down, z away from the viewer; metres
  std::vector<Vector2d> rays;    ///< x/z, y/z of the points
  double focal{0};               ///< pixels, so that residuals are pixels
  double depth{0};               ///< of MarkerSighting
  Vector3d depth_at;             ///< in the marker's frame
  Isometry3d T_eye_marker;       ///< what it says alone
  double doubt{0};               ///< residual of that over that of the other pose; [0, 1]
};

Isometry3d moved(const Vector6d& twist, const Isometry3d& T) {
  const double angle = twist.tail<3>().norm();
  Isometry3d motion = Isometry3d::Identity();
  if (angle > 0) motion.linear() = Eigen::AngleAxisd(angle, twist.tail<3>() / angle).toRotationMatrix();
  motion.translation() = twist.head<3>();
  return motion * T;
}

/** \brief What a look says about small motions of its marker in the world; of its eye it says the opposite. */
struct Pull {
  Matrix6d A{Matrix6d::Zero()};
  Vector6d g{Vector6d::Zero()};
  double squares{0};  ///< of the distances, pixels
  double cost{0};     ///< the same by Huber's function
};

/** \brief Distance from which on a point counts less, pixels: something may have hidden it. */
constexpr double kRobust = 1.5;

Pull pullOf(const Look& look, const Isometry3d& T_world_eye, const Isometry3d& T_world_marker) {
  Pull pull;
  const Isometry3d T_eye_world = T_world_eye.inverse();
  for (std::size_t k = 0; k < look.points.size(); ++k) {
    const Vector3d x = T_world_marker * look.points[k], p = T_eye_world * x;
    if (!(p.z() > 1e-6)) {
      pull.cost = pull.squares = std::numeric_limits<double>::infinity();
      return pull;
    }
    const Vector2d ray = p.head<2>() / p.z();
    const Vector2d r = look.focal * (ray - look.rays[k]);
    Eigen::Matrix<double, 2, 3> along;
    along << 1, 0, -ray.x(), 0, 1, -ray.y();
    const Eigen::Matrix<double, 2, 3> a = look.focal / p.z() * along * T_eye_world.linear();
    Eigen::Matrix<double, 2, 6> J;
    for (int row = 0; row < 2; ++row) {
      const Vector3d t = a.row(row).transpose();
      J.row(row) << t.transpose(), x.cross(t).transpose();
    }
    const double distance = r.norm(), w = distance > kRobust ? kRobust / distance : 1.0;
    pull.A += w * J.transpose() * J;
    pull.g += w * J.transpose() * r;
    pull.squares += r.squaredNorm();
    pull.cost += distance > kRobust ? kRobust * (2 * distance - kRobust) : r.squaredNorm();
  }
  return pull;
}

/** \brief The pose of a marker that one look says, from a guess on. */
Isometry3d refined(const Look& look, Isometry3d T) {
  Pull pull = pullOf(look, Isometry3d::Identity(), T);
  double damping = 1e-6;
  for (int iteration = 0; iteration < 40 && damping < 1e6; ++iteration) {
    Matrix6d A = pull.A;
    A.diagonal() *= 1 + damping;
    const Isometry3d next = moved(host::CholeskyFactors(A).solve(-pull.g), T);
    const Pull there = pullOf(look, Isometry3d::Identity(), next);
    if (there.cost < pull.cost) {
      T = next;
      pull = there;
      damping *= 0.1;
    } else {
      damping *= 10;
    }
  }
  return T;
}

Vector3d middle(const std::vector<Vector3d>& points) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& p : points) sum += p / static_cast<double>(points.size());
  return sum;
}

/** \brief From the homography of its points. Nothing if they do not determine it: four or more, and not all but one on a line. */
std::optional<Isometry3d> guess(const Look& look) {
  const auto n = static_cast<Eigen::Index>(look.points.size());
  if (n < 4) return std::nullopt;
  // About their middle, which is in front of the camera, wherever the marker's origin is.
  const Vector3d mean = middle(look.points);
  Eigen::Matrix<double, Eigen::Dynamic, 8> A = Eigen::Matrix<double, Eigen::Dynamic, 8>::Zero(2 * n, 8);
  Eigen::VectorXd b(2 * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Vector3d c = look.points[static_cast<std::size_t>(k)] - mean;
    const Vector2d& ray = look.rays[static_cast<std::size_t>(k)];
    for (int row = 0; row < 2; ++row) {
      A.row(2 * k + row).segment<3>(3 * row) << c.x(), c.y(), 1;
      A.row(2 * k + row).tail<2>() << -ray[row] * c.x(), -ray[row] * c.y();
      b[2 * k + row] = ray[row];
    }
  }
  Eigen::ColPivHouseholderQR<decltype(A)> qr(A);
  qr.setThreshold(1e-7);
  if (qr.rank() < 8) return std::nullopt;
  // Four points leave nothing to average.
  Eigen::Matrix<double, 8, 1> h;
  if (n == 4)
    h = Eigen::Matrix<double, 8, 8>(A).partialPivLu().solve(Eigen::Matrix<double, 8, 1>(b));
  else
    h = qr.solve(b);
  const Vector3d x(h[0], h[3], h[6]), y(h[1], h[4], h[7]), t(h[2], h[5], 1);
  const double scale = 1 / std::sqrt(x.norm() * y.norm());
  // Between the two, at right angles to each other.
  const Vector3d sum = (x.normalized() + y.normalized()).normalized();
  const Vector3d difference = (x.normalized() - y.normalized()).normalized();
  Isometry3d T = Isometry3d::Identity();
  T.linear().col(0) = (sum + difference) * std::sqrt(0.5);
  T.linear().col(1) = (sum - difference) * std::sqrt(0.5);
  T.linear().col(2) = T.linear().col(0).cross(T.linear().col(1));
  T.translation() = scale * t - T.linear() * mean;
  return T;
}

/** \brief The pose that looks nearly the same: its normal mirrored about the line of sight to a point of it. */
Isometry3d mirrored(const Isometry3d& T, const Vector3d& about) {
  const Vector3d seen = T * about, sight = seen.normalized(), normal = T.linear().col(2);
  const Vector3d axis = normal.cross(sight);
  if (!(axis.norm() > 1e-9)) return T;
  Isometry3d result = T;
  const double angle = 2 * std::atan2(axis.norm(), normal.dot(sight));
  result.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix() * T.linear();
  result.translation() = seen - result.linear() * about;
  return result;
}

/** \brief Fills in what a look says alone. False if that is nothing. */
bool solve(Look& look) {
  constexpr double same = 0.999;  // cosine of 2.5°
  const std::optional<Isometry3d> begin = guess(look);
  if (!begin) return false;
  const Isometry3d first = refined(look, *begin), second = refined(look, mirrored(first, middle(look.points)));
  const double a = pullOf(look, Isometry3d::Identity(), first).squares;
  const double b = pullOf(look, Isometry3d::Identity(), second).squares;
  look.T_eye_marker = a <= b ? first : second;
  const bool one = first.linear().col(2).dot(second.linear().col(2)) > same;
  look.doubt = one || !(std::max(a, b) > 0) ? 0.0 : std::sqrt(std::min(a, b) / std::max(a, b));
  return std::isfinite(std::min(a, b)) && look.T_eye_marker.matrix().allFinite();
}

/** \brief Cameras that took the images, markers at their instants, and who sees which. */
class MarkerGraph {
 public:
  MarkerGraph(const std::vector<Isometry3d>& eyes, std::vector<Look> looks, std::size_t markers)
      : eyes_(eyes),
        markers_(markers, Isometry3d::Identity()),
        eye_placed_(eyes.size(), false),
        marker_placed_(markers, false),
        looks_(std::move(looks)) {}

  /** \brief From the first eye on, along looks with as little doubt as may be. */
  void place() {
    eye_placed_[0] = true;
    for (;;) {
      const Look* next = nullptr;
      for (const Look& look : looks_)
        if (eye_placed_[look.eye] != marker_placed_[look.marker] && (!next || look.doubt < next->doubt)) next = &look;
      if (!next) break;
      if (eye_placed_[next->eye]) {
        markers_[next->marker] = eyes_[next->eye] * next->T_eye_marker;
        marker_placed_[next->marker] = true;
      } else {
        eyes_[next->eye] = markers_[next->marker] * next->T_eye_marker.inverse();
        eye_placed_[next->eye] = true;
      }
    }
    looks_.erase(std::remove_if(looks_.begin(), looks_.end(), [&](const Look& look) { return !eye_placed_[look.eye]; }),
                 looks_.end());
  }

  /** \brief All poses that lower the distances of all corners most; the first eye stays. */
  void adjust() {
    double damping = 1e-6, cost = linearize();
    for (int iteration = 0; iteration < 60 && damping < 1e6; ++iteration) {
      const std::vector<Isometry3d> eyes = eyes_, markers = markers_;
      const std::vector<Pull> pulls = pulls_;
      step(damping);
      const double next = linearize();
      const bool still = next > cost * (1 - 1e-9);
      if (next < cost) {
        cost = next;
        damping *= 0.1;
        if (still) return;
      } else {
        eyes_ = eyes;
        markers_ = markers;
        pulls_ = pulls;
        damping *= 10;
      }
    }
  }

  const Isometry3d& eye(std::size_t k) const { return eyes_[k]; }
  bool placed(std::size_t eye) const { return eye_placed_[eye]; }

  std::size_t sharedMarkers() const {
    std::vector<std::size_t> count(markers_.size(), 0);
    for (const Look& look : looks_) ++count[look.marker];
    return static_cast<std::size_t>(std::count_if(count.begin(), count.end(), [](std::size_t n) { return n > 1; }));
  }
  double residual() const {
    double squares = 0;
    std::size_t points = 0;
    for (const Pull& pull : pulls_) squares += pull.squares;
    for (const Look& look : looks_) points += look.points.size();
    return points == 0 ? 0.0 : std::sqrt(squares / static_cast<double>(points));
  }
  double depthRatio() const {
    std::vector<double> ratios;
    for (const Look& look : looks_)
      if (look.depth > 0)
        ratios.push_back(look.depth / (eyes_[look.eye].inverse() * (markers_[look.marker] * look.depth_at)).z());
    if (ratios.empty()) return 0;
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    return *middle;
  }

 private:
  double linearize() {
    double cost = 0;
    pulls_.clear();
    for (const Look& look : looks_) {
      pulls_.push_back(pullOf(look, eyes_[look.eye], markers_[look.marker]));
      cost += pulls_.back().cost;
    }
    return cost;
  }

  /** \brief Gauss and Newton's. A marker's motion follows from those of the eyes that see it, so only these are asked for. */
  void step(double damping) {
    const Eigen::Index size = 6 * static_cast<Eigen::Index>(eyes_.size());
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(size);
    std::vector<Matrix6d> inverse(markers_.size(), Matrix6d::Zero());
    std::vector<Vector6d> slope(markers_.size(), Vector6d::Zero());
    const auto begin = [](std::size_t eye) { return 6 * static_cast<Eigen::Index>(eye); };
    for (std::size_t k = 0; k < looks_.size(); ++k) {
      inverse[looks_[k].marker] += pulls_[k].A;
      slope[looks_[k].marker] += pulls_[k].g;
      A.block<6, 6>(begin(looks_[k].eye), begin(looks_[k].eye)) += pulls_[k].A;
      g.segment<6>(begin(looks_[k].eye)) -= pulls_[k].g;
    }
    A.diagonal() *= 1 + damping;
    for (Matrix6d& M : inverse) {
      M.diagonal() *= 1 + damping;
      M = host::CholeskyFactors(M).solveColumns(Matrix6d::Identity());
    }
    for (std::size_t k = 0; k < looks_.size(); ++k) {
      const Matrix6d half = pulls_[k].A * inverse[looks_[k].marker];
      g.segment<6>(begin(looks_[k].eye)) += half * slope[looks_[k].marker];
      for (std::size_t l = 0; l < looks_.size(); ++l)
        if (looks_[l].marker == looks_[k].marker)
          A.block<6, 6>(begin(looks_[k].eye), begin(looks_[l].eye)) -= half * pulls_[l].A;
    }
    hold(A, g);
    const Eigen::VectorXd motion = host::CholeskyFactors(A).solve(-g);
    for (std::size_t k = 0; k < looks_.size(); ++k)
      slope[looks_[k].marker] -= pulls_[k].A * motion.segment<6>(begin(looks_[k].eye));
    for (std::size_t m = 0; m < markers_.size(); ++m)
      if (marker_placed_[m]) markers_[m] = moved(Vector6d(-inverse[m] * slope[m]), markers_[m]);
    for (std::size_t e = 1; e < eyes_.size(); ++e)
      if (eye_placed_[e]) eyes_[e] = moved(Vector6d(motion.segment<6>(begin(e))), eyes_[e]);
  }

  /** \brief The first eye, and those that nothing is known of. */
  void hold(Eigen::MatrixXd& A, Eigen::VectorXd& g) const {
    for (std::size_t e = 0; e < eyes_.size(); ++e) {
      if (e > 0 && eye_placed_[e]) continue;
      const Eigen::Index k = 6 * static_cast<Eigen::Index>(e);
      A.middleRows<6>(k).setZero();
      A.middleCols<6>(k).setZero();
      A.block<6, 6>(k, k).setIdentity();
      g.segment<6>(k).setZero();
    }
  }

  std::vector<Isometry3d> eyes_, markers_;
  std::vector<bool> eye_placed_, marker_placed_;
  std::vector<Look> looks_;
  std::vector<Pull> pulls_;  ///< look by look
};

const Intrinsics& colorIntrinsics(const Camera& camera) {
  return camera.color ? camera.color->intrinsics : camera.intrinsics;
}

Isometry3d depthToColor(const Camera& camera) {
  return camera.color ? camera.color->T_depth_color : Isometry3d::Identity();
}

Look look(const MarkerSighting& sighting, const Intrinsics& K, std::size_t marker) {
  Look result;
  result.eye = sighting.camera;
  result.marker = marker;
  result.focal = 0.5 * static_cast<double>(K.fx + K.fy);
  result.depth = static_cast<double>(sighting.depth);
  result.depth_at << sighting.depth_at, 0;
  for (const MarkerPoint& point : sighting.points) {
    const Ray ray = unproject(K, point.pixel);
    result.points.emplace_back(point.place.x(), point.place.y(), 0);
    result.rays.emplace_back(static_cast<double>(ray.x), static_cast<double>(ray.y));
  }
  return result;
}

}  // namespace

std::vector<MarkerPoint> squarePoints(double side, const std::array<Pixel, 4>& corners) {
  static constexpr double x[] = {-0.5, 0.5, 0.5, -0.5}, y[] = {0.5, 0.5, -0.5, -0.5};
  std::vector<MarkerPoint> points;
  for (std::size_t k = 0; k < 4; ++k) points.push_back({side * Vector2d(x[k], y[k]), corners[k]});
  return points;
}

MarkerRig placeByMarkers(const std::vector<Camera>& cameras, const std::vector<MarkerSighting>& sightings) {
  MarkerRig rig;
  std::map<std::pair<std::size_t, int>, std::size_t> numbers;
  std::vector<Look> looks;
  for (const MarkerSighting& sighting : sightings) {
    const std::size_t marker =
        numbers.emplace(std::make_pair(sighting.frame, sighting.id), numbers.size()).first->second;
    looks.push_back(look(sighting, colorIntrinsics(cameras[sighting.camera]), marker));
    if (solve(looks.back())) continue;
    looks.pop_back();
    ++rig.unusable;
  }
  std::vector<Isometry3d> eyes;
  for (const Camera& camera : cameras) eyes.push_back(camera.T_world_camera * depthToColor(camera));
  MarkerGraph graph(eyes, looks, numbers.size());
  graph.place();
  graph.adjust();
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    rig.placed.push_back(graph.placed(i));
    rig.T_world_camera.push_back(i > 0 && graph.placed(i) ? graph.eye(i) * depthToColor(cameras[i]).inverse()
                                                          : cameras[i].T_world_camera);
  }
  rig.markers = graph.sharedMarkers();
  rig.residual = graph.residual();
  rig.depth_ratio = graph.depthRatio();
  return rig;
}

}  // namespace fuse_flow::io
