#include "clouds/ply_header.h"

#include "recordings/files/cut_short.h"
#include "recordings/files/text_header.h"

#include <fuse_flow/recordings/error.h>

#include <filesystem>
#include <map>
#include <vector>

namespace fuse_flow::io {
namespace {

using Line = std::vector<std::string>;

std::string wordOf(const Line& line, std::size_t k) { return k < line.size() ? line[k] : std::string(); }

/** \brief A number by which PCL's reader takes memory. */
double countOf(const std::string& path, const Line& line) {
  const long count = headerNumber(wordOf(line, 2));
  if (count < 0)
    throw InputError(path + ": " + cutShort(wordOf(line, 1)) + " is '" + cutShort(wordOf(line, 2)) +
                     "', must be a whole number");
  return static_cast<double>(count);
}

std::size_t typeSize(const std::string& type) {
  for (const char* two : {"short", "ushort", "int16", "uint16"})
    if (type == two) return 2;
  for (const char* four : {"int", "uint", "int32", "uint32", "float", "float32"})
    if (type == four) return 4;
  return type == "double" || type == "float64" ? 8 : 1;
}

/** \brief The fewest bytes that hold what the header tells of. */
class PlySize {
 public:
  void addLine(const std::string& path, const Line& line) {
    if (line[0] == "format") is_text_ = wordOf(line, 1) == "ascii";
    if (line[0] == "element") entries_ = countOf(path, line);
    if (line[0] != "property" || entries_ == 0) return;
    // As text a value and what ends it. Of a list the type of its count follows the word, and it may be empty.
    const std::string type = wordOf(line, wordOf(line, 1) == "list" ? 2 : 1);
    bytes_ += entries_ * static_cast<double>(is_text_ ? 2 : typeSize(type));
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
  void addLine(const std::string& path, const Line& line) {
    if (line[0] == "obj_info" && wordOf(line, 1) == "num_cols") columns_ = wordOf(line, 2);
    if (line[0] == "obj_info" && wordOf(line, 1) == "num_rows") rows_ = wordOf(line, 2);
    if (line[0] == "element" && wordOf(line, 1) == "vertex") vertices_ = countOf(path, line);
  }
  void check(const std::string& path) const {
    const long columns = headerNumber(columns_), rows = headerNumber(rows_);
    const bool product = static_cast<double>(columns) * static_cast<double>(rows) == vertices_;
    if (columns >= 0 && rows >= 0 && (product || (columns == 0 && rows == 0))) return;
    throw InputError(path + ": obj_info has '" + cutShort(columns_) + "' columns and '" + cutShort(rows_) +
                     "' rows, must be as many as its " + std::to_string(static_cast<long>(vertices_)) + " vertices");
  }

 private:
  std::string columns_{"0"}, rows_{"0"};
  double vertices_{0};
};

/** \brief The bytes of a vertex's colour, of which PCL's reader makes one field: begun by red, written at blue, and then changed by alpha. In another
 *  order it writes beside that field. */
class PlyColor {
 public:
  void addProperty(const std::string& path, const std::string& type, const std::string& name) {
    static const std::map<std::string, int> steps{{"red", 0},           {"diffuse_red", 0}, {"green", 1},
                                                  {"diffuse_green", 1}, {"blue", 2},        {"diffuse_blue", 2}};
    const bool is_byte = type == "uchar" || type == "uint8";
    const auto found = steps.find(name);
    const int step = is_byte && found != steps.end() ? found->second : -1;
    if (is_byte && name == "alpha") {
      if (!takes_alpha_) throw InputError(path + ": has alpha without red, green and blue before it");
      takes_alpha_ = false;
    } else if (step >= 0 ? step != next_ : next_ != 0) {
      throw InputError(path + ": has " + cutShort(name) + (next_ == 0 ? " without red" : " without all of a colour") +
                       " before it, must be red, green, blue");
    } else if (step >= 0) {
      next_ = (next_ + 1) % 3;
      takes_alpha_ = next_ == 0;
    }
  }
  void end(const std::string& path) const {
    if (next_ != 0) throw InputError(path + ": has a part of a colour, must be red, green, blue");
  }

 private:
  int next_{0};  ///< of red, green, blue
  bool takes_alpha_{false};
};

}  // namespace

void checkPlyHeader(const std::string& path) {
  const TextHeader header = readTextHeader(path, "end_header");
  PlySize size;
  PlyGrid grid;
  PlyColor color;
  std::string element;
  for (std::size_t k = 0; k < header.lines.size(); ++k) {
    const Line& line = header.lines[k];
    if (line[0] == "obj_info" && header.indented[k])
      throw InputError(path + ": has white space before obj_info, must have none");
    size.addLine(path, line);
    grid.addLine(path, line);
    if (line[0] == "element") element = wordOf(line, 1);
    if (element == "range_grid") throw InputError(path + ": has a range_grid, must have vertices alone or with faces");
    if (line[0] != "property" || element != "vertex") continue;
    if (wordOf(line, 1) == "list")
      throw InputError(path + ": has a list among the properties of its vertices, must have numbers");
    color.addProperty(path, wordOf(line, 1), wordOf(line, 2));
  }
  color.end(path);
  grid.check(path);
  const auto there = static_cast<double>(std::filesystem::file_size(path)) - static_cast<double>(header.end);
  if (there < size.bytes()) throw InputError(path + ": is cut short: it holds fewer values than its header says");
}

}  // namespace fuse_flow::io
