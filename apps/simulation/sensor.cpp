#include "simulation/sensor.h"

#include "simulation/indirect_light.h"
#include "simulation/pi.h"
#include "simulation/portable_math.h"
#include "simulation/random.h"
#include "simulation/true_view.h"

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector3f;
using host::parallelFor;

/** \brief 0 below a, 1 above b, smooth between. */
float smoothStep(float a, float b, float x) {
  const float t = std::clamp((x - a) / (b - a), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

Intrinsics scaledIntrinsics(int width, int height, float f, double scale) {
  Intrinsics K;
  K.width = std::max(1, static_cast<int>(std::lround(width * scale)));
  K.height = std::max(1, static_cast<int>(std::lround(height * scale)));
  K.fx = K.fy = static_cast<float>(f * scale);
  K.cx = 0.5f * static_cast<float>(K.width - 1);
  K.cy = 0.5f * static_cast<float>(K.height - 1);
  return K;
}

/** \brief A seed of its own for a noise image of a shot. */
std::uint64_t imageSeed(const ShotNumber& shot, std::uint64_t purpose) {
  return shot.seed * 1000003 + shot.frame * 8191 + shot.camera * 131 + purpose;
}

/** \brief Calls body(u, v, random) for every pixel. */
template <typename Body>
void forEachPixel(const Intrinsics& K, const ShotNumber& shot, int threads, const Body& body) {
  parallelFor(threads, static_cast<std::size_t>(K.height), [&](std::size_t row, int) {
    for (int u = 0; u < K.width; ++u) {
      Random random(shot.seed, shot.frame, shot.camera,
                    row * static_cast<std::uint64_t>(K.width) + static_cast<std::uint64_t>(u));
      body(u, static_cast<int>(row), random);
    }
  });
}

/** \brief Exact depth in tenths of a millimetre: no errors but rounding. */
class IdealSensor : public Sensor {
 public:
  explicit IdealSensor(double scale) : K_(scaledIntrinsics(640, 480, 525.0f, scale)) {}
  Intrinsics intrinsics() const override { return K_; }
  float depthScale() const override { return 0.0001f; }
  float minRange() const override { return 0.1f; }
  float maxRange() const override { return 6.5f; }  // of what 16 bits hold

  void measure(const Exposure& exposure, const Eigen::Isometry3d& T_world_camera, const ShotNumber&, int threads,
               io::FloatImage& depth) const override {
    depth = renderTrueView(exposure, K_, T_world_camera, Vector3f::Zero(), threads).depth;
  }

 private:
  Intrinsics K_;
};

/** \brief Kinect v1: a projector 75 mm beside the camera, disparity in eighths of a pixel.
 *
 *  Axial noise as Nguyen, Izadi and Lovell measured it (3DIMPVT 2012): 1.2 mm + 1.9 mm (z − 0.4)² + 0.1 mm / √z · θ² /
 *  (π/2 − θ)² at incidence θ. Of its variance we give half to an error that neighbours share, since matching windows
 *  overlap; their paper does not say how much is. A pixel's measurement comes from half a pixel beside it (Barron and Malik,
 *  CVPR 2013: σ = 0.5 pixels). Holes: in the projector's shadow, at grazing angles, where little light comes back. Where a pixel
 *  sees another surface for a share of its exposure, the pattern of both is blurred: that share of the measurements is lost. */
class StructuredLight : public Sensor {
 public:
  explicit StructuredLight(double scale) : K_(scaledIntrinsics(640, 480, 575.8f, scale)) {}
  Intrinsics intrinsics() const override { return K_; }
  float minRange() const override { return 0.5f; }
  float maxRange() const override { return 4.5f; }

  void measure(const Exposure& exposure, const Eigen::Isometry3d& T_world_camera, const ShotNumber& shot, int threads,
               io::FloatImage& depth) const override {
    const TrueView truth = renderTrueView(exposure, K_, T_world_camera, Vector3f(kBaseline, 0, 0), threads);
    const io::FloatImage shared = correlatedNoise(K_.width, K_.height, 1.5f, imageSeed(shot, 1), threads);
    depth.resize(K_.width, K_.height);
    forEachPixel(K_, shot, threads, [&](int u, int v, Random& random) {
      const float z = beside(truth, u, v, random);
      const float theta = portable::acos(std::clamp(truth.cosine.at(u, v), 0.0f, 1.0f));
      const bool dropped = random.uniform() < dropRate(truth, u, v, theta);
      const float both = 0.70711f * (static_cast<float>(random.gaussian()) + shared.at(u, v));
      depth.at(u, v) = z > 0 && !dropped ? quantised(z + both * axialDeviation(z, theta)) : 0.0f;
    });
  }

 private:
  static constexpr float kBaseline = 0.075f;
  /** \brief Disparity times depth: eighths of a pixel times metres, of the full image whatever the scale. */
  static constexpr float kSteps = 8 * 575.8f * kBaseline;

  static float axialDeviation(float z, float theta) {
    const float from_nearest = z - 0.4f;
    const float open = std::max(kPiF / 2 - theta, 0.05f);
    const float measured =
        0.0012f + 0.0019f * from_nearest * from_nearest + 0.0001f / std::sqrt(z) * theta * theta / (open * open);
    // What they measured holds the error of rounding to a disparity, which quantised() adds.
    const float step = z * z / kSteps;
    return std::sqrt(std::max(measured * measured - step * step / 12, 0.0f));
  }

  static float quantised(float z) {
    const float count = std::floor(kSteps / z + 0.5f);
    return count > 0 ? kSteps / count : 0.0f;
  }

  float dropRate(const TrueView& truth, int u, int v, float theta) const {
    const float z = truth.depth.at(u, v);
    if (!(z > 0) || truth.seen_twice.at(u, v) == 0) return 1;
    const float light = truth.infrared.at(u, v) * truth.cosine.at(u, v) / (z * z);
    const float unclear = 1 - truth.steadiness.at(u, v);
    return std::max({smoothStep(1.22f, 1.48f, theta), 1 - smoothStep(0.002f, 0.01f, light), unclear});  // 70° … 85°
  }

  /** \brief Depth of the surface where the measurement really comes from. Across an edge mostly of one side, at times a
   *  mixture of both. */
  float beside(const TrueView& truth, int u, int v, Random& random) const {
    const float x = std::clamp(static_cast<float>(u + 0.5 * random.gaussian()), 0.0f, static_cast<float>(K_.width - 1));
    const float y =
        std::clamp(static_cast<float>(v + 0.5 * random.gaussian()), 0.0f, static_cast<float>(K_.height - 1));
    const int u0 = static_cast<int>(x), v0 = static_cast<int>(y);
    const int u1 = std::min(u0 + 1, K_.width - 1), v1 = std::min(v0 + 1, K_.height - 1);
    const float a = x - static_cast<float>(u0), b = y - static_cast<float>(v0);
    const float z[4] = {truth.depth.at(u0, v0), truth.depth.at(u1, v0), truth.depth.at(u0, v1), truth.depth.at(u1, v1)};
    const float low = std::min({z[0], z[1], z[2], z[3]}), high = std::max({z[0], z[1], z[2], z[3]});
    const bool edge = high - low > 0.05f * high;
    if (edge && (low == 0 || random.uniform() < 0.85)) return z[(a > 0.5f ? 1 : 0) + (b > 0.5f ? 2 : 0)];
    return (1 - b) * ((1 - a) * z[0] + a * z[1]) + b * ((1 - a) * z[2] + a * z[3]);
  }

  Intrinsics K_;
};

/** \brief Azure Kinect in its narrow field of view without binning.
 *
 *  Noise is shot noise, inverse to the light that comes back: 0.4 mm + 0.2 mm z² at reflectance 0.7 seen straight on;
 *  that is 3 mm at 3.5 m, and 17 mm on black, the bound that Tölgyessy et al. (Sensors 2021, 21, 413) confirm. A pixel mixes all
 *  it sees, weighted with its light: flying pixels at edges, unless the surfaces are so far apart that the phases contradict
 *  each other. Indirect light, by way of another surface (multipath interference), lengthens what corners measure. It adds up as phases of a
 *  modulation of 200 MHz, within the 320 MHz that Bamji et al. (ISSCC 2018) give for the pixel: ways of many lengths cancel. */
class TimeOfFlight : public Sensor {
 public:
  TimeOfFlight(double scale, bool multipath) : K_(scaledIntrinsics(640, 576, 504.0f, scale)), multipath_(multipath) {}
  Intrinsics intrinsics() const override { return K_; }
  float minRange() const override { return 0.5f; }
  float maxRange() const override { return 3.86f; }
  float modulationFrequency() const override { return multipath_ ? kModulationFrequency : 0; }

  void measure(const Exposure& exposure, const Eigen::Isometry3d& T_world_camera, const ShotNumber& shot, int threads,
               io::FloatImage& depth) const override {
    const PixelRays rays(K_, T_world_camera);
    std::optional<IndirectLight> indirect;
    if (multipath_) indirect.emplace(exposure, K_, T_world_camera, kModulationPeriod, imageSeed(shot, 1), threads);
    depth.resize(K_.width, K_.height);
    forEachPixel(K_, shot, threads, [&](int u, int v, Random& random) {
      depth.at(u, v) = decide(expose(exposure, rays, indirect, u, v), random);
    });
  }

 private:
  static constexpr float kModulationFrequency = 200e6f;  // Hz
  /** \brief Depth at which its phase begins again, metres. */
  static constexpr float kModulationPeriod = 0.5f * 299792458.0f / kModulationFrequency;

  /** \brief All light that falls on one pixel. */
  struct Echo {
    float light{0};
    float light_depth{0};
    /** \brief Of the indirect light: in phase with the direct light, and a quarter behind it. */
    float in_phase{0};
    float behind{0};
    float length_per_depth{1};
    float nearest{std::numeric_limits<float>::infinity()};
    float farthest{0};
  };

  /** \brief The phase of the modulation is measured as three images, a third of a period apart, one after the other. What moves
   *  meanwhile gives each another depth: at its edges, and along its way, the phase is that of neither (Lindner and Kolb,
   *  Compensation of Motion Artifacts for Time-of-Flight Cameras, Dyn3D 2009). */
  static Echo expose(const Exposure& exposure, const PixelRays& rays, const std::optional<IndirectLight>& indirect,
                     int u, int v) {
    if (exposure.instant()) return gather(exposure, rays, indirect, u, v, 0);
    constexpr int images = 3;
    Echo echo[images], all;
    for (int image = 0; image < images; ++image) {
      echo[image] = gather(exposure, rays, indirect, u, v, Exposure::middleOf(image, images));
      all.light += echo[image].light / images;
      all.light_depth += echo[image].light_depth / images;
      all.in_phase += echo[image].in_phase / images;
      all.behind += echo[image].behind / images;
      all.nearest = std::min(all.nearest, echo[image].nearest);
      all.farthest = std::max(all.farthest, echo[image].farthest);
    }
    all.length_per_depth = echo[0].length_per_depth;
    if (!(all.light > 0)) return all;
    // Beside the phase of the mean depth.
    all.in_phase -= all.light;
    for (int image = 0; image < images; ++image) {
      if (!(echo[image].light > 0)) continue;
      const float further = echo[image].light_depth / echo[image].light - all.light_depth / all.light;
      const float phase = 2 * kPiF / kModulationPeriod * further * all.length_per_depth;
      const float shift = 2 * kPiF / images * static_cast<float>(image);
      const float sample = 2.0f / images * echo[image].light * portable::cos(phase - shift);
      all.in_phase += sample * portable::cos(shift);
      all.behind += sample * portable::sin(shift);
    }
    return all;
  }

  static Echo gather(const Exposure& exposure, const PixelRays& rays, const std::optional<IndirectLight>& indirect,
                     int u, int v, float part) {
    // The lens blurs a little beyond the pixel's own square.
    constexpr float offsets[5][2] = {{0, 0}, {-0.45f, -0.3f}, {0.45f, 0.3f}, {-0.3f, 0.45f}, {0.3f, -0.45f}};
    const RayScene& scene = exposure.scene();
    const float moment = exposure.moment(v, rays.rows(), part);
    Echo echo;
    echo.length_per_depth = rays.direction(static_cast<float>(u), static_cast<float>(v)).norm();
    for (const auto& offset : offsets) {
      const Vector3f direction = rays.direction(static_cast<float>(u) + offset[0], static_cast<float>(v) + offset[1]);
      const RayHit hit = scene.intersect(rays.origin(), direction, moment);
      if (!hit) continue;
      const float light = returnedLight(scene, hit, rays.origin());
      echo.light += light;
      echo.light_depth += light * hit.t;
      echo.nearest = std::min(echo.nearest, hit.t);
      echo.farthest = std::max(echo.farthest, hit.t);
      if (indirect && &offset == &offsets[0]) addIndirect(scene, hit, indirect->at(u, v), echo);
    }
    return echo;
  }

  /** \brief Five times the central ray's, like the direct light. */
  static void addIndirect(const RayScene& scene, const RayHit& hit, const IndirectLight::Light& light, Echo& echo) {
    const float returned = 5 * scene.object(hit.object).material.infrared;
    echo.in_phase = returned * light.in_phase;
    echo.behind = returned * light.behind;
  }

  static float decide(const Echo& echo, Random& random) {
    const double doubt = random.uniform(), error = random.gaussian();
    if (!(echo.light > 0)) return 0;
    const float lag = kModulationPeriod / (2 * kPiF) * portable::atan2(echo.behind, echo.light + echo.in_phase);
    const float z = echo.light_depth / echo.light + lag / echo.length_per_depth;
    const float reference = 5 * 0.7f / (z * z);  // reflectance 0.7 straight on
    const float weakness = reference / echo.light;
    if (weakness > 12 || (echo.farthest - echo.nearest > 0.3f && doubt < 0.7)) return 0;
    return z + static_cast<float>(error) * (0.0004f + 0.0002f * z * z) * std::max(1.0f, weakness);
  }

  Intrinsics K_;
  bool multipath_;
};

/** \brief RealSense D435: two imagers 50 mm apart.
 *
 *  The error of the disparity is 0.08 pixels RMS, within what Intel gives for textured scenes (Grunnet-Jepsen et al.,
 *  Best-Known-Methods for Tuning RealSense D400: z error = z² · subpixel / (f · baseline)), shared by neighbours, as matching windows
 *  overlap. Windows that reach over an edge take the nearer surface: objects grow by up to three pixels. Beside nearer
 *  objects lies a band that the second imager does not see. What moves while a pixel is exposed is lost as with structured light. */
class ActiveStereo : public Sensor {
 public:
  explicit ActiveStereo(double scale) : K_(scaledIntrinsics(848, 480, 424.0f, scale)) {}
  Intrinsics intrinsics() const override { return K_; }
  float minRange() const override { return 0.28f; }
  float maxRange() const override { return 6.0f; }

  void measure(const Exposure& exposure, const Eigen::Isometry3d& T_world_camera, const ShotNumber& shot, int threads,
               io::FloatImage& depth) const override {
    const TrueView truth = renderTrueView(exposure, K_, T_world_camera, Vector3f(kBaseline, 0, 0), threads);
    const io::FloatImage shared = correlatedNoise(K_.width, K_.height, 2.0f, imageSeed(shot, 1), threads);
    const io::FloatImage ragged = correlatedNoise(K_.width, K_.height, 3.0f, imageSeed(shot, 2), threads);
    depth.resize(K_.width, K_.height);
    forEachPixel(K_, shot, threads, [&](int u, int v, Random& random) {
      const float growth = std::clamp(1.5f + ragged.at(u, v), 0.0f, 3.0f);
      const auto [z, cosine] = nearestAround(truth, u, v, growth);
      const float theta = portable::acos(std::clamp(cosine, 0.0f, 1.0f));
      const double doubt = random.uniform(), own = random.gaussian();
      const bool fattened = z < 0.97f * truth.depth.at(u, v);
      const bool unseen = truth.seen_twice.at(u, v) == 0 && doubt < 0.9;
      const double unclear = static_cast<double>(1 - truth.steadiness.at(u, v));
      depth.at(u, v) = 0;
      if (!(z > 0) || (unseen && !fattened) || doubt < smoothStep(1.22f, 1.48f, theta) || doubt < unclear) return;
      const float disparity =
          424.0f * kBaseline / z + 0.08f * (0.95f * shared.at(u, v) + 0.31f * static_cast<float>(own));
      const float rounded = std::floor(disparity * 32 + 0.5f) / 32;  // five bits below the pixel
      if (rounded > 0) depth.at(u, v) = 424.0f * kBaseline / rounded;
    });
  }

 private:
  static constexpr float kBaseline = 0.05f;

  /** \brief The surface that a matching window takes. */
  struct Match {
    float depth;
    float cosine;
  };

  Match nearestAround(const TrueView& truth, int u, int v, float radius) const {
    const int reach = static_cast<int>(radius);
    const Match own{truth.depth.at(u, v), truth.cosine.at(u, v)};
    Match nearest{std::numeric_limits<float>::infinity(), 0};
    for (int b = std::max(v - reach, 0); b <= std::min(v + reach, K_.height - 1); ++b)
      for (int a = std::max(u - reach, 0); a <= std::min(u + reach, K_.width - 1); ++a)
        if (truth.depth.at(a, b) > 0 && truth.depth.at(a, b) < nearest.depth)
          nearest = {truth.depth.at(a, b), truth.cosine.at(a, b)};
    return nearest.depth < 0.95f * own.depth ? nearest : own;  // on one surface the match stays its own
  }

  Intrinsics K_;
};

}  // namespace

std::vector<std::string> sensorNames() {
  return {"ideal", "structured_light", "time_of_flight", "time_of_flight_multipath", "active_stereo"};
}

std::unique_ptr<Sensor> makeSensor(const std::string& name, double scale) {
  if (!(scale > 0 && scale <= 2))
    throw io::InputError("sensor scale is " + std::to_string(scale) + ", must be in (0, 2]");
  if (name == "ideal") return std::make_unique<IdealSensor>(scale);
  if (name == "structured_light") return std::make_unique<StructuredLight>(scale);
  if (name == "time_of_flight") return std::make_unique<TimeOfFlight>(scale, false);
  if (name == "time_of_flight_multipath") return std::make_unique<TimeOfFlight>(scale, true);
  if (name == "active_stereo") return std::make_unique<ActiveStereo>(scale);
  std::string known;
  for (const std::string& sensor : sensorNames()) known += (known.empty() ? "" : ", ") + sensor;
  throw io::InputError("sensor '" + name + "' is not known; must be one of " + known);
}

Vector3f litColor(const Material& material, const Vector3f& n, const Vector3f& rest) {
  // Two far lamps and the light of the walls; no shadows.
  const Vector3f lamp = Vector3f(0.3f, -0.5f, 0.81f), window = Vector3f(-0.8f, 0.5f, 0.33f);
  const float light =
      0.45f + 0.1f * (n.z() + 1) + 0.3f * std::max(0.0f, n.dot(lamp)) + 0.15f * std::max(0.0f, n.dot(window));
  return (light * albedo(material, rest)).cwiseMin(255.0f);
}

void renderColor(const Exposure& exposure, const Intrinsics& K, const Eigen::Isometry3d& T_world_camera,
                 const ShotNumber& shot, int threads, const ImageErrors& errors, io::ColorImage& color) {
  color.resize(K.width, K.height);
  const RayScene& scene = exposure.scene();
  const PixelRays rays(K, T_world_camera);
  const int parts = exposure.parts();
  ShotNumber own = shot;
  own.seed += 0x5bd1e995;  // not the depth image's noise
  // Variances of independent noise add up; 2 grey levels are every camera's.
  const float deviation = std::sqrt(2.0f * 2.0f + errors.noise * errors.noise);
  forEachPixel(K, own, threads, [&](int u, int v, Random& random) {
    const Vector3f direction = rays.direction(static_cast<float>(u), static_cast<float>(v));
    Vector3f c = Vector3f::Zero();
    for (int part = 0; part < parts; ++part) {
      const float moment = exposure.moment(v, K.height, Exposure::middleOf(part, parts));
      const RayHit hit = scene.intersect(rays.origin(), direction, moment);
      if (hit) c += litColor(scene.object(hit.object).material, hit.normal, hit.rest);
    }
    c /= static_cast<float>(parts);
    const float factor = errors.gain * errors.fallOff(K, u, v);
    const auto channel = [&](float value) {
      const float level = factor * value + errors.black_level + deviation * static_cast<float>(random.gaussian());
      return static_cast<std::uint8_t>(std::clamp(level, 0.0f, 255.0f));
    };
    color.at(u, v) = {channel(c.x()), channel(c.y()), channel(c.z())};
  });
}

}  // namespace fuse_flow::simulation
