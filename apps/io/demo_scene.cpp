#include "io/demo_scene.h"

#include "io/demo_sensor.h"
#include "io/demo_shapes.h"
#include "io/error.h"
#include "io/rig_json.h"
#include "io/view_files.h"

#include <fuse_flow/impl/host/parallel.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

using Eigen::Vector3d;

constexpr double degree = 0.017453292519943295;

/** \brief A camera at eye whose optical axis meets target, with the world's z up in the image. */
Eigen::Isometry3d lookAt(const Vector3d& eye, const Vector3d& target) {
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  const Vector3d forward = (target - eye).normalized();
  const Vector3d right = forward.cross(Vector3d::UnitZ()).normalized();
  T_world_camera.linear() << right, forward.cross(right), forward;
  T_world_camera.translation() = eye;
  return T_world_camera;
}

std::vector<Camera> makeCameras(const DemoOptions& options) {
  struct Place {
    const char* name;
    double azimuth, height;  // degrees about the scene's middle; metres
  };
  std::vector<Camera> cameras;
  for (const Place& place :
       {Place{"south_east", -30, 1.25}, {"east", 20, 1.45}, {"north", 70, 1.35}, {"north_west", 120, 1.2}}) {
    Camera camera;
    camera.name = place.name;
    Intrinsics& K = camera.intrinsics;
    K.width = options.width;
    K.height = options.height;
    K.fx = K.fy = 525.0f * static_cast<float>(options.width) / 640;
    K.cx = 0.5f * static_cast<float>(options.width - 1);
    K.cy = 0.5f * static_cast<float>(options.height - 1);
    const double a = place.azimuth * degree;
    camera.T_world_camera = lookAt({1.7 * std::cos(a), 1.7 * std::sin(a), place.height}, {-0.1, -0.05, 0.35});
    cameras.push_back(camera);
  }
  return cameras;
}

void disturbPose(const DemoOptions& options, PortableRandom& random, Eigen::Isometry3d& T_world_camera) {
  const auto vector = [&random] {
    const double x = random.gaussian(), y = random.gaussian(), z = random.gaussian();
    return Vector3d(x, y, z);
  };
  const Vector3d shift = options.pose_noise * vector();
  const Vector3d turn = options.pose_noise_deg * degree * vector();
  T_world_camera.translation() += shift;
  if (turn.norm() > 0) T_world_camera.rotate(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
}

Rgb8 shade(const Rgb8& paint, double light, double noise) {
  const auto channel = [&](std::uint8_t value) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(value * light + 2 * noise), 0l, 255l));
  };
  return {channel(paint.r), channel(paint.g), channel(paint.b)};
}

void render(const DemoScene& scene, const Camera& camera, PortableRandom& random, TrueView& truth, ColorImage& color) {
  const Intrinsics& K = camera.intrinsics;
  const Vector3d origin = camera.T_world_camera.translation();
  const Vector3d projector = camera.T_world_camera * Vector3d(0.075, 0, 0);
  const Vector3d lamp(0.8, 0.9, 2.6);
  for (FloatImage* image : {&truth.depth, &truth.cosine, &truth.lit}) {
    image->resize(K.width, K.height);
    std::fill(image->data.begin(), image->data.end(), 0.0f);
  }
  color.resize(K.width, K.height);
  for (int v = 0; v < K.height; ++v)
    for (int u = 0; u < K.width; ++u) {
      const double noise = random.gaussian();
      const Ray ray = unproject(K, {static_cast<float>(u), static_cast<float>(v)});
      // The direction has length 1 along the optical axis, so that t is the depth.
      const Vector3d direction = camera.T_world_camera.linear() * Vector3d(ray.x, ray.y, 1);
      const auto hit = scene.trace(origin, direction);
      if (!hit) {
        color.at(u, v) = shade({90, 96, 104}, 1, noise);
        continue;
      }
      const Vector3d p_W = origin + hit->t * direction;
      truth.depth.at(u, v) = static_cast<float>(hit->t);
      truth.cosine.at(u, v) = static_cast<float>(-hit->normal.dot(direction.normalized()));
      truth.lit.at(u, v) = scene.sees(projector, p_W) ? 1.0f : 0.0f;
      const double lambert = std::max(0.0, hit->normal.dot((lamp - p_W).normalized()));
      color.at(u, v) = shade(hit->shape->colorAt(p_W), 0.45 + 0.6 * lambert, noise);
    }
}

void checkOptions(const DemoOptions& options) {
  const auto require = [](bool good, const std::string& problem) {
    if (!good) throw InputError("demo recording: " + problem);
  };
  require(options.frames >= 1 && options.frames <= 100,
          "frames is " + std::to_string(options.frames) + ", must be in [1, 100]: all are held in memory");
  require(options.width >= 16 && options.width <= 4096 && options.height >= 16 && options.height <= 4096,
          "the size is " + std::to_string(options.width) + "x" + std::to_string(options.height) +
              ", sides must be in [16, 4096]");
  require(options.pose_noise >= 0 && options.pose_noise <= 1,
          "pose noise is " + std::to_string(options.pose_noise) + " m, must be in [0, 1]");
  require(options.pose_noise_deg >= 0 && options.pose_noise_deg <= 45,
          "pose noise is " + std::to_string(options.pose_noise_deg) + " degrees, must be in [0, 45]");
}

}  // namespace

DemoRecording makeDemoRecording(const DemoOptions& options) {
  checkOptions(options);
  DemoRecording recording;
  recording.true_cameras = makeCameras(options);
  recording.cameras = recording.true_cameras;
  const auto camera_count = static_cast<int>(recording.cameras.size());
  for (int c = 0; c < camera_count; ++c) {
    // A "frame" of its own, so that the poses do not depend on how many frames there are.
    PortableRandom random(options.seed, 0xffffffffu, static_cast<std::uint32_t>(c));
    disturbPose(options, random, recording.cameras[static_cast<std::size_t>(c)].T_world_camera);
  }
  const auto frame_count = static_cast<std::size_t>(options.frames);
  recording.depth.assign(frame_count, std::vector<DepthImage>(recording.cameras.size()));
  recording.color.assign(frame_count, std::vector<ColorImage>(recording.cameras.size()));
  const std::size_t cameras = recording.cameras.size();
  host::parallelFor(host::resolveThreads(0), frame_count * cameras, [&](std::size_t image, int) {
    const std::size_t frame = image / cameras, camera = image % cameras;
    PortableRandom random(options.seed, static_cast<std::uint32_t>(frame), static_cast<std::uint32_t>(camera));
    TrueView truth;
    render(DemoScene(frame), recording.true_cameras[camera], random, truth, recording.color[frame][camera]);
    if (options.sensor_noise)
      senseDepth(truth, random, recording.depth[frame][camera]);
    else
      roundDepth(truth, recording.depth[frame][camera]);
  });
  return recording;
}

double demoSurfaceDistance(const Vector3d& p_W, std::size_t frame) { return DemoScene(frame).distance(p_W); }

void writeDemoRecording(const std::string& folder, const DemoRecording& recording) {
  std::error_code error;
  const auto makeFolder = [&](const fs::path& path) {
    fs::create_directories(path, error);
    if (error) throw OutputError(path.string() + ": cannot be made: " + error.message());
  };
  RigDescription rig;
  for (std::size_t c = 0; c < recording.cameras.size(); ++c) {
    rig.cameras.push_back({recording.cameras[c], recording.depth_scale});
    const fs::path camera = fs::path(folder) / recording.cameras[c].name;
    makeFolder(camera / "depth");
    makeFolder(camera / "color");
    for (std::size_t frame = 0; frame < recording.depth.size(); ++frame) {
      const std::string file = frameStem(frame) + ".png";
      writeDepthPng((camera / "depth" / file).string(), recording.depth[frame][c]);
      writeColorPng((camera / "color" / file).string(), recording.color[frame][c]);
    }
  }
  writeRigJson((fs::path(folder) / "rig.json").string(), rig);  // last: without it the folder is no recording
}

}  // namespace fuse_flow::io
