#include <fuse_flow/recordings/rig_json.h>

#include "recordings/calibrations/calibration.h"
#include "recordings/calibrations/lens_models.h"
#include "recordings/files/cut_short.h"
#include "recordings/files/file_io.h"
#include "recordings/files/json_file.h"
#include "recordings/files/unknown_keys.h"

#include <fuse_flow/recordings/error.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <set>

namespace fuse_flow::io {
namespace {

using Json = nlohmann::ordered_json;

/** \brief One JSON object, and what messages call it: "rig.json: camera 'left'". */
struct Entry {
  const Json& object;
  std::string owner;

  [[noreturn]] void fail(const std::string& key, const std::string& problem) const {
    throw InputError(owner + ": " + key + " " + problem);
  }
  bool has(const char* key) const { return object.contains(key); }
  const Json& get(const char* key, const std::string& expected) const {
    if (!has(key)) fail(key, "is missing, must be " + expected);
    return object[key];
  }
  double number(const char* key) const {
    const Json& value = get(key, "a number");
    if (!value.is_number()) fail(key, "is " + quoted(value) + ", must be a number");
    return value.get<double>();
  }
  double positive(const char* key) const {
    const double value = number(key);
    if (!(value > 0)) fail(key, "is " + quoted(object[key]) + ", must be positive");
    return value;
  }
  int size(const char* key) const {
    const double value = positive(key);
    if (value != std::floor(value) || value > 65535)
      fail(key, "is " + quoted(object[key]) + ", must be a whole number of pixels, 65535 at most");
    return static_cast<int>(value);
  }
  std::vector<double> numbers(const char* key, std::size_t count) const {
    const Json& values = get(key, "a list of " + std::to_string(count) + " numbers");
    const auto is_number = [](const Json& value) { return value.is_number(); };
    if (!values.is_array() || !std::all_of(values.begin(), values.end(), is_number))
      fail(key, "must be a list of " + std::to_string(count) + " numbers");
    if (values.size() != count)
      fail(key, "has " + std::to_string(values.size()) + " numbers, must be " + std::to_string(count));
    return values.get<std::vector<double>>();
  }
};

Intrinsics parseIntrinsics(const Entry& entry, std::vector<std::string>& warnings) {
  Intrinsics K;
  K.width = entry.size("width");
  K.height = entry.size("height");
  K.fx = static_cast<float>(entry.positive("fx"));
  K.fy = static_cast<float>(entry.positive("fy"));
  K.cx = static_cast<float>(entry.number("cx"));
  K.cy = static_cast<float>(entry.number("cy"));
  if (!entry.has("distortion")) {
    if (!entry.has("distortion_model") || entry.object["distortion_model"] == "none" ||
        entry.object["distortion_model"] == "pinhole")
      return K;
    entry.fail("distortion", "is missing, must be the coefficients of distortion_model " +
                                 quoted(entry.object["distortion_model"]) + "; without a lens model leave both out");
  }
  if (!entry.has("distortion_model")) {
    const std::vector<double> values = entry.numbers("distortion", 8);
    const std::vector<float> d(values.begin(), values.end());
    K.distortion = {d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]};
    return K;
  }
  const Json& model = entry.object["distortion_model"];
  if (!model.is_string()) entry.fail("distortion_model", "is " + quoted(model) + ", must be a name, like equidistant");
  const Json& values = entry.object["distortion"];
  return withDistortion(entry.owner, K, model.get<std::string>(), entry.numbers("distortion", values.size()), warnings);
}

DepthCorrection parseDepthCorrection(const Entry& entry) {
  DepthCorrection correction;
  correction.columns = entry.size("columns");
  correction.rows = entry.size("rows");
  const std::size_t knots = static_cast<std::size_t>(correction.columns) * static_cast<std::size_t>(correction.rows);
  for (const double a : entry.numbers("relative", knots)) correction.relative.push_back(static_cast<float>(a));
  for (const double b : entry.numbers("per_metre", knots)) correction.per_metre.push_back(static_cast<float>(b));
  return correction;
}

Multipath parseMultipath(const Entry& entry) {
  Multipath multipath;
  multipath.modulation_frequency = static_cast<float>(entry.positive("modulation_frequency"));
  if (entry.has("reflectance")) multipath.reflectance = static_cast<float>(entry.positive("reflectance"));
  return multipath;
}

/** \brief What is not named is 0. */
NoiseModel parseNoise(const Entry& entry) {
  NoiseModel noise{0, 0, 0};
  const auto read = [&](const char* key, float& value) {
    if (!entry.has(key)) return;
    value = static_cast<float>(entry.number(key));
    if (!(value >= 0 && value <= 10))
      entry.fail(key, "is " + quoted(entry.object[key]) + ", must be 0 to 10: the standard deviation of depth z is " +
                          "floor + linear z + quadratic z^2, in metres");
  };
  read("floor", noise.floor);
  read("linear", noise.linear);
  read("quadratic", noise.quadratic);
  return noise;
}

const std::vector<std::string> kLensKeys = {"width", "height", "fx",         "fy",
                                            "cx",    "cy",     "distortion", "distortion_model"};

std::vector<std::string> withLensKeys(std::vector<std::string> keys) {
  keys.insert(keys.end(), kLensKeys.begin(), kLensKeys.end());
  return keys;
}

/** \brief What other programs call what we have, and how it differs. */
const std::vector<std::pair<std::string, std::string>> kAliases = {
    {"T_camera_world", "T_world_camera, camera to world, the inverse"},
    {"T_world_cam", "T_world_camera"},
    {"extrinsics", "T_world_camera, camera to world"},
    {"extrinsic", "T_world_camera, camera to world"},
    {"pose", "T_world_camera, camera to world"},
    {"transform", "T_world_camera, camera to world"},
    {"transform_matrix", "T_world_camera, camera to world, of axes x right, y down, z forward"},
    {"T_color_depth", "T_depth_color, colour camera to depth camera, the inverse"},
    {"model", "distortion_model"},
    {"distortion_coefficients", "distortion"},
    {"coeffs", "distortion"},
    {"D", "distortion"},
    {"K", "fx, fy, cx, cy"},
    {"intrinsics", "fx, fy, cx, cy"},
    {"intrinsic_matrix", "fx, fy, cx, cy"},
    {"ppx", "cx"},
    {"ppy", "cy"},
    {"depth_unit", "depth_scale, metres per unit"},
    {"depth_units", "depth_scale, metres per unit"},
    {"fps", "frames_per_second, beside cameras"},
    {"framerate", "frames_per_second, beside cameras"},
    {"rgb", "color"},
    {"colour", "color"}};

/** \brief Keys that are ignored, and the owners that have them, in the order in which they are met. */
class UnknownKeys {
 public:
  void look(const Json& object, const std::string& owner, const std::vector<std::string>& known) {
    if (!object.is_object()) return;
    for (const auto& item : object.items()) {
      if (std::find(known.begin(), known.end(), item.key()) != known.end()) continue;
      const auto found = std::find_if(unknown_.begin(), unknown_.end(),
                                      [&](const Unknown& u) { return u.key == item.key() && u.known == &known; });
      if (found == unknown_.end())
        unknown_.push_back({item.key(), &known, owner, 1});
      else
        ++found->owners;
    }
  }
  std::vector<std::string> warnings() const {
    std::vector<std::string> lines;
    for (const Unknown& u : unknown_) {
      std::string line = u.owner;
      if (u.owners > 1) line += " and " + std::to_string(u.owners - 1) + (u.owners == 2 ? " other" : " others");
      line += ": the key '" + cutShort(u.key) + "' is not known and has no effect";
      const std::string meant = likelyMeant(u.key, *u.known, kAliases);
      if (!meant.empty()) line += "; there is " + meant;
      lines.push_back(line);
    }
    return lines;
  }
  /** \brief Behind an error, of which they may be the reason: those that were likely meant for another. */
  std::string misspelt() const {
    std::string text;
    int named = 0;
    for (const Unknown& u : unknown_) {
      const std::string meant = likelyMeant(u.key, *u.known, kAliases);
      if (meant.empty() || named == 3) continue;
      text += (named++ == 0 ? " (not known there: '" : ", '") + cutShort(u.key) + "', there is " + meant;
    }
    return named == 0 ? "" : text + ")";
  }

 private:
  struct Unknown {
    std::string key;
    const std::vector<std::string>* known;  ///< tells objects of different kinds apart
    std::string owner;
    std::size_t owners;
  };
  std::vector<Unknown> unknown_;
};

void lookAtKeys(const Json& object, const std::string& owner, UnknownKeys& unknown) {
  static const std::vector<std::string> of_camera =
      withLensKeys({"name", "depth_scale", "depth_is", "depth_offset", "confidence_scale", "T_world_camera",
                    "depth_correction", "multipath", "noise", "color"});
  static const std::vector<std::string> of_color = withLensKeys({"T_depth_color"});
  static const std::vector<std::string> of_correction = {"columns", "rows", "relative", "per_metre"};
  static const std::vector<std::string> of_multipath = {"modulation_frequency", "reflectance"};
  static const std::vector<std::string> of_noise = {"floor", "linear", "quadratic"};
  unknown.look(object, owner, of_camera);
  const auto look_inside = [&](const char* key, const std::vector<std::string>& known) {
    if (object.contains(key)) unknown.look(object[key], owner + " " + key, known);
  };
  look_inside("color", of_color);
  look_inside("depth_correction", of_correction);
  look_inside("multipath", of_multipath);
  look_inside("noise", of_noise);
}

Eigen::Isometry3d parsePose(const Entry& entry) {
  if (!entry.has("T_world_camera") && entry.has("T_camera_world"))
    entry.fail("T_world_camera",
               "is missing, and there is T_camera_world: must be its inverse, from the camera's frame to the world's");
  return rigidPose(entry.owner + ": T_world_camera", entry.numbers("T_world_camera", 16));
}

/** \param with_poses false: a pose that is none is kept as RigCamera::pose_error */
RigCamera parseCamera(const Entry& entry, const std::string& name, bool with_poses,
                      std::vector<std::string>& warnings) {
  RigCamera result;
  result.camera.name = name;
  result.camera.intrinsics = parseIntrinsics(entry, warnings);
  result.has_depth_scale = entry.has("depth_scale");
  if (result.has_depth_scale) {
    const float depth_scale = result.camera.depth_scale = static_cast<float>(entry.positive("depth_scale"));
    if (!std::isfinite(depth_scale) || depth_scale == 0)
      entry.fail("depth_scale", "is " + quoted(entry.object["depth_scale"]) + ", must be metres per unit, like 0.001");
  }
  if (entry.has("depth_is")) {
    const Json& meaning = entry.object["depth_is"];
    if (meaning != "z" && meaning != "distance")
      entry.fail("depth_is",
                 "is " + quoted(meaning) + ", must be z, along the optical axis, or distance, along the pixel's ray");
    result.depth.is_distance = meaning == "distance";
  }
  if (entry.has("depth_offset")) {
    constexpr double most = 10;
    const double offset = entry.number("depth_offset");
    if (!(std::fabs(offset) <= most))
      entry.fail("depth_offset", "is " + quoted(entry.object["depth_offset"]) + ", must be within " +
                                     std::to_string(static_cast<int>(most)) +
                                     " m: metres that are added to the measured depth");
    result.depth.offset = static_cast<float>(offset);
  }
  if (entry.has("confidence_scale")) {
    result.confidence_scale = static_cast<float>(entry.positive("confidence_scale"));
    if (!(*result.confidence_scale > 0 && *result.confidence_scale <= 1))
      entry.fail("confidence_scale", "is " + quoted(entry.object["confidence_scale"]) +
                                         ", must be in (0, 1]: what one step of the confidence images is worth, like "
                                         "0.5 where they hold 0, 1 and 2");
  }
  try {
    result.camera.T_world_camera = parsePose(entry);
  } catch (const InputError& error) {
    if (with_poses) throw;
    result.pose_error = error.what();
  }
  if (entry.has("depth_correction")) {
    const Entry correction{entry.object["depth_correction"], entry.owner + " depth_correction"};
    if (!correction.object.is_object())
      entry.fail("depth_correction", "must be an object with columns, rows, relative, per_metre");
    result.camera.depth_correction = parseDepthCorrection(correction);
  }
  if (entry.has("multipath")) {
    const Entry multipath{entry.object["multipath"], entry.owner + " multipath"};
    if (!multipath.object.is_object())
      entry.fail("multipath", "must be an object with modulation_frequency, reflectance");
    result.camera.multipath = parseMultipath(multipath);
  }
  if (entry.has("noise")) {
    const Entry noise{entry.object["noise"], entry.owner + " noise"};
    if (!noise.object.is_object()) entry.fail("noise", "must be an object with floor, linear, quadratic");
    result.camera.noise = parseNoise(noise);
    if (*result.camera.noise == NoiseModel{0, 0, 0})
      entry.fail("noise", "is 0 at every depth; leave it out where it is not known");
  }
  if (entry.has("color")) {
    const Entry color{entry.object["color"], entry.owner + " color"};
    if (!color.object.is_object())
      entry.fail("color", "must be an object with width, height, fx, fy, cx, cy, T_depth_color");
    result.camera.color = ColorCamera{parseIntrinsics(color, warnings),
                                      rigidPose(color.owner + ": T_depth_color", color.numbers("T_depth_color", 16))};
  }
  return result;
}

/** \brief The shortest decimal that reads back as the same float: 0.001 and not 0.0010000000474974513. */
double shortest(float value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text - 1, value).ptr;
  *end = '\0';
  return std::strtod(text, nullptr);
}

void putIntrinsics(Json& json, const Intrinsics& K) {
  json["width"] = K.width;
  json["height"] = K.height;
  json["fx"] = shortest(K.fx);
  json["fy"] = shortest(K.fy);
  json["cx"] = shortest(K.cx);
  json["cy"] = shortest(K.cy);
  const Distortion& d = K.distortion;
  if (isIdeal(d)) return;
  for (const float k : {d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6}) json["distortion"].push_back(shortest(k));
}

Json poseNumbers(const Eigen::Isometry3d& T) {
  Json numbers = Json::array();
  for (int row = 0; row < 4; ++row)
    for (int col = 0; col < 4; ++col) numbers.push_back(T.matrix()(row, col));
  return numbers;
}

/** \brief A camera's name is the name of its folder. */
bool isFolderName(const std::string& name) {
  return !name.empty() && name != "." && name != ".." && name.find_first_of("/\\\n") == std::string::npos &&
         name.find('\0') == std::string::npos;
}

}  // namespace

RigDescription readRigJson(const std::string& path, bool with_poses) {
  const Json json = readJson<Json>(path, "a rig");
  if (!json.is_object() || !json.contains("cameras") || !json["cameras"].is_array() || json["cameras"].empty())
    throw InputError(path + ": cameras is missing or empty, must be a list with an object for each camera");

  RigDescription rig;
  if (const char* key = "frames_per_second"; json.contains(key)) {
    rig.frames_per_second = Entry{json, path}.positive(key);
    if (*rig.frames_per_second < 1e-3 || *rig.frames_per_second > 1e6)
      Entry{json, path}.fail(key, "is " + quoted(json[key]) + ", must be 0.001 to 1000000");
  }
  UnknownKeys unknown;
  static const std::vector<std::string> of_rig = {"cameras", "frames_per_second"};
  unknown.look(json, path, of_rig);
  std::set<std::string> names;
  for (const Json& object : json["cameras"]) {
    const std::string number = path + ": camera number " + std::to_string(rig.cameras.size());
    if (!object.is_object()) throw InputError(number + ": is " + quoted(object) + ", must be an object");
    const Json& name = Entry{object, number}.get("name", "the name of a folder beside the file");
    if (!name.is_string() || !isFolderName(name.get<std::string>()))
      throw InputError(number + ": name is " + quoted(name) + ", must be the name of a folder beside the file");
    if (!names.insert(name.get<std::string>()).second)
      throw InputError(number + ": name is " + quoted(name) + ", which another camera has");
    const std::string owner = path + ": camera '" + name.get<std::string>() + "'";
    try {
      rig.cameras.push_back(parseCamera(Entry{object, owner}, name.get<std::string>(), with_poses, rig.warnings));
      checkCameraInput(path, rig.cameras.back().camera);
    } catch (const InputError& error) {
      UnknownKeys of_camera;
      lookAtKeys(object, owner, of_camera);
      throw InputError(error.what() + of_camera.misspelt());
    }
    lookAtKeys(object, owner, unknown);
  }
  for (std::string& line : unknown.warnings()) rig.warnings.push_back(std::move(line));
  return rig;
}

void writeRigJson(const std::string& path, const RigDescription& rig) {
  Json json;
  if (rig.frames_per_second) json["frames_per_second"] = *rig.frames_per_second;
  for (const RigCamera& rig_camera : rig.cameras) {
    Json entry;
    entry["name"] = rig_camera.camera.name;
    putIntrinsics(entry, rig_camera.camera.intrinsics);
    if (rig_camera.has_depth_scale) entry["depth_scale"] = shortest(rig_camera.camera.depth_scale);
    if (rig_camera.depth.is_distance) entry["depth_is"] = "distance";
    if (rig_camera.depth.offset != 0) entry["depth_offset"] = shortest(rig_camera.depth.offset);
    if (rig_camera.confidence_scale) entry["confidence_scale"] = shortest(*rig_camera.confidence_scale);
    entry["T_world_camera"] = poseNumbers(rig_camera.camera.T_world_camera);
    if (rig_camera.camera.color) {
      putIntrinsics(entry["color"], rig_camera.camera.color->intrinsics);
      entry["color"]["T_depth_color"] = poseNumbers(rig_camera.camera.color->T_depth_color);
    }
    if (const DepthCorrection& correction = rig_camera.camera.depth_correction; !correction.empty()) {
      Json& knots = entry["depth_correction"];
      knots["columns"] = correction.columns;
      knots["rows"] = correction.rows;
      for (const float a : correction.relative) knots["relative"].push_back(shortest(a));
      for (const float b : correction.per_metre) knots["per_metre"].push_back(shortest(b));
    }
    if (const Multipath& multipath = rig_camera.camera.multipath; multipath.modulation_frequency > 0) {
      entry["multipath"]["modulation_frequency"] = shortest(multipath.modulation_frequency);
      entry["multipath"]["reflectance"] = shortest(multipath.reflectance);
    }
    if (const std::optional<NoiseModel>& noise = rig_camera.camera.noise) {
      entry["noise"]["floor"] = shortest(noise->floor);
      entry["noise"]["linear"] = shortest(noise->linear);
      entry["noise"]["quadratic"] = shortest(noise->quadratic);
    }
    json["cameras"].push_back(std::move(entry));
  }
  writeFile(path, json.dump(2) + "\n");
}

}  // namespace fuse_flow::io
