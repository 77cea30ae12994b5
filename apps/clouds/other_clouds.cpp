#include "clouds/other_clouds.h"

#include "recordings/files/file_io.h"

#include <cstddef>
#include <filesystem>

namespace fs = std::filesystem;

namespace fuse_flow::io {

std::string otherClouds(const std::string& output, const std::vector<std::string>& folders,
                        const std::function<bool(const std::string& path)>& is_ours) {
  std::size_t count = 0;
  std::string first;
  for (const std::string& folder : folders)
    for (const std::string& name : filesIn(folder)) {
      const fs::path path = fs::path(folder) / name;
      const std::string stem = path.stem().string(), extension = path.extension().string();
      const bool numbered = stem.size() >= 6 && stem.find_first_not_of("0123456789") == std::string::npos;
      if (!numbered || (extension != ".ply" && extension != ".pcd") || is_ours(path.string())) continue;
      if (count++ == 0) first = path.lexically_relative(output).string();
    }
  if (count == 0) return "";
  return output + " holds " + std::to_string(count) + " cloud" + (count == 1 ? "" : "s") +
         " that this run has not written, such as " + first + "; must be removed unless they belong to the others";
}

}  // namespace fuse_flow::io
