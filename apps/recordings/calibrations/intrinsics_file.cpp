#include "recordings/calibrations/intrinsics_file.h"

#include "recordings/calibrations/calibration.h"
#include "recordings/calibrations/colmap_camera.h"
#include "recordings/calibrations/lens_models.h"
#include "recordings/files/file_io.h"
#include "recordings/files/json_file.h"

#include <fuse_flow/recordings/error.h>

#include <nlohmann/json.hpp>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>
#include <vector>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

using IntrinsicsJson = nlohmann::json;

std::string sizeText(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

/** \brief Nine numbers row by row, or sixteen of a 4×4 matrix whose last row and column say nothing. */
Intrinsics fromMatrix(const std::string& path, std::vector<double> m) {
  if (m.size() == 16) {
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
      throw InputError(path + ": the 4x4 matrix has a last row or column, must be 3x3 intrinsics and 0 0 0 1");
    m = {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
  }
  return intrinsicsOf(path, m);
}

/** \brief The images that the intrinsics are for. */
struct Images {
  int width, height;                   ///< pixels; 0: not known
  std::vector<std::string>& warnings;  ///< to add to
};

/** \brief What a file says of distortion. */
struct DistortionText {
  std::string model;
  std::vector<double> coefficients;
};

/** \brief \param K without a size gets that of the images */
Intrinsics distorted(const std::string& path, Intrinsics K, const DistortionText& text, const Images& images) {
  if (K.width == 0 || K.height == 0) {
    K.width = images.width;
    K.height = images.height;
  }
  std::vector<std::string> lines;
  const Intrinsics result = withDistortion(path, K, text.model, text.coefficients, lines);
  images.warnings.insert(images.warnings.end(), lines.begin(), lines.end());
  return result;
}

bool same(const Intrinsics& a, const Intrinsics& b) {
  const auto numbers = [](const Intrinsics& K) {
    const Distortion& d = K.distortion;
    return std::vector<float>{K.fx, K.fy, K.cx, K.cy, d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6};
  };
  return numbers(a) == numbers(b);
}

// ---- JSON

std::vector<double> flatNumbers(const IntrinsicsJson& json) {
  std::vector<double> numbers;
  for (const IntrinsicsJson& entry : json)
    if (entry.is_array())
      for (const IntrinsicsJson& number : entry) numbers.push_back(number.get<double>());
    else
      numbers.push_back(entry.get<double>());
  return numbers;
}

/** \brief One camera; none where the object is something else. */
std::optional<Intrinsics> fromObject(const std::string& path, const IntrinsicsJson& json, const Images& images) {
  if (!json.is_object()) return std::nullopt;
  Intrinsics K;
  if (json.contains("intrinsic_matrix")) {
    const IntrinsicsJson& matrix = json["intrinsic_matrix"];
    std::vector<double> m = flatNumbers(matrix);
    const bool by_columns = !matrix.empty() && !matrix.front().is_array();  // Open3D's flat list
    if (m.size() != 9 || (by_columns && (m[2] != 0 || m[5] != 0 || m[8] != 1)))
      throw InputError(path + ": intrinsic_matrix must have 9 numbers, column by column: fx 0 0 0 fy 0 cx cy 1");
    if (by_columns) m = {m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]};
    K = fromMatrix(path, m);
  } else if (json.contains("fx") && json.contains("fy")) {
    K.fx = json["fx"].get<float>();
    K.fy = json["fy"].get<float>();
    K.cx = json.contains("cx") ? json["cx"].get<float>() : json.at("ppx").get<float>();
    K.cy = json.contains("cy") ? json["cy"].get<float>() : json.at("ppy").get<float>();
  } else {
    return std::nullopt;
  }
  K.width = imageSide(path, "width", json.value("width", 0.0));
  K.height = imageSide(path, "height", json.value("height", 0.0));
  DistortionText text;
  for (const char* key : {"distortion", "distortion_coefficients", "coeffs"})
    if (json.contains(key)) text.coefficients = flatNumbers(json[key]);
  for (const char* key : {"model", "distortion_model"})
    if (json.contains(key) && json[key].is_string()) text.model = json[key].get<std::string>();
  return distorted(path, K, text, images);
}

/** \brief That of all frames of Open3D's PinholeCameraTrajectory; none where it is something else. */
std::optional<Intrinsics> fromTrajectory(const std::string& path, const IntrinsicsJson& json, const Images& images) {
  if (!json.is_object() || !json.contains("parameters") || !json["parameters"].is_array()) return std::nullopt;
  std::optional<Intrinsics> camera;
  for (const IntrinsicsJson& entry : json["parameters"]) {
    if (!entry.is_object() || !entry.contains("intrinsic")) continue;
    const auto K = fromObject(path, entry["intrinsic"], images);
    if (K && camera && !same(*K, *camera))
      throw InputError(path + ": its frames have different intrinsics, must have those of one camera");
    if (K) camera = K;
  }
  return camera;
}

std::optional<Intrinsics> fromJson(const std::string& path, const Images& images) {
  const auto json = readJson<IntrinsicsJson>(path, "a camera as Open3D writes it");
  try {
    const std::optional<Intrinsics> K = fromTrajectory(path, json, images);
    return K ? K : fromObject(path, json, images);
  } catch (const IntrinsicsJson::exception&) {
    throw InputError(path +
                     ": is not a camera as Open3D writes it: width, height, intrinsic_matrix of 9 numbers, or fx, fy, "
                     "cx, cy");
  }
}

// ---- YAML

/** \brief A list, or the data of what ROS and OpenCV write as a matrix. */
std::vector<double> yamlNumbers(const YAML::Node& node) {
  const YAML::Node list = node.IsMap() ? node["data"] : node;
  std::vector<double> numbers;
  if (!list || !list.IsSequence()) return numbers;
  // An alias repeats a row with two letters: no matrix or lens has more.
  constexpr std::size_t most = 64;
  for (const YAML::Node& entry : list) {
    if (entry.IsSequence())
      for (const YAML::Node& number : entry) numbers.push_back(number.as<double>());
    else
      numbers.push_back(entry.as<double>());
    if (numbers.size() > most) break;
  }
  return numbers;
}

template <typename... Keys>
YAML::Node firstOf(const YAML::Node& node, const Keys&... keys) {
  YAML::Node found;
  for (const char* key : {keys...})
    if (!found.IsDefined() || found.IsNull())
      if (node[key]) found.reset(node[key]);
  return found;
}

std::optional<Intrinsics> fromYaml(const std::string& path, std::string text, const Images& images) {
  // OpenCV begins its files with "%YAML:1.0", which is no directive of YAML's.
  if (text.rfind("%YAML:", 0) == 0) text.erase(0, text.find('\n'));
  try {
    YAML::Node root = YAML::Load(text);
    if (root.IsMap() && root["camera_info"]) root.reset(root["camera_info"]);
    if (!root.IsMap()) return std::nullopt;
    const YAML::Node matrix = firstOf(root, "camera_matrix", "K", "k", "Camera_Matrix");
    if (!matrix.IsDefined() || matrix.IsNull()) return std::nullopt;
    Intrinsics K = fromMatrix(path, yamlNumbers(matrix));
    if (const YAML::Node node = firstOf(root, "image_width", "width"); node.IsScalar())
      K.width = imageSide(path, "image_width", node.as<double>());
    if (const YAML::Node node = firstOf(root, "image_height", "height"); node.IsScalar())
      K.height = imageSide(path, "image_height", node.as<double>());
    DistortionText lens;
    if (const YAML::Node node = firstOf(root, "distortion_coefficients", "Distortion_Coefficients", "D", "d");
        node.IsDefined() && !node.IsNull())
      lens.coefficients = yamlNumbers(node);
    if (const YAML::Node node = firstOf(root, "distortion_model", "camera_model"); node.IsScalar())
      lens.model = node.as<std::string>();
    return distorted(path, K, lens, images);
  } catch (const YAML::Exception& error) {
    std::string line = error.mark.is_null() ? "" : " at line " + std::to_string(error.mark.line + 1);
    throw InputError(path + ": is not a camera_info as ROS writes it" + line +
                     ": image_width, image_height, camera_matrix, distortion_coefficients");
  }
}

// ---- Text

/** \brief One line of COLMAP's cameras.txt, behind the camera's number: MODEL WIDTH HEIGHT PARAMS… */
Intrinsics fromColmapLine(const std::string& path, std::istringstream& words) {
  std::string model;
  double width = 0, height = 0;
  words >> model >> width >> height;
  std::vector<double> parameters;
  for (double x; words >> x;) parameters.push_back(x);
  return colmapIntrinsics(path, model, width, height, parameters);
}

/** \brief Whether a line is one of COLMAP's: a number, then a model's name in capitals. */
bool isColmapLine(const std::string& line) {
  std::istringstream words(line);
  std::string number, model;
  words >> number >> model;
  return !model.empty() && std::isupper(static_cast<unsigned char>(model[0])) &&
         std::all_of(number.begin(), number.end(), [](unsigned char c) { return std::isdigit(c); });
}

Intrinsics fromText(const std::string& path, const std::string& text, int width, int height) {
  std::vector<Intrinsics> cameras;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    line.erase(std::find(line.begin(), line.end(), '#'), line.end());
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    if (!isColmapLine(line)) {
      cameras.clear();
      break;
    }
    std::istringstream words(line);
    std::string number;
    words >> number;
    const Intrinsics K = fromColmapLine(path, words);
    if (width > 0 && (K.width != width || K.height != height)) continue;
    if (std::none_of(cameras.begin(), cameras.end(), [&](const Intrinsics& other) { return same(K, other); }))
      cameras.push_back(K);
  }
  if (cameras.size() == 1) return cameras[0];
  if (cameras.size() > 1)
    throw InputError(path + ": has " + std::to_string(cameras.size()) +
                     " different cameras for these images, must be one: keep the line of the one that took them");
  std::vector<double> numbers = readNumbers(path);
  if (numbers.size() == 4) numbers = {numbers[0], 0, numbers[2], 0, numbers[1], numbers[3], 0, 0, 1};
  return fromMatrix(path, numbers);
}

bool isText(const fs::path& file) {
  static const std::vector<std::string> names = {
      "camera-intrinsics", "camera_intrinsics", "intrinsics",       "intrinsic", "intrinsic_depth", "intrinsics_depth",
      "depth_intrinsics",  "depth_intrinsic",   "camera_intrinsic", "K",         "cameras"};
  return file.extension() == ".txt" && std::find(names.begin(), names.end(), file.stem().string()) != names.end();
}

std::optional<Intrinsics> tryFile(const std::string& path, const Images& images) {
  const fs::path file(path);
  const std::string extension = file.extension().string();
  if (extension == ".json") return fromJson(path, images);
  if (extension == ".yaml" || extension == ".yml") return fromYaml(path, readText(path, kMostCalibrationBytes), images);
  return fromText(path, readText(path, kMostCalibrationBytes), images.width, images.height);
}

}  // namespace

Intrinsics readIntrinsicsFile(const std::string& path, int width, int height, std::vector<std::string>* warnings) {
  std::vector<std::string> lines;
  const std::optional<Intrinsics> K = tryFile(path, {width, height, lines});
  if (!K)
    throw InputError(path +
                     ": has no camera intrinsics, must be a camera_info .yaml, a .json with intrinsic_matrix, a 3x3 "
                     "matrix as text, or COLMAP's cameras.txt");
  if (warnings) warnings->insert(warnings->end(), lines.begin(), lines.end());
  return *K;
}

std::optional<FoundIntrinsics> findIntrinsics(const std::string& folder, int width, int height) {
  struct Found {
    std::string path;
    Intrinsics K;
    bool of_depth;
    std::vector<std::string> warnings;
  };
  std::vector<Found> found;
  const auto add = [&](const std::string& name) {
    const std::string path = (fs::path(folder) / name).string();
    std::vector<std::string> lines;
    if (const auto K = tryFile(path, {width, height, lines}))
      found.push_back({path, *K, name.find("depth") != std::string::npos, lines});
  };
  bool has_trajectory = false;  // which repeats, rounded, what a file of its own says
  for (const std::string& name : filesIn(folder)) {
    const fs::path file(name);
    const std::string extension = file.extension().string();
    if (name == kOpen3dTrajectory)
      has_trajectory = true;
    else if (extension == ".json" || extension == ".yaml" || extension == ".yml" || isText(file))
      add(name);
  }
  if (found.empty() && has_trajectory) add(kOpen3dTrajectory);
  if (found.empty()) return std::nullopt;
  const auto keep = [&](const auto& wanted) {
    std::vector<Found> kept;
    std::copy_if(found.begin(), found.end(), std::back_inserter(kept), wanted);
    if (!kept.empty()) found = std::move(kept);
  };
  keep([&](const Found& f) { return f.K.width == 0 || (f.K.width == width && f.K.height == height); });
  keep([](const Found& f) { return f.of_depth; });
  for (const Found& other : found)
    if (!same(found[0].K, other.K))
      throw InputError(folder + ": " + fs::path(found[0].path).filename().string() + " and " +
                       fs::path(other.path).filename().string() +
                       " have different intrinsics for these images; --intrinsics says which");
  const Intrinsics& K = found[0].K;
  if (K.width != 0 && (K.width != width || K.height != height))
    throw InputError(found[0].path + ": is of a camera of " + sizeText(K.width, K.height) +
                     " pixels, the depth images are " + sizeText(width, height) +
                     "; must be that of the depth images, or --intrinsics gives another file");
  return FoundIntrinsics{K, found[0].path, found[0].warnings};
}

}  // namespace fuse_flow::io
