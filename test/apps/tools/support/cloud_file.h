#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace tool_test {

/** \brief A point as the tools write it. */
struct FilePoint {
  float x{0}, y{0}, z{0};
  float nx{0}, ny{0}, nz{0};
  std::uint8_t r{0}, g{0}, b{0};
  float confidence{0};
  std::uint32_t view_count{0};
  std::uint32_t camera_mask[2]{0, 0};

  /** \brief Of what is always written. */
  bool operator==(const FilePoint& o) const {
    return x == o.x && y == o.y && z == o.z && r == o.r && g == o.g && b == o.b && confidence == o.confidence &&
           view_count == o.view_count;
  }
};

/** \brief Reads a binary PLY or PCD by its header, without the library under test. Throws std::runtime_error unless the
 *  header is understood and exactly the bytes that it announces follow. */
std::vector<FilePoint> readCloudFile(const std::filesystem::path& path);

}  // namespace tool_test
