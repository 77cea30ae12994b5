#include "recordings/files/pcd_file.h"

#include "recordings/files/cut_short.h"
#include "recordings/files/file_io.h"
#include "recordings/files/text_header.h"

#include <pcl/common/io.h>
#include <pcl/io/pcd_io.h>
#include <pcl/pcl_config.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <sstream>
#include <vector>

namespace fuse_flow::io {
namespace {

enum class PcdData { Ascii = 0, Binary = 1, Compressed = 2 };  // PCL's numbers

/** \brief A header, each of whose lines is there once, and none that is not known: PCL's reader takes POINTSX for POINTS, the last of
 *  several lines, and memory by each of them. */
class PcdHeader {
 public:
  explicit PcdHeader(const std::string& path) : path_(path) {
    const TextHeader text = readTextHeader(path, "DATA");
    for (const std::vector<std::string>& line : text.lines)
      if (line[0][0] != '#') addLine(line);
    data_begin = text.end;
    const std::string data = lines_["DATA"].empty() ? "" : lines_["DATA"][0];
    if (data == "binary")
      kind = PcdData::Binary;
    else if (data == "binary_compressed")
      kind = PcdData::Compressed;
    else if (data != "ascii")
      fail("DATA is '" + cutShort(data) + "', must be ascii, binary or binary_compressed");
    check();
  }

  [[noreturn]] void fail(const std::string& problem) const {
    throw InputError(path_ + ": is damaged or cut short: " + problem);
  }

  std::size_t data_begin{0};
  PcdData kind{PcdData::Ascii};

 private:
  void addLine(const std::vector<std::string>& line) {
    const std::string keyword = line[0] == "COLUMNS" ? "FIELDS" : line[0];
    if (!isKeyword(keyword)) fail("its header has a line '" + cutShort(keyword) + "', which no PCD has");
    if (!lines_.emplace(keyword, std::vector<std::string>(line.begin() + 1, line.end())).second)
      fail("its header has two lines " + keyword);
  }
  static bool isKeyword(const std::string& word) {
    for (const char* keyword :
         {"VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA"})
      if (word == keyword) return true;
    return false;
  }
  std::vector<double> numbers(const std::string& keyword) const {
    std::vector<double> values;
    const auto line = lines_.find(keyword);
    if (line == lines_.end()) return values;
    for (const std::string& word : line->second) {
      values.push_back(static_cast<double>(headerNumber(word)));
      if (values.back() < 0) fail(keyword + " has '" + cutShort(word) + "', must have whole numbers");
    }
    return values;
  }
  double number(const std::string& keyword, double otherwise) const {
    const std::vector<double> values = numbers(keyword);
    return values.empty() ? otherwise : values[0];
  }
  /** \brief Throws unless what the header tells of fits into the file. */
  void check() const {
    const std::vector<double> sizes = numbers("SIZE"), counts = numbers("COUNT");
    constexpr double most_values = 1 << 20;
    if (!std::all_of(sizes.begin(), sizes.end(), [](double n) { return n == 1 || n == 2 || n == 4 || n == 8; }))
      fail("SIZE must have 1, 2, 4 and 8 alone");
    if (!std::all_of(counts.begin(), counts.end(), [](double n) { return n <= most_values; }))
      fail("COUNT must have numbers up to 1048576 alone");
    double of_point = 0;
    if (sizes.empty())
      of_point = (kind == PcdData::Ascii ? 2.0 : 4.0) *
                 static_cast<double>(lines_.count("FIELDS") ? lines_.at("FIELDS").size() : 0);
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      const double values = i < counts.size() ? std::max(1.0, counts[i]) : 1;  // some files say 0 where they mean 1
      of_point += values * (kind == PcdData::Ascii ? 2 : sizes[i]);            // as text a value and what ends it
    }
    const double points = number("POINTS", 0);
    double least = of_point * std::max(points, number("WIDTH", 0) * number("HEIGHT", 1));
    if (kind == PcdData::Ascii) least -= 1;         // nothing need end the last
    if (kind == PcdData::Compressed) least /= 100;  // LZF makes 264 bytes of 3 at best
    if (static_cast<double>(fileSize(path_)) - static_cast<double>(data_begin) < least)
      fail("it holds fewer values than its header says");
  }

  std::string path_;
  std::map<std::string, std::vector<std::string>> lines_;
};

/** \brief Before 1.13 PCL's reader refused files without points, after their whole header. */
bool isRefusedAsEmpty(const pcl::PCLPointCloud2& header) {
#if PCL_VERSION_COMPARE(<, 1, 13, 0)
  return header.width * header.height == 0;
#else
  (void)header;
  return false;
#endif
}

/** \brief Whether the data are as many as the header says; of compressed ones, what they say themselves. */
bool isWhole(const PcdHeader& header, const pcl::PCLPointCloud2& cloud, const std::string& bytes) {
  const std::size_t points = static_cast<std::size_t>(cloud.width) * cloud.height;
  const std::size_t there = bytes.size() - header.data_begin;
  if (header.kind == PcdData::Ascii) return true;
  if (header.kind == PcdData::Binary) return there >= points * cloud.point_step;
  std::size_t point_bytes = 0;
  for (const pcl::PCLPointField& field : cloud.fields)
    if (field.name != "_")
      point_bytes +=
          std::max<std::size_t>(1, field.count) * static_cast<std::size_t>(pcl::getFieldSize(field.datatype));
  std::uint32_t sizes[2] = {0, 0};  // compressed, uncompressed
  if (there < sizeof sizes) return false;
  std::memcpy(sizes, bytes.data() + header.data_begin, sizeof sizes);
  return sizeof sizes + sizes[0] <= there && sizes[1] == points * point_bytes;
}

/** \brief False for what PCL refuses. */
bool parse(const PcdHeader& header, std::string& bytes, pcl::PCLPointCloud2& cloud, SensorPose& pose) {
  const SilencePcl silence;
  int version = 0, kind = 0;
  unsigned int begin = 0;
  std::istringstream text(bytes.substr(0, header.data_begin) + '\n');  // which the last line of a file may lack
  pcl::PCDReader reader;
  const bool is_whole = reader.readHeader(text, cloud, pose.origin, pose.orientation, version, kind, begin) >= 0;
  if (cloud.fields.empty() || cloud.point_step == 0 || kind != static_cast<int>(header.kind)) return false;
  if (isRefusedAsEmpty(cloud)) return true;
  const std::size_t points = static_cast<std::size_t>(cloud.width) * cloud.height;
  if (!is_whole || cloud.data.size() != points * cloud.point_step) return false;
  if (points == 0) return true;
  if (!isWhole(header, cloud, bytes)) return false;
  cloud.is_dense = true;
  if (header.kind == PcdData::Ascii) {
    std::istringstream body(bytes.substr(header.data_begin));
    return reader.readBodyASCII(body, cloud, version) >= 0;
  }
  return reader.readBodyBinary(reinterpret_cast<const unsigned char*>(bytes.data()), cloud, version,
                               header.kind == PcdData::Compressed, static_cast<unsigned int>(header.data_begin)) >= 0;
}

/** \brief Doubles become floats in their place, which PCL's point types have: Open3D's PLY holds doubles. */
void toSinglePrecision(pcl::PCLPointCloud2& cloud) {
  const std::size_t points = static_cast<std::size_t>(cloud.width) * cloud.height;
  for (pcl::PCLPointField& field : cloud.fields) {
    if (field.datatype != pcl::PCLPointField::FLOAT64) continue;
    for (std::size_t i = 0; i < points; ++i) {
      std::uint8_t* at = cloud.data.data() + i * cloud.point_step + field.offset;
      for (std::size_t k = 0; k < std::max<std::size_t>(1, field.count); ++k) {
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

SensorPose readPcd(const std::string& path, pcl::PCLPointCloud2& cloud) {
  const PcdHeader header(path);
  std::string bytes = readFile(path);
  SensorPose pose;
  bool is_read = false;
  try {
    is_read = parse(header, bytes, cloud, pose);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {  // of words that are no numbers, of too few of them
  }
  if (!is_read) throw InputError(path + ": is damaged or cut short, must be a whole pcd file");
  return pose;
}

void checkCloud(const std::string& path, pcl::PCLPointCloud2& cloud, EmptyCloud empty) {
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
}

}  // namespace fuse_flow::io
