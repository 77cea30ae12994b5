#pragma once

#include <nlohmann/json.hpp>

#include <cstddef>
#include <filesystem>
#include <string>

namespace tool_test {

namespace fs = std::filesystem;

/** \brief Cameras side by side, all looking along +z at a wall: every true point has z = wall distance, which grows by
 *  50 mm from frame to frame. Camera k is called "camera_k" and stands at x = 0.1 k. */
struct WallRecording {
  std::size_t cameras{2};
  std::size_t frames{2};
  int width{32};
  int height{24};
  bool color{true};

  static double wallDistance(std::size_t frame) { return 2.0 + 0.05 * static_cast<double>(frame); }
  /** \brief rig.json as it should be; tests break it. */
  nlohmann::json rig() const;
  void write(const fs::path& folder) const;
};

fs::path depthFile(const fs::path& recording, std::size_t camera, std::size_t frame);
fs::path colorFile(const fs::path& recording, std::size_t camera, std::size_t frame);

/** \brief Creates the folders on the way. */
void writeText(const fs::path& path, const std::string& bytes);
std::string readText(const fs::path& path);
/** \brief Names of everything below a folder, sorted; empty if it does not exist. */
std::vector<std::string> listing(const fs::path& folder);

}  // namespace tool_test
