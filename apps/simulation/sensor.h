#pragma once

#include "simulation/exposure.h"
#include "simulation/image_errors.h"

#include <fuse_flow/camera.h>
#include <fuse_flow/recordings/image.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::simulation {

/** \brief Which measurement of which camera: what the random numbers of an image depend on. */
struct ShotNumber {
  std::uint64_t seed{0};
  std::uint64_t frame{0};
  std::uint64_t camera{0};
};

/** \brief A depth camera: optics, and the errors of its principle. */
class Sensor {
 public:
  virtual ~Sensor() = default;

  /** \brief Of the depth image; the colour image is registered to it. */
  virtual Intrinsics intrinsics() const = 0;
  /** \brief Metres per depth unit. */
  virtual float depthScale() const { return 0.001f; }
  /** \brief Nearest and farthest depth that it measures, metres. */
  virtual float minRange() const = 0;
  virtual float maxRange() const = 0;
  /** \brief Modulation frequency of a time-of-flight sensor with multipath interference, Hz; 0: a sensor without. */
  virtual float modulationFrequency() const { return 0; }

  /** \brief What it measures from a pose: metres, 0 where nothing. The same shot gives the same image for any number of
   *  threads. */
  virtual void measure(const Exposure& exposure, const Eigen::Isometry3d& T_world_camera, const ShotNumber& shot,
                       int threads, io::FloatImage& depth) const = 0;
};

/** \brief "ideal", "structured_light" (Kinect v1), "time_of_flight" (Azure Kinect, narrow field of view),
 *  "time_of_flight_multipath", or "active_stereo" (RealSense D435). scale: of the image's sides and focal lengths, (0, 2].
 *  Throws io::InputError on another name. */
std::unique_ptr<Sensor> makeSensor(const std::string& name, double scale = 1.0);

std::vector<std::string> sensorNames();

/** \brief Colour of a surface point under the scene's light, which does not depend on who looks: channels 0 … 255. */
Eigen::Vector3f litColor(const Material& material, const Eigen::Vector3f& normal, const Eigen::Vector3f& rest);

/** \brief The colour image that is registered to a depth camera. Its noise has 2 grey levels, and what the errors say. What moves
 *  is blurred: the mean over the exposure. */
void renderColor(const Exposure& exposure, const Intrinsics& intrinsics, const Eigen::Isometry3d& T_world_camera,
                 const ShotNumber& shot, int threads, const ImageErrors& errors, io::ColorImage& color);

}  // namespace fuse_flow::simulation
