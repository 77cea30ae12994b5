#pragma once

#include <cstddef>
#include <string>

namespace fuse_flow::io {

/** \brief Text of an input as a message quotes it: of a long one the beginning, in whole characters of UTF-8. */
inline std::string cutShort(const std::string& text) {
  constexpr std::size_t most = 80;
  if (text.size() <= most) return text;
  std::size_t end = most;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  return text.substr(0, end) + "…";
}

}  // namespace fuse_flow::io
