#include "recordings/streams/azure_kinect.h"

#include "recordings/calibrations/calibration.h"
#include "recordings/files/json_file.h"

#include <algorithm>
#include <map>
#include <vector>

namespace fuse_flow::io {
namespace {

/** \brief A mode: the whole sensor scaled to a size, and the part of it that is the image. Pixels. */
struct Mode {
  int scaled_width, scaled_height;
  int crop_left, crop_top;
  int width, height;
};

const std::map<std::string, Mode>& depthModes() {
  static const std::map<std::string, Mode> modes{{"NFOV_2X2BINNED", {512, 512, 96, 90, 320, 288}},
                                                 {"NFOV_UNBINNED", {1024, 1024, 192, 180, 640, 576}},
                                                 {"WFOV_2X2BINNED", {512, 512, 0, 0, 512, 512}},
                                                 {"WFOV_UNBINNED", {1024, 1024, 0, 0, 1024, 1024}}};
  return modes;
}

const std::map<std::string, Mode>& colorModes() {
  static const std::map<std::string, Mode> modes{
      {"720P", {1280, 960, 0, 120, 1280, 720}},    {"1080P", {1920, 1440, 0, 180, 1920, 1080}},
      {"1440P", {2560, 1920, 0, 240, 2560, 1440}}, {"1536P", {2048, 1536, 0, 0, 2048, 1536}},
      {"2160P", {3840, 2880, 0, 360, 3840, 2160}}, {"3072P", {4096, 3072, 0, 0, 4096, 3072}}};
  return modes;
}

const Mode& modeOf(const std::string& owner, const std::string& kind, const std::map<std::string, Mode>& modes,
                   const std::string& name) {
  const auto found = modes.find(name);
  if (found != modes.end()) return found->second;
  std::string known;
  for (const auto& [mode, size] : modes) known += (known.empty() ? "" : ", ") + mode;
  throw InputError(owner + ": its " + kind + " mode is '" + name + "', must be one of " + known);
}

std::vector<double> numbers(const std::string& owner, const nlohmann::json& list, std::size_t count,
                            const std::string& key) {
  if (!list.is_array() || list.size() != count ||
      !std::all_of(list.begin(), list.end(), [](const nlohmann::json& n) { return n.is_number(); }))
    throw InputError(owner + ": " + key + " is " + quoted(list) + ", must be " + std::to_string(count) + " numbers");
  return list.get<std::vector<double>>();
}

/** \brief What is under a key, null if nothing is. */
const nlohmann::json& at(const nlohmann::json& object, const char* key) {
  static const nlohmann::json nothing;
  return object.is_object() && object.contains(key) ? object[key] : nothing;
}

const nlohmann::json& cameraAt(const std::string& owner, const nlohmann::json& calibration, const char* location) {
  for (const nlohmann::json& camera : at(at(calibration, "CalibrationInformation"), "Cameras"))
    if (at(camera, "Location") == location) return camera;
  throw InputError(owner + ": has no camera " + location + ", must be the calibration of an Azure Kinect or a Femto");
}

Intrinsics lens(const std::string& owner, const nlohmann::json& camera, const Mode& mode) {
  constexpr const char* brown_conrady = "CALIBRATION_LensDistortionModelBrownConrady";
  const nlohmann::json& intrinsics = at(camera, "Intrinsics");
  if (at(intrinsics, "ModelType") != brown_conrady)
    throw InputError(owner + ": ModelType is " + quoted(at(intrinsics, "ModelType")) + ", must be " + brown_conrady);
  // cx cy fx fy k1 … k6, centre of distortion, p2 p1
  const std::vector<double> p = numbers(owner, at(intrinsics, "ModelParameters"), 14, "ModelParameters");
  if (p[10] != 0 || p[11] != 0)
    throw InputError(owner + ": ModelParameters has a centre of distortion beside the optical axis, must be 0 0");
  const auto value = [&](std::size_t k) { return static_cast<float>(p[k]); };
  Intrinsics K;
  K.width = mode.width;
  K.height = mode.height;
  K.fx = static_cast<float>(p[2] * mode.scaled_width);
  K.fy = static_cast<float>(p[3] * mode.scaled_height);
  K.cx = static_cast<float>(p[0] * mode.scaled_width - mode.crop_left - 0.5);  // from a pixel's corner to its centre
  K.cy = static_cast<float>(p[1] * mode.scaled_height - mode.crop_top - 0.5);
  K.distortion = {value(4), value(5), value(13), value(12), value(6), value(7), value(8), value(9)};
  return K;
}

/** \brief From the frame of the device to the camera's, metres. */
Eigen::Isometry3d pose(const std::string& owner, const nlohmann::json& camera) {
  const nlohmann::json& Rt = at(camera, "Rt");
  const std::vector<double> R = numbers(owner, at(Rt, "Rotation"), 9, "Rotation");
  const std::vector<double> t = numbers(owner, at(Rt, "Translation"), 3, "Translation");
  return nearlyRigidPose(owner + ": Rt",
                         {R[0], R[1], R[2], t[0], R[3], R[4], R[5], t[1], R[6], R[7], R[8], t[2], 0, 0, 0, 1});
}

/** \brief The colour sensor's parameters of early devices are parts of its 16:9 image. */
void requireWholeSensor(const std::string& owner, const nlohmann::json& camera, int width, int height) {
  const nlohmann::json &w = at(camera, "SensorWidth"), &h = at(camera, "SensorHeight");
  if (w.is_number_integer() && h.is_number_integer() && w.get<long long>() * height == h.get<long long>() * width)
    return;
  throw InputError(owner + ": SensorWidth and SensorHeight are " + quoted(w) + " and " + quoted(h) + ", must be as " +
                   std::to_string(width) + " to " + std::to_string(height));
}

}  // namespace

Camera azureKinectCamera(const std::string& owner, const std::string& json, const AzureKinectModes& modes) {
  const auto calibration =
      parseJson<nlohmann::json>(owner, json.substr(0, json.find('\0')), "a calibration");  // the recorder adds a zero
  const nlohmann::json& depth = cameraAt(owner, calibration, "CALIBRATION_CameraLocationD0");
  requireWholeSensor(owner, depth, 1, 1);
  Camera camera;
  camera.depth_scale = 0.001f;
  camera.intrinsics = lens(owner, depth, modeOf(owner, "depth", depthModes(), modes.depth));
  if (modes.color.empty()) return camera;
  const nlohmann::json& color = cameraAt(owner, calibration, "CALIBRATION_CameraLocationPV0");
  requireWholeSensor(owner, color, 4, 3);
  ColorCamera own;
  own.intrinsics = lens(owner, color, modeOf(owner, "colour", colorModes(), modes.color));
  own.T_depth_color = pose(owner, depth) * pose(owner, color).inverse();
  camera.color = own;
  return camera;
}

}  // namespace fuse_flow::io
