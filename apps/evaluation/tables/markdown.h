#pragma once

#include <cmath>
#include <iomanip>
#include <sstream>
#include <string>
#include <vector>

namespace fuse_flow::tables {

/** \brief A number for a table; "–" where there is none. */
inline std::string number(double value, int decimals) {
  if (std::isnan(value)) return "–";
  std::ostringstream out;
  out << std::fixed << std::setprecision(decimals) << value;
  return out.str();
}

/** \brief A table in Markdown, row by row. */
class MarkdownTable {
 public:
  explicit MarkdownTable(const std::vector<std::string>& header) {
    row(header);
    text_ += "|";
    for (std::size_t k = 0; k < header.size(); ++k) text_ += "---|";
    text_ += "\n";
  }
  void row(const std::vector<std::string>& cells) {
    text_ += "|";
    for (const std::string& cell : cells) text_ += " " + cell + " |";
    text_ += "\n";
  }
  std::string text() const { return text_ + "\n"; }

 private:
  std::string text_;
};

}  // namespace fuse_flow::tables
