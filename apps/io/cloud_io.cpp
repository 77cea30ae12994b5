#include "io/cloud_io.h"

#include "io/file_io.h"

#include <pcl/common/io.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/pcl_config.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <vector>

namespace fuse_flow::io {
namespace {

// Both formats are written here and not by PCL: its writers do not report a full disk, and its PLY carries a camera
// element that other programs stumble over.

std::string extensionOf(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

bool isColor(const pcl::PCLPointField& field) { return field.name == "rgb" || field.name == "rgba"; }

/** \brief Some files say 0 where they mean one value. */
std::size_t valueCount(const pcl::PCLPointField& field) { return std::max<std::size_t>(1, field.count); }

std::size_t byteSize(const pcl::PCLPointField& field) {
  return valueCount(field) * static_cast<std::size_t>(pcl::getFieldSize(field.datatype));
}

/** \brief The fields that mean something, in the order in which they lie in a point. */
std::vector<pcl::PCLPointField> dataFields(const pcl::PCLPointCloud2& cloud) {
  std::vector<pcl::PCLPointField> fields;
  for (const pcl::PCLPointField& field : cloud.fields)
    if (field.name != "_") fields.push_back(field);
  return fields;
}

/** \brief Of the fields those of the position. */
std::vector<pcl::PCLPointField> axesOf(const std::vector<pcl::PCLPointField>& fields) {
  std::vector<pcl::PCLPointField> axes;
  for (const pcl::PCLPointField& field : fields)
    if (field.name == "x" || field.name == "y" || field.name == "z") axes.push_back(field);
  return axes;
}

bool isFinite(const std::vector<pcl::PCLPointField>& axes, const std::uint8_t* point) {
  for (const pcl::PCLPointField& axis : axes) {
    float value = 0;
    std::memcpy(&value, point + axis.offset, sizeof value);
    if (!std::isfinite(value)) return false;
  }
  return true;
}

std::string plyType(const pcl::PCLPointField& field) {
  switch (field.datatype) {
    case pcl::PCLPointField::INT8:
      return "char";
    case pcl::PCLPointField::UINT8:
      return "uchar";
    case pcl::PCLPointField::INT16:
      return "short";
    case pcl::PCLPointField::UINT16:
      return "ushort";
    case pcl::PCLPointField::INT32:
      return "int";
    case pcl::PCLPointField::UINT32:
      return "uint";
    case pcl::PCLPointField::FLOAT64:
      return "double";
    default:
      return "float";
  }
}

std::string plyName(const std::string& name) {
  if (name == "normal_x") return "nx";
  if (name == "normal_y") return "ny";
  if (name == "normal_z") return "nz";
  return name;
}

void appendPlyProperties(std::ostream& header, const pcl::PCLPointField& field) {
  if (isColor(field)) {
    header << "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    return;
  }
  for (std::size_t i = 0; i < valueCount(field); ++i)
    header << "property " << plyType(field) << ' ' << plyName(field.name)
           << (valueCount(field) > 1 ? "_" + std::to_string(i) : "") << '\n';
}

std::string toPly(const pcl::PCLPointCloud2& cloud) {
  const std::vector<pcl::PCLPointField> fields = dataFields(cloud), axes = axesOf(fields);
  std::vector<bool> is_color;
  for (const pcl::PCLPointField& field : fields) is_color.push_back(isColor(field));
  std::string records;
  records.reserve(cloud.data.size());
  std::size_t written = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(cloud.width) * cloud.height; ++i) {
    const std::uint8_t* point = cloud.data.data() + i * cloud.point_step;
    if (!isFinite(axes, point)) continue;
    ++written;
    for (std::size_t k = 0; k < fields.size(); ++k) {
      const auto* value = reinterpret_cast<const char*>(point + fields[k].offset);
      if (is_color[k])
        records.append({value[2], value[1], value[0]});  // PCL packs blue, green, red, alpha
      else
        records.append(value, byteSize(fields[k]));
    }
  }
  std::ostringstream header;
  header << "ply\nformat binary_little_endian 1.0\nelement vertex " << written << '\n';
  for (const pcl::PCLPointField& field : fields) appendPlyProperties(header, field);
  header << "end_header\n";
  return header.str() + records;
}

char pcdType(const pcl::PCLPointField& field) {
  return pcl::getFieldType(field.datatype);  // 'I', 'U' or 'F'
}

std::string toPcd(const pcl::PCLPointCloud2& cloud, const SensorPose& pose) {
  const std::vector<pcl::PCLPointField> fields = dataFields(cloud);
  std::ostringstream names, sizes, types, counts;
  for (const pcl::PCLPointField& field : fields) {
    names << ' ' << field.name;
    sizes << ' ' << pcl::getFieldSize(field.datatype);
    types << ' ' << pcdType(field);
    counts << ' ' << valueCount(field);
  }
  const std::size_t points = static_cast<std::size_t>(cloud.width) * cloud.height;
  std::ostringstream header;
  header.precision(9);
  header << "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS" << names.str() << "\nSIZE" << sizes.str()
         << "\nTYPE" << types.str() << "\nCOUNT" << counts.str() << "\nWIDTH " << cloud.width << "\nHEIGHT "
         << cloud.height << "\nVIEWPOINT " << pose.origin.x() << ' ' << pose.origin.y() << ' ' << pose.origin.z() << ' '
         << pose.orientation.w() << ' ' << pose.orientation.x() << ' ' << pose.orientation.y() << ' '
         << pose.orientation.z() << "\nPOINTS " << points << "\nDATA binary\n";
  std::string bytes = header.str();
  bytes.reserve(bytes.size() + cloud.data.size());
  for (std::size_t i = 0; i < points; ++i)
    for (const pcl::PCLPointField& field : fields)
      bytes.append(reinterpret_cast<const char*>(cloud.data.data() + i * cloud.point_step + field.offset),
                   byteSize(field));
  return bytes;
}

/** \brief Before 1.13 PCL's reader refused files without points, after their whole header. */
bool isRefusedAsEmpty(const pcl::PCLPointCloud2& header) {
#if PCL_VERSION_COMPARE(<, 1, 13, 0)
  return header.width * header.height == 0;
#else
  (void)header;
  return false;
#endif
}

/** \brief Whether compressed data are as long as they say, and make what the header says. */
bool hasCompressedData(const std::string& path, std::size_t data_begin, std::size_t bytes) {
  std::uint32_t sizes[2] = {0, 0};  // compressed, uncompressed
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(data_begin));
  if (!file.read(reinterpret_cast<char*>(sizes), sizeof sizes)) return false;
  return data_begin + sizeof sizes + sizes[0] <= std::filesystem::file_size(path) && sizes[1] == bytes;
}

/** \brief The numbers of a PCD's header by which PCL's reader takes memory before anything else. */
struct PcdSize {
  std::vector<double> sizes, counts;
  double width{0}, height{1}, points{0};

  void addLine(const std::string& keyword, std::istream& words) {
    std::vector<double> numbers;
    for (double number = 0; words >> number;) numbers.push_back(number);
    if (keyword == "SIZE") sizes = numbers;
    if (keyword == "COUNT") counts = numbers;
    if (numbers.size() != 1) return;
    if (keyword == "WIDTH") width = numbers[0];
    if (keyword == "HEIGHT") height = numbers[0];
    if (keyword == "POINTS") points = numbers[0];
  }
  bool hasPossibleFields() const {
    constexpr double most_values = 1 << 20;
    return std::all_of(counts.begin(), counts.end(), [](double n) { return n >= 0 && n <= most_values; }) &&
           std::all_of(sizes.begin(), sizes.end(), [](double n) { return n == 1 || n == 2 || n == 4 || n == 8; });
  }
  /** \brief The fewest that hold the points. \param data ascii, binary or binary_compressed */
  double bytes(const std::string& data) const {
    double of_point = 0;
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      const double values = i < counts.size() ? std::max(1.0, counts[i]) : 1;
      of_point += values * (data == "ascii" ? 2 : sizes[i]);  // as text a value and what ends it
    }
    const double all = of_point * std::max(points, width * height);
    if (data == "ascii") return all - 1;                   // nothing need end the last
    return data == "binary_compressed" ? all / 100 : all;  // LZF makes 264 bytes of 3 at best
  }
};

/** \brief Whether a PCD may hold what its header says. */
bool hasPossibleSize(const std::string& path) {
  PcdSize size;
  std::ifstream file(path, std::ios::binary);
  for (std::string line, keyword, data; std::getline(file, line);) {
    std::istringstream words(line);
    if (!(words >> keyword)) continue;
    if (keyword != "DATA") {
      size.addLine(keyword, words);
      continue;
    }
    words >> data;
    const std::streamoff header_end = file.tellg();  // -1: nothing follows
    const auto there = static_cast<double>(std::filesystem::file_size(path)) - static_cast<double>(header_end);
    return size.hasPossibleFields() && (header_end < 0 || size.bytes(data) <= there);
  }
  return size.hasPossibleFields();
}

/** \brief Whether a PCD's header is one that PCL's reader survives: it reads the data of any other without looking. */
bool hasPcdHeader(const std::string& path) {
  if (!hasPossibleSize(path)) return false;
  constexpr int compressed = 2;
  pcl::PCLPointCloud2 header;
  SensorPose pose;
  int version = 0, data_type = 0;
  unsigned int data_begin = 0;
  const bool whole =
      pcl::PCDReader().readHeader(path, header, pose.origin, pose.orientation, version, data_type, data_begin) >= 0;
  if (!(whole || isRefusedAsEmpty(header)) || header.fields.empty() || header.point_step == 0 || data_begin == 0)
    return false;
  std::size_t point_bytes = 0;
  for (const pcl::PCLPointField& field : dataFields(header)) point_bytes += byteSize(field);
  const std::size_t points = static_cast<std::size_t>(header.width) * header.height;
  return data_type != compressed || points == 0 || hasCompressedData(path, data_begin, points * point_bytes);
}

std::size_t plyTypeSize(const std::string& type) {
  for (const char* two : {"short", "ushort", "int16", "uint16"})
    if (type == two) return 2;
  for (const char* four : {"int", "uint", "int32", "uint32", "float", "float32"})
    if (type == four) return 4;
  return type == "double" || type == "float64" ? 8 : 1;
}

/** \brief The fewest bytes that hold what the header of a PLY tells of. */
class PlySize {
 public:
  void addLine(const std::string& keyword, const std::string& type, const std::string& name) {
    if (keyword == "format") is_text_ = type == "ascii";
    if (keyword == "element") entries_ = std::strtod(name.c_str(), nullptr);
    // As text a value and what ends it. Of a list "type" is list, then "name" is the type of its count, and it may be empty.
    if (keyword == "property" && entries_ > 0)
      bytes_ += entries_ * static_cast<double>(is_text_ ? 2 : plyTypeSize(type == "list" ? name : type));
  }
  /** \brief Behind the header; of text the last value needs nothing that ends it. */
  double bytes() const { return is_text_ ? bytes_ - 1 : bytes_; }

 private:
  bool is_text_{false};
  double entries_{0}, bytes_{0};
};

/** \brief The size of an organised cloud, which PCL's reader takes from obj_info. */
class PlyGrid {
 public:
  void addLine(const std::string& keyword, const std::string& type, const std::string& name) {
    if (keyword == "obj_info" && type == "num_cols") columns_ = std::strtod(name.c_str(), nullptr);
    if (keyword == "obj_info" && type == "num_rows") rows_ = std::strtod(name.c_str(), nullptr);
    if (keyword == "element" && type == "vertex") vertices_ = std::strtod(name.c_str(), nullptr);
  }
  void check(const std::string& path) const {
    if (columns_ * rows_ == vertices_ || (columns_ == 0 && rows_ == 0)) return;
    std::ostringstream message;
    message << path << ": obj_info has " << columns_ << " columns and " << rows_ << " rows, must be as many as its "
            << vertices_ << " vertices";
    throw InputError(message.str());
  }

 private:
  double columns_{0}, rows_{0}, vertices_{0};
};

/** \brief Throws InputError for a PLY at which PCL's reader would end the program: with green or blue without red before it, with
 *  lists in its vertices, with rows and columns that are not as many, or with a grid of them, whose numbers it does not check. Also for one that is too short for what its
 *  header tells of: the reader takes memory by that first. */
void checkPlyHeader(const std::string& path) {
  const std::set<std::string> first{"red", "diffuse_red"};
  const std::set<std::string> later{"green", "blue", "diffuse_green", "diffuse_blue"};
  bool has_red = false;
  std::string element;
  PlySize size;
  PlyGrid grid;
  std::ifstream file(path, std::ios::binary);
  for (std::string line; std::getline(file, line) && line.rfind("end_header", 0) != 0;) {
    std::string keyword, type, name;
    std::istringstream(line) >> keyword >> type >> name;
    size.addLine(keyword, type, name);
    grid.addLine(keyword, type, name);
    if (keyword == "element") element = type;
    if (element == "range_grid") throw InputError(path + ": has a range_grid, must have vertices alone or with faces");
    if (keyword != "property") continue;
    if (element == "vertex" && type == "list")
      throw InputError(path + ": has a list among the properties of its vertices, must have numbers");
    has_red = has_red || first.count(name) > 0;
    if (!has_red && later.count(name) > 0)
      throw InputError(path + ": has " + name + " without red before it, must be red, green, blue");
  }
  grid.check(path);
  const std::streamoff header_end = file.tellg();
  if (header_end >= 0 &&
      static_cast<double>(std::filesystem::file_size(path)) - static_cast<double>(header_end) < size.bytes())
    throw InputError(path + ": is cut short: it holds fewer values than its header says");
}

/** \brief PCL's return code; its exceptions count as failure. */
int readByExtension(const std::string& path, const std::string& extension, pcl::PCLPointCloud2& cloud,
                    SensorPose& pose) {
  const SilencePcl silence;
  int version = 0;
  try {
    if (extension == ".ply") return pcl::PLYReader().read(path, cloud, pose.origin, pose.orientation, version);
    if (!hasPcdHeader(path)) return -1;
    const int result = pcl::PCDReader().read(path, cloud, pose.origin, pose.orientation, version);
    return isRefusedAsEmpty(cloud) ? 0 : result;
  } catch (const std::exception&) {
    return -1;
  }
}

/** \brief Doubles become floats in their place, which PCL's point types have: Open3D's PLY holds doubles. */
void toSinglePrecision(pcl::PCLPointCloud2& cloud) {
  const std::size_t points = static_cast<std::size_t>(cloud.width) * cloud.height;
  for (pcl::PCLPointField& field : cloud.fields) {
    if (field.datatype != pcl::PCLPointField::FLOAT64) continue;
    for (std::size_t i = 0; i < points; ++i) {
      std::uint8_t* at = cloud.data.data() + i * cloud.point_step + field.offset;
      for (std::size_t k = 0; k < valueCount(field); ++k) {
        double value = 0;
        std::memcpy(&value, at + k * sizeof value, sizeof value);
        const auto single = static_cast<float>(value);
        std::memcpy(at + k * sizeof single, &single, sizeof single);
      }
    }
    field.datatype = pcl::PCLPointField::FLOAT32;
  }
}

}  // namespace

void writeCloud(const std::string& path, const pcl::PCLPointCloud2& cloud, const SensorPose& pose) {
  const std::string extension = extensionOf(path);
  if (extension == ".ply")
    writeFile(path, toPly(cloud));
  else if (extension == ".pcd")
    writeFile(path, toPcd(cloud, pose));
  else
    throw OutputError(path + ": the extension is '" + extension + "', must be .ply or .pcd");
}

SensorPose readCloud(const std::string& path, pcl::PCLPointCloud2& cloud, EmptyCloud empty) {
  const std::string extension = extensionOf(path);
  if (extension != ".ply" && extension != ".pcd")
    throw InputError(path + ": the extension is '" + extension + "', must be .ply or .pcd");
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw InputError(path + ": not found, must be a .ply or .pcd file");
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(path + ": is not a file");
  if (extension == ".ply") checkPlyHeader(path);
  SensorPose pose;
  if (readByExtension(path, extension, cloud, pose) < 0)
    throw InputError(path + ": is damaged or cut short, must be a whole " + extension.substr(1) + " file");
  const std::size_t points = static_cast<std::size_t>(cloud.width) * cloud.height;
  if (cloud.data.size() < points * cloud.point_step) throw InputError(path + ": is cut short");
  toSinglePrecision(cloud);
  for (const char* axis : {"x", "y", "z"}) {
    const int index = pcl::getFieldIndex(cloud, axis);
    if (index < 0) throw InputError(path + ": has no field " + axis + ", must have x, y and z");
    if (cloud.fields[static_cast<std::size_t>(index)].datatype != pcl::PCLPointField::FLOAT32)
      throw InputError(path + ": field " + axis + " is not of floating point, must be float or double");
  }
  if (points == 0 && empty == EmptyCloud::Refused) throw InputError(path + ": has no points, must have one at least");
  return pose;
}

}  // namespace fuse_flow::io
