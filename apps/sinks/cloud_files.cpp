#include "sinks/cloud_files.h"

#include "clouds/cloud_io.h"
#include "clouds/other_clouds.h"
#include "recordings/files/file_io.h"

#include <pcl/conversions.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace fuse_flow::io {
namespace {

namespace fs = std::filesystem;

std::string lowerExtension(const std::string& path) {
  std::string extension = fs::path(path).extension();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

/** \brief The cloud with those fields beyond PointFused that were asked for. */
pcl::PCLPointCloud2 withAskedFields(const FusedFrame& frame) {
  pcl::PCLPointCloud2 cloud;
  pcl::toPCLPointCloud2(frame.with_normals, cloud);
  const auto unasked = [&](const pcl::PCLPointField& field) {
    return (!frame.has_normals && field.name.rfind("normal_", 0) == 0) ||
           (!frame.has_camera_mask && field.name == "camera_mask");
  };
  cloud.fields.erase(std::remove_if(cloud.fields.begin(), cloud.fields.end(), unasked), cloud.fields.end());
  return cloud;
}

}  // namespace

CloudFiles::CloudFiles(std::string output, std::string format, std::size_t frames, bool times)
    : output_(std::move(output)), format_(std::move(format)), times_(times) {
  const std::string extension = lowerExtension(output_);
  names_file_ = extension == ".ply" || extension == ".pcd";
  if (names_file_ && frames > 1)
    throw OptionError("-o " + output_ + ": names one file for " + std::to_string(frames) +
                      " frames; name a folder, or one frame with --frames");
  if (!names_file_ && !extension.empty() && !fs::is_directory(output_))
    throw OptionError("-o " + output_ + ": must end in .ply or .pcd; the folder of this name is " + output_ + "/");
}

std::string CloudFiles::pathOf(std::size_t frame) const {
  if (names_file_) return output_;
  char name[32];
  std::snprintf(name, sizeof(name), "%06zu.", frame);
  return (fs::path(output_) / (name + format_)).string();
}

void CloudFiles::take(const std::shared_ptr<const FusedFrame>& frame) {
  const std::string path = pathOf(frame->number);
  makeFolderOf(path);
  if (frame->has_normals || frame->has_camera_mask) {
    writeCloud(path, withAskedFields(*frame));
  } else {
    writeCloud(path, frame->cloud);
  }
  written_.insert(path);
  if (times_) addTime(path, frame->input.rig.stamp);
}

void addTime(const std::string& cloud, std::uint64_t stamp) {
  constexpr std::uint64_t second = 1000000;  // microseconds
  const std::string path = (fs::path(cloud).parent_path() / "timestamps.txt").string();
  char line[64];
  std::snprintf(line, sizeof line, "%s %llu.%06llu\n", fs::path(cloud).filename().c_str(),
                static_cast<unsigned long long>(stamp / second), static_cast<unsigned long long>(stamp % second));
  std::ofstream file(path, std::ios::app);
  file << line;
  if (!file.flush()) throw OutputError(path + ": cannot be written: " + std::strerror(errno));
}

std::vector<std::string> CloudFiles::finish() {
  if (written_.empty() || !fs::is_directory(output_)) return {};
  const std::string others = otherClouds(
      output_, {output_}, [&](const std::string& path) { return written_.count(path) > 0 || left_.count(path) > 0; });
  if (others.empty()) return {};
  return {others};
}

}  // namespace fuse_flow::io
