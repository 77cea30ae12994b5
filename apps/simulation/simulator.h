#pragma once

#include "simulation/image_errors.h"
#include "simulation/scene.h"
#include "simulation/sensor.h"
#include "simulation/surfaces/ray_scene.h"

#include <fuse_flow/recordings/recording.h>
#include <fuse_flow/recordings/rig_json.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::simulation {

/** \brief What is wrong with the rig, beyond its sensors' noise. All 0: nothing. */
struct Faults {
  /** \brief Every calibrated camera is this far from its true place, metres, in a random direction … */
  double position_error{0};
  /** \brief … and turned by this angle about a random axis, radians. */
  double rotation_error{0};
  /** \brief Each camera adds a constant to its depth, uniform in ± this, metres. */
  double depth_bias{0};
  /** \brief Each camera bends what it measures in a way of its own, by about this at 2 m, metres; see randomCorrection(). */
  double depth_distortion{0};
  /** \brief Probability that a camera's frame is lost; [0, 1]. */
  double drop_rate{0};
  /** \brief From frame bump_frame on the last camera stands this far from where it stood, metres, in a random direction … */
  double bump{0};
  /** \brief … and is turned by this angle about a random axis, radians. */
  double bump_rotation{0};
  std::size_t bump_frame{0};
  /** \brief Each camera exposes earlier or later by a constant, uniform in ± this, seconds. */
  double out_of_sync{0};
  /** \brief The exposures of a frame are spread evenly over this, seconds: the first camera's is half of it before the frame's
   *  nominal time, the last one's half of it after. As of cameras that nothing synchronises. */
  double out_of_step{0};
  /** \brief From the first to the last row's exposure, seconds; [0, 0.1]. 0: a global shutter, all rows at once. A rolling one exposes
   *  the row in the middle at the image's time. */
  double readout_time{0};
  /** \brief How long each row is exposed, about its time, seconds; [0, 0.1]. 0: an instant, nothing is blurred. */
  double exposure_time{0};
  /** \brief Of the colour images. */
  ImageErrorSpread image;
};

struct SimulationOptions {
  std::string scene{"room"};
  std::string rig{"ring-4"};
  std::string sensor{"structured_light"};
  /** \brief Of the images' sides and focal lengths. */
  double scale{1};
  double frames_per_second{30};
  std::uint64_t seed{1};
  Faults faults;
  int threads{2};
  bool color{true};
  /** \brief Side of the marker that someone shows to the cameras, metres; [0, 2]. 0: nobody does. */
  double marker{0};
  /** \brief Embree's configuration, see RayScene; changes no image. */
  std::string embree;
};

/** \brief A rig of depth cameras in a scene. The same options give the same images, frame by frame, in any order. */
class Simulator {
 public:
  /** \brief Throws io::InputError for an unknown name or a number out of range. */
  explicit Simulator(const SimulationOptions& options);

  const SimulationOptions& options() const { return options_; }
  const Sensor& sensor() const { return *sensor_; }
  /** \brief As calibrated. */
  const std::vector<Camera>& cameras() const { return cameras_; }
  /** \brief The same, with all that a recording of it says. */
  io::RigDescription rig() const;
  /** \brief Where they stand at first, and what puts their depth right. */
  const std::vector<Camera>& trueCameras() const { return true_cameras_; }
  /** \brief Where a camera stands in a frame: as trueCameras() says until it is bumped. */
  const Eigen::Isometry3d& truePose(std::size_t frame, std::size_t camera) const;
  /** \brief How much later than at a frame's nominal time a camera exposes, seconds. */
  double exposureDelay(std::size_t camera) const { return delay_[camera]; }
  /** \brief What is wrong with a camera's colour images. */
  const ImageErrors& imageErrors(std::size_t camera) const { return image_errors_[camera]; }
  const std::vector<Object>& fixedObjects() const { return fixed_; }
  /** \brief At the frame's nominal time, with velocities. */
  std::vector<Object> movingObjects(std::size_t frame) const;

  /** \brief What the cameras measure; views of lost frames are missing. */
  void measure(std::size_t frame, io::LoadedFrame& out);

  /** \brief The surfaces of a frame, at its nominal time; valid until the next call of either. */
  const RayScene& truth(std::size_t frame);

 private:
  std::vector<Object> objectsAt(double time) const;
  double time(std::size_t frame) const { return static_cast<double>(frame) / options_.frames_per_second; }
  /** \brief What moves, from half a span before a time to half of it after. */
  void moveTo(double time, double span = 0);
  /** \brief How long a camera takes for an image, seconds. */
  double shutterSpan() const { return options_.faults.readout_time + options_.faults.exposure_time; }
  Shutter shutter() const;

  SimulationOptions options_;
  std::unique_ptr<Scene> scene_;
  std::unique_ptr<Sensor> sensor_;
  std::vector<Camera> cameras_;
  std::vector<Camera> true_cameras_;
  Eigen::Isometry3d bumped_pose_;
  std::vector<double> bias_;
  std::vector<double> delay_;
  std::vector<ImageErrors> image_errors_;
  std::vector<Object> fixed_;
  RayScene rays_;
  double at_{-1e9};
  double span_{0};
};

}  // namespace fuse_flow::simulation
