#include <fuse_flow/stream/description.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <limits>
#include <string_view>

namespace fuse_flow::stream {

namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostCameras = 1024, kMostName = 1024;
constexpr std::size_t kMostBytes = std::size_t{16} << 20;
constexpr int kLargestImage = 65536;  // pixels, wide or high

[[noreturn]] void fail(const std::string& what) { throw FormatError("description: " + what); }

const Json& at(const Json& json, const char* key, std::string_view of) {
  const auto found = json.find(key);
  if (found == json.end()) fail(std::string(of) + "'" + key + "' is missing");
  return *found;
}

std::string text(const Json& json, const char* key, const std::string& of) {
  const Json& value = at(json, key, of);
  if (!value.is_string()) fail(of + "'" + key + "' must be a text");
  std::string result = value.get<std::string>();
  if (result.size() > kMostName) fail(of + "'" + key + "' is longer than 1024 bytes");
  return result;
}

double number(const Json& value, const std::string& what) {
  if (!value.is_number()) fail(what + " must be a number");
  const double result = value.get<double>();
  if (!std::isfinite(result)) fail(what + " must be finite");
  return result;
}

/** \brief As a float, which must hold it. */
float small(const Json& json, const char* key, const std::string& of, bool positive) {
  const std::string what = of + "'" + key + "'";
  const double value = number(at(json, key, of), what);
  if (!(std::abs(value) <= std::numeric_limits<float>::max())) fail(what + " is too large");
  const auto result = static_cast<float>(value);
  if (positive && !(result > 0)) fail(what + " must be above 0");
  return result;
}

int pixels(const Json& json, const char* key, const std::string& of) {
  const Json& value = at(json, key, of);
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() < 1 || value.get<std::uint64_t>() > kLargestImage)
    fail(of + "'" + key + "' must be a whole number from 1 to 65536");
  return value.get<int>();
}

Eigen::Isometry3d pose(const Json& json, const std::string& of) {
  const std::string what = of + "'T_world_camera'";
  const Json& value = at(json, "T_world_camera", of);
  if (!value.is_array() || value.size() != 16) fail(what + " must be 16 numbers");
  Eigen::Matrix4d matrix;
  for (std::size_t k = 0; k < 16; ++k)
    matrix(static_cast<int>(k / 4), static_cast<int>(k % 4)) = number(value[k], what);
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  if (!((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= 1e-3) ||
      !(rotation.determinant() > 0) || !(matrix.row(3) == Eigen::RowVector4d(0, 0, 0, 1)))
    fail(what + " must be a rotation and a translation, row by row");
  Eigen::Isometry3d result;
  result.matrix() = matrix;
  return result;
}

Camera camera(const Json& json, std::size_t k) {
  std::string of = "camera " + std::to_string(k) + ": ";
  if (!json.is_object()) fail(of + "must be an object");
  Camera result;
  result.name = text(json, "name", of);
  result.intrinsics.width = pixels(json, "width", of);
  result.intrinsics.height = pixels(json, "height", of);
  result.intrinsics.fx = small(json, "fx", of, true);
  result.intrinsics.fy = small(json, "fy", of, true);
  result.intrinsics.cx = small(json, "cx", of, false);
  result.intrinsics.cy = small(json, "cy", of, false);
  result.T_world_camera = pose(json, of);
  return result;
}

}  // namespace

std::string toJson(const Description& description) {
  Json cameras = Json::array();
  for (const Camera& camera : description.cameras) {
    Json matrix = Json::array();
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column) matrix.push_back(camera.T_world_camera.matrix()(row, column));
    const Intrinsics& in = camera.intrinsics;
    cameras.push_back({{"name", camera.name},
                       {"width", in.width},
                       {"height", in.height},
                       {"fx", in.fx},
                       {"fy", in.fy},
                       {"cx", in.cx},
                       {"cy", in.cy},
                       {"T_world_camera", matrix}});
  }
  const Json json = {{"type", "stream"},         {"version", 1},
                     {"name", description.name}, {"frame", description.frame},
                     {"step", description.step}, {"cameras", cameras}};
  // Names come from files of others, and need not be UTF-8.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Description descriptionFromJson(const std::string& json_text) {
  if (json_text.size() > kMostBytes) fail("is longer than 16 MB");
  bool deep = false;  // a value of a hundred thousand brackets is no description
  const Json json = Json::parse(
      json_text.begin(), json_text.end(), [&](int depth, Json::parse_event_t, Json&) { return !(deep |= depth > 16); },
      false);
  if (deep || json.is_discarded() || !json.is_object()) fail("must be a JSON object");
  if (text(json, "type", "") != "stream") fail("'type' must be \"stream\"");
  const Json& version = at(json, "version", "");
  if (!version.is_number_unsigned()) fail("'version' must be 1");
  if (version != 1) fail("is of a later version: 'version' must be 1");
  Description description;
  description.name = text(json, "name", "");
  description.frame = text(json, "frame", "");
  description.step = number(at(json, "step", ""), "'step'");
  if (!(description.step > 0)) fail("'step' must be above 0");
  const Json& cameras = at(json, "cameras", "");
  if (!cameras.is_array()) fail("'cameras' must be a list");
  if (cameras.size() > kMostCameras) fail("has more than 1024 cameras");
  for (std::size_t k = 0; k < cameras.size(); ++k) description.cameras.push_back(camera(cameras[k], k));
  return description;
}

}  // namespace fuse_flow::stream
