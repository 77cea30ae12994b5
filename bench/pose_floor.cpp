#include "pose_floor.h"

#include "simulation/true_view.h"

#include <Eigen/Cholesky>

#include <cmath>
#include <functional>

namespace bench {
namespace {

using namespace fuse_flow;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/** \brief A measurement beside the surface that it is of. */
struct Measurement {
  bool there{false};
  Eigen::Vector3f x;  ///< where the pixel's ray truly meets the surface, world
  Eigen::Vector3f n;  ///< the surface's normal
  double error;       ///< along it, metres
  double deviation;   ///< of that error
};

/** \brief What a sensor's makers or testers say of its axial noise, metres; as the simulator has it. */
std::function<double(double)> axialDeviation(const std::string& sensor) {
  if (sensor == "active_stereo") return [](double z) { return 0.08 * z * z / (424 * 0.05); };
  if (sensor == "structured_light") return [](double z) { return 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4); };
  if (sensor == "ideal") return [](double) { return 0.0001; };
  return [](double z) { return 0.0004 + 0.0002 * z * z; };
}

/** \brief One view: smooth surfaces only, seen from less than 78°, and no flying pixels. */
class MeasuredView {
 public:
  MeasuredView(const simulation::RayScene& scene, const Camera& camera, const DepthView& measured,
               const std::string& sensor)
      : K_(camera.intrinsics),
        to_camera_(camera.T_world_camera.inverse().cast<float>()),
        all_(static_cast<std::size_t>(K_.width) * static_cast<std::size_t>(K_.height)) {
    const simulation::TrueView truth =
        simulation::renderTrueView(scene, K_, camera.T_world_camera, Eigen::Vector3f::Zero(), 2);
    const simulation::PixelRays rays(K_, camera.T_world_camera);
    const auto deviation = axialDeviation(sensor);
    const auto place = [&](int u, int v) {
      return Eigen::Vector3f(rays.origin() + truth.depth.at(u, v) * rays.direction(u, v));
    };
    for (int v = 1; v + 1 < K_.height; ++v)
      for (int u = 1; u + 1 < K_.width; ++u) {
        const double z = static_cast<double>(camera.depth_scale) * measured.depth16.row(v)[u];
        const double true_z = static_cast<double>(truth.depth.at(u, v));
        if (!(z > 0) || !(true_z > 0) || !smooth(truth.depth, u, v)) continue;
        // Of stereo disparity is what errs evenly.
        const double off = sensor == "active_stereo" ? true_z * (1 - true_z / z) : z - true_z;
        const double largest = sensor == "time_of_flight_multipath" ? 0.05 : 4 * deviation(true_z);
        if (std::fabs(off) > largest) continue;
        Eigen::Vector3f n = (place(u + 1, v) - place(u - 1, v)).cross(place(u, v + 1) - place(u, v - 1)).normalized();
        const Eigen::Vector3f ray = rays.direction(u, v);
        if (n.dot(ray) > 0) n = -n;
        const double facing = static_cast<double>(n.dot(ray));
        if (-facing < 0.2 * static_cast<double>(ray.norm())) continue;
        all_[index(u, v)] = {true, place(u, v), n, facing * off, -facing * deviation(true_z)};
      }
  }

  int width() const { return K_.width; }
  int height() const { return K_.height; }
  const Measurement& at(int u, int v) const { return all_[index(u, v)]; }
  /** \brief What it measured of the place that another view measured; null if nothing. */
  const Measurement* of(const Measurement& other) const {
    const Eigen::Vector3f q = to_camera_ * other.x;
    if (!(q.z() > 0.1f)) return nullptr;
    const long u = std::lround(K_.fx * q.x() / q.z() + K_.cx), v = std::lround(K_.fy * q.y() / q.z() + K_.cy);
    if (u < 0 || v < 0 || u >= K_.width || v >= K_.height) return nullptr;
    const Measurement& own = at(static_cast<int>(u), static_cast<int>(v));
    const bool same = own.there && (own.x - other.x).norm() < 0.02f && own.n.dot(other.n) > 0.95f &&
                      std::fabs(own.n.dot(own.x - other.x)) < 0.002f;
    return same ? &own : nullptr;
  }

 private:
  static bool smooth(const io::FloatImage& z, int u, int v) {
    const float bound = 0.02f * z.at(u, v);
    for (const auto& [du, dv] : {std::pair{1, 0}, std::pair{0, 1}}) {
      const float before = z.at(u - du, v - dv), after = z.at(u + du, v + dv);
      if (!(before > 0) || !(after > 0) || std::fabs(before + after - 2 * z.at(u, v)) > bound) return false;
    }
    return true;
  }
  std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(K_.width) + static_cast<std::size_t>(u);
  }

  Intrinsics K_;
  Eigen::Isometry3f to_camera_;
  std::vector<Measurement> all_;
};

}  // namespace

std::vector<Eigen::Isometry3d> posesOfExactCorrespondences(simulation::Simulator& simulator, std::size_t frames,
                                                           int stride) {
  const std::vector<Camera>& cameras = simulator.trueCameras();
  const auto size = static_cast<Eigen::Index>(6 * cameras.size());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(size);
  for (std::size_t frame = 0; frame < frames; ++frame) {
    io::LoadedFrame loaded;
    simulator.measure(frame, loaded);
    const simulation::RayScene& scene = simulator.truth(frame);
    std::vector<MeasuredView> views;
    for (std::size_t i = 0; i < cameras.size(); ++i)
      views.emplace_back(scene, cameras[i], loaded.rig.views[i], simulator.options().sensor);
    for (std::size_t i = 0; i < views.size(); ++i)
      for (std::size_t j = 0; j < views.size(); ++j) {
        if (i == j) continue;
        const auto a = static_cast<Eigen::Index>(6 * i), b = static_cast<Eigen::Index>(6 * j);
        Matrix6d A = Matrix6d::Zero();
        Vector6d gradient = Vector6d::Zero();
        for (int v = 0; v < views[i].height(); v += stride)
          for (int u = 0; u < views[i].width(); u += stride) {
            const Measurement& own = views[i].at(u, v);
            const Measurement* other = own.there ? views[j].of(own) : nullptr;
            if (!other) continue;
            const double w = 1 / (own.deviation * own.deviation + other->deviation * other->deviation);
            const Eigen::Vector3d n = own.n.cast<double>(), x = own.x.cast<double>();
            Vector6d J;
            J << n, x.cross(n);
            A += w * J * J.transpose();
            gradient += w * (own.error - other->error) * J;
          }
        H.block<6, 6>(a, a) += A;
        H.block<6, 6>(b, b) += A;
        H.block<6, 6>(a, b) -= A;
        H.block<6, 6>(b, a) -= A;
        g.segment<6>(a) += gradient;
        g.segment<6>(b) -= gradient;
      }
  }
  H.diagonal().array() += 1e-9 * H.diagonal().maxCoeff();  // the pose of the whole rig is unobservable
  const Eigen::VectorXd twists = -H.ldlt().solve(g);
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Vector6d twist = twists.segment<6>(static_cast<Eigen::Index>(6 * i));
    const double angle = twist.tail<3>().norm();
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    if (angle > 0) motion.rotate(Eigen::AngleAxisd(angle, twist.tail<3>() / angle));
    motion.pretranslate(Eigen::Vector3d(twist.head<3>()));
    poses.push_back(motion * cameras[i].T_world_camera);
  }
  return poses;
}

}  // namespace bench
