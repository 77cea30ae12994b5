#include "wall_recording.h"

#include "png_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace tool_test {

nlohmann::json WallRecording::rig() const {
  nlohmann::json json;
  for (std::size_t k = 0; k < cameras; ++k)
    json["cameras"].push_back(
        {{"name", "camera_" + std::to_string(k)},
         {"width", width},
         {"height", height},
         {"fx", width},
         {"fy", width},
         {"cx", (width - 1) / 2.0},
         {"cy", (height - 1) / 2.0},
         {"depth_scale", 0.001},
         {"T_world_camera", {1, 0, 0, 0.1 * static_cast<double>(k), 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}});
  return json;
}

void WallRecording::write(const fs::path& folder) const {
  writeText(folder / "rig.json", rig().dump(2));
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const auto depth = static_cast<std::uint16_t>(std::lround(1000 * wallDistance(frame)));
    const std::string depth_bytes =
        depthPng(width, height, std::vector<std::uint16_t>(static_cast<std::size_t>(width * height), depth));
    const std::string color_bytes = colorPng(width, height, 200, 100, 50);
    for (std::size_t k = 0; k < cameras; ++k) {
      writeText(depthFile(folder, k, frame), depth_bytes);
      if (color) writeText(colorFile(folder, k, frame), color_bytes);
    }
  }
}

namespace {

fs::path imageFile(const fs::path& recording, std::size_t camera, const char* kind, std::size_t frame) {
  const std::string digits = std::to_string(frame);
  return recording / ("camera_" + std::to_string(camera)) / kind /
         (std::string(6 - digits.size(), '0') + digits + ".png");
}

}  // namespace

fs::path depthFile(const fs::path& recording, std::size_t camera, std::size_t frame) {
  return imageFile(recording, camera, "depth", frame);
}

fs::path colorFile(const fs::path& recording, std::size_t camera, std::size_t frame) {
  return imageFile(recording, camera, "color", frame);
}

void writeText(const fs::path& path, const std::string& bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream file(path, std::ios::binary);
  file << bytes;
  if (!file.flush()) throw std::runtime_error(path.string() + ": cannot be written");
}

std::string readText(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path.string() + ": cannot be read");
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::string> listing(const fs::path& folder) {
  std::vector<std::string> names;
  if (!fs::is_directory(folder)) return names;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    names.push_back(entry.path().lexically_relative(folder).string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace tool_test
