#include "simulation/simulator.h"

#include "simulation/depth_distortion.h"
#include "simulation/portable_math.h"
#include "simulation/random.h"
#include "simulation/rig_layout.h"
#include "simulation/surfaces/marker.h"

#include <fuse_flow/recordings/error.h>

#include <cmath>
#include <sstream>
#include <utility>

namespace fuse_flow::simulation {
namespace {

// What is drawn once a camera has a frame number that no frame reaches.
constexpr std::uint64_t kOnce = ~std::uint64_t{0};

/** \brief Between two steps of a motion vertices move on straight lines: at 200 m/s², more than any of the scenes has, within 0.4 mm
 *  of the true way. Seconds. */
constexpr double kMotionStep = 0.004;

void require(bool good, const std::string& name, double value, const std::string& range) {
  if (good) return;
  std::ostringstream message;
  message << name << " is " << value << ", must be " << range;
  throw io::InputError(message.str());
}

void check(const SimulationOptions& o) {
  require(o.frames_per_second > 0 && o.frames_per_second <= 1000, "frames per second", o.frames_per_second,
          "in (0, 1000]");
  require(o.faults.position_error >= 0 && o.faults.position_error <= 1, "position error in metres",
          o.faults.position_error, "in [0, 1]");
  require(o.faults.rotation_error >= 0 && o.faults.rotation_error <= 0.8, "rotation error in radians",
          o.faults.rotation_error, "in [0, 0.8]");
  require(o.faults.bump >= 0 && o.faults.bump <= 1, "bump in metres", o.faults.bump, "in [0, 1]");
  require(o.faults.bump_rotation >= 0 && o.faults.bump_rotation <= 0.8, "bump in radians", o.faults.bump_rotation,
          "in [0, 0.8]");
  require(o.faults.depth_bias >= 0 && o.faults.depth_bias <= 0.5, "depth bias in metres", o.faults.depth_bias,
          "in [0, 0.5]");
  require(o.faults.depth_distortion >= 0 && o.faults.depth_distortion <= 0.1, "depth distortion in metres",
          o.faults.depth_distortion, "in [0, 0.1]");
  require(o.faults.drop_rate >= 0 && o.faults.drop_rate <= 1, "drop rate", o.faults.drop_rate, "in [0, 1]");
  require(o.marker >= 0 && o.marker <= 2, "side of the marker in metres", o.marker, "in [0, 2]");
  require(o.faults.out_of_sync >= 0 && o.faults.out_of_sync <= 1, "time out of sync in seconds", o.faults.out_of_sync,
          "in [0, 1]");
  require(o.faults.out_of_step >= 0 && o.faults.out_of_step <= 1, "time out of step in seconds", o.faults.out_of_step,
          "in [0, 1]");
  require(o.faults.readout_time >= 0 && o.faults.readout_time <= 0.1, "readout time in seconds", o.faults.readout_time,
          "in [0, 0.1]");
  require(o.faults.exposure_time >= 0 && o.faults.exposure_time <= 0.1, "exposure time in seconds",
          o.faults.exposure_time, "in [0, 0.1]");
  const ImageErrorSpread& image = o.faults.image;
  require(image.noise >= 0 && image.noise <= 100, "image noise in grey levels", image.noise, "in [0, 100]");
  require(image.exposure >= 0 && image.exposure <= 0.9, "spread of the exposure", image.exposure, "in [0, 0.9]");
  require(image.vignetting >= 0 && image.vignetting <= 1, "vignetting", image.vignetting, "in [0, 1]");
}

Eigen::Vector3d randomDirection(Random& random) {
  Eigen::Vector3d d;
  do {
    d = Eigen::Vector3d(random.gaussian(), random.gaussian(), random.gaussian());
  } while (d.norm() < 1e-3);
  return d.normalized();
}

Eigen::Isometry3d disturbed(const Eigen::Isometry3d& T, double metres, double radians, Random& random) {
  Eigen::Isometry3d result = T;
  result.pretranslate(metres * randomDirection(random));
  result.rotate(portable::turn(radians, randomDirection(random)));
  return result;
}

/** \brief Metres to the sensor's units; out of its range: 0. */
void encode(const io::FloatImage& metres, double bias, const DepthCorrection& correction, const Sensor& sensor,
            io::DepthImage& depth) {
  depth.resize(metres.width, metres.height);
  const double per_unit = 1.0 / static_cast<double>(sensor.depthScale());
  for (int v = 0; v < metres.height; ++v)
    for (int u = 0; u < metres.width; ++u) {
      const float z = metres.at(u, v);
      const bool measured = z >= sensor.minRange() && z <= sensor.maxRange();
      const double bent = mismeasured(static_cast<double>(z), correction.at(u, v, metres.width, metres.height));
      const double units = measured ? std::floor((bent + bias) * per_unit + 0.5) : 0.0;
      depth.at(u, v) = units > 0 && units < 65535 ? static_cast<std::uint16_t>(units) : std::uint16_t{0};
    }
}

std::string cameraName(std::size_t k) {
  std::ostringstream name;
  name << "camera_" << (k < 10 ? "0" : "") << k;
  return name.str();
}

}  // namespace

Simulator::Simulator(const SimulationOptions& options) : options_(options), rays_(options.embree) {
  check(options_);
  scene_ = makeScene(options_.scene, static_cast<std::uint32_t>(options_.seed));
  sensor_ = makeSensor(options_.sensor, options_.scale);
  const std::vector<Eigen::Isometry3d> poses = placeCameras(options_.rig, *scene_);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    Camera camera;
    camera.name = cameraName(k);
    camera.intrinsics = sensor_->intrinsics();
    camera.depth_scale = sensor_->depthScale();
    camera.T_world_camera = poses[k];
    camera.multipath.modulation_frequency = sensor_->modulationFrequency();
    if (options_.faults.depth_distortion > 0) {
      Random random(options_.seed, kOnce, k, 1);
      camera.depth_correction = randomCorrection(options_.faults.depth_distortion, random);
    }
    true_cameras_.push_back(camera);
    camera.depth_correction = {};
    Random random(options_.seed, kOnce, k, 0);
    camera.T_world_camera = disturbed(poses[k], options_.faults.position_error, options_.faults.rotation_error, random);
    cameras_.push_back(camera);
    bias_.push_back(options_.faults.depth_bias * (2 * random.uniform() - 1));
    const double step = poses.size() > 1 ? static_cast<double>(k) / static_cast<double>(poses.size() - 1) - 0.5 : 0;
    delay_.push_back(options_.faults.out_of_sync * (2 * random.uniform() - 1) + options_.faults.out_of_step * step);
    image_errors_.push_back(options_.faults.image.draw(Random(options_.seed, kOnce, k, 2)));
  }
  Random random(options_.seed, kOnce, poses.size(), 0);
  bumped_pose_ = disturbed(poses.back(), options_.faults.bump, options_.faults.bump_rotation, random);
  fixed_ = scene_->fixedObjects();
  rays_.setFixed(fixed_);
}

io::RigDescription Simulator::rig() const {
  io::RigDescription rig{{}, options_.frames_per_second};
  for (const Camera& camera : cameras_) rig.cameras.push_back({camera});
  return rig;
}

const Eigen::Isometry3d& Simulator::truePose(std::size_t frame, std::size_t camera) const {
  const Faults& faults = options_.faults;
  const bool bumped =
      (faults.bump > 0 || faults.bump_rotation > 0) && frame >= faults.bump_frame && camera + 1 == true_cameras_.size();
  return bumped ? bumped_pose_ : true_cameras_[camera].T_world_camera;
}

std::vector<Object> Simulator::objectsAt(double time) const {
  std::vector<Object> objects = scene_->movingObjects(time);
  if (options_.marker > 0) objects.push_back(makeMarker(options_.marker, scene_->subject(), time));
  return objects;
}

std::vector<Object> Simulator::movingObjects(std::size_t frame) const {
  constexpr double step = 1e-3;  // seconds; over less, the rounding of the coordinates would count
  std::vector<Object> objects = objectsAt(time(frame));
  const std::vector<Object> before = objectsAt(time(frame) - step), after = objectsAt(time(frame) + step);
  for (std::size_t k = 0; k < objects.size(); ++k) {
    TriangleMesh& mesh = objects[k].mesh;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
      mesh.velocities.push_back((after[k].mesh.vertices[i] - before[k].mesh.vertices[i]) /
                                static_cast<float>(2 * step));
  }
  return objects;
}

void Simulator::moveTo(double time, double span) {
  if (time == at_ && span == span_) return;
  std::vector<std::vector<Object>> steps;
  const int count = span > 0 ? static_cast<int>(std::ceil(span / kMotionStep)) + 1 : 1;
  for (int step = 0; step < count; ++step)
    steps.push_back(objectsAt(count > 1 ? time + span * (static_cast<double>(step) / (count - 1) - 0.5) : time));
  rays_.setMotion(std::move(steps));
  at_ = time;
  span_ = span;
}

Shutter Simulator::shutter() const {
  const double span = shutterSpan();
  if (!(span > 0)) return {};
  const auto share = [&](double seconds) { return static_cast<float>(seconds / span); };
  const double exposure = options_.faults.exposure_time;
  return {share(0.5 * exposure), share(0.5 * exposure + options_.faults.readout_time), share(exposure)};
}

void Simulator::measure(std::size_t frame, io::LoadedFrame& out) {
  out.rig.cameras = cameras_;
  out.rig.views.assign(cameras_.size(), DepthView());
  out.rig.stamp = static_cast<std::uint64_t>(std::llround(1e6 * time(frame)));
  out.images.resize(cameras_.size());
  io::FloatImage metres;
  for (std::size_t k = 0; k < cameras_.size(); ++k) {
    Random random(options_.seed, frame, k, kOnce);
    if (random.uniform() < options_.faults.drop_rate) continue;
    moveTo(time(frame) + delay_[k], shutterSpan());
    const Exposure exposure(rays_, shutter());
    const ShotNumber shot{options_.seed, frame, k};
    const Eigen::Isometry3d& pose = truePose(frame, k);
    sensor_->measure(exposure, pose, shot, options_.threads, metres);
    io::LoadedView& images = out.images[k];
    encode(metres, bias_[k], true_cameras_[k].depth_correction, *sensor_, images.depth16);
    DepthView& view = out.rig.views[k];
    view.depth16 = images.depth16.view();
    if (!options_.color) continue;
    renderColor(exposure, true_cameras_[k].intrinsics, pose, shot, options_.threads, image_errors_[k], images.color);
    view.color = images.color.view();
  }
}

const RayScene& Simulator::truth(std::size_t frame) {
  moveTo(time(frame));
  return rays_;
}

}  // namespace fuse_flow::simulation
