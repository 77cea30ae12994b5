#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief The number that a text is, of digits alone; none if it is anything else, or too large. */
std::optional<std::size_t> wholeNumber(const std::string& text);

/** \brief The numbers in a file's name without its extension: of "0000007-000000233333" 7 and 233333. Those too large are left out. */
std::vector<std::size_t> numbersIn(const std::string& stem);

}  // namespace fuse_flow::io
