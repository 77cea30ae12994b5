#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief The lines of text with which a file begins, in front of its data, split at white space. */
struct TextHeader {
  std::vector<std::vector<std::string>> lines;  ///< without empty ones; the last is the one that ends it
  std::vector<bool> indented;                   ///< of each line: it begins with white space
  std::size_t end{0};                           ///< where the data begin, bytes
};

/** \brief Reads up to the first line that begins with a word. Throws InputError if none of the first mebibyte's does.
 *  \param path a file, not a pipe */
TextHeader readTextHeader(const std::string& path, const std::string& last_line_begins_with);

/** \brief The value of a whole number, digits alone, up to the largest of 32 bits; −1 for any other text. */
long headerNumber(const std::string& text);

}  // namespace fuse_flow::io
