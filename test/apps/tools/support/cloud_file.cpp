#include "cloud_file.h"

#include "wall_recording.h"

#include <cstring>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>

namespace tool_test {
namespace {

/** \brief Where each property lies in a record. */
struct Layout {
  std::map<std::string, std::size_t> offsets;
  std::size_t record{0};
  std::size_t points{0};
  std::size_t data_begin{0};

  void add(const std::string& name, std::size_t size) {
    offsets[name] = record;
    record += size;
  }
};

std::vector<std::string> words(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> result;
  for (std::string word; in >> word;) result.push_back(word);
  return result;
}

std::size_t plySize(const std::string& type) {
  static const std::map<std::string, std::size_t> sizes{{"char", 1}, {"uchar", 1}, {"short", 2}, {"ushort", 2},
                                                        {"int", 4},  {"uint", 4},  {"float", 4}, {"double", 8}};
  return sizes.at(type);
}

Layout parseHeader(const std::string& path, const std::string& bytes) {
  Layout layout;
  std::vector<std::string> fields, sizes, counts;
  std::size_t at = 0;
  for (std::size_t end; (end = bytes.find('\n', at)) != std::string::npos;) {
    const std::vector<std::string> line = words(bytes.substr(at, end - at));
    at = end + 1;
    if (line.empty()) continue;
    if (line[0] == "element") layout.points = std::stoul(line.at(2));
    if (line[0] == "property") layout.add(line.at(2), plySize(line.at(1)));
    if (line[0] == "FIELDS") fields = line;
    if (line[0] == "SIZE") sizes = line;
    if (line[0] == "COUNT") counts = line;
    if (line[0] == "POINTS") layout.points = std::stoul(line.at(1));
    if (line[0] == "end_header" || line[0] == "DATA") {
      for (std::size_t i = 1; i < fields.size(); ++i)
        layout.add(fields[i], std::stoul(sizes.at(i)) * std::stoul(counts.at(i)));
      layout.data_begin = at;
      return layout;
    }
  }
  throw std::runtime_error(path + ": has no whole header");
}

template <typename Value>
void copy(const Layout& layout, const char* record, const char* name, Value& value) {
  const auto offset = layout.offsets.find(name);
  if (offset != layout.offsets.end()) std::memcpy(&value, record + offset->second, sizeof value);
}

}  // namespace

std::vector<FilePoint> readCloudFile(const std::filesystem::path& path) {
  const std::string bytes = readText(path);
  const Layout layout = parseHeader(path.string(), bytes);
  if (bytes.size() != layout.data_begin + layout.points * layout.record)
    throw std::runtime_error(path.string() + ": has another size than its header says");
  std::vector<FilePoint> points(layout.points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const char* record = bytes.data() + layout.data_begin + i * layout.record;
    FilePoint& p = points[i];
    copy(layout, record, "x", p.x);
    copy(layout, record, "y", p.y);
    copy(layout, record, "z", p.z);
    for (const auto& [name, value] : std::map<std::string, float*>{{"nx", &p.nx},
                                                                   {"ny", &p.ny},
                                                                   {"nz", &p.nz},
                                                                   {"normal_x", &p.nx},
                                                                   {"normal_y", &p.ny},
                                                                   {"normal_z", &p.nz}})
      copy(layout, record, name.c_str(), *value);
    copy(layout, record, "red", p.r);
    copy(layout, record, "green", p.g);
    copy(layout, record, "blue", p.b);
    std::uint32_t packed = 0;
    for (const char* name : {"rgb", "rgba"}) copy(layout, record, name, packed);
    if (layout.offsets.count("red") == 0) {
      p.r = static_cast<std::uint8_t>(packed >> 16);
      p.g = static_cast<std::uint8_t>(packed >> 8);
      p.b = static_cast<std::uint8_t>(packed);
    }
    copy(layout, record, "confidence", p.confidence);
    copy(layout, record, "view_count", p.view_count);
    copy(layout, record, "camera_mask_0", p.camera_mask[0]);
    copy(layout, record, "camera_mask_1", p.camera_mask[1]);
    copy(layout, record, "camera_mask", p.camera_mask);
  }
  return points;
}

}  // namespace tool_test
