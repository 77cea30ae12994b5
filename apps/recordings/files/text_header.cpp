#include "recordings/files/text_header.h"

#include "recordings/files/file_io.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>
#include <sstream>

namespace fuse_flow::io {

TextHeader readTextHeader(const std::string& path, const std::string& last_line_begins_with) {
  constexpr std::size_t most = 1 << 20;
  const std::string bytes = readFileStart(path, most);
  TextHeader header;
  while (header.end < bytes.size()) {
    const std::size_t line_end = std::min(bytes.find('\n', header.end), bytes.size());
    std::istringstream words(bytes.substr(header.end, line_end - header.end));
    std::vector<std::string> line{std::istream_iterator<std::string>(words), {}};
    const bool indented = bytes.compare(header.end, 1, line.empty() ? "" : line[0].substr(0, 1)) != 0;
    header.end = std::min(line_end + 1, bytes.size());
    if (line.empty()) continue;
    header.indented.push_back(indented);
    header.lines.push_back(std::move(line));
    if (header.lines.back()[0] == last_line_begins_with) return header;
  }
  throw InputError(path + ": is damaged or cut short: no line of its " +
                   (bytes.size() < most ? "" : "first " + std::to_string(most) + " bytes ") + "begins with " +
                   last_line_begins_with);
}

long headerNumber(const std::string& text) {
  constexpr std::size_t most_digits = 10;
  if (text.empty() || text.size() > most_digits || text.find_first_not_of("0123456789") != std::string::npos) return -1;
  const long value = std::stol(text);
  return value <= std::numeric_limits<std::uint32_t>::max() ? value : -1;
}

}  // namespace fuse_flow::io
