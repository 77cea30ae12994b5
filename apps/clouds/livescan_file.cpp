#include "clouds/livescan_file.h"

#include "recordings/files/file_io.h"

#include <fuse_flow/recordings/error.h>

#include <cstdio>
#include <limits>

namespace fuse_flow::io {
namespace {

constexpr std::size_t kPointBytes = 3 * sizeof(std::int16_t), kColorBytes = 4;
constexpr char kStart[] = "n_points= ";

/** \brief The number of a line "NAME= NUMBER"; false: it is no such line. */
bool parseLine(const std::string& line, const char* name, long long& number) {
  int length = 0;
  const std::string format = std::string(name) + "= %lld%n";
  if (std::sscanf(line.c_str(), format.c_str(), &number, &length) != 1) return false;
  return static_cast<std::size_t>(length) == line.size() ||
         (static_cast<std::size_t>(length) + 1 == line.size() && line.back() == '\r');
}

}  // namespace

bool LiveScanFile::is(const std::string& path) { return readFileStart(path, sizeof kStart - 1) == kStart; }

LiveScanFile::LiveScanFile(const std::string& path) : path_(path), file_(path, std::ios::binary) {
  const std::uint64_t size = fileSize(path);
  std::string first, second;
  for (std::uint64_t at = 0; at < size;) {
    file_.seekg(static_cast<std::streamoff>(at));
    long long points = 0, stamp = 0;
    std::getline(file_, first);
    const bool whole_first = !file_.eof();
    if (whole_first) std::getline(file_, second);
    if (!file_ || file_.eof()) {
      cut_short_ = true;
      break;
    }
    if (!parseLine(first, "n_points", points) || !parseLine(second, "frame_timestamp", stamp) || points < 0 ||
        points > std::numeric_limits<std::int32_t>::max())
      throw InputError(path + ": frame " + std::to_string(frames_.size()) +
                       " does not begin with the lines n_points= and frame_timestamp=, as LiveScan3D writes them");
    const auto begin = static_cast<std::uint64_t>(file_.tellg());
    const std::uint64_t bytes = static_cast<std::uint64_t>(points) * (kPointBytes + kColorBytes);
    if (bytes > size - begin) {
      cut_short_ = true;
      break;
    }
    frames_.push_back({begin, static_cast<std::size_t>(points)});
    at = begin + bytes + 1;
  }
  file_.clear();
  if (frames_.empty()) throw InputError(path + ": has no whole frame");
}

void LiveScanFile::read(std::size_t frame, pcl::PointCloud<PointFusedNormal>& points) {
  const Frame& chosen = frames_.at(frame);
  std::vector<unsigned char> bytes(chosen.points * (kPointBytes + kColorBytes));
  file_.seekg(static_cast<std::streamoff>(chosen.at));
  if (!file_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()))) {
    file_.clear();
    throw InputError(path_ + ": frame " + std::to_string(frame) + " cannot be read");
  }
  points.clear();
  points.resize(chosen.points);
  const unsigned char* color = bytes.data() + chosen.points * kPointBytes;
  for (std::size_t k = 0; k < chosen.points; ++k, color += kColorBytes) {
    const auto metres = [&](std::size_t axis) {
      const unsigned char* two = bytes.data() + k * kPointBytes + 2 * axis;
      return 0.001f * static_cast<float>(static_cast<std::int16_t>(two[0] | two[1] << 8));
    };
    PointFusedNormal& point = points[k];
    point.x = metres(0);
    point.y = metres(1);
    point.z = metres(2);
    point.b = color[0];
    point.g = color[1];
    point.r = color[2];
    point.confidence = 1;
  }
}

}  // namespace fuse_flow::io
