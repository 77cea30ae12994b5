#include "clouds/cloud_io.h"

#include "clouds/ply_header.h"
#include "recordings/files/file_io.h"
#include "recordings/files/pcd_file.h"

#include <pcl/common/io.h>
#include <pcl/io/ply_io.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
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

/** \brief Throws InputError for what PCL's reader would end the program at, or refuses. */
SensorPose readPly(const std::string& path, pcl::PCLPointCloud2& cloud) {
  checkPlyHeader(path);
  SensorPose pose;
  const SilencePcl silence;
  int version = 0;
  bool is_read = false;
  try {
    is_read = pcl::PLYReader().read(path, cloud, pose.origin, pose.orientation, version) >= 0;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {
  }
  if (!is_read) throw InputError(path + ": is damaged or cut short, must be a whole ply file");
  return pose;
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
  const SensorPose pose = extension == ".ply" ? readPly(path, cloud) : readPcd(path, cloud);
  checkCloud(path, cloud, empty);
  return pose;
}

}  // namespace fuse_flow::io
